"""A block of cycles with the profiles as they are: what wears where in a mean cycle, peaks, spread over the cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.engines.compiled.replay import Steps
from linkages.errors import InputError, Status
from linkages.explore.flow import Flow, lasting, period_of
from linkages.laws.wear.archard import SAMPLE, fill_moments
from linkages.laws.wear.profile import depth_of
from linkages.outputs.registry import JITTER, names
from linkages.system import System

Array = NDArray[np.float64]
#: Removed area per angle over the radius [m], bearing then journal, (2, n), of each joint that wears.
Removed = Mapping[str, Array]

_MOST = 16  # measured cycles of a block
_LEAST = 2
_SETTLING = 2  # cycles after the drive's ramp that are not measured
_FEW, _SAME = 5, 0.1
_UNLIKE, _ALIKE = 3.0, 1e-3  # difference of two halves that is too large: in standard errors, and of the mean
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
    samples : dict of (m, 7) arrays
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

    samples: dict[str, Array]
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
    for law, (name, _), model in zip(system.laws, system.tree.contacts, system.models, strict=True):
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
        If there are none, or the drive has no constant speed.
    """
    joints = wearing(system)
    if not joints:
        raise InputError(system.experiment.source, "joints", "none wears; give one a table [joints.NAME.wear]")
    period_of(system.experiment, drive)
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
        not, in which the contacts find the worn profiles, nor are four more of a motion that does not repeat.
    scatter : float
        Standard error of the mean work over that mean, of each joint, at which it is enough; at most 16 cycles, of
        which those are dropped that come before the motion is steady.
    drive : str, optional
        Whose revolutions; default the first of constant speed.
    single : bool
        Measure the first cycle after the start, and no other.
    """
    joints = wearing(system)
    period = period_of(system.experiment, drive)
    ramp = max((d.ramp for d in system.experiment.drives.values()), default=0.0)
    begin = int(np.ceil(ramp / period)) + _SETTLING  # cycles on the drive's clock at which blocks but the first begin
    first, lead = (0, begin) if start is None else (begin, 0 if single else 1)
    most = lead + (1 if single else _MOST)
    flow = Flow(lasting(worn_system(system, removed), first + most, drive))
    if start is not None:
        flow.resume(begin * period, start.y, start.memory, start.step)
    outputs = watched(system)
    found: dict[str, list[Array]] = {joint.name: [] for joint in joints}
    work: dict[str, list[float]] = {joint.name: [] for joint in joints}
    peaks: dict[str, list[float]] = {name: [] for name in outputs}
    done, dropped = 0, 0
    while flow.status is Status.OK and done < most:
        piece = flow.advance((first + done + 1) * period)
        if flow.status is not Status.OK:
            break
        done += 1
        if done <= lead:
            continue
        columns, weights = _sampled(flow, piece, outputs, joints)
        for name in outputs:
            peaks[name].append(float(np.abs(columns[name]).max()))
        for joint in joints:
            cycle = _samples(joint, columns, weights, system)
            found[joint.name].append(cycle)
            work[joint.name].append(float(cycle[:, SAMPLE.index("work")].sum()))
        if any(map(_drifts, work.values())):
            early = (done - lead - dropped) // 2
        else:
            early = _FEW - 1 if dropped == 0 and done - lead == _FEW else 0
        dropped += early
        for lists in (found, work, peaks):
            for values in lists.values():
                del values[:early]
        if all(_known(values, scatter) for values in work.values()):
            break
    end = Start(flow.y, flow.memory.copy(), flow.step)
    worn = {joint.name: depths_of(joint, removed[joint.name]) for joint in joints}
    samples = {
        joint.name: _thinned(joint, np.concatenate(lines), worn[joint.name], len(lines))
        for joint in joints
        if (lines := found[joint.name])
    }
    totals = {name: np.array(values) for name, values in work.items()}
    means = {name: float(np.mean(values)) if values else np.nan for name, values in peaks.items()}
    return Block(samples, totals, means, done, end, flow.status)


def depths_of(joint: Wearing, removed: Array) -> Array:
    """Control depths of bearing and journal [m], (2, n)."""
    return np.array([depth_of(lost, radius) for lost, radius in zip(removed, joint.radii, strict=True)])


def watched(system: System) -> list[str]:
    """Name outputs whose peaks are kept: forces in joints, drives' torques, jitter of the experiment's own outputs."""
    drives = system.experiment.drives
    found = [f"{name}.force" for name in system.tree.journals] + [f"{name}.torque" for name in drives]
    if system.determinate:
        known = set(names(system))
        found += [f"{name}{JITTER}" for name in system.experiment.outputs if name in known]
    return found


def _sampled(
    flow: Flow, piece: Steps, outputs: list[str], joints: tuple[Wearing, ...]
) -> tuple[dict[str, Array], Array]:
    """Compute outputs at the steps and halfway between them, and Simpson's weights of an integral over time [s]."""
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
    return flow.columns(piece, both, list(dict.fromkeys(wanted))), weights


def _samples(joint: Wearing, columns: Mapping[str, Array], weights: Array, system: System) -> Array:
    """Take the samples of a cycle, (m, 7), moments still to be filled."""
    lines = np.zeros((len(weights), len(SAMPLE)))
    for k, link in enumerate(joint.links):
        if link != "world":
            lines[:, k] = columns[f"{link}.angle"] - system.mechanism.point[link].angle
    lines[:, 2], lines[:, 3] = columns[f"{joint.name}.ex"], columns[f"{joint.name}.ey"]
    lines[:, 6] = weights * columns[f"{joint.name}.load"] * np.abs(columns[f"{joint.name}.sliding"])
    return lines[lines[:, 6] > 0.0]


def _drifts(values: list[float]) -> bool:
    """Whether the first half of some cycles is unlike the second: the motion was not steady yet."""
    half = len(values) // 2
    if half < _LEAST:
        return False
    old, new = np.array(values[:half]), np.array(values[half:])
    spread = np.hypot(np.std(old, ddof=1) / np.sqrt(len(old)), np.std(new, ddof=1) / np.sqrt(len(new)))
    return bool(abs(old.mean() - new.mean()) > max(_UNLIKE * spread, _ALIKE * new.mean()))


def _known(values: list[float], scatter: float) -> bool:
    """Whether the mean of some cycles is known well enough."""
    if len(values) < _LEAST:
        return False
    mean, deviation = float(np.mean(values)), float(np.std(values, ddof=1))
    if len(values) < _FEW:  # whose deviation means little: enough only of a motion that repeats
        return deviation <= _SAME * scatter * mean
    return deviation <= scatter * mean * np.sqrt(len(values))


def _thinned(joint: Wearing, lines: Array, depths: Array, cycles: int) -> Array:
    """Give samples the works of a mean cycle, and their moments; of many, keep `_SAMPLES` of equal work."""
    work = lines[:, 6]
    total = float(work.sum()) / cycles
    if len(lines) > _SAMPLES:
        reached = np.cumsum(work)
        aims = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * reached[-1]
        lines = lines[np.minimum(np.searchsorted(reached, aims), len(lines) - 1)]
        lines[:, 6] = 1.0
    fill_moments(lines, joint.reach, joint.radius - joint.clearance, depths)
    lines = lines[np.hypot(lines[:, 4], lines[:, 5]) > 0.0]
    if len(lines):
        lines[:, 6] *= total / lines[:, 6].sum()
    return lines
