"""The return map of a linkage over whole periods of its drives, with exact derivatives.

The state at the section consists of minimal coordinates (`linkages.explore.local_coordinates`), and of the approach
speeds that contacts remember. Such a speed is an unknown if the contact is closed at the section and begins anew
within the period; otherwise it has no effect, or keeps its value. States that no formula reads keep theirs. Revolute
coordinates that advance by whole turns in a period are compared without these turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.elements.analysis import Analysis
from linkages.engines.compiled.derivatives.sensitivity import differentiate
from linkages.engines.compiled.run.linear import closure_at
from linkages.engines.compiled.run.model import per_length
from linkages.engines.compiled.run.replay import Steps
from linkages.explore.flow import Flow
from linkages.explore.linearisation import extrapolated
from linkages.explore.local_coordinates import LocalCoordinates, local_coordinates
from linkages.explore.numerics import (
    RETURN_MAP_AMPLE,
    RETURN_MAP_APART,
    RETURN_MAP_LIFTED,
    RETURN_MAP_LIFTS,
    RETURN_MAP_LOOSE,
    RETURN_MAP_STEPS,
)
from linkages.explore.periodic.continuation import Residual
from linkages.explore.periodic.multipliers import Multipliers, multipliers
from linkages.explore.sections import Section, recorded
from linkages.laws.states import LATCHED, LATCHED_NAMES
from linkages.mechanics.planar.contact_memory import restore_memory
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS, RATES
from linkages.results.outputs.registry import pack
from linkages.results.steady_state import common_period
from linkages.system import System


@dataclass(frozen=True, eq=False)
class Passage:
    """One passage of the return map.

    Attributes
    ----------
    system : System
    period, start : float
        Time of the passage and of its start [s].
    y : (ny,) array
        State at the start, see `linkages.explore.flow.Flow`.
    memory : array
        Memory of the contacts at the start.
    monodromy : (n, n) array
        Derivative of the state at the end with respect to the state at the start.
    multipliers : (n,) array
        Floquet multipliers; NaN if an impact grazes.
    contacts : tuple of int
        For each contact that can touch, how often it begins; -1 if it stays closed.
    """

    system: System
    period: float
    start: float
    y: Array
    memory: Array
    monodromy: Array
    multipliers: Multipliers
    contacts: tuple[int, ...]

    def section(self, names: Sequence[str], revolutions: int) -> Section:
        """Run once more, and compute outputs at the end of each of the revolutions and their extremes within."""
        pack(self.system, names)
        flow = Flow(self.system)
        flow.resume(self.start, self.y, self.memory, 0.0)
        return recorded(flow, self.start, self.period / revolutions, names, revolutions)


class ReturnMap:
    """The return map of a linkage, as equations of its fixed point: the state at the section, and the value at a path.

    `start` (nx,) is the state at the section after the transient, or the given state with the memory of the contacts;
    `names` are its entries, ``approach.CONTACT`` of approach speeds; `error` (nx,) is their scale in the engine's error
    control. A passage takes `periods` common periods of the drives, each a `period` [s] at the first value. InputError
    if the drives have no common period, or nothing is free; RunError if the transient fails.
    """

    def __init__(
        self,
        system: System,
        path: str | None,
        periods: int,
        transient: int,
        accuracy: float,
        given: tuple[Array, Array] | None = None,
    ) -> None:
        system.check_analysis(Analysis.PERIODIC)
        self._system = system.replaced({"solver.accuracy": min(accuracy, system.settings.accuracy)})
        self._path, self.periods = path, periods
        period = self._period(None if path is None else system.value(path))
        #: Periods before the section: a drive must have its speed; at t = 0 a run resets what contacts remember.
        self._first = 1 + int(np.ceil(system.ramp / period))
        transient = max(transient, self._first)
        self._flows: dict[float | None, tuple[Flow, float]] = {}
        flow, period = self._flow(None if path is None else system.value(path), transient + 1)
        self.period = period
        turns = system.tree.free_angles
        if given is None:
            flow.reach((transient - 1) * period)
            last = flow.reach(transient * period)
            self._range = np.ptp(last.states, axis=0)
            whole = np.round((flow.y - last.states[0])[turns] / (2.0 * np.pi))
            flow.y[turns] -= 2.0 * np.pi * whole * (transient - self._first)  # loops may close at one angle alone
        else:
            self._range = np.zeros(len(flow.y))
            flow.resume(transient * period, *given, 0.0)
        self._local = self._coordinates(flow, self._first * period, flow.y)
        self._unread = {f"s.{name}" for name in system.unread_states}
        if self._unread.issuperset(self._local.names):
            problem = "they determine the whole motion, so every motion is periodic"
            raise InputError(system.description.source, "drives", problem)
        model = flow.runner.model
        self._reference = flow.y.copy()
        self._memory = flow.memory.copy()
        #: Contact, and place in its memory, of each latched state that counts.
        self._latched = np.nonzero((model.touching == 1)[:, None] & np.isfinite(flow.memory[:, :LATCHED]))
        contact, place = self._latched
        self._range = self._range[self._local.entries]
        self.start = np.concatenate([flow.y[self._local.entries], self._memory[self._latched]])
        speeds = system.motion_rate * np.maximum(system.laws["clearance"][contact], 1e-9 * system.tree.extent)
        self.error = np.concatenate([flow.scale[self._local.entries], speeds])
        self._turning = np.flatnonzero(np.isin(self._local.entries, turns))
        latched = (f"{LATCHED_NAMES[i]}.{system.contacts[k][1]}" for k, i in zip(contact, place, strict=True))
        self.names = (*self._local.names, *latched)
        self._turns: Array | None = None

    def sizes(self, clearance: float) -> Array:
        """Return a usual change of each entry (nx,): some clearances in the time of the motion, or else its range."""
        length = RETURN_MAP_AMPLE * clearance
        if length == np.inf:
            state = np.where(self._range > 0.0, self._range, self.error[: len(self._local.entries)])
            return np.concatenate([state, RETURN_MAP_APART * self.error[len(state) :]])
        rate = max(self._system.motion_rate, 2.0 * np.pi / self.period)
        position = length * per_length(self._system)
        of_laws = np.full(len(self._system.law_states.names), self.error.min())
        own = self._system.state_scales * length / self._system.tree.extent
        state = np.concatenate([position, rate * position, of_laws, own])[self._local.entries]
        return np.concatenate([state, np.full(len(self._latched[0]), RETURN_MAP_APART * rate * length)])

    def _flow(self, value: float | None, periods: int) -> tuple[Flow, float]:
        """Return a flow for a value, and the common period of its drives."""
        period = self._period(value)
        longest = min(self._system.settings.max_step or np.inf, period / RETURN_MAP_STEPS)
        changed: dict[str, float] = {"duration": periods * period, "solver.max_step": longest}
        if self._path is not None and value is not None:
            changed[self._path] = value
        return Flow(self._system.replaced(changed)), period

    def _period(self, value: float | None) -> float:
        """Return the common period of the drives at a value [s]."""
        given = self._system if self._path is None or value is None else self._system.replaced({self._path: value})
        period = common_period(given)
        if period is None:
            where = self._system.description.source
            raise InputError(where, "drives", "have no common period, or loads depend on time: no motion is periodic")
        return period

    def __call__(self, x: Array, value: float) -> Residual:
        """Return the change of the state x at the section by the passage, less whole turns, with its derivatives.

        Its detail is the `Passage`. RunError if it fails.
        """
        begin = self._first
        if value not in self._flows:
            self._flows = {value: self._flow(value, begin + self.periods)}
        flow, period = self._flows[value]
        first, last = begin * period, (begin + self.periods) * period
        memory = self._memory.copy()
        memory[self._latched] = x[len(self._local.entries) :]
        y = self._lifted(flow, first, x[: len(self._local.entries)])
        flow.resume(first, y, memory, 0.0)
        steps = flow.reach(last)
        return self._returned(flow, period, steps, x, value)

    def _returned(self, flow: Flow, period: float, steps: Steps, x: Array, value: float) -> Residual:
        """Differentiate a passage and collect its result."""
        local, latched, runner = self._local, self._latched, flow.runner
        nx, ny, nm = len(local.entries), len(flow.y), len(latched[0])
        paths = () if self._path is None else (self._path,)
        tangent = self._coordinates(flow, steps.times[0], steps.states[0], local).tangent
        columns = np.zeros((ny, nx + nm + len(paths)))
        columns[:, :nx] = tangent
        nc, rows = len(runner.model.ends), LATCHED * latched[0] + latched[1]
        remembered = np.zeros((nc * LATCHED, columns.shape[1]))
        remembered[rows, nx + np.arange(nm)] = 1.0
        found = differentiate(runner, steps, paths, columns, remembered)
        end = np.concatenate([flow.y[local.entries], flow.memory[latched]])
        whole = np.vstack([found.states[-1][local.entries], found.memory[-1][rows]])
        monodromy, by_p = whole[:, : nx + nm], np.zeros(nx + nm)
        if paths:
            slope = self._period_slope(value)
            by_p = whole[:, -1].copy()
            if slope:
                rates = [_rate(flow, steps, t) for t in steps.times[[0, -1]]]
                early = whole[:, :nx] @ rates[0][local.entries] * self._first
                late = np.concatenate([rates[1][local.entries], np.zeros(nm)]) * (self._first + self.periods)
                by_p += (late - early) * slope
        begins = np.array([np.count_nonzero(found.event == k + 1) for k in range(nc)])
        depth = runner.evaluate(steps, steps.times[:1])[3][0, :, CLEARANCE_OUTPUTS.index("penetration")]
        read = np.array([name not in self._unread for name in local.names])
        kept = np.concatenate([read, (begins > 0)[latched[0]] & (depth > 0.0)[latched[0]]])
        spectrum = multipliers(monodromy[np.ix_(kept, kept)])
        for k in np.flatnonzero(~kept):
            end[k], by_p[k], monodromy[k] = x[k], 0.0, 0.0
        if self._turns is None:
            self._turns = np.zeros(len(x))
            self._turns[self._turning] = np.round((end - x)[self._turning] / (2.0 * np.pi)) * 2.0 * np.pi
        closed = runner.model.touching == 1
        contacts = np.where((begins == 0) & (depth > 0.0), -1, begins)[closed]
        start = Steps(steps.times[:1], steps.states[:1], steps.memory[:1])
        memory = np.zeros_like(flow.memory)
        restore_memory(memory, start.memory[0])
        passage = Passage(
            flow.system, self.periods * period, float(start.times[0]), start.states[0].copy(), memory, monodromy,
            spectrum, tuple(int(k) for k in contacts),
        )  # fmt: skip
        return Residual(end - self._turns - x, monodromy - np.eye(len(x)), by_p, passage)

    def _period_slope(self, value: float) -> float:
        """Differentiate the common period by the value; only drives change it."""
        if not (self._path or "").startswith("drives."):
            return 0.0
        step = RETURN_MAP_LOOSE * abs(value) if value else RETURN_MAP_LOOSE
        return float(extrapolated(lambda change: np.array([self._period(value + change)]), step)[0][0])

    def _coordinates(self, flow: Flow, t: float, y: Array, like: LocalCoordinates | None = None) -> LocalCoordinates:
        """Choose minimal coordinates at a state; `like` gives the choice."""
        if like is not None and not flow.runner.model.elimination.rank:
            return like
        return local_coordinates(self._system, closure_at(flow.runner, t, y), like)

    def _lifted(self, flow: Flow, t: float, x: Array) -> Array:
        """Return the state with closed loops whose minimal coordinates are x, from the last such state."""
        local, y = self._local, self._reference
        if not flow.runner.model.elimination.rank:
            return x.copy()
        for _ in range(RETURN_MAP_LIFTS):
            missing = x - y[local.entries]
            if np.abs(missing / flow.scale[local.entries]).max() <= RETURN_MAP_LIFTED:
                break
            y = flow.closed(t, y + local.tangent @ missing)
        self._reference, self._local = y, self._coordinates(flow, t, y, local)
        return y


def least_clearance(system: System) -> float:
    """Return the smallest clearance of the joints [m]; infinite without clearance joints."""
    return min((system.joints[name].clearance or np.inf for name in system.tree.play), default=np.inf)


def _rate(flow: Flow, steps: Steps, t: float) -> Array:
    """Compute dy/dt at a time of a run, (ny,)."""
    runner = flow.runner
    _, v, a, contacts = runner.evaluate(steps, np.array([t]))
    free, own = runner.model.free, a.shape[1] - len(runner.model.states)
    contact, place = runner.model.law_states.T
    return np.concatenate([v[0, free], a[0, free], contacts[0, contact, RATES + place], a[0, own:]])
