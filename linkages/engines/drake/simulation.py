"""A run of the Drake diagram as a trajectory."""

from __future__ import annotations

import time as clock
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import IntegratorBase, ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, Diagram, EventStatus

from linkages.engines.budget import Budget
from linkages.engines.drake.diagram import Linkage, build_diagram
from linkages.errors import Status
from linkages.model.tables import IMPLICIT
from linkages.outputs.columns import Columns, columns
from linkages.planar.contacts import WIDTH
from linkages.results.trajectory import Progress, Trajectory, sample
from linkages.system import System
from linkages.system.ideal_motion import cause

Array = NDArray[np.float64]

_SMALLEST_STEP = 1e-11  # of the duration: below it the run has collapsed
_EVENT_ACCURACY = 1e-3  # of the accuracy: with what contacts are located
_SHRUNK = 0.5  # of the step before: below it the integrator's matrices are dropped
_SMALL, _PATIENCE = 1e-2, 50  # with contacts: as many steps below this part of the largest one
_BETWEEN = 1e-2  # of the accuracy: for what is integrated again between two steps
_FINEST = 1e-10  # accuracy beyond which rounding keeps Drake's implicit schemes from converging


def simulate(system: System, progress: Progress | None = None) -> Trajectory:
    """Simulate a system with Drake.

    Parameters
    ----------
    system : System
    progress : callable, optional
        Called with the simulated time [s] after every step.

    Returns
    -------
    Trajectory
        Up to the end, or to where the run failed or was interrupted (`Trajectory.status`).

    Raises
    ------
    AssemblyError, InputError
        If there is nothing to start from.
    """
    started = clock.perf_counter()
    diagram, linkage = build_diagram(system)
    simulator = Simulator(diagram)
    linkage.set_initial_state(simulator.get_mutable_context())
    integrator = _set_up(simulator, system)
    watch = _Watch(linkage, progress)
    simulator.set_monitor(watch)
    status = Status.OK
    try:
        simulator.Initialize()
        _advance(simulator, integrator, watch.steps, system.experiment.duration)
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    except RuntimeError as problem:  # Drake gives these failures no type of their own
        if not any(words in str(problem) for words in ("step size", "select step", "NaN")):
            raise
        status = Status.STEP_SIZE_COLLAPSE
    if watch.status is not Status.OK:
        status = watch.status
    status = cause(status, system, watch.times[-1])
    provenance = {
        "engine": "drake",
        "steps": len(watch.times) - 1,
        "evaluations": watch.steps.evaluations + int(integrator.get_num_derivative_evaluations()),
        "wall_time": clock.perf_counter() - started,
        "loop_error": watch.loop_error,
    }
    recorder = _Recorder(diagram, linkage, watch)
    trajectory = sample(recorder.times, recorder, status, provenance)
    if status in (Status.STEP_SIZE_COLLAPSE, Status.LOCKED):  # nor can its last steps be integrated again
        trajectory = replace(trajectory, evaluate=None)
    return trajectory


def scheme(system: System) -> str:
    """Name Drake's integration scheme: the experiment's, else implicit where the joint laws are stiff."""
    return system.experiment.solver.integrator or ("radau3" if system.stiff else "runge_kutta5")


def max_step(system: System) -> float:
    """Largest step [s]: the experiment's, else short enough not to miss a contact, which lasts some 50 microseconds."""
    return system.experiment.solver.max_step or (2e-5 if system.touching.any() else 2e-3)


def _set_up(simulator: Simulator, system: System) -> IntegratorBase:
    accuracy = system.experiment.solver.accuracy
    integrator = ResetIntegratorFromFlags(simulator, scheme(system), max_step(system))
    integrator.set_target_accuracy(accuracy)
    simulator.get_mutable_context().SetAccuracy(_EVENT_ACCURACY * accuracy)
    integrator.set_requested_minimum_step_size(_SMALLEST_STEP * system.experiment.duration)
    integrator.set_throw_on_minimum_step_size_violation(True)
    return integrator


