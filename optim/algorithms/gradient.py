"""Generalised reduced gradient method; docs/optimisation_algorithms.md derives it.

Of the variables and slacks, as many as there are constraints are basic: they follow from the others by the equations
``c(x) + s = 0`` with the Jacobian ``A = [B A_N]``. With ``Z = [I; -B^-1 A_N]`` the gradient with respect to the
nonbasic ones is the *reduced gradient* ``r = Z^T g``. Each iteration

1. minimises the model ``r.v + v.H.v / 2`` over the steps v of the nonbasic variables that keep all variables
   within their bounds to first order; `H` is a BFGS approximation of the reduced Hessian,
2. chooses the basis for that step: independent columns, variables that have room,
3. searches along the step, and at every trial point corrects the basic variables by Newton's method until the
   equations hold; a basic variable that meets a bound is exchanged there.

So all iterates are feasible and each is better than the last. While the start is not feasible (phase I) the
objective is the sum of the violations.

J. Abadie, J. Carpentier, Generalization of the Wolfe reduced gradient method to the case of nonlinear constraints,
in: R. Fletcher (ed.), Optimization, Academic Press 1969, 37-47. L. S. Lasdon, A. D. Waren, A. Jain, M. Ratner,
Design and testing of a generalized reduced gradient code for nonlinear programming, ACM Transactions on
Mathematical Software 4 (1978) 34-50. They move the superbasic variables only and release bounds by the sign of
their multipliers; here the bounds are part of the model, so that degenerate points need no special rule.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from linkages.input.files.toml import Positive, Table
from optim.algorithms.archive import Archive
from optim.algorithms.curvature import escape
from optim.algorithms.derivatives import DIFFERENCES, SOURCES, Source
from optim.algorithms.line_search import Restored, search
from optim.algorithms.nlp import Array, Ending, Problem, Progress, Report, Result
from optim.algorithms.quadratic_model import bounded_minimum, damped_bfgs
from optim.algorithms.standard_form import Phase, ScaledSlopes, StandardForm, pushed

#: First step, relative to the scales.
FIRST_STEP = 0.1
#: Curvature of the model of phase I times the violation: at the start, and its range. It falls after good steps and
#: rises after bad ones.
FIRST_SOFTNESS, SOFTNESS = 1e-3, (1e-6, 1e3)
#: The reduced Hessian is forgotten when it is worse conditioned.
WORST_CONDITION = 1e14
#: The objective has converged if it falls by less than this, relatively, in so many iterations.
STANDSTILL, PATIENCE = 1e-12, 5


class ReducedGradient(Table):
    """Settings of the generalised reduced gradient method."""

    iterations: int = Field(200, ge=1, description="iterations at most")
    tolerance: Positive = Field(1e-7, description="of the reduced gradient, relative to 1 + |objective|, scaled")
    feasibility: Positive = Field(1e-9, description="tolerance of the constraints, relative to their scales")
    step: Positive = Field(1e-6, description="of the central differences, relative to the bounds")
    derivatives: Source = Field(DIFFERENCES, description=SOURCES)
    starts: int = Field(1, ge=1, description="number of starts: the nominal design, then designs of a Latin hypercube")


def reduced_gradient(
    problem: Problem, settings: ReducedGradient, seed: int = 0, progress: Report | None = None
) -> Result:
    """Minimise the first objective from the problem's start (the middle of the bounds if it has none).

    Parameters as in `optim.minimise`; the seed is not used: the method draws no random numbers.
    """
    run = _Descent(problem, settings)
    status = Ending.INTERRUPTED
    with run.archive.interruptible():
        status = run.run(progress)
    return Result(run.x[None, :], run.archive(run.x), status, run.iteration, len(run.archive))


class _Descent:
    """One run: the point, its partition, the reduced Hessian."""

    form: StandardForm
    point: Restored

    def __init__(self, problem: Problem, settings: ReducedGradient) -> None:
        self.problem, self.settings = problem, settings
        self.archive = Archive(problem)
        self.x = problem.first
        self.iteration = 0
        self.feasibility = settings.feasibility
        self.error = np.inf  # in the conditions of optimality
        self.hessian: Array | None = None
        self.fresh = True  # nothing was learnt yet
        self.softness = FIRST_SOFTNESS
        self.steps: list[Array] = []  # of the scaled variables in phase II
        # nonbasic variables and reduced gradient of the last point, in the partition of this one
        self.last: tuple[Array, Array] | None = None

    def run(self, progress: Report | None) -> Ending:
        if self.archive(self.x).failed[0]:
            return Ending.EVALUATION_FAILED
        self.form = form = StandardForm(self.problem, self.archive, self.x, self.settings.step)
        self._place(np.clip(self.x / form.width, form.lower[: form.n], form.upper[: form.n]))
        still, pushed, first = 0, False, True
        while self.iteration < self.settings.iterations:
            slopes = form.slopes(self.point.y[: form.n])
            if slopes is None:
                return Ending.EVALUATION_FAILED
            measured, slopes = form.measured, form.measure(slopes)
            phase = form.phase(self.point.y, slopes, self.feasibility)
            feasible = first and not phase.first
            if feasible or form.measured is not measured:  # the objective is new, or has another scale
                self.point = self.point._replace(f=form.evaluate(self.point.y[: form.n])[0])
                self.hessian = self.last = None
                if feasible and not np.isfinite(
                    self.point.f
                ):  # the problem takes the violation for one: it must become smaller
                    self.feasibility *= 0.1
                    continue
            first = phase.first
            if not first:  # violations below the tolerance are set on their bounds
                self.point = self.point._replace(y=np.clip(self.point.y, phase.low, phase.high))
            before = form.merit(phase, self.point.y, self.point.f)
            status = self._iterate(slopes, phase)
            if status is Ending.INFEASIBLE and not pushed:
                pushed = True
                self._push()
                continue
            if status is not None:
                return status
            fall = before - form.merit(phase, self.point.y, self.point.f)
            still = still + 1 if fall <= STANDSTILL * (1.0 + abs(before)) else 0
            if still >= PATIENCE:
                return Ending.INFEASIBLE if first else Ending.NO_PROGRESS
            self.iteration += 1
            self.x = form.design(self.point.y[: form.n])
            if progress is not None:
                basis = self.point.partition.basic.tolist()
                state = {"phase": 1 if first else 2, "error": float(self.error), "basis": basis}
                values = self.archive(self.x)
                progress(Progress(self.iteration, self.settings.iterations, self.x[None, :], values, state))
        return Ending.BUDGET_USED

    def _place(self, x: Array) -> None:
        """Go to scaled variables, with the slacks as basis; where there is no value, stay."""
        f, c = self.form.evaluate(x)
        if not np.isfinite(c if len(c) else f).all():
            return
        self.point = Restored(np.concatenate([x, -c]), f, np.zeros_like(c), self.form.slacks)
        self.hessian = self.last = None

    def _push(self) -> None:
        """Leave what may be a saddle of the violation."""
        n = self.form.n
        self._place(pushed(self.point.y[:n], self.form.lower[:n], self.form.upper[:n]))

    def _iterate(self, slopes: ScaledSlopes, phase: Phase) -> Ending | None:
        """Take one step, or say why there is none."""
        Z = self._tangents(slopes, phase)
        r = Z.T @ phase.gradient
        if not phase.first:
            self._learn(Z, r)
        y, nonbasic = self.point.y, self.point.partition.nonbasic
        free = phase.high[nonbasic] > phase.low[nonbasic]
        low, high = np.minimum(phase.low - y, 0.0), np.maximum(phase.high - y, 0.0)
        for _ in range(2):
            H = self._model(Z, r, phase)[np.ix_(free, free)]
            v, multipliers = bounded_minimum(H, r[free], Z[:, free], low, high)
            gaps = np.where(multipliers > 0.0, -low, high)
            slack = np.where(multipliers != 0.0, gaps, 0.0) * np.abs(multipliers)
            self.error = max(np.abs(H @ v).max(initial=0.0), slack.max(initial=0.0))
            slope = float(r[free] @ v)
            if phase.first and -slope <= self.settings.tolerance * self.form.merit(phase, y, self.point.f):
                return Ending.INFEASIBLE
            if not phase.first and self.error <= self.settings.tolerance * (1.0 + abs(self.point.f)):
                return None if self._escape(slopes, phase, Z, r) else Ending.CONVERGED
            direction = Z[:, free] @ v
            room = np.minimum(y + direction - phase.low, phase.high - y - direction)
            if phase.first:
                room[phase.gradient != 0.0] = 1.0  # a violated slack need not stop at its bound
            partition = self.point.partition.improved(slopes.A, room)
            found = search(self.form, slopes.A, self.point, partition, direction, slope, phase, self.feasibility)
            if found is not None:
                self._move(*found, phase, Z, r)
                return None
            if self.fresh:
                break
            self.hessian = None  # the curvature of the model may be wrong: repeat without it
        return Ending.INFEASIBLE if phase.first else Ending.NO_PROGRESS

    def _tangents(self, slopes: ScaledSlopes, phase: Phase) -> Array:
        """Directions along the constraints; with another partition if its basis has become singular."""
        try:
            return self.point.partition.tangents(slopes.A)
        except np.linalg.LinAlgError:
            room = np.minimum(self.point.y - phase.low, phase.high - self.point.y)
            self.point = self.point._replace(partition=self.form.slacks.improved(slopes.A, room))
            self.hessian = self.last = None
            return self.point.partition.tangents(slopes.A)

    def _model(self, Z: Array, r: Array, phase: Phase) -> Array:
        """Hessian of the model: in phase I soft, so that the step reaches the bounds; else the quasi-Newton update.

        What nothing is known about is steepest descent in the space of the scaled variables.
        """
        self.fresh = phase.first or self.hessian is None
        if self.hessian is None or phase.first:
            if phase.first:
                size = self.softness / self.form.merit(phase, self.point.y, self.point.f)
            else:
                size = max(float(np.linalg.norm(r)) / FIRST_STEP, 1e-8)
            self.hessian = size * self._metric(Z)
        return self.hessian

    def _metric(self, Z: Array) -> Array:
        """Squared length of a step in the scaled variables, as a quadratic form of the nonbasic ones."""
        X = Z[: self.form.n]
        return X.T @ X + 1e-8 * np.eye(self.form.n)

    def _learn(self, Z: Array, r: Array) -> None:
        """Update the Hessian by the last step."""
        if self.last is None or self.hessian is None:
            return
        y, r_last = self.last
        step, change = self.point.y[self.point.partition.nonbasic] - y, r - r_last
        curvature = float(step @ change)
        moved = step != 0.0
        if self.fresh and curvature > 0.0:
            metric = self._metric(Z)
            size = change[moved] @ np.linalg.solve(metric[np.ix_(moved, moved)], change[moved]) / curvature
            self.hessian = float(size) * metric
        self.hessian = damped_bfgs(self.hessian, step, change)
        if not np.all(np.isfinite(self.hessian)) or np.linalg.cond(self.hessian) > WORST_CONDITION:
            self.hessian = None

    def _escape(self, slopes: ScaledSlopes, phase: Phase, Z: Array, r: Array) -> bool:
        """Leave a stationary point that is no minimum; False if it is one as far as can be seen."""
        tolerances = self.settings.tolerance, self.feasibility
        found = escape(self.form, slopes, self.point, phase, self.steps, *tolerances)
        if found is not None:
            self._move(*found, phase, Z, r)
            self.hessian = self.last = None  # the model bends upwards
        return found is not None

    def _move(self, point: Restored, trials: int, phase: Phase, Z: Array, r: Array) -> None:
        """Go to a new point; the curvature is transferred to the nonbasic variables of its partition."""
        if not phase.first:
            self.steps.append((point.y - self.point.y)[: self.form.n])
        nonbasic = point.partition.nonbasic
        T = np.linalg.inv(Z[nonbasic])
        if self.hessian is not None:
            self.hessian = T.T @ self.hessian @ T
        self.last = (self.point.y[nonbasic], T.T @ r)
        self.point = point
        self.softness = float(np.clip(self.softness * (10.0 if trials > 2 else 0.3), *SOFTNESS))
