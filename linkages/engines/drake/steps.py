"""Drake's simulator and integrator, led past habits that spoil a run's steps.

Its implicit integrators keep their iteration matrix while Newton's method seems to converge, even when the step has
shrunk since; with a film's stiffness the iteration then stops short, the error estimate stays large and the step never
recovers. So when a step shrinks by much the integrator begins anew, which drops the matrix.

Two of its explicit ones put the state back after a rejected attempt without dropping what was computed from the state
alone (seen in 1.51): the next attempt begins with the accelerations at the end of the one before. The step is off by up
to 75 times the accuracy, as the error estimate knows 1/75 of what it begins with. So a step that needed a second
attempt is thrown away, and taken anew from its start.

And where an attempt leads to states without forces, as far in a wall, Drake raises: a shorter step is tried there.
"""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, EventStatus

from linkages.arrays import Array
from linkages.model.experiment_tables import IMPLICIT
from linkages.system import System

_SMALLEST = 1e-11  # of the duration: below it the run has collapsed
_EVENT_ACCURACY = 1e-3  # of the accuracy: with what contacts are located
_SHRUNK = 0.5  # of the step before: below it an implicit integrator begins anew
_SMALL, _PATIENCE = 1e-2, 50  # with contacts: after so many steps below this part of the largest one
_SPOILT = ("runge_kutta5", "bogacki_shampine3")  # schemes whose second attempts begin with the first one's end
_CUT = 0.1  # of the step before: what is tried where an attempt led to no number
_COLLAPSES = ("step size", "select step", "NaN")  # words of Drake's errors where a step collapses
_SHORTER = 0.9  # of a step that needed a second attempt: with what it is taken anew


def scheme(system: System) -> str:
    """Name Drake's integration scheme: the experiment's, else implicit where the joint laws are stiff."""
    return system.experiment.solver.integrator or ("radau3" if system.stiff else "runge_kutta5")


def longest_step(system: System) -> float:
    """Return the longest step [s]: the experiment's, else one that is short for contacts, some 50 microseconds."""
    return system.experiment.solver.max_step or (2e-5 if system.touching.any() else 2e-3)


def is_collapse(problem: RuntimeError) -> bool:
    """Return whether an error of Drake is a collapse of the step size; Drake has no exception type for it."""
    return any(words in str(problem) for words in _COLLAPSES)


class Steps:
    """A simulator that advances by steps worth keeping.

    Its monitor must call `take` at each step, and return `verdict` unless it ends the run.

    Parameters
    ----------
    simulator : Simulator
        Gets the integrator that the system's settings ask for.
    system : System

    Attributes
    ----------
    kept : bool
        Whether the step looked at last counts; else it is taken anew.
    again : bool
        Whether the integrator is to begin anew; a monitor that ends the run unsets it.
    """

    def __init__(self, simulator: Simulator, system: System) -> None:
        self.simulator = simulator
        self._integrator = ResetIntegratorFromFlags(simulator, scheme(system), longest_step(system))
        self._accuracy, self._largest = system.experiment.solver.accuracy, longest_step(system)
        self._smallest = _SMALLEST * system.experiment.duration
        self._contacts_end_steps = bool(system.touching.any())
        self._implicit, self._spoilt = scheme(system) in IMPLICIT, scheme(system) in _SPOILT
        self._evaluations = self._crawling = 0
        self._time, self._step, self._state = 0.0, 0.0, np.empty(0)
        self.again, self.kept = False, True
        simulator.get_mutable_context().SetAccuracy(_EVENT_ACCURACY * self._accuracy)
        self._settle()

    @property
    def evaluations(self) -> int:
        """How often the derivatives were evaluated."""
        return self._evaluations + int(self._integrator.get_num_derivative_evaluations())

    def begin(self, first: float, accuracy: float) -> None:
        """Begin at the state that the simulator's context is put to, with a first step so long [s]."""
        self._time, self._accuracy = self.simulator.get_context().get_time(), accuracy
        self._restart(first)

    def advance(self, end: float) -> None:
        """Advance to a time [s], or to where the monitor ends the run."""
        root = self.simulator.get_mutable_context()
        while True:
            try:
                self.simulator.AdvanceTo(end)
            except RuntimeError as problem:
                if "NaN" not in str(problem) or 0.0 < self._step <= self._smallest:
                    raise
                self.again, self.kept, self._step = True, False, _CUT * (self._step or self._largest)
            if not self.again or (self.kept and root.get_time() >= end):
                return
            if not self.kept:
                root.SetTime(self._time)
                root.SetContinuousState(self._state)
            self._restart(self._step)

    def take(self, root: Context) -> Array:
        """Look at the step that ends in a context, and return the state there."""
        step = root.get_time() - self._time  # zero: begun anew
        state: Array = root.get_continuous_state_vector().CopyToVector()
        self.again, self.kept = False, True
        if step > 0.0 and self._spoilt and self._integrator.get_num_step_shrinkages_from_error_control():
            self.again, self.kept, step = True, False, _SHORTER * step
        elif step > 0.0 and self._implicit and self._shrank(step):
            self.again, self.kept = True, not self._contacts_end_steps  # a contact at its end would be forgotten
        if self.kept:
            self._time, self._state = root.get_time(), state
        if step > 0.0:
            self._step = step
        return state

    def verdict(self) -> EventStatus:
        """Return what a monitor must."""
        if self.again:
            return EventStatus.ReachedTermination(self.simulator.get_system(), "the integrator begins anew")
        return EventStatus.DidNothing()

    def _shrank(self, step: float) -> bool:
        """Whether steps shrank; where contacts end steps, only if they stay small."""
        if not self._contacts_end_steps:
            return step < _SHRUNK * self._step
        self._crawling = self._crawling + 1 if step < _SMALL * self._largest else 0
        return self._crawling >= _PATIENCE

    def _restart(self, first: float) -> None:
        self._evaluations = self.evaluations
        self._step, self._crawling = max(first, self._smallest), 0
        self._settle()
        self._integrator.request_initial_step_size_target(self._step)
        self.simulator.Initialize()

    def _settle(self) -> None:
        """Make the settings of an integrator that has forgotten everything."""
        self._integrator.Reset()
        self._integrator.set_maximum_step_size(self._largest)
        self._integrator.set_target_accuracy(self._accuracy)
        self._integrator.set_requested_minimum_step_size(self._smallest)
        self._integrator.set_throw_on_minimum_step_size_violation(True)
