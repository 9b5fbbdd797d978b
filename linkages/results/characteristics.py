"""Characteristic numbers of a trajectory or a part of it: extremes of outputs, forces, torques, work, contacts."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.elements.machine import OF_ELEMENTS
from linkages.results.extremes import averages, extremes, integral, peaks
from linkages.results.impacts import Impact
from linkages.results.outputs.registry import unit
from linkages.results.trajectory import Trajectory
from linkages.system import System

_LINK = ("deflection", "bending", "stress")  # quantities of a flexible link whose peaks are in ``links``


def numbers(
    system: System, trajectory: Trajectory, meaningless: Collection[str], touches: Sequence[Impact] = ()
) -> dict[str, Any]:
    """Collect outputs, joints, drives, loads (including stops and contacts) and flexible links; None if meaningless.

    Contacts that begin in the time range are counted; of their durations only the part within it.
    """
    experiment = system.experiment
    # rigid links have no deformation outputs
    given = [name for name in experiment.outputs if name in trajectory and name not in meaningless]
    films = [f"{name}.film_thickness" for name in experiment.play if f"{name}.film_thickness" in trajectory]
    extreme = extremes(trajectory, [*given, *films])
    columns = [column for column in peak_columns(system) if column in trajectory]
    peak = peaks(trajectory, [column for column in columns if column not in meaningless])

    def of(column: str) -> dict[str, float | None]:
        value, when = peak.get(column, (None, None))
        return {"peak": value, "time": when}

    def effort(name: str, quantity: str) -> dict[str, Any]:
        work = integral(trajectory, f"{name}.power") if f"{name}.{quantity}" in peak else None
        return {quantity: of(f"{name}.{quantity}"), "work": work}

    result: dict[str, Any] = {"outputs": {}, "joints": {}, "drives": {}}
    for name in experiment.outputs:
        found = extreme.get(name)
        result["outputs"][name] = {key: found and getattr(found, key) for key in ("min", "max", "peak", "time")}
    for name in system.mechanism.joint:
        entry: dict[str, Any] = {"model": "ideal", "force": of(f"{name}.force")}
        if f"{name}.eccentricity_ratio" in columns:
            entry["model"] = experiment.joints[name].model
            entry["eccentricity_ratio"] = {"peak": peak[f"{name}.eccentricity_ratio"].value}
            if (least := extreme.get(f"{name}.film_thickness")) is not None:
                share = least.min / (experiment.joints[name].clearance or np.inf)
                entry["film_thickness"] = {"min": least.min, "time": least.time_min, "share": share}
            entry |= _contacts(trajectory, [row for row in touches if row.owner == name])
        if f"{name}.tilting_moment" in columns:
            entry["tilting_moment"] = of(f"{name}.tilting_moment")
        result["joints"][name] = entry
    for name in experiment.drives:
        result["drives"][name] = effort(name, "torque") | {"unit": unit(system, f"{name}.torque")}
        if not experiment.drives[name].acts:
            result["drives"][name]["acts"] = False
        if name in system.tree.powered and f"{name}.rate" in trajectory:
            result["drives"][name]["fluctuation"] = _fluctuation(trajectory, f"{name}.rate")
    for table, name in experiment.acting:
        entry = result.setdefault("loads", {})[name] = effort(name, effort_of(system, table, name))
        if any(f"{label}.penetration" in trajectory for label in _labels(system, name)):
            entry |= _contacts(trajectory, [row for row in touches if row.owner == name])
    for name in experiment.flexible:
        if f"{name}.stress" in columns:
            link = result.setdefault("links", {})[name] = {key: of(f"{name}.{key}") for key in _LINK}
            for key in ("deflection", "stress"):
                link[key]["place"] = _at(trajectory, f"{name}.{key}_place", link[key]["time"])
    return result


def _fluctuation(trajectory: Trajectory, column: str) -> float | None:
    """Compute the range of a column over the magnitude of its mean; None where the mean is zero."""
    top, (mean, _) = extremes(trajectory, [column])[column], averages(trajectory, column)
    return (top.max - top.min) / abs(mean) if mean else None


def _contacts(trajectory: Trajectory, rows: Sequence[Impact]) -> dict[str, Any]:
    """Count the contacts of a joint, and compute the part of the time with at least one."""
    begin, end = float(trajectory.time[0]), float(trajectory.time[-1])
    total, until = 0.0, begin
    for row in sorted(rows, key=lambda row: row.start):
        last = min(row.start + row.duration, end)
        total += max(0.0, last - max(row.start, until))
        until = max(until, last)
    lasted = end - begin  # zero if the run failed at once
    fraction = total / lasted if lasted else float(bool(rows))
    return {"contact_fraction": fraction, "impacts": sum(begin <= row.start <= end for row in rows)}


def _at(trajectory: Trajectory, column: str, time: float | None) -> float | None:
    """Return the value of a column at the sample nearest to a time [s]."""
    return None if time is None else float(trajectory[column][np.argmin(np.abs(trajectory.time - time))])


def peak_columns(system: System) -> list[str]:
    """Name the columns of joints, drives, loads and flexible links whose peaks are in a summary.

    A run lacks the columns of other models.
    """
    experiment = system.experiment
    return [
        *(f"{joint.name}.force" for joint in system.mechanism.joints),
        *(f"{name}.{quantity}" for name in experiment.play for quantity in ("eccentricity_ratio", "tilting_moment")),
        *(f"{name}.torque" for name in experiment.drives),
        *(f"{name}.{effort_of(system, table, name)}" for table, name in experiment.acting),
        *(f"{name}.{quantity}" for name in experiment.flexible for quantity in _LINK),
    ]


def effort_of(system: System, table: str, name: str) -> str:
    """Return the characteristic quantity of an applied load, element or contact."""
    if table in OF_ELEMENTS:
        kind, keys = OF_ELEMENTS[table], system.experiment.elements[table][name]
        return kind.outputs_of(keys, system.mechanism.slides)[0].effort
    return "torque" if table in ("torques", "motors") else "force"


def _labels(system: System, name: str) -> list[str]:
    """List the contacts of an element that has several."""
    return [label for owner, label in system.contacts if owner == name != label]


def peaks_by_key(numbers: Mapping[str, Any]) -> dict[str, float | None]:
    """Return all peaks of a summary by key: ``slider7.ax.peak``, ``A.force.peak``."""
    result = {f"{name}.peak": value["peak"] for name, value in numbers["outputs"].items()}
    for kind in ("joints", "drives", "loads", "links"):
        for name, entry in numbers.get(kind, {}).items():
            for quantity, value in entry.items():
                if isinstance(value, dict) and "peak" in value:
                    result[f"{name}.{quantity}.peak"] = value["peak"]
    return result
