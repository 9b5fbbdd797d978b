"""The summary of a run: extremes of what was asked for, beside the ideal linkage's, and the error of each."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from linkages.errors import Status
from linkages.files.versions import versions
from linkages.outputs.registry import unit
from linkages.planar.arrays import Arrays
from linkages.results.extremes import extremes, integral, peaks
from linkages.results.impacts import Impact, impacts
from linkages.results.indeterminate import indeterminate
from linkages.results.parting import horizon
from linkages.results.ranges import outside
from linkages.results.singular import Passage, passages
from linkages.results.trajectory import Trajectory
from linkages.results.warnings import chaotic, meaningless, rough, singular, undetermined
from linkages.system import System

_COMPARED = 500  # times at which the run and the tighter one are compared


@dataclass(frozen=True)
class Study:
    """A run with what is needed to judge it.

    Attributes
    ----------
    system : System
    engine : str
        That made the run.
    run : Trajectory
    ideal : Trajectory
        The same linkage with every joint ideal; see `linkages.ideal`.
    tighter : Trajectory or None
        The run repeated at a ten times tighter tolerance.
    """

    system: System
    engine: str
    run: Trajectory
    ideal: Trajectory
    tighter: Trajectory | None

    @cached_property
    def contacts(self) -> list[Impact]:
        """Every contact of the run."""
        return impacts(self.run, touching(self.system))

    @cached_property
    def passages(self) -> list[Passage]:
        """Singular positions of its closed loops that the run passes or nears."""
        return passages(self.system.tree, self.system.arrays, self.run)

    @cached_property
    def ideal_passages(self) -> list[Passage]:
        """The same of the motion with ideal joints."""
        system, arrays = self._ideal_model
        return passages(system.tree, arrays, self.ideal)

    @cached_property
    def indeterminate(self) -> tuple[str, ...]:
        """Joints and drives of the run whose force or torque is statically indeterminate."""
        return indeterminate(self.system, self.system.arrays, self.run)

    @cached_property
    def ideal_indeterminate(self) -> tuple[str, ...]:
        """The same of the motion with ideal joints."""
        return indeterminate(*self._ideal_model, self.ideal)

    @cached_property
    def meaningless(self) -> frozenset[str]:
        """Columns of the run whose peaks mean nothing."""
        return meaningless(_judged(self.system), self.passages, self.indeterminate)

    @cached_property
    def _ideal_model(self) -> tuple[System, Arrays]:
        """System whose coordinates the motion with ideal joints has, and its arrays."""
        if self.system.determinate:
            return self.system, self.system.ideal_arrays
        system = self.system.ideal()
        return system, system.arrays

    @cached_property
    def parted(self) -> float | None:
        """When the run and the tighter one part [s]; None if they stay together to their end, or there are not two."""
        run, tighter = self.run, self.tighter
        if tighter is None or run.evaluate is None or not self.system.touching.any():
            return None
        until = horizon(run, tighter, self.system, 1 + len(tighter.time) // _COMPARED)
        return until if until < min(run.time[-1], tighter.time[-1]) else None


def summarize(study: Study) -> dict[str, Any]:
    """Make the contents of ``summary.json``: SI units; see docs/outputs.md.

    Parameters
    ----------
    study : Study
        From `linkages.study`.

    Returns
    -------
    dict
        Of numbers, texts, lists and dicts, ready for JSON.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> summary = linkages.summarize(linkages.study(system, "compiled"))
    >>> summary["status"], round(summary["joints"]["A"]["force"]["peak"], 2)
    ('ok', 3.32)
    """
    system, tree = study.system, study.system.tree
    quality = system.assembly.quality
    numbers = _numbers(system, study.run, study.meaningless, study.contacts)
    ideal_meaningless = meaningless(_judged(system), study.ideal_passages, study.ideal_indeterminate)
    ideal_numbers = _numbers(system, study.ideal, ideal_meaningless)
    return {
        "engine": study.engine,
        "duration": float(study.run.time[-1]),
        "status": study.run.status.value,
        "mechanism": {
            "name": system.mechanism.name,
            "mobility": system.assembly.mobility,
            "driven": [*tree.driven, *tree.powered],
            "cut": {"play": list(tree.play), "ideal": list(tree.loops)},
            "quality": None if np.isnan(quality) else quality,
            "loop_error": study.run.provenance.get("loop_error", 0.0),
        },
        **numbers,
        "ideal": {"status": study.ideal.status.value, **ideal_numbers},
        **judge(study, numbers),
        "provenance": {
            "versions": versions(),
            "experiment": system.experiment.model_dump(exclude_unset=True, exclude_none=True)
            | {"file": system.experiment.source.name},
            "sources": system.experiment.sources,
            "run": {key: value for key, value in study.run.provenance.items() if key != "wall_time"},
            "wall_time": study.run.provenance["wall_time"],
        },
    }


def judge(study: Study, numbers: dict[str, Any]) -> dict[str, Any]:
    """Make ``error`` and ``warnings`` of a summary.

    Parameters
    ----------
    study : Study
    numbers : dict
        From `summarize`, of the same run.

    Returns
    -------
    dict
        ``error`` has the change of each peak at the tighter tolerance by the peak's key (``slider7.ax.peak``), None
        where there is none; without a tighter run it is empty.
    """
    peak = peaks_by_key(numbers)
    change: dict[str, float | None] = {}
    parted = None
    if study.tighter is not None:
        ended = study.tighter.status is Status.OK
        finer = peaks_by_key(_numbers(study.system, study.tighter, study.meaningless)) if ended else {}
        for key, value in peak.items():
            other = finer.get(key)
            change[key] = None if value is None or other is None else abs(value - other)
        parted = study.parted
    later = [key for key in change if parted is not None and _when(study.run, key) > parted]
    found = [
        *singular(study.passages, study.ideal_passages),
        *undetermined(study.indeterminate, study.ideal_indeterminate),
        *rough(study.tighter, peak, change),
        *chaotic(parted, later),
        *outside(study.system, study.run, study.contacts),
    ]
    return {"error": change | dict.fromkeys(later), "warnings": found}


def _when(run: Trajectory, key: str) -> float:
    """Time of a peak by its key [s], to a step."""
    return float(run.time[np.argmax(np.abs(run[key.removesuffix(".peak")]))])


def meaningless_of(system: System, run: Trajectory, names: Iterable[str]) -> frozenset[str]:
    """Choose from columns of one run those whose values mean nothing, see `linkages.results.warnings.meaningless`."""
    found = passages(system.tree, system.arrays, run), indeterminate(system, system.arrays, run)
    return meaningless(names, *found) & frozenset(names)


def warnings_of(system: System, run: Trajectory, contacts: Sequence[Impact]) -> list[dict[str, Any]]:
    """Warn of what one run shows by itself: singular positions, forces left open, laws outside their ranges."""
    return [
        *singular(passages(system.tree, system.arrays, run), ()),
        *undetermined(indeterminate(system, system.arrays, run), ()),
        *outside(system, run, contacts),
    ]


def touching(system: System) -> list[str]:
    """Contacts that can touch: joints, and the corners of guides."""
    return [label for (_, label), able in zip(system.tree.contacts, system.touching, strict=True) if able]


def _judged(system: System) -> list[str]:
    """Columns of outputs, forces in joints and torques of drives."""
    experiment = system.experiment
    forces = [f"{joint.name}.force" for joint in system.mechanism.joints]
    return [*experiment.outputs, *forces, *(f"{name}.torque" for name in experiment.drives)]


def _numbers(
    system: System, trajectory: Trajectory, meaningless: Collection[str], touches: Sequence[Impact] = ()
) -> dict[str, Any]:
    """Collect outputs, joints, drives and applied loads of one trajectory with these contacts; None if meaningless."""
    experiment = system.experiment
    joints = [joint.name for joint in system.mechanism.joints]
    play = [name for name in experiment.play if f"{name}.eccentricity_ratio" in trajectory.columns]
    judged = [
        *(f"{name}.force" for name in joints),
        *(f"{name}.eccentricity_ratio" for name in play),
        *(f"{name}.torque" for name in experiment.drives),
        *(f"{name}.{_effort(table)}" for table, name in experiment.loads),
    ]
    extreme = extremes(trajectory, [name for name in experiment.outputs if name not in meaningless])
    peak = peaks(trajectory, [name for name in judged if name not in meaningless])
    result: dict[str, Any] = {"outputs": {}, "joints": {}, "drives": {}}
    for name in experiment.outputs:
        found = extreme.get(name)
        result["outputs"][name] = {key: found and getattr(found, key) for key in ("min", "max", "peak")}
    for name in joints:
        value, when = peak.get(f"{name}.force", (None, None))
        entry: dict[str, Any] = {"model": "ideal", "force": {"peak": value, "time": when}}
        if name in play:
            entry["model"] = experiment.joints[name].model
            entry["eccentricity_ratio"] = {"peak": peak[f"{name}.eccentricity_ratio"].value}
            contacts = [row for row in touches if row.joint.partition(".")[0] == name]
            lasted = float(np.ptp(trajectory.time))  # nothing, if the run failed at once
            entry["contact_fraction"] = _covered(contacts) / lasted if lasted else float(bool(contacts))
            entry["impacts"] = len(contacts)
        result["joints"][name] = entry
    for name in experiment.drives:
        torque, _ = peak.get(f"{name}.torque", (None, None))
        power = trajectory[f"{name}.torque"] * trajectory[f"{name}.rate"]
        kind = unit(system, f"{name}.torque")
        work = None if torque is None else integral(trajectory, power)
        result["drives"][name] = {"torque": {"peak": torque}, "unit": kind, "work": work}
    for table, name in experiment.loads:
        effort = _effort(table)
        work = integral(trajectory, trajectory[f"{name}.power"])
        result.setdefault("loads", {})[name] = {effort: {"peak": peak[f"{name}.{effort}"].value}, "work": work}
    return result


def _effort(table: str) -> str:
    """Quantity by which a kind of applied load is judged."""
    return "torque" if table in ("torques", "torsion_springs") else "force"


def _covered(rows: list[Impact]) -> float:
    """Time in which at least one of the contacts lasts [s]."""
    total, until = 0.0, -np.inf
    for row in sorted(rows, key=lambda row: row.start):
        end = row.start + row.duration
        total += max(0.0, end - max(row.start, until))
        until = max(until, end)
    return total


def peaks_by_key(numbers: dict[str, Any]) -> dict[str, float | None]:
    """Every peak of a summary with its key: ``slider7.ax.peak``, ``A.force.peak``."""
    result = {f"{name}.peak": value["peak"] for name, value in numbers["outputs"].items()}
    for kind in ("joints", "drives", "loads"):
        for name, entry in numbers.get(kind, {}).items():
            for key in ("force", "eccentricity_ratio", "torque"):
                if key in entry:
                    result[f"{name}.{key}.peak"] = entry[key]["peak"]
    return result
