"""A block of cycles with constant profiles: loads of a mean cycle, peaks, scatter over the cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri, stdtrit

from linkages.base.arrays import Array
from linkages.base.errors import InputError, Status
from linkages.elements.analysis import Analysis
from linkages.engines.compiled.run.replay import Steps
from linkages.explore.flow import Flow, lasting, period_of
from linkages.explore.numerics import (
    MEASURE_ASPERITIES,
    MEASURE_NOTHING,
    MEASURE_SAMPLES,
    MEASURE_SETTLING,
    MEASURE_UNSETTLED,
)
from linkages.laws.wear.archard import SAMPLE, fill_moments
from linkages.laws.wear.profile import depth_of
from linkages.results.extremes import peaks
from linkages.results.outputs.registry import JITTER, has_jitter
from linkages.system import System

#: Removed area per angle over the radius [m], bearing then journal, (2, n), of each wearing joint.
Removed = Mapping[str, Array]
#: `linkages.laws.wear.archard.SAMPLE` of a mean cycle, (m, 7), of each wearing joint.
LoadSamples = Mapping[str, Array]

_MOST = 16  # most measured cycles of a block
_LEAST = 2
_ABOVE = 0.975  # quantile of Student's distribution (95 % two-sided)
_COUNTS = np.arange(_LEAST, _MOST + 1)
#: Factor on the standard error by the number of cycles (Student's distribution).
_STUDENT = dict(zip(_COUNTS.tolist(), stdtrit(_COUNTS - 1, _ABOVE) / ndtri(_ABOVE), strict=True))


@dataclass(frozen=True)
class BlockStart:
    """Start of a block.

    Attributes
    ----------
    y : array
        State at the end of a cycle; angles are less the whole turns since the start of the block's first later cycle.
    memory : (nc, 2) array
        Memory of the contacts.
    step : float
        Next step of the integrator [s].
    """

    y: Array
    memory: Array
    step: float


@dataclass(frozen=True)
class CycleBlock:
    """Measurements with given profiles.

    Attributes
    ----------
    loads : dict of (m, 7) arrays
        `linkages.laws.wear.archard.SAMPLE` of a mean cycle, by joint.
    work : dict of (nc,) arrays
        Integral of N |v_t| dt over each measured cycle, by joint [N m].
    peaks : dict of str to float
        Largest magnitude of outputs in a cycle, over continuous time; mean over the measured cycles.
    cycles : int
        All simulated cycles, including the unmeasured ones.
    end : BlockStart
        Start of the next block.
    status : Status
    """

    loads: dict[str, Array]
    work: dict[str, Array]
    peaks: dict[str, float]
    cycles: int
    end: BlockStart
    status: Status


@dataclass(frozen=True)
class Wearing:
    """The data of a wearing joint."""

    name: str
    clearance: float
    radius: float  # radius of the bearing [m]
    length: float
    coefficients: tuple[float, float]  # wear coefficients of bearing and journal [m2/N]
    reach: float  # clearance at which load is carried, reduced by the asperities [m]
    links: tuple[str, str]  # links of bearing and journal

    @property
    def radii(self) -> tuple[float, float]:
        """Return the radius of the bearing, and the negative radius of the journal [m]."""
        return self.radius, self.clearance - self.radius


def wearing(system: System) -> tuple[Wearing, ...]:
    """Return the wearing joints of a system."""
    found = []
    for law, (name, _), model in zip(system.laws, system.tree.contacts, system.models, strict=False):
        if model.wear is None:
            continue
        joint, clearance = system.joints[name], float(law["clearance"])
        reach = clearance - MEASURE_ASPERITIES * float(law["roughness"])
        links = joint.parent, joint.child
        size = float(law["radius"]), float(law["length"])
        found.append(Wearing(name, clearance, *size, model.wear.coefficients, reach, links))
    return tuple(found)


def check_wears(system: System, drive: str | None = None) -> tuple[Wearing, ...]:
    """Return the wearing joints of a system with a periodic drive.

    InputError if no joint wears, a model does not support it, or the drive is not periodic.
    """
    system.check_analysis(Analysis.WEAR)
    joints = wearing(system)
    if not joints:
        raise InputError(system.description.source, "joints", "no joint wears; give one a table [joints.NAME.wear]")
    period_of(system, drive)
    return joints


def worn_system(system: System, removed: Removed) -> System:
    """Return the system with given profiles."""
    values = {}
    for joint in wearing(system):
        for side, radius, lost in zip(("bearing", "journal"), joint.radii, removed[joint.name], strict=True):
            depths = depth_of(lost, radius)
            values[f"joints.{joint.name}.wear.{side}_depth"] = np.where(depths < MEASURE_NOTHING, 0.0, depths).tolist()
    return system.replaced(values)


def measure(
    system: System,
    removed: Removed,
    start: BlockStart | None,
    scatter: float,
    drive: str | None = None,
    single: bool = False,
) -> CycleBlock:
    """Simulate cycles with given profiles until their mean work has a required standard error.

    By default the block begins at the experiment's start, without measurement during the drive's ramp and two more
    cycles. A later block skips one cycle, in which the contacts adapt to the profiles. `scatter` is the relative
    standard error of the mean work of each joint, multiplied by Student's factor for few cycles. The first cycles are
    dropped if the others suffice without them; after 16 cycles the last 12 are used. With `single` only the first cycle
    after the start is measured.
    """
    joints = wearing(system)
    period = period_of(system, drive)
    ramp = system.ramp
    begin = int(np.ceil(ramp / period)) + MEASURE_SETTLING  # first cycle of later blocks, counted by the drive
    first, lead = (0, begin) if start is None else (begin, 0 if single else 1)
    most = lead + (1 if single else _MOST)
    flow = Flow(lasting(worn_system(system, removed), first + most, drive))
    if start is not None:
        flow.resume(begin * period, start.y, start.memory, start.step)
    outputs, cycles = watched(system), list[_Cycle]()
    done, kept, before = 0, 0, flow.y
    while flow.status is Status.OK and done < most and kept == 0:
        piece = flow.advance((first + done + 1) * period)
        if flow.status is Status.OK:
            done += 1
            before = flow.y if first + done == begin else before
            if done > lead:
                cycles.append(_cycle(flow, piece, outputs, joints))
                kept = _settled(_works(cycles), scatter)
    if kept > 0 or len(cycles) == _MOST:
        cycles = cycles[-kept or MEASURE_UNSETTLED :]
    end = BlockStart(_unwound(flow, before), flow.memory.copy(), flow.step)
    if not cycles:
        return CycleBlock({}, {}, dict.fromkeys(outputs, np.nan), done, end, flow.status)
    loads = {
        joint.name: _thinned(joint, lines, depths_of(joint, removed[joint.name]), len(cycles))
        for joint, lines in zip(
            joints, map(np.concatenate, zip(*(c.samples for c in cycles), strict=True)), strict=True
        )
    }
    work = {joint.name: values for joint, values in zip(joints, _works(cycles).T, strict=True)}
    means = np.mean([cycle.peaks for cycle in cycles], axis=0).tolist()
    return CycleBlock(loads, work, dict(zip(outputs, means, strict=True)), done, end, flow.status)


def _unwound(flow: Flow, before: Array) -> Array:
    """Return the state of a run with its angles less the whole turns since a state `before`.

    With it a run can start at the time of that state: driven angles have their values there, and loops are closed.
    """
    tree, turns = flow.system.tree, np.zeros(len(before))
    angles = tree.free_angles
    turns[angles] = 2.0 * np.pi * np.round((flow.y - before)[angles] / (2.0 * np.pi))
    return flow.y - turns


def depths_of(joint: Wearing, removed: Array) -> Array:
    """Return the control depths of bearing and journal [m], (2, n)."""
    return np.array([depth_of(lost, radius) for lost, radius in zip(removed, joint.radii, strict=True)])


def watched(system: System) -> list[str]:
    """List outputs with recorded peaks: joint forces, drive torques, the experiment's outputs.

    For outputs of points the jitter is recorded, if the drives determine the ideal motion.
    """
    drives = system.drives
    found = [f"{name}.force" for name in system.tree.journals] + [f"{name}.torque" for name in drives]
    found += [f"{name}{JITTER}" if has_jitter(system, name) else name for name in system.settings.outputs]
    return list(dict.fromkeys(found))


class _Cycle(NamedTuple):
    samples: list[Array]  # samples of each wearing joint, with moments to be filled
    peaks: list[float]  # peaks of each recorded output


def _cycle(flow: Flow, piece: Steps, outputs: list[str], joints: tuple[Wearing, ...]) -> _Cycle:
    """Measure at a cycle's steps and halfway between them, and integrate over time by Simpson's rule."""
    wanted = [*outputs]
    for joint in joints:
        wanted += [f"{joint.name}.{what}" for what in ("ex", "ey", "load", "sliding")]
        wanted += [f"{link}.angle" for link in joint.links if link != "world"]
    wanted = list(dict.fromkeys(wanted))
    run = flow.sampled(piece, wanted)
    middles = flow.columns(piece, 0.5 * (run.time[1:] + run.time[:-1]), wanted)
    places, h = np.arange(1, len(run.time)), np.diff(run.time) / 6.0
    weights = np.insert(np.convolve(h, [1.0, 1.0]), places, 4.0 * h)
    columns = {name: np.insert(values, places, middles[name]) for name, values in run.columns.items()}
    samples = [_samples(joint, columns, weights, flow.system) for joint in joints]
    return _Cycle(samples, [peak.value for peak in peaks(run, outputs).values()])


def _works(cycles: list[_Cycle]) -> Array:
    """Compute the integral of N |v_t| dt over each cycle [N m], (nc, nj)."""
    return np.array([[lines[:, 6].sum() for lines in cycle.samples] for cycle in cycles])


def _samples(joint: Wearing, columns: Mapping[str, Array], weights: Array, system: System) -> Array:
    """Take the samples of a cycle, (m, 7), with moments to be filled."""
    lines = np.zeros((len(weights), len(SAMPLE)))
    for k, link in enumerate(joint.links):
        if link != "world":
            lines[:, k] = columns[f"{link}.angle"] - system.points[link].angle
    lines[:, 2], lines[:, 3] = columns[f"{joint.name}.ex"], columns[f"{joint.name}.ey"]
    lines[:, 6] = weights * columns[f"{joint.name}.load"] * np.abs(columns[f"{joint.name}.sliding"])
    return lines[lines[:, 6] > 0.0]


def _settled(works: Array, scatter: float) -> int:
    """Return the number of last cycles whose mean works (nc, nj) are accurate enough; 0 if none."""
    for count in range(len(works), _LEAST - 1, -1):
        last = works[-count:]
        if np.all(_STUDENT[count] * np.std(last, axis=0, ddof=1) <= scatter * np.sqrt(count) * last.mean(axis=0)):
            return count
    return 0


def equal_works(lines: Array) -> Array:
    """Reduce many samples to representatives of equal work; few samples are unchanged."""
    if len(lines) <= MEASURE_SAMPLES:
        return lines
    reached = np.cumsum(lines[:, 6])
    aims = (np.arange(MEASURE_SAMPLES) + 0.5) / MEASURE_SAMPLES * reached[-1]
    kept = lines[np.minimum(np.searchsorted(reached, aims), len(lines) - 1)]
    kept[:, 6] = reached[-1] / MEASURE_SAMPLES
    return kept


def _thinned(joint: Wearing, lines: Array, depths: Array, cycles: int) -> Array:
    """Scale samples to a mean cycle, fill their moments, and keep at most `MEASURE_SAMPLES`."""
    total = float(lines[:, 6].sum()) / cycles
    lines = equal_works(lines)
    fill_moments(lines, joint.reach, joint.radius - joint.clearance, depths)
    lines = lines[np.hypot(lines[:, 4], lines[:, 5]) > 0.0]
    if len(lines):
        lines[:, 6] *= total / lines[:, 6].sum()
    return lines
