"""Characteristic numbers of a trajectory or a part of it: extremes of outputs, forces, torques, work, contacts."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.outputs.joints import turns
from linkages.outputs.registry import unit
from linkages.results.extremes import extremes, integral, peaks
from linkages.results.impacts import Impact
from linkages.results.trajectory import Trajectory
from linkages.system import System


def numbers(
    system: System, trajectory: Trajectory, meaningless: Collection[str], touches: Sequence[Impact] = ()
) -> dict[str, Any]:
    """Collect outputs, joints, drives, loads (including stops and contacts) and flexible links; None if meaningless.

    Contacts that begin in the time range are counted; of their durations only the part within it.
    """
    experiment = system.experiment
    joints = [joint.name for joint in system.mechanism.joints]
    play = [name for name in experiment.play if f"{name}.eccentricity_ratio" in trajectory.columns]
    tilted = [name for name in play if f"{name}.tilting_moment" in trajectory.columns]
    efforts = [(name, effort_of(system, table, name)) for table, name in experiment.named]
    judged = [
        *(f"{name}.force" for name in joints),
        *(f"{name}.eccentricity_ratio" for name in play),
        *(f"{name}.tilting_moment" for name in tilted),
        *(f"{name}.torque" for name in experiment.drives),
        *(f"{name}.{effort}" for name, effort in efforts if f"{name}.{effort}" in trajectory.columns),
    ]
    bent = [name for name in experiment.flexible if f"{name}.stress" in trajectory.columns]
    judged += [column for name in bent for column in link_columns(name)]
    there = [
        name for name in experiment.outputs if name in trajectory.columns
    ]  # rigid links have no deformation outputs
    extreme = extremes(trajectory, [name for name in there if name not in meaningless])
    peak = peaks(trajectory, [name for name in judged if name not in meaningless])
    result: dict[str, Any] = {"outputs": {}, "joints": {}, "drives": {}}
    for name in experiment.outputs:
        found = extreme.get(name)
        result["outputs"][name] = {key: found and getattr(found, key) for key in ("min", "max", "peak", "time")}
    for name in joints:
        value, when = peak.get(f"{name}.force", (None, None))
        entry: dict[str, Any] = {"model": "ideal", "force": {"peak": value, "time": when}}
        if name in play:
            entry["model"] = experiment.joints[name].model
            entry["eccentricity_ratio"] = {"peak": peak[f"{name}.eccentricity_ratio"].value}
            contacts = [row for row in touches if row.joint.partition(".")[0] == name]
            begin, end = float(trajectory.time[0]), float(trajectory.time[-1])
            lasted = end - begin  # zero if the run failed at once
            entry["contact_fraction"] = _covered(contacts, begin, end) / lasted if lasted else float(bool(contacts))
            entry["impacts"] = sum(begin <= row.start <= end for row in contacts)
        if name in tilted:
            value, when = peak[f"{name}.tilting_moment"]
            entry["tilting_moment"] = {"peak": value, "time": when}
        result["joints"][name] = entry
    for name in experiment.drives:
        torque, when = peak.get(f"{name}.torque", (None, None))
        power = trajectory[f"{name}.torque"] * trajectory[f"{name}.rate"]
        kind = unit(system, f"{name}.torque")
        work = None if torque is None else integral(trajectory, power)
        result["drives"][name] = {"torque": {"peak": torque, "time": when}, "unit": kind, "work": work}
    for name, effort in efforts:
        value, when = peak.get(f"{name}.{effort}", (None, None))
        work = None if value is None else integral(trajectory, trajectory[f"{name}.power"])
        result.setdefault("loads", {})[name] = {effort: {"peak": value, "time": when}, "work": work}
    for name in bent:
        link: dict[str, dict[str, Any]] = {}
        for column in link_columns(name):
            value, when = peak.get(column, (None, None))
            link[column.rpartition(".")[2]] = entry = {"peak": value, "time": when}
            if f"{column}_place" in trajectory.columns:
                places = trajectory[f"{column}_place"]
                entry["place"] = None if when is None else float(places[_nearest(trajectory, when)])
        result.setdefault("links", {})[name] = link
    return result


def link_columns(name: str) -> tuple[str, str, str]:
    """Name the columns of a flexible link whose peaks are in ``links``."""
    return f"{name}.deflection", f"{name}.bending", f"{name}.stress"


def _nearest(trajectory: Trajectory, time: float) -> int:
    return int(np.argmin(np.abs(trajectory.time - time)))


def effort_of(system: System, table: str, name: str) -> str:
    """Return the characteristic quantity of an applied load, gear, stop or contact."""
    along = table in ("frictions", "gears", "stops", "torsion_springs")
    return "torque" if table == "torques" or (along and turns(system, table, name)) else "force"


def _covered(rows: list[Impact], begin: float, last: float) -> float:
    """Compute the time between two times with at least one contact [s]."""
    total, until = 0.0, begin
    for row in sorted(rows, key=lambda row: row.start):
        end = min(row.start + row.duration, last)
        total += max(0.0, end - max(row.start, until))
        until = max(until, end)
    return total


def peaks_by_key(numbers: Mapping[str, Any]) -> dict[str, float | None]:
    """Return all peaks of a summary by key: ``slider7.ax.peak``, ``A.force.peak``."""
    result = {f"{name}.peak": value["peak"] for name, value in numbers["outputs"].items()}
    for kind in ("joints", "drives", "loads"):
        for name, entry in numbers.get(kind, {}).items():
            for key in ("force", "eccentricity_ratio", "tilting_moment", "torque"):
                if key in entry:
                    result[f"{name}.{key}.peak"] = entry[key]["peak"]
    for name, entry in numbers.get("links", {}).items():
        for column in link_columns(name):
            result[f"{column}.peak"] = entry[column.rpartition(".")[2]]["peak"]
    return result
