"""A run as the numbers of the page: poses of the bodies, curves and orbits that it draws; its table of peaks.

Times in a view are counted from the start of the shown part of the run, so that views of different runs of one machine
lie on each other at the same phase of its drives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import Status
from linkages.input.model.output_names import QUANTITIES
from linkages.results.assessment import Assessment
from linkages.results.characteristics import numbers
from linkages.results.extremes import extremes, peaks
from linkages.results.outputs.registry import names, unit
from linkages.results.shape import peaks_by_key
from linkages.results.trajectory import Trajectory
from linkages.show.naming import output_in_words
from linkages.show.plots.drawing.drawing import Drawing
from linkages.show.plots.pages import columns, curves, short
from linkages.show.report.words import motion_lines
from linkages.system import System

FRAMES = 121  # poses of the moving picture; the page interpolates
_ORBIT = 600  # points of an orbit
_INTERVALS = 160  # parts of the time of a curve, see `linkages.show.plots.pages.seen`


def columns_of(system: System) -> list[str]:
    """Name the columns of a run that a view needs: all but the motions of frames that nobody has asked for."""
    shown = {f"{link.name}.{key}" for link in system.links.values() for key in ("x", "y", "angle", "omega")}
    shown |= set(system.settings.outputs)
    return [name for name in names(system) if name in shown or name.rpartition(".")[2] not in QUANTITIES]


def view(
    assessment: Assessment, exact: Trajectory | None, part: tuple[float, float], frames: Mapping[str, Array]
) -> dict[str, Any]:
    """Return the pictures of the page for a part of a run [s], ready for JSON.

    They are `status`, `periodic`, `from` and `to` [s], `time` of the frames of the moving picture, `curves`, `orbits`.
    The motion with ideal joints begins at the phase of the part; the frames are from `frames_of`.
    """
    system, run = assessment.system, assessment.run
    shown = run.within(*part)
    moved = replace(shown, time=shown.time - shown.time[0], evaluate=None)
    drawn = columns(system.settings.outputs, system.tree.play, system.actuators)
    return {
        "status": run.status.value,
        "remedy": "" if run.status is Status.OK else run.status.remedy,
        "periodic": assessment.motion.kind == "periodic",
        "from": part[0],
        "to": part[1],
        "time": short(np.linspace(0.0, part[1] - part[0], FRAMES)),
        "curves": curves(drawn, moved, exact, assessment.noise, _INTERVALS, _measured(assessment, part)),
        "orbits": [_orbit(system, name, shown, frames) for name in system.tree.play if f"{name}.ex" in run.columns],
    }


def _measured(assessment: Assessment, part: tuple[float, float]) -> dict[str, tuple[Array, Array]]:
    """Return the measured curves within a part of the run, over the time since its begin."""
    found = {}
    for name, one in assessment.measured.items():
        inside = (one.time >= part[0]) & (one.time <= part[1])
        if inside.any():
            found[name] = one.time[inside] - part[0], one.values[inside]
    return found


def frames_of(run: Trajectory, part: tuple[float, float]) -> Mapping[str, Array]:
    """Evaluate a run at the times of the frames of the moving picture, from the begin to the end of a part [s]."""
    return run.evaluate(np.linspace(*part, FRAMES)) if run.evaluate else {}


def numbers_for(assessment: Assessment, exact: Trajectory | None) -> dict[str, Any]:
    """Return the numbers of the page for a run, which can take longer than the run: `motion` (lines) and `table`."""
    run, span, report = assessment.run, assessment.windows.get(assessment.reported), assessment.reported
    part = run if span is None else run.within(*span)
    peaks = numbers(assessment.system, part, assessment.meaningless, assessment.contacts).content
    windows = {} if span is None else {report: {"from": span[0], "to": span[1], **peaks}}
    told = {
        "motion": assessment.motion.summary.content,
        "start_up": assessment.start_up,
        "duration": float(run.time[-1]),
    }
    about = {"report": report, "windows": windows, "no_ideal": assessment.no_ideal}
    lines = motion_lines(peaks | told | about)
    return {"motion": lines, "table": _table(assessment, peaks, exact)}


def _table(assessment: Assessment, peaks: dict[str, Any], exact: Trajectory | None) -> list[dict[str, Any]]:
    """Rows of the table: name, unit, peak, the ideal linkage's peak, and the spread of the peaks of single periods."""
    system = assessment.system
    perfect = {} if exact is None else peaks_by_key(numbers(system, exact, ()).content | {"links": {}})
    drives = {name: one for name, one in peaks["drives"].items() if one.get("acts", True)}
    listed = peaks_by_key(peaks | {"drives": drives, "loads": {}})
    shown = {name.removesuffix(".peak"): value for name, value in listed.items()}
    spreads = _spreads(assessment, [name for name, value in shown.items() if value is not None])
    none = {"least": None, "most": None}
    return [
        {"name": name, "label": output_in_words(name), "unit": unit(system, name)}
        | {"value": value, "ideal": perfect.get(f"{name}.peak")}
        | spreads.get(name, none)
        for name, value in shown.items()
    ]


