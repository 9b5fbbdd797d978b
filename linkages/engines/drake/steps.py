"""Control of Drake's simulator and integrators, which avoids three defects of their steps.

Implicit integrators keep their iteration matrix while Newton's method seems to converge, even after the step has
shrunk. If a film is stiff, the iteration then stops too early, the error estimate stays large and the step never
recovers; an old matrix also costs iterations. Remedy: after a strong reduction of the step, and after as many steps as
there are states, the integrator is restarted, which drops the matrix: a new one takes as many evaluations.

Two explicit integrators restore the state after a rejected attempt, but not the cached derivatives (seen in Drake
1.51): the next attempt starts with the accelerations at the end of the rejected one. The error of that step can be 75
times the accuracy, because the error estimate has the weight 1/75 on the first stage. Remedy: a step that needed a
second attempt is discarded, and repeated from its start.

If an attempt reaches states without finite forces, as deep in a wall, Drake raises. Remedy: a shorter step.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, Diagram, EventStatus

from linkages.base.arrays import Array
from linkages.base.errors import RunError, Status
from linkages.engines.drake.drives import Drives
from linkages.engines.methods import method
from linkages.engines.numerics import (
    STEPS_CUT,
    STEPS_EVENT_ACCURACY,
    STEPS_FIRST,
    STEPS_SHORTER,
    STEPS_SHRUNK,
    STEPS_SMALLEST,
)
from linkages.input.model.experiment_tables import IMPLICIT
from linkages.system import System

_SMALL, _PATIENCE = 1e-2, 50  # with contacts: restart after this many steps below this fraction of the largest step
_SPOILT = ("runge_kutta5", "bogacki_shampine3")  # schemes with wrong derivatives in second attempts
_COLLAPSES = ("step size", "select step", "NaN")  # parts of Drake's messages about a step collapse
_SINGULAR = "not positive-definite"  # the same about masses


def longest_step(system: System) -> float:
    """Return the longest step [s]: the experiment's, otherwise 20 microseconds with contacts."""
    return system.settings.max_step or (2e-5 if system.can_touch else 2e-3)


def is_collapse(problem: RuntimeError) -> bool:
    """Check whether an error of Drake is a step-size collapse, for which Drake has no exception type."""
    return any(words in str(problem) for words in _COLLAPSES)