def _advance(simulator: Simulator, integrator: IntegratorBase, steps: _Steps, end: float) -> None:
    """Advance to the end, or to where the simulator's monitor, which looks at the steps, ends the run.

    Drake's implicit integrators keep their iteration matrix while Newton's method seems to converge, even when the
    step has shrunk since; with a film's stiffness the iteration then stops short, the error estimate stays large and
    the step never recovers. So whenever a step shrinks by much the integrator is initialised, which drops the matrix.
    """
    while True:
        simulator.AdvanceTo(end)
        if simulator.get_context().get_time() >= end or not steps.stuck:
            return
        steps.evaluations += int(integrator.get_num_derivative_evaluations())
        integrator.request_initial_step_size_target(steps.last)
        simulator.Initialize()


class _Steps:
    """Looks at the lengths of steps: whether those of an implicit scheme shrink for no good reason (`_advance`)."""

    def __init__(self, system: System) -> None:
        self._contacts_end_steps = bool(system.touching.any())
        self._implicit = scheme(system) in IMPLICIT
        self._small = _SMALL * max_step(system)
        self.evaluations = 0  # of the derivatives, before the matrices were dropped
        self.begin(0.0, 0.0)

    def begin(self, time: float, asked: float) -> None:
        """Forget the steps before; the next one is asked to be so long."""
        self.time, self.last, self.stuck = time, asked, False
        self._crawling = 0

    def take(self, time: float) -> None:
        """Look at the step that ends at a time."""
        self.stuck = False
        if time > self.time:  # else initialised anew
            before, self.last, self.time = self.last, time - self.time, time
            self.stuck = self._implicit and self._shrank(before)

    def _shrank(self, before: float) -> bool:
        """Whether steps shrank; where contacts end steps, only if they stay small."""
        if not self._contacts_end_steps:
            return self.last < _SHRUNK * before
        self._crawling = self._crawling + 1 if self.last < self._small else 0
        if self._crawling < _PATIENCE:
            return False
        self._crawling = 0
        return True


class _Watch:
    """Keeps the state of every accepted step and looks at it: journals in their bearings, loops closed."""

    def __init__(self, linkage: Linkage, progress: Progress | None) -> None:
        self.linkage, self.progress = linkage, progress
        system = linkage.system
        self.status = Status.OK
        self.loop_error = 0.0
        self.steps, self.budget = _Steps(system), Budget(system)
        self.times: list[float] = []
        self.states: list[Array] = []
        self.memories: list[Array | None] = []
        self._limit = system.laws["clearance"] * system.film_limits
        self._has_loops = bool(system.tree.loops)
        self._film_alone = ~system.touching

    def __call__(self, root: Context) -> EventStatus:
        time = root.get_time()
        if self.times and time == self.times[-1]:  # initialised anew
            return EventStatus.DidNothing()
        self.steps.take(time)
        self.times.append(time)
        self.states.append(root.get_continuous_state_vector().CopyToVector())
        self.memories.append(
            root.get_discrete_state_vector().CopyToVector() if root.num_discrete_state_groups() else None
        )
        if self.progress is not None:
            self.progress(time)
        linkage = self.linkage
        if self.budget.spent(time):
            return self._end(Status.TOO_MANY_STEPS, "the end is out of reach")
        if self._has_loops:
            error = linkage.drives.loop_error(linkage.drives.GetMyContextFromRoot(root))
            self.loop_error = max(self.loop_error, error)
        if linkage.clearance is not None:
            joints = linkage.clearance.evaluate(linkage.clearance.GetMyContextFromRoot(root))
            outside = self._film_alone & (np.hypot(joints[:, 0], joints[:, 1]) >= self._limit)
            if outside.any():
                name = linkage.clearance.joints[int(np.argmax(outside))]
                return self._end(Status.JOURNAL_LEFT_BEARING, f"journal {name} left its bearing")
        return _unless_stuck(self.steps, linkage)

    def _end(self, status: Status, reason: str) -> EventStatus:
        """End the run."""
        self.status, self.steps.stuck = status, False
        return EventStatus.ReachedTermination(self.linkage.drives, reason)


