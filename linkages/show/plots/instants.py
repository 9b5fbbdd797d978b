"""The instants that frames of magnified joints show, and the motion of journals and blocks at them; without Drake."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.tree import CORNERS

GAP = 0.4  # drawn clearance over the view's radius
LENGTH, HEIGHT = 0.8, 0.3  # half the drawn block's sides over the view's radius


def strongest(run: Trajectory, name: str, times: Array) -> Array:
    """Find the time of a joint's largest force within each frame; the frame's time if it has no step."""
    force, result = run[f"{name}.force"], times.copy()
    for k, (first, last) in enumerate(_windows(run.time, times)):
        if last > first:
            result[k] = run.time[first + int(np.argmax(force[first:last]))]
    return result


def closed(run: Trajectory, name: str, times: Array) -> NDArray[np.bool_]:
    """Check whether a contact is closed at a step within each frame, or at the frame's time."""
    depth = run.columns.get(f"{name}.penetration")
    if depth is None:
        return np.zeros(len(times), dtype=bool)
    steps = np.array([np.any(depth[first:last] > 0.0) for first, last in _windows(run.time, times)])
    return steps | (np.interp(times, run.time, depth) > 0.0)


def _windows(steps: Array, times: Array) -> list[tuple[int, int]]:
    """Return the first step of each frame and of the next; a frame extends halfway to its neighbours."""
    edges = np.concatenate([times[:1], 0.5 * (times[1:] + times[:-1]), times[-1:]])
    places = np.searchsorted(steps, edges)
    places[-1] = len(steps)
    return list(zip(places[:-1].tolist(), places[1:].tolist(), strict=True))


@dataclass(frozen=True)
class JournalFrames:
    """The motion of a journal, frame by frame."""

    e: Array  # (n, 2) eccentricity over clearance, plane axes [1]
    force: Array  # (n, 2) force on the journal [N]
    touching: NDArray[np.bool_]  # (n,) whether journal and bearing touch within the frame
    journal: Array  # (n,) angle of the body with the journal [rad]
    bearing: Array  # (n,) angle of the body with the bearing [rad]


def journal_frames(system: System, run: Trajectory, name: str, times: Array) -> JournalFrames:
    """Compute the journal's motion at the instant of the largest force in each frame."""
    joint = system.joints[name]
    moments = strongest(run, name, times)
    clearance = system.joints[name].clearance or 0.0

    def vector(symbol: str) -> Array:
        return np.stack([np.interp(moments, run.time, run[f"{name}.{symbol}{axis}"]) for axis in "xy"], axis=1)

    def angle(body: str) -> Array:
        return np.zeros(len(times)) if body == "world" else np.interp(times, run.time, run[f"{body}.angle"])

    e, force = vector("e") / clearance, vector("f")
    return JournalFrames(e, force, closed(run, name, times), angle(joint.child), angle(joint.parent))


@dataclass(frozen=True)
class GuideFrames:
    """The motion of a block in its slot, frame by frame."""

    offset: Array  # (n,) offset of the block's middle, over the clearance [1]
    tilt: Array  # (n,) additional offset of its end, over the clearance [1]
    force: Array  # (n, 2) force on the block, along and across the slot [N]
    touching: NDArray[np.bool_]  # (n, 4) whether each corner touches within the frame


def guide_frames(system: System, run: Trajectory, name: str, times: Array) -> GuideFrames:
    """Compute the block's motion at the instant of the largest force in each frame."""
    joint = system.joints[name]
    moments = strongest(run, name, times)
    clearance = system.joints[name].clearance or 0.0
    half = 0.5 * joint.slot.length if joint.slot is not None else 0.0

    def at(column: str) -> Array:
        return np.interp(moments, run.time, run[column])

    angle = np.full(len(times), np.arctan2(joint.direction[1], joint.direction[0]))
    if joint.parent != "world":
        angle += at(f"{joint.parent}.angle") - system.links[joint.parent].angle
    fx, fy, c, s = at(f"{name}.fx"), at(f"{name}.fy"), np.cos(angle), np.sin(angle)
    return GuideFrames(
        at(f"{name}.offset") / clearance,
        half * at(f"{name}.tilt") / clearance,
        np.stack([c * fx + s * fy, c * fy - s * fx], axis=1),
        np.stack([closed(run, f"{name}.corner{k + 1}", times) for k in range(len(CORNERS))], axis=1),
    )