class StepControl:
    """A simulator that advances by valid steps only.

    Its monitor must call `take` at each step, and return `verdict`, or `end` the run. The systems are all linkages of
    its diagram; the simulator gets the integrator of their settings: implicit if one needs it, with the smallest
    accuracy and the shortest steps.

    Attributes
    ----------
    accuracy, largest : float
        Accuracy and longest step [s] of the systems.
    kept : bool
        Whether the last step is valid; otherwise it is repeated.
    again : bool
        Whether the integrator must be restarted.
    status : Status
        OK unless `end` has ended the run.
    """

    def __init__(self, simulator: Simulator, *systems: System) -> None:
        self.simulator = simulator
        schemes = sorted((method(system, "drake") for system in systems), key=lambda name: name not in IMPLICIT)
        self.accuracy = self._accuracy = min(system.settings.accuracy for system in systems)
        self.largest = min(map(longest_step, systems))
        self._integrator = ResetIntegratorFromFlags(simulator, schemes[0], self.largest)
        self._smallest = STEPS_SMALLEST * self.largest
        self._contacts_end_steps = any(system.can_touch for system in systems)
        self._implicit, self._spoilt = schemes[0] in IMPLICIT, schemes[0] in _SPOILT
        self._evaluations = self._age = 0
        self._time, self._step, self._state = 0.0, 0.0, np.empty(0)
        self.again, self.kept, self.status = False, True, Status.OK
        simulator.get_mutable_context().SetAccuracy(STEPS_EVENT_ACCURACY * self._accuracy)
        self._settle()

    @property
    def evaluations(self) -> int:
        """Return the number of evaluations of the derivatives."""
        return self._evaluations + int(self._integrator.get_num_derivative_evaluations())

    def begin(self, first: float, accuracy: float) -> None:
        """Begin at the state of the simulator's context, with a given first step [s]."""
        self._time, self._accuracy = self.simulator.get_context().get_time(), accuracy
        self._restart(first)

    def begin_again(self) -> None:
        """Begin again at the context's state, which has changed, with steps of the last size."""
        self._state = self.simulator.get_context().get_continuous_state_vector().CopyToVector()
        self._restart(self._step or STEPS_FIRST * self.largest)

    def limit(self, longest: float) -> None:
        """Limit the next step [s]; for events at its start."""
        self._integrator.set_maximum_step_size(min(self.largest, longest))

    def advance(self, end: float) -> None:
        """Advance to a time [s], or until the monitor ends the run.

        Raises
        ------
        RunError
            If the mass matrix is singular to rounding.
        """
        root = self.simulator.get_mutable_context()
        while True:
            try:
                self.simulator.AdvanceTo(end)
            except RuntimeError as problem:
                if _SINGULAR in str(problem):
                    text = "is singular to rounding: its masses differ by all their digits; check their units"
                    raise RunError(f"Drake cannot find the accelerations: the mass matrix {text}") from None
                if "NaN" not in str(problem) or 0.0 < self._step <= self._smallest:
                    raise
                self.again, self.kept, self._step = True, False, STEPS_CUT * (self._step or self.largest)
            if not self.again or (self.kept and root.get_time() >= end):
                return
            if not self.kept:
                root.SetTime(self._time)
                root.SetContinuousState(self._state)
            self._restart(self._step)

    def take(self, root: Context) -> Array:
        """Check the step that ends in a context, and return the state."""
        step = root.get_time() - self._time  # zero after a restart
        state: Array = root.get_continuous_state_vector().CopyToVector()
        self.again, self.kept = False, True
        if step > 0.0 and self._spoilt and self._integrator.get_num_step_shrinkages_from_error_control():
            self.again, self.kept, step = True, False, STEPS_SHORTER * step
        elif step > 0.0 and self._implicit and self._is_stale(step, len(state)):
            self.again, self.kept = True, not self._contacts_end_steps  # a restart would lose a contact at its end
        if self.kept:
            self._time, self._state = root.get_time(), state
        if step > 0.0:
            self._step = step
        return state

    def verdict(self) -> EventStatus:
        """Return the status for Drake's monitor."""
        if self.again:
            return EventStatus.ReachedTermination(self.simulator.get_system(), "the integrator restarts")
        return EventStatus.DidNothing()

    def end(self, status: Status) -> EventStatus:
        """End the run; returns the status for Drake's monitor."""
        self.status, self.again = status, False
        return EventStatus.ReachedTermination(self.simulator.get_system(), status.value)

    def _is_stale(self, step: float, states: int) -> bool:
        """Check whether steps shrank, or the iteration matrix is old; if contacts end steps: if they stay small."""
        if not self._contacts_end_steps:
            self._age += 1
            return step < STEPS_SHRUNK * self._step or self._age >= states
        self._age = self._age + 1 if step < _SMALL * self.largest else 0
        return self._age >= _PATIENCE

    def _restart(self, first: float) -> None:
        self._evaluations = self.evaluations
        self._step, self._age = min(max(first, self._smallest), self.largest), 0  # Drake rejects a longer one
        self._settle()
        self._integrator.request_initial_step_size_target(self._step)
        self.simulator.Initialize()

    def _settle(self) -> None:
        """Set the options of a new integrator."""
        self._integrator.Reset()
        self._integrator.set_maximum_step_size(self.largest)
        self._integrator.set_target_accuracy(self._accuracy)
        self._integrator.set_requested_minimum_step_size(self._smallest)
        self._integrator.set_throw_on_minimum_step_size_violation(True)


def drives_of(diagram: Diagram) -> Iterator[Drives]:
    """Yield the drives of all linkages in a diagram, and in diagrams within it."""
    for system in diagram.GetSystems():
        if isinstance(system, Drives):
            yield system
        elif isinstance(system, Diagram):
            yield from drives_of(system)
