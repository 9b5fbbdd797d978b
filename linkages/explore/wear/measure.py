"""A block of cycles with the profiles as they are: what wears where in a mean cycle, peaks, spread over the cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri, stdtrit

from linkages.arrays import Array
from linkages.engines.compiled.replay import Steps
from linkages.errors import InputError, Status
from linkages.explore.flow import Flow, lasting, period_of
from linkages.laws.wear.archard import SAMPLE, fill_moments
from linkages.laws.wear.profile import depth_of
from linkages.outputs.registry import JITTER, has_jitter
from linkages.system import System

#: Removed area per angle over the radius [m], bearing then journal, (2, n), of each joint that wears.
Removed = Mapping[str, Array]
#: `linkages.laws.wear.archard.SAMPLE` of a mean cycle, (m, 7), of each joint that wears.
Loads = Mapping[str, Array]

_MOST = 16  # measured cycles of a block
_LEAST = 2
_SETTLING = 2  # cycles after the drive's ramp that are not measured
_UNSETTLED = 4  # cycles of a block that are dropped where it does not settle
_ABOVE = 0.975  # where Student's distribution is taken: 95 % lie between both its ends
_COUNTS = np.arange(_LEAST, _MOST + 1)
#: Factor of the standard error of so many cycles: their deviation is itself uncertain.
_STUDENT = dict(zip(_COUNTS.tolist(), stdtrit(_COUNTS - 1, _ABOVE) / ndtri(_ABOVE), strict=True))
_SAMPLES = 600  # kept of a block, for each joint
_NOTHING = 1e-30  # depth that is none [m]: an experiment takes no number so small
_ASPERITIES = 4.0  # standard deviations of the roughness at which asperities carry load


@dataclass(frozen=True)
class Start:
    """Where a block begins: a state at the end of a cycle, what the contacts remember, the step to try [s]."""

    y: Array
    memory: Array
    step: float


@dataclass(frozen=True)
class Block:
    """What was measured with given profiles.

    Attributes
    ----------
    loads : dict of (m, 7) arrays
        `linkages.laws.wear.archard.SAMPLE` of a mean cycle, by joint.
    work : dict of (nc,) arrays
        Integral of N |v_t| dt over each measured cycle [N m], by joint.
    peaks : dict of float
        Largest magnitude of outputs in a cycle, at its steps and halfway between them; the mean of the measured cycles.
    cycles : int
        All that were simulated, those before the measured ones too.
    end : Start
        Where the next block begins.
    status : Status
    """

    loads: dict[str, Array]
    work: dict[str, Array]
    peaks: dict[str, float]
    cycles: int
    end: Start
    status: Status


@dataclass(frozen=True)
class Wearing:
    """A joint that wears, as numbers."""

    name: str
    clearance: float
    radius: float  # of the bearing [m]
    length: float
    coefficients: tuple[float, float]  # of bearing and journal [m2/N]
    reach: float  # clearance at which load is carried: asperities stand out [m]
    links: tuple[str, str]  # of bearing and journal

    @property
    def radii(self) -> tuple[float, float]:
        """Radius of bearing and, negative, of journal [m]."""
        return self.radius, self.clearance - self.radius


def wearing(system: System) -> tuple[Wearing, ...]:
    """Joints of a system that wear."""
    found = []
    for law, (name, _), model in zip(system.laws, system.tree.contacts, system.models, strict=False):
        if model.wear is None:
            continue
        joint, clearance = system.mechanism.joint[name], float(law["clearance"])
        reach = clearance - _ASPERITIES * float(law["roughness"])
        links = joint.parent, joint.child
        size = float(law["radius"]), float(law["length"])
        found.append(Wearing(name, clearance, *size, model.wear.coefficients, reach, links))
    return tuple(found)


def check_wears(system: System, drive: str | None = None) -> tuple[Wearing, ...]:
    """Return the joints that wear while a drive turns.

    Raises
    ------
    InputError
        If there are none, or the drive does not repeat its motion.
    """
    joints = wearing(system)
    if not joints:
        raise InputError(system.experiment.source, "joints", "none wears; give one a table [joints.NAME.wear]")
    period_of(system, drive)
    return joints


def worn_system(system: System, removed: Removed) -> System:
    """Return the system with these profiles."""
    values = {}
    for joint in wearing(system):
        for side, radius, lost in zip(("bearing", "journal"), joint.radii, removed[joint.name], strict=True):
            depths = depth_of(lost, radius)
            values[f"joints.{joint.name}.wear.{side}_depth"] = np.where(depths < _NOTHING, 0.0, depths).tolist()
    return system.replaced(values)


def measure(
    system: System,
    removed: Removed,
    start: Start | None,
    scatter: float,
    drive: str | None = None,
    single: bool = False,
) -> Block:
    """Simulate cycles with given profiles, until their mean work is known to a standard error.

    Parameters
    ----------
    system : System
    removed : mapping of (2, n) arrays
        The profiles.
    start : Start, optional
        Default the experiment's start: the ramp of the drive and two cycles more are not measured. Later one cycle is
        not, in which the contacts find the worn profiles.
    scatter : float
        Standard error of the mean work over that mean, of each joint, at which it is enough; larger by Student's factor
        where there are few cycles. The first cycles are dropped if the others are enough without them alone; after 16
        the last 12 must do.
    drive : str, optional
        Whose revolutions, or periods; default: as `linkages.explore.flow.period_of`.
    single : bool
        Measure the first cycle after the start, and no other.
    """
    joints = wearing(system)
    period = period_of(system, drive)
    ramp = max((d.ramp for d in system.experiment.drives.values()), default=0.0)
    begin = int(np.ceil(ramp / period)) + _SETTLING  # cycles on the drive's clock at which blocks but the first begin
    first, lead = (0, begin) if start is None else (begin, 0 if single else 1)
    most = lead + (1 if single else _MOST)
    flow = Flow(lasting(worn_system(system, removed), first + most, drive))
    if start is not None:
        flow.resume(begin * period, start.y, start.memory, start.step)
    outputs, cycles = watched(system), list[_Cycle]()
    done, kept = 0, 0
    while flow.status is Status.OK and done < most and kept == 0:
        piece = flow.advance((first + done + 1) * period)
        if flow.status is Status.OK:
            done += 1
            if done > lead:
                cycles.append(_cycle(flow, piece, outputs, joints))
                kept = _settled(_works(cycles), scatter)
    if kept > 0 or len(cycles) == _MOST:
        cycles = cycles[-kept or _UNSETTLED :]
    end = Start(flow.y, flow.memory.copy(), flow.step)
    if not cycles:
        return Block({}, {}, dict.fromkeys(outputs, np.nan), done, end, flow.status)
    loads = {
        joint.name: _thinned(joint, lines, depths_of(joint, removed[joint.name]), len(cycles))
        for joint, lines in zip(
            joints, map(np.concatenate, zip(*(c.samples for c in cycles), strict=True)), strict=True
        )
    }
    work = {joint.name: values for joint, values in zip(joints, _works(cycles).T, strict=True)}
    peaks = np.mean([cycle.peaks for cycle in cycles], axis=0)
    return Block(loads, work, dict(zip(outputs, peaks.tolist(), strict=True)), done, end, flow.status)


def depths_of(joint: Wearing, removed: Array) -> Array:
    """Control depths of bearing and journal [m], (2, n)."""
    return np.array([depth_of(lost, radius) for lost, radius in zip(removed, joint.radii, strict=True)])


def watched(system: System) -> list[str]:
    """Name outputs whose peaks are kept: forces in joints, drives' torques, the experiment's own outputs.

    The peak of an output of a point is that of its jitter, where the drives determine the ideal motion.
    """
    drives = system.experiment.drives
    found = [f"{name}.force" for name in system.tree.journals] + [f"{name}.torque" for name in drives]
    found += [f"{name}{JITTER}" if has_jitter(system, name) else name for name in system.experiment.outputs]
    return list(dict.fromkeys(found))


class _Cycle(NamedTuple):
    """What was measured in a cycle."""

    samples: list[Array]  # of each joint that wears, moments still to be filled
    peaks: list[float]  # of each output that is watched


def _cycle(flow: Flow, piece: Steps, outputs: list[str], joints: tuple[Wearing, ...]) -> _Cycle:
    """Measure at a cycle's steps and halfway between them, and integrate over time by Simpson's rule."""
    times = np.unique(piece.times)
    both = np.empty(2 * len(times) - 1)
    both[::2], both[1::2] = times, 0.5 * (times[1:] + times[:-1])
    weights, h = np.zeros(len(both)), np.diff(times) / 6.0
    weights[:-2:2] += h
    weights[1::2] += 4.0 * h
    weights[2::2] += h
    wanted = [*outputs]
    for joint in joints:
        wanted += [f"{joint.name}.{what}" for what in ("ex", "ey", "load", "sliding")]
        wanted += [f"{link}.angle" for link in joint.links if link != "world"]
    columns = flow.columns(piece, both, list(dict.fromkeys(wanted)))
    samples = [_samples(joint, columns, weights, flow.system) for joint in joints]
    return _Cycle(samples, [float(np.abs(columns[name]).max()) for name in outputs])


def _works(cycles: list[_Cycle]) -> Array:
    """Integral of N |v_t| dt over each cycle [N m], (nc, nj)."""
    return np.array([[lines[:, 6].sum() for lines in cycle.samples] for cycle in cycles])


def _samples(joint: Wearing, columns: Mapping[str, Array], weights: Array, system: System) -> Array:
    """Take the samples of a cycle, (m, 7), moments still to be filled."""
    lines = np.zeros((len(weights), len(SAMPLE)))
    for k, link in enumerate(joint.links):
        if link != "world":
            lines[:, k] = columns[f"{link}.angle"] - system.mechanism.point[link].angle
    lines[:, 2], lines[:, 3] = columns[f"{joint.name}.ex"], columns[f"{joint.name}.ey"]
    lines[:, 6] = weights * columns[f"{joint.name}.load"] * np.abs(columns[f"{joint.name}.sliding"])
    return lines[lines[:, 6] > 0.0]


def _settled(works: Array, scatter: float) -> int:
    """How many of the last cycles give means of all works (nc, nj) that are known well enough; 0 if none do."""
    for count in range(len(works), _LEAST - 1, -1):
        last = works[-count:]
        if np.all(_STUDENT[count] * np.std(last, axis=0, ddof=1) <= scatter * np.sqrt(count) * last.mean(axis=0)):
            return count
    return 0


def equal_works(lines: Array) -> Array:
    """Of many samples some that stand for the same part of the work each; few as they are."""
    if len(lines) <= _SAMPLES:
        return lines
    reached = np.cumsum(lines[:, 6])
    aims = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * reached[-1]
    kept = lines[np.minimum(np.searchsorted(reached, aims), len(lines) - 1)]
    kept[:, 6] = reached[-1] / _SAMPLES
    return kept


def _thinned(joint: Wearing, lines: Array, depths: Array, cycles: int) -> Array:
    """Give samples the works of a mean cycle, and their moments; of many, keep `_SAMPLES`."""
    total = float(lines[:, 6].sum()) / cycles
    lines = equal_works(lines)
    fill_moments(lines, joint.reach, joint.radius - joint.clearance, depths)
    lines = lines[np.hypot(lines[:, 4], lines[:, 5]) > 0.0]
    if len(lines):
        lines[:, 6] *= total / lines[:, 6].sum()
    return lines
