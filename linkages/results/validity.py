"""Rules on the validity of models in a run, the warnings from their findings; `FLEXIBLE_RULES` of flexible links."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from linkages.mechanics.planar.record_types import SECTION
from linkages.results import numerics
from linkages.results.impacts import Impact
from linkages.results.link_loads import row_markers
from linkages.results.shape import RunWarning
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.flexible_link import FlexibleLink

Case = TypeVar("Case")


def warning(kind: str, time: float | None, what: str, remedy: str, changes: dict[str, Any] | None = None) -> RunWarning:
    """Make an entry of ``warnings`` in ``summary.json``; docs/outputs.md explains the kinds."""
    return RunWarning(kind=kind, time=time, what=what, remedy=remedy, changes=changes or {})


class Violation(NamedTuple):
    """A number outside its limits, the time [s] (None: always), and the limits as text."""

    value: float
    time: float | None
    limit: str


#: Function of a rule.
Find = Callable[[Case], Violation | None]
#: Function that returns values by dotted path which heed the warning of a rule.
Heed = Callable[[Case], dict[str, Any]]


class Rules(Generic[Case]):
    """Rules for cases of one kind, in the order of their warnings; `rule` adds one."""

    def __init__(self) -> None:
        self._rules: list[tuple[str, str, str, Heed[Case] | None, Find[Case]]] = []

    def rule(
        self, kind: str, what: str, remedy: str, heed: Heed[Case] | None = None
    ) -> Callable[[Find[Case]], Find[Case]]:
        """Add a function that returns a violation (None: valid), with kind, texts and changes of its warning."""

        def add(find: Find[Case]) -> Find[Case]:
            self._rules.append((kind, what, remedy, heed, find))
            return find

        return add

    def broken(self, cases: Sequence[tuple[str, Case]]) -> list[RunWarning]:
        """Return a warning for each rule violated by the named cases."""
        result = []
        for kind, what, remedy, heed, find in self._rules:
            broken = [(name, case, violation) for name, case in cases if (violation := find(case)) is not None]
            found = [(name, violation) for name, _, violation in broken]
            if found:
                numbers = [
                    f"{value:.3g} in {name}{'' if time is None else f' at {time:.6g} s'} ({limit})"
                    for name, (value, time, limit) in found
                ]
                times = [violation.time for _, violation in found if violation.time is not None]
                said = f"{what}: {', '.join(numbers)}"
                changes = {path: new for _, case, _ in broken if heed for path, new in heed(case).items()}
                result.append(warning(kind, min(times, default=None), said, remedy, changes))
        return result


#: Slope against the frame's axis with a stiffness error of 1 % (half the squared slope) [rad].
SLOPE = math.sqrt(2.0 * 0.01)
#: Compressive force over the pinned beam's Euler load that doubles the deflections [1].
BUCKLING = 0.5
#: Number of axial modes for accurate impact peaks. Errors for a 0.3 m steel rod when its dry joint closes: a third with
#: one mode, 10 % with two, 0.1 % with four (docs/flexible_theory.md, Limits).
AXIAL = 4
#: Smallest ratio of the highest kept bending frequency to the excitation frequency [1].
ABOVE = 10.0


class FlexibleCase(NamedTuple):
    """A flexible link in one run, with the impacts of the contacts on it."""

    link: str
    substructures: Sequence[FlexibleLink]
    run: Trajectory
    impacts: Sequence[Impact]
    drives: Sequence[str]  # drives of revolute joints


FLEXIBLE_RULES = Rules[FlexibleCase]()


def flexible_cases(system: System, run: Trajectory, impacts: Sequence[Impact]) -> list[tuple[str, FlexibleCase]]:
    """Yield the flexible links with the data of the rules; none for runs with other link models."""
    carried = _carriers(system)
    drives = [name for name in system.tree.driven if system.joints[name].type == "revolute"]
    return [
        (name, FlexibleCase(name, substructures, run, [hit for hit in impacts if name in carried[hit.joint]], drives))
        for name, substructures in system.tree.flexible.items()
        if f"q.{substructures[0].coordinates[0]}" in run.columns
    ]


def _carriers(system: System) -> dict[str, set[str]]:
    """Return the links on which each contact acts, by its label."""
    tree = system.tree
    records = tree.bodies.records
    names = {tree.index[part.name]: link for link, parts in tree.flexible.items() for part in parts}
    found: dict[str, set[str]] = {}
    for (_, label), end in zip(system.contacts, system.ends, strict=True):
        bodies = [int(marker["body"]) for marker in (end["bearing"], end["journal"], *row_markers(end["row"]))]
        mounts = [int(records[b]["mount"]["body"]) if records[b]["type"] == SECTION else b for b in bodies]
        found[label] = {names[b] for b in mounts if b in names}
    return found


@FLEXIBLE_RULES.rule(
    "flexible",
    "the deflection of a link exceeds the validity of its model: its largest slope is",
    "make it stiffer, or give it more `pieces`",
)
def _slope(case: FlexibleCase) -> Violation | None:
    largest = np.zeros(len(case.run.time))
    for part in case.substructures:
        eta = np.array([case.run[f"q.{name}"] for name in part.coordinates])
        slopes = part.modes.shapes(np.linspace(*part.ends, numerics.VALIDITY_SAMPLES), 1)[1] @ eta
        largest = np.maximum(largest, np.max(np.abs(slopes), axis=0))
    worst = int(np.argmax(largest))
    value = float(largest[worst])
    text = f"the relative error of the stiffness is half its square, 1 % at {SLOPE:.3g}"
    text += f"; the link has `pieces` = {len(case.substructures)}"
    return Violation(value, float(case.run.time[worst]), text) if value > SLOPE else None


@FLEXIBLE_RULES.rule(
    "flexible",
    "the compressive load of a link nears the Euler buckling load: their ratio is",
    "make it stiffer or shorter",
)
def _strut(case: FlexibleCase) -> Violation | None:
    force = case.run[f"{case.link}.compression"]
    worst, elastic = int(np.argmax(force)), case.substructures[0].beam.elastic()
    euler = math.pi**2 * elastic.bending / elastic.length**2
    value = float(force[worst]) / euler
    text = f"half doubles the deflection; the Euler load with pinned ends is {euler:.3g} N"
    return Violation(value, float(case.run.time[worst]), text) if value > BUCKLING else None


@FLEXIBLE_RULES.rule(
    "flexible",
    "impacts on a link need more axial modes, as axial waves determine the peaks: the number is",
    f"set its axial = {AXIAL} or more",
)
def _wave(case: FlexibleCase) -> Violation | None:
    count = sum(len(part.modes.names) - part.modes.bending for part in case.substructures)
    if count >= AXIAL or not case.impacts:
        return None
    return Violation(count, min(hit.start for hit in case.impacts), f"{AXIAL} or more")


@FLEXIBLE_RULES.rule(
    "flexible",
    "a contact is shorter than one period of the fastest mode of a link: ratio",
    "keep more modes, axial ones first, until the peaks converge",
)
def _impact(case: FlexibleCase) -> Violation | None:
    shortest = min(case.impacts, key=lambda hit: hit.duration, default=None)
    if shortest is None or not shortest.duration > 0.0:
        return None
    highest = max(float(np.max(part.modes.frequencies)) for part in case.substructures) / (2.0 * math.pi)
    value = highest * shortest.duration
    text = f"at least 1; a contact lasts {shortest.duration:.3g} s, the fastest mode has {highest:.3g} Hz"
    return Violation(value, shortest.start, text) if value < 1.0 else None


@FLEXIBLE_RULES.rule(
    "flexible", "the fastest bending mode of a link is close to the drive frequency: ratio", "keep more bending modes"
)
def _drive(case: FlexibleCase) -> Violation | None:
    rates = [np.abs(case.run[f"{name}.rate"]) for name in case.drives]
    bending = [part.modes.frequencies[: part.modes.bending] for part in case.substructures if part.modes.bending]
    if not rates or not bending:
        return None
    fastest = np.max(rates, axis=0)
    worst = int(np.argmax(fastest))
    if not fastest[worst] > 0.0:
        return None
    value = max(float(np.max(frequencies)) for frequencies in bending) / float(fastest[worst])
    return Violation(value, float(case.run.time[worst]), f"{ABOVE:g} or more") if value < ABOVE else None