def _spreads(assessment: Assessment, names: Sequence[str]) -> dict[str, dict[str, float | None]]:
    """Smallest and largest peak of the single periods after the start-up, where the motion is not periodic."""
    result: dict[str, dict[str, float | None]] = {name: {"least": None, "most": None} for name in names}
    period, run = assessment.motion.period, assessment.run
    there = [name for name in names if name in run.columns]
    if assessment.motion.kind == "periodic" or period is None:
        return result
    end = float(run.time[-1])
    first = assessment.start_up if assessment.start_up is not None and assessment.start_up < end - 2.0 * period else 0.0
    count = int((end - first) / period * (1.0 + 1e-9))
    if count < 2:
        return result
    edges = np.maximum(end - period * np.arange(count + 1)[::-1], 0.0)
    found = [peaks(run.within(*span), there) for span in pairwise(edges.tolist())]
    for name in there:
        values = [one[name].value for one in found]
        result[name] = {"least": min(values), "most": max(values)}
    return result


def _orbit(system: System, name: str, shown: Trajectory, frames: Mapping[str, Array]) -> dict[str, Any]:
    """Path of a journal's centre in parts of the clearance, its place in each frame, and the thinnest film [m]."""
    clearance = system.joints[name].clearance or 1.0
    keep = np.unique(np.linspace(0, len(shown.time) - 1, min(_ORBIT, len(shown.time))).astype(int))
    path = [short(shown[f"{name}.{axis}"][keep] / clearance) for axis in ("ex", "ey")]
    now = [short(frames.get(f"{name}.{axis}", np.zeros(0)) / clearance) for axis in ("ex", "ey")]
    turns, film = system.joints[name].type == "revolute", f"{name}.film_thickness"
    least = extremes(shown, [film])[film].min if film in shown else None
    return {"name": name, "clearance": clearance, "path": path, "now": now, "turns": turns, "film": least}


def joints_of(drawing: Drawing, system: System) -> dict[str, list[float]]:
    """Return the body of each joint in a drawing, and the place on it [m], by name."""
    bodies, found = {link: body for body, link in drawing.links_of.items()}, {}
    for name, pin in system.mechanism.pin.items():
        if pin.link in bodies:
            x, y, angle = drawing.reference[bodies[pin.link]].tolist()
            dx, dy, cos, sin = pin.origin[0] - x, pin.origin[1] - y, np.cos(angle), np.sin(angle)
            found[name] = [bodies[pin.link], float(cos * dx + sin * dy), float(cos * dy - sin * dx)]
    return found


def poses_of(drawing: Drawing, system: System, frames: Mapping[str, Array]) -> list[list[list[float | None]]]:
    """Return the poses (frames, bodies, 3) of the drawing's bodies: x, y [m], angle [rad].

    A flexible link moves with its frame, and its deflection is not drawn.
    """
    count = len(next(iter(frames.values()), ()))
    poses = np.repeat(drawing.pose[None], count, axis=0)
    for body, name in drawing.links_of.items():
        if name == "world" or f"{name}.x" not in frames:
            continue
        link = system.links[name]
        turn = frames[f"{name}.angle"] - link.angle
        cos, sin = np.cos(turn), np.sin(turn)
        dx, dy = drawing.reference[body, :2] - link.origin
        poses[:, body, 0] = frames[f"{name}.x"] + cos * dx - sin * dy
        poses[:, body, 1] = frames[f"{name}.y"] + sin * dx + cos * dy
        poses[:, body, 2] = drawing.reference[body, 2] + turn
    return short(poses)
