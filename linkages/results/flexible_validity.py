"""Where the model of a link that bends ceases to hold in a run: one rule each, in `BENT_RULES`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.planar.record_types import SECTION
from linkages.results.impacts import Impact
from linkages.results.trajectory import Trajectory
from linkages.results.validity import Finding, Rule
from linkages.system import System
from linkages.system.flexible_link import BentLink

#: Slope against the frame's axis at which the stiffness, off by half its square, is off by 1 %.
SLOPE = math.sqrt(2.0 * 0.01)
#: Compressive force over Euler's load of the beam with pinned ends: there deflections are twice those without it.
BUCKLING = 0.5
#: Stretching modes with which the peak of a blow is right: with one it is wrong by a third, with two by 10 %, with four
#: by 0.1 %, of a steel rod of 0.3 m whose dry joint closes (docs/flexible.md, Limits).
AXIAL = 4
#: Highest kept bending frequency over what excites the link: its own modes answer to that as they do at rest.
ABOVE = 10.0

_SAMPLES = 101  # along the beam


class BentCase(NamedTuple):
    """A link that bends in one run; the impacts are those of contacts that it carries."""

    link: str
    pieces: Sequence[BentLink]
    run: Trajectory
    impacts: Sequence[Impact]
    drives: Sequence[str]  # of joints that turn


def bent_cases(system: System, run: Trajectory, impacts: Sequence[Impact]) -> list[tuple[str, BentCase]]:
    """Name the links that bend, with what rules look at; none of a run whose links are moved by other models."""
    carried = _carriers(system)
    drives = [name for name in system.tree.driven if system.mechanism.joint[name].type == "revolute"]
    return [
        (name, BentCase(name, pieces, run, [hit for hit in impacts if name in carried[hit.joint]], drives))
        for name, pieces in system.tree.pieces.items()
        if f"q.{pieces[0].coordinates[0]}" in run.columns
    ]


def _carriers(system: System) -> dict[str, set[str]]:
    """Links on which each contact acts, by its label."""
    tree = system.tree
    records, names = (
        tree.bodies.records,
        {tree.index[p.name]: link for link, found in tree.pieces.items() for p in found},
    )
    found: dict[str, set[str]] = {}
    for (_, label), end in zip(system.contacts, system.ends, strict=True):
        bodies = [int(end[side]["body"]) for side in ("bearing", "journal")]
        mounts = [int(records[b]["mount"]["body"]) if records[b]["type"] == SECTION else b for b in bodies]
        found[label] = {names[b] for b in mounts if b in names}
    return found


def _slope(case: BentCase) -> Finding | None:
    largest = np.zeros(len(case.run.time))
    for piece in case.pieces:
        eta = np.array([case.run[f"q.{name}"] for name in piece.coordinates])
        slopes = piece.modes.shapes(np.linspace(*piece.ends, _SAMPLES), 1)[1] @ eta
        largest = np.maximum(largest, np.max(np.abs(slopes), axis=0))
    worst = int(np.argmax(largest))
    value = float(largest[worst])
    text = f"stiffness is off by half its square, 1 % at {SLOPE:.3g}"
    return Finding(value, float(case.run.time[worst]), text) if value > SLOPE else None


def _strut(case: BentCase) -> Finding | None:
    force = case.run[f"{case.link}.compression"]
    worst, elastic = int(np.argmax(force)), case.pieces[0].beam.elastic()
    euler = math.pi**2 * elastic.bending / elastic.length**2
    value = float(force[worst]) / euler
    text = f"half and more doubles what bends; Euler's load with pinned ends is {euler:.3g} N"
    return Finding(value, float(case.run.time[worst]), text) if value > BUCKLING else None


def _wave(case: BentCase) -> Finding | None:
    count = sum(len(piece.modes.names) - piece.modes.bending for piece in case.pieces)
    if count >= AXIAL or not case.impacts:
        return None
    return Finding(count, min(hit.start for hit in case.impacts), f"{AXIAL} or more")


def _blow(case: BentCase) -> Finding | None:
    shortest = min(case.impacts, key=lambda hit: hit.duration, default=None)
    if shortest is None or not shortest.duration > 0.0:
        return None
    highest = max(float(np.max(piece.modes.frequencies)) for piece in case.pieces) / (2.0 * math.pi)
    value = highest * shortest.duration
    text = f"1 or more; a contact lasts {shortest.duration:.3g} s, the fastest mode has {highest:.3g} Hz"
    return Finding(value, shortest.start, text) if value < 1.0 else None


def _drive(case: BentCase) -> Finding | None:
    rates = [np.abs(case.run[f"{name}.rate"]) for name in case.drives]
    bending = [piece.modes.frequencies[: piece.modes.bending] for piece in case.pieces if piece.modes.bending]
    if not rates or not bending:
        return None
    fastest = np.max(rates, axis=0)
    worst = int(np.argmax(fastest))
    if not fastest[worst] > 0.0:
        return None
    value = max(float(np.max(frequencies)) for frequencies in bending) / float(fastest[worst])
    return Finding(value, float(case.run.time[worst]), f"{ABOVE:g} or more") if value < ABOVE else None


BENT_RULES = (
    Rule(
        "flexible",
        "a link bends further than its model holds: its largest slope is",
        "make it stiffer, or set its pieces = 2 or more",
        _slope,
    ),
    Rule(
        "flexible",
        "a link is pressed nearly as hard as buckles it: in parts of that load",
        "make it stiffer or shorter",
        _strut,
    ),
    Rule(
        "flexible",
        "blows on a link need more stretching modes, for waves along it decide their peaks: there are",
        f"set its axial = {AXIAL} or more",
        _wave,
    ),
    Rule(
        "flexible",
        "a contact is over before the fastest mode of a link has swung once: their ratio is",
        "keep more modes, axial ones above all, until peaks settle",
        _blow,
    ),
    Rule(
        "flexible",
        "a drive turns nearly as fast as the fastest bending mode of a link swings: the ratio of their frequencies is",
        "keep more bending modes",
        _drive,
    ),
)
