"""A run of the Drake diagram as a trajectory."""

from __future__ import annotations

import time as clock
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, EventStatus

from linkages.base.arrays import Array
from linkages.base.errors import RunError, Status, TimeOverError
from linkages.engines.budget import Budget
from linkages.engines.drake.diagram import Linkage, build_diagram
from linkages.engines.drake.drives import StatefulDrives
from linkages.engines.drake.steps import StepControl, is_collapse
from linkages.engines.drake.steps import longest_step as longest_step  # part of the engine's interface
from linkages.engines.methods import expect_run
from linkages.engines.numerics import SIMULATION_BETWEEN, SIMULATION_FINEST, SIMULATION_FIRST
from linkages.mechanics.planar.contacts import WIDTH
from linkages.results.outputs.columns import Columns, columns
from linkages.results.trajectory import Loops, TimeReport, Trajectory, sample
from linkages.system import System
from linkages.system.ideal_motion import cause


def simulate(system: System, progress: TimeReport | None = None) -> Trajectory:
    """Simulate a system with Drake; see `linkages.engines.assessment.simulate`."""
    started = clock.perf_counter()
    expect_run(system, "drake")
    diagram, linkage = build_diagram(system, samples=True)
    system, simulator = linkage.system, Simulator(diagram)
    linkage.set_initial_state(simulator.get_mutable_context())
    watch = _Watch(linkage, StepControl(simulator, system), progress)
    if linkage.clearance is not None:
        linkage.clearance.limit_step = watch.steps.limit
    simulator.set_monitor(watch)
    status = Status.OK
    try:
        simulator.Initialize()
        for until in watch.samples():
            watch.steps.advance(until)
            if watch.steps.status is not Status.OK:
                break
    except (KeyboardInterrupt, TimeOverError) as ended:
        if not watch.times:
            raise
        status = Status.TIME_OVER if isinstance(ended, TimeOverError) else Status.INTERRUPTED
    except RuntimeError as problem:
        jammed = linkage.drives.is_jammed()
        if not jammed and not is_collapse(problem):
            raise
        status = Status.JAMMED if jammed else Status.STEP_SIZE_COLLAPSE
    if watch.steps.status is not Status.OK:
        status = watch.steps.status
    if status is Status.JAMMED and len(watch.times) < 2:
        raise RunError(f"{status.value} at the start; {status.remedy}")
    status, end = cause(status, system, watch.times[-1])
    provenance = {
        "engine": "drake",
        "steps": len(watch.times) - 1,
        "evaluations": watch.steps.evaluations,
        "wall_time": clock.perf_counter() - started,
    }
    recorder = _Recorder(diagram, linkage, watch)
    times, loops = recorder.times[recorder.times <= end], Loops(system.tree, system.tree.loop_rows)
    trajectory = sample(times, recorder, status, provenance, loops)
    trajectory = replace(trajectory, accuracy=system.settings.accuracy)
    if status in (Status.STEP_SIZE_COLLAPSE, Status.JAMMED, Status.LOCKED):  # its last steps cannot be integrated again
        trajectory = replace(trajectory, evaluate=None)
    return trajectory


class _Watch:
    """Stores the state of every accepted step, and checks it: journals inside bearings, loops closed."""

    def __init__(self, linkage: Linkage, steps: StepControl, progress: TimeReport | None) -> None:
        self.linkage, self.steps, self.progress = linkage, steps, progress
        self.budget = Budget(linkage.system)
        self.times: list[float] = []
        self.states: list[Array] = []
        self.memories: list[Array | None] = []
        self._reach, self._is_light = linkage.system.reach, linkage.system.has_light_links

    def samples(self) -> Iterator[float]:
        """Yield the times at which the run pauses; sampled states get their next values there."""
        drives, end = self.linkage.drives, self.linkage.system.settings.duration
        periods = np.array([one.period for one in self.linkage.system.own_states.values()])
        counts, root = np.zeros(len(periods)), self.steps.simulator.get_mutable_context()
        while isinstance(drives, StatefulDrives) and periods.any():
            due = np.where(periods > 0.0, counts * periods, np.inf)
            until = float(due.min())
            if until > end:
                break
            if until > 0.0:
                yield until
            drives.sample(drives.GetMyMutableContextFromRoot(root), due)
            counts[due <= until] += 1.0
            self.steps.begin_again()
            state = root.get_continuous_state_vector().CopyToVector()
            self.states[-1:] = [state] * len(self.states[-1:])
            if until == end:
                return
        yield end

    def __call__(self, root: Context) -> EventStatus:
        time = root.get_time()
        state = self.steps.take(root)
        if not self.steps.kept or (self.times and time == self.times[-1]):  # the latter after a restart
            return self.steps.verdict()
        if self.times and self.linkage.drives.has_open_loop(root):
            return self.steps.end(Status.LOOP_OPEN)
        self.times.append(time)
        self.states.append(state)
        self.memories.append(
            root.get_discrete_state_vector().CopyToVector() if root.num_discrete_state_groups() else None
        )
        if self.progress is not None:
            self.progress(time)
        linkage = self.linkage
        if self._is_light and linkage.system.first_alone(state[linkage.place.positions][None]) is not None:
            return self.steps.end(Status.FREE_OF_MASS)
        if self.budget.spent(time):
            return self.steps.end(Status.TOO_MANY_STEPS)
        if linkage.clearance is not None:
            joints = linkage.clearance.evaluate(linkage.clearance.GetMyContextFromRoot(root))
            if np.any(np.hypot(joints[:, 0], joints[:, 1]) >= self._reach):
                return self.steps.end(Status.JOURNAL_LEFT_BEARING)
        return self.steps.verdict()


