"""Characteristic numbers of a trajectory or a part of it: extremes of outputs, forces, torques, work, contacts."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from linkages.elements.machine import OF_ELEMENTS, OF_PARTS, all_elements_of
from linkages.results import shape
from linkages.results.extremes import Extremes, Peak, averages, extremes, integral, peaks
from linkages.results.impacts import Impact
from linkages.results.outputs.registry import unit
from linkages.results.shape import Numbers
from linkages.results.trajectory import Trajectory
from linkages.system import System


def numbers(
    system: System, trajectory: Trajectory, meaningless: Collection[str], touches: Sequence[Impact] = ()
) -> Numbers:
    """Collect outputs, joints, drives, loads (including stops and contacts) and deformable links; None if meaningless.

    Contacts that begin in the time range are counted; of their durations only the part within it.
    """
    part = _Part.of(system, trajectory, meaningless, touches)
    loads = {name: part.load(name, effort_of(system, table, name)) for table, name in system.acting}
    links = {name: part.link(name) for name, own in peaks_of_models(system, "link") if set(own) <= {*part.columns}}
    own: dict[str, Any] = ({"loads": loads} if loads else {}) | ({"links": links} if links else {})
    return Numbers(
        outputs={name: part.range(name) for name in system.settings.outputs},
        joints={name: part.joint(name) for name in system.joints},
        drives={name: part.drive(name) for name in system.drives},
        **own,
    )


@dataclass(frozen=True)
class _Part:
    """A motion or a part of it, with the extremes and peaks of its columns, and the peak columns that it has."""

    system: System
    trajectory: Trajectory
    touches: Sequence[Impact]
    columns: Sequence[str]
    extremes: Mapping[str, Extremes]
    peaks: Mapping[str, Peak]

    @classmethod
    def of(
        cls, system: System, trajectory: Trajectory, meaningless: Collection[str], touches: Sequence[Impact]
    ) -> _Part:
        """Search the extremes of outputs and film thicknesses, and the peaks of the other columns."""
        columns = [column for column in peak_columns(system) if column in trajectory]
        # rigid links have no deformation outputs
        given = [name for name in system.settings.outputs if name in trajectory and name not in meaningless]
        films = [f"{name}.film_thickness" for name in system.play if f"{name}.film_thickness" in trajectory]
        found = peaks(trajectory, [column for column in columns if column not in meaningless])
        return cls(system, trajectory, touches, columns, extremes(trajectory, [*given, *films]), found)

    def range(self, name: str) -> shape.Range:
        """Return the extremes of an output."""
        found = self.extremes.get(name)
        if found is None:
            return shape.Range(min=None, max=None, peak=None, time=None)
        return shape.Range(min=found.min, max=found.max, peak=found.peak, time=found.time)

    def peak(self, column: str) -> shape.Peak:
        """Return the peak of a column."""
        value, when = self.peaks.get(column, (None, None))
        return shape.Peak(peak=value, time=when)

    def joint(self, name: str) -> shape.JointNumbers:
        """Collect the numbers of a joint."""
        force, ratio, tilting = (f"{name}.{quantity}" for quantity in ("force", "eccentricity_ratio", "tilting_moment"))
        own: dict[str, Any] = {"tilting_moment": self.peak(tilting)} if tilting in self.columns else {}
        if ratio not in self.columns:
            return shape.JointNumbers(model="ideal", force=self.peak(force), **own)
        return shape.JointNumbers(
            model=self.system.joints[name].model,
            force=self.peak(force),
            eccentricity_ratio=shape.Ratio(peak=self.peaks[ratio].value),
            **self._film(name),
            **self._contacts(name),
            **own,
        )

    def _film(self, name: str) -> dict[str, Any]:
        """Return the thinnest film of a joint, if it has one."""
        least = self.extremes.get(f"{name}.film_thickness")
        if least is None:
            return {}
        share = least.min / (self.system.joints[name].clearance or np.inf)
        return {"film_thickness": shape.Least(min=least.min, time=least.time_min, share=share)}

    def drive(self, name: str) -> shape.Drive:
        """Collect the numbers of a drive."""
        own: dict[str, Any] = {} if self.system.drives[name].acts else {"acts": False}
        if name in self.system.tree.powered and f"{name}.rate" in self.trajectory:
            own["fluctuation"] = self._fluctuation(f"{name}.rate")
        return shape.Drive(**self._effort(name, "torque"), unit=unit(self.system, f"{name}.torque"), **own)

    def load(self, name: str, quantity: str) -> shape.Load:
        """Collect the numbers of a load with this characteristic quantity."""
        backlash = any(f"{label}.penetration" in self.trajectory for label in _labels(self.system, name))
        return shape.Load(**self._effort(name, quantity), **(self._contacts(name) if backlash else {}))

    def link(self, name: str) -> shape.Link:
        """Collect the numbers of a deformable link."""
        return shape.Link(
            deflection=self._placed(f"{name}.deflection"),
            bending=self.peak(f"{name}.bending"),
            stress=self._placed(f"{name}.stress"),
        )

    def _placed(self, column: str) -> shape.Placed:
        """Return the peak of a column along a link, with the place at the sample nearest to its time."""
        value, when = self.peaks.get(column, (None, None))
        place = None
        if when is not None:
            place = float(self.trajectory[f"{column}_place"][np.argmin(np.abs(self.trajectory.time - when))])
        return shape.Placed(peak=value, time=when, place=place)

    def _effort(self, name: str, quantity: str) -> dict[str, Any]:
        column = f"{name}.{quantity}"
        work = integral(self.trajectory, f"{name}.power") if column in self.peaks else None
        return {quantity: self.peak(column), "work": work}

    def _fluctuation(self, column: str) -> float | None:
        """Compute the range of a column over the magnitude of its mean; None where the mean is zero."""
        top, (mean, _) = extremes(self.trajectory, [column])[column], averages(self.trajectory, column)
        return (top.max - top.min) / abs(mean) if mean else None

    def _contacts(self, name: str) -> dict[str, Any]:
        """Count the contacts of a joint or gear, and compute the part of the time with at least one."""
        begin, end = float(self.trajectory.time[0]), float(self.trajectory.time[-1])
        rows = [row for row in self.touches if row.owner == name]
        total, until = 0.0, begin
        for row in sorted(rows, key=lambda row: row.start):
            last = min(row.start + row.duration, end)
            total += max(0.0, last - max(row.start, until))
            until = max(until, last)
        lasted = end - begin  # zero if the run failed at once
        fraction = total / lasted if lasted else float(bool(rows))
        return {"contact_fraction": fraction, "impacts": sum(begin <= row.start <= end for row in rows)}


def peak_columns(system: System) -> list[str]:
    """Name the columns of joints, drives, loads and deformable links whose peaks are in a summary.

    A run lacks the columns of other models.
    """
    return [
        *(f"{joint.name}.force" for joint in system.joints.values()),
        *(f"{name}.{quantity}" for name in system.play for quantity in ("eccentricity_ratio", "tilting_moment")),
        *(f"{name}.torque" for name in system.drives),
        *(f"{name}.{effort_of(system, table, name)}" for table, name in system.acting),
        *(column for _, own in peaks_of_models(system, "link") for column in own),
    ]


def peaks_of_models(system: System, part: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the joints or links that models give outputs, with the columns whose peaks are in a summary."""
    for kind, name, keys in all_elements_of(system.parts, OF_PARTS):
        found = kind.outputs_of(keys, system.slides) if kind.part == part else ()
        if own := [f"{name}.{key}" for outputs in found for key in outputs.peaks]:
            yield name, own


def effort_of(system: System, table: str, name: str) -> str:
    """Return the characteristic quantity of an applied load, element or contact."""
    if table in OF_ELEMENTS:
        kind, keys = OF_ELEMENTS[table], system.parts[table][name]
        return kind.outputs_of(keys, system.slides)[0].effort
    return "force"


def _labels(system: System, name: str) -> list[str]:
    """List the contacts of an element that has several."""
    return [label for owner, label in system.contacts if owner == name != label]