def _unless_stuck(steps: _Steps, linkage: Linkage) -> EventStatus:
    """Return what a monitor does."""
    if steps.stuck:
        return EventStatus.ReachedTermination(linkage.drives, "the step shrank")
    return EventStatus.DidNothing()


class _Recorder:
    """All columns at any times of a run.

    At the integrator's own steps the diagram is evaluated as it was. Between them the state is found by
    integrating again from the step before: the film is so stiff that its force, which follows from the last
    digits of the velocities, is lost in any interpolation of the state.
    """

    def __init__(self, diagram: Diagram, linkage: Linkage, watch: _Watch) -> None:
        self.times, self.states = np.array(watch.times), np.array(watch.states)
        # what was latched at the start of a step is known at its end
        self.memories = [*watch.memories[1:], watch.memories[-1]]
        self.diagram, self.linkage, self.system = diagram, linkage, linkage.system
        self.simulator = Simulator(diagram)
        self.integrator = _set_up(self.simulator, self.system)
        self.steps = _Steps(self.system)
        self.simulator.set_monitor(self._look)
        # a short step lets through errors of the velocities that a long one damps: they would show in a film's force
        accuracy = self.system.experiment.solver.accuracy
        self.accuracy = min(accuracy, max(_BETWEEN * accuracy, _FINEST))

    def __call__(self, times: Array) -> Columns:
        linkage, root = self.linkage, self.simulator.get_mutable_context()
        states = np.empty((len(times), self.states.shape[1]))
        rates = np.empty_like(states)
        contacts = np.empty((len(times), len(self.system.tree.contacts), WIDTH))
        before = np.inf
        for k, t in enumerate(times):
            self._go_to(t, before)
            before = t
            states[k] = root.get_continuous_state_vector().CopyToVector()
            rates[k] = self.diagram.EvalTimeDerivatives(root).CopyToVector()
            if linkage.clearance is not None:
                contacts[k] = linkage.clearance.evaluate(linkage.clearance.GetMyContextFromRoot(root))
        place = linkage.place
        return columns(self.system, times, states[:, place.q], states[:, place.v], rates[:, place.v], contacts)

    def _go_to(self, t: float, here: float) -> None:
        """Put the simulator's context at time t, going on from where it is if that lies in the same step."""
        step = max(int(np.searchsorted(self.times, t, side="right")) - 1, 0)
        try:
            if self.times[step] < here <= t:
                _advance(self.simulator, self.integrator, self.steps, t)
            else:
                self._advance_from(step, t, self.accuracy)
        except RuntimeError:  # too much asked where the laws are nearly singular: as the run itself did
            self._advance_from(step, t, self.system.experiment.solver.accuracy)

    def _advance_from(self, step: int, t: float, accuracy: float) -> None:
        """Integrate from the start of a step."""
        start = self.times[step]
        root = self.simulator.get_mutable_context()
        root.SetTime(start)
        root.SetContinuousState(self.states[step])
        if self.memories[step] is not None:
            root.SetDiscreteState(self.memories[step])
        if t > start:
            self.integrator.set_target_accuracy(accuracy)
            asked = max(t - start, self.integrator.get_requested_minimum_step_size())
            self.integrator.request_initial_step_size_target(asked)
            self.steps.begin(start, asked)
            self.simulator.Initialize()
            _advance(self.simulator, self.integrator, self.steps, t)

    def _look(self, root: Context) -> EventStatus:
        self.steps.take(root.get_time())
        return _unless_stuck(self.steps, self.linkage)