class _Recorder:
    """Computes all columns at any times of a run.

    At the integrator's steps the diagram is evaluated at the stored state. Between steps the state is found by repeated
    integration from the last known time of the same step: a film is so stiff that its force depends on the last digits
    of the velocities, which interpolation of the state would lose. States that this integration reaches are kept: the
    search for a maximum asks for times close to each other.
    """

    def __init__(self, diagram: Diagram, linkage: Linkage, watch: _Watch) -> None:
        self.times, self.states = np.array(watch.times), np.array(watch.states)
        # the values latched at the start of a step are known at its end
        self.memories = [*watch.memories[1:], watch.memories[-1]]
        if linkage.clearance is not None:
            linkage.clearance.replaying = True
        self.diagram, self.linkage, self.system = diagram, linkage, linkage.system
        self.simulator = Simulator(diagram)
        self.steps = StepControl(self.simulator, self.system)
        self.simulator.set_monitor(self._look)
        self._between: dict[int, tuple[list[float], list[Array]]] = {}  # known times and states, by step
        self._kept: tuple[list[float], list[Array]] = [], []  # of the present step
        # a short step keeps velocity errors that a long step damps; they would appear in a film's force
        accuracy = self.system.settings.accuracy
        self.accuracy = min(accuracy, max(SIMULATION_BETWEEN * accuracy, SIMULATION_FINEST))

    def __call__(self, times: Array) -> Columns:
        return columns(self.system, times, *self.states_at(times))

    def states_at(self, times: Array) -> tuple[Array, Array, Array, Array]:
        """Compute coordinates, rates, accelerations and contacts at the given times."""
        linkage, root = self.linkage, self.simulator.get_mutable_context()
        states = np.empty((len(times), self.states.shape[1]))
        rates = np.empty_like(states)
        contacts = np.empty((len(times), len(self.system.contacts), WIDTH))
        for k, t in enumerate(times):
            self._go_to(t)
            states[k] = root.get_continuous_state_vector().CopyToVector()
            rates[k] = self.diagram.EvalTimeDerivatives(root).CopyToVector()
            if linkage.clearance is not None:
                contacts[k] = linkage.clearance.evaluate(linkage.clearance.GetMyContextFromRoot(root))
        place, nz = linkage.place, len(self.system.own_states)
        own = slice(states.shape[1] - nz, None)  # the drives are the diagram's last system
        q = np.pad(states[:, place.positions], ((0, 0), (0, nz)))
        v, a = (np.hstack([found[:, place.v], found[:, own]]) for found in (states, rates))
        return q, v, a, contacts

    def _go_to(self, t: float) -> None:
        """Set the simulator's context to time t."""
        step = max(int(np.searchsorted(self.times, t, side="right")) - 1, 0)
        self._kept = self._between.setdefault(step, ([self.times[step]], [self.states[step]]))
        try:
            self._advance(step, t, self.accuracy)
        except RuntimeError:  # accuracy not reached near a singularity of the laws: accept the accuracy of the run
            self._advance(step, t, self.system.settings.accuracy)

    def _advance(self, step: int, t: float, accuracy: float) -> None:
        """Integrate from the last known time of a step."""
        times, states = self._kept
        last = bisect_right(times, t) - 1
        root = self.simulator.get_mutable_context()
        root.SetTime(times[last])
        root.SetContinuousState(states[last])
        if self.memories[step] is not None:
            root.SetDiscreteState(self.memories[step])
        if t > times[last]:
            # at the run's own accuracy a short step would keep velocity errors that a long one damps
            whole = accuracy > SIMULATION_BETWEEN * self.system.settings.accuracy
            longest = (1.0 if whole else SIMULATION_FIRST) * (self.times[step + 1] - self.times[step])
            self.steps.begin(min(t - times[last], longest), accuracy)
            self.steps.advance(t)

    def _look(self, root: Context) -> EventStatus:
        state, time = self.steps.take(root), root.get_time()
        times, states = self._kept
        place = bisect_left(times, time)
        if self.steps.kept and times[place : place + 1] != [time]:
            times.insert(place, time)
            states.insert(place, state)
        return self.steps.verdict()
