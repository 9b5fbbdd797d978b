"""SNOPT, sequential quadratic programming, as it comes with Drake.

P. E. Gill, W. Murray, M. A. Saunders, SNOPT: An SQP algorithm for large-scale constrained optimization, SIAM Review
47 (2005) 99-131.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import Field
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.solvers import MathematicalProgram, SnoptSolver, SolverOptions

from linkages import RunError
from linkages.input.files.toml import Positive, Table
from optim.algorithms.archive import Archive
from optim.algorithms.curvature import escape
from optim.algorithms.derivatives import DIFFERENCES, SOURCES, Source
from optim.algorithms.line_search import Restored
from optim.algorithms.nlp import Array, Ending, Problem, Progress, Report, Result
from optim.algorithms.standard_form import StandardForm

#: Scaled value that stands for a failed evaluation: SNOPT knows no infinity, but backs off from a bad value.
BAD = 1e12
#: SNOPT's exit conditions (User's Guide, section 8.6): its hundreds are their kinds.
_ENDINGS = {0: Ending.CONVERGED, 10: Ending.INFEASIBLE, 30: Ending.BUDGET_USED}


class Snopt(Table):
    """Settings of SNOPT."""

    iterations: int = Field(200, ge=1, description="major iterations at most")
    tolerance: Positive = Field(1e-7, description="major optimality tolerance")
    feasibility: Positive = Field(1e-8, description="major feasibility tolerance, of the scaled constraints")
    step: Positive = Field(1e-6, description="of the central differences, relative to the bounds")
    derivatives: Source = Field(DIFFERENCES, description=SOURCES)
    starts: int = Field(1, ge=1, description="number of starts: the nominal design, then designs of a Latin hypercube")


def snopt(problem: Problem, settings: Snopt, seed: int = 0, progress: Report | None = None) -> Result:
    """Minimise the first objective from the problem's start (the middle of the bounds if it has none).

    Variables and constraints are scaled, and derivatives taken, as by the reduced gradient method.

    Parameters as in `optim.minimise`; the seed is not used: the method draws no random numbers. `progress` is
    called after each new point at which SNOPT needs derivatives, which are its iterations.
    """
    search = _Snopt(problem, settings, progress)
    with search.archive.interruptible():
        return search.run()
    return search.result(None, Ending.INTERRUPTED)


class _Snopt:
    def __init__(self, problem: Problem, settings: Snopt, progress: Report | None) -> None:
        self.problem, self.settings, self.progress = problem, settings, progress
        self.archive = Archive(problem)
        self.iterations = 0
        self.stop: BaseException | None = None

    def run(self) -> Result:
        start = self.problem.first
        if self.archive(start).failed[0]:
            return self.result(start, Ending.EVALUATION_FAILED)
        if not StandardForm(self.problem, self.archive, start, self.settings.step).measured:
            # to the constraints, then to the optimum
            start, _ = self._solve(start, 0.0)
            if not np.isfinite(self.archive(start).objectives[0, 0]):
                return self.result(start, Ending.INFEASIBLE)
        design, status = self._solve(start, 1.0)
        while status is Ending.CONVERGED and (better := self._escape(design)) is not None:
            design, status = self._solve(better, 1.0)
        known = np.isfinite(self.archive(design).objectives[0, 0])
        return self.result(design if known else None, status)

    def _solve(self, start: Array, weight: float) -> tuple[Array, Ending]:
        """Call SNOPT, the objective times a weight: where it ends, and why."""
        form = self.form = StandardForm(self.problem, self.archive, start, self.settings.step)
        self._slopes: dict[bytes, Array] = {}
        self._visited: list[Array] = []
        f, _ = form.evaluate(start / form.width)
        # stands for the objective where there is none, since constraints are violated: SNOPT passes there
        self.beyond = f if np.isfinite(f) else 0.0
        n, m = form.n, form.m
        program = MathematicalProgram()
        x = program.NewContinuousVariables(n)
        program.AddBoundingBoxConstraint(form.lower[:n], form.upper[:n], x)
        program.AddCost(lambda at: weight * self._evaluate(at, slice(0, 1))[0], x)
        if m:
            low = -form.upper[n:]  # range of the slacks
            program.AddConstraint(lambda at: self._evaluate(at, slice(1, None)), low, np.zeros(m), x)
        options = SolverOptions()
        for name, value in (
            ("Major iterations limit", self.settings.iterations),
            ("Iterations limit", 1000 * self.settings.iterations),
            ("Major optimality tolerance", self.settings.tolerance),
            ("Major feasibility tolerance", self.settings.feasibility),
            ("Verify level", -1),
        ):
            options.SetOption(SnoptSolver.id(), name, value)
        try:
            solution = SnoptSolver().Solve(program, start / form.width, options)
        except Exception as error:  # Drake turns whatever a function raises into an error of its own
            if self.stop is None:
                raise RunError(f"SNOPT: {' '.join(str(error).split())}") from error
            raise self.stop from None
        kind = 10 * (solution.get_solver_details().info // 10)
        design = form.design(np.clip(solution.GetSolution(x), form.lower[:n], form.upper[:n]))
        return design, _ENDINGS.get(kind, Ending.NO_PROGRESS)

    def _escape(self, design: Array) -> Array | None:
        """Return a better design near a stationary one that is no minimum; None near a minimum."""
        form, x = self.form, design / self.form.width
        (f, c), slopes = form.evaluate(x), form.slopes(x)
        if slopes is None or not np.isfinite(f):
            return None
        feasibility = 10.0 * self.settings.feasibility
        phase = form.phase(np.append(x, -c), slopes, feasibility)
        if phase.first:
            return None
        y = np.clip(np.append(x, -c), phase.low, phase.high)
        partition = form.slacks.improved(slopes.A, np.minimum(y - phase.low, phase.high - y))
        steps = [after - before for before, after in pairwise(self._visited)]
        found = escape(
            form, slopes, Restored(y, f, c + y[form.n :], partition), phase, steps, self.settings.tolerance, feasibility
        )
        return None if found is None else form.design(found[0].y[: form.n])

    def result(self, design: Array | None, status: Ending) -> Result:
        """Return a design, or the best one that was evaluated."""
        if design is None:
            design = self.archive.designs[self.archive.best(1e-6)]
        return Result(design[None, :], self.archive(design), status, self.iterations, len(self.archive))

    def _evaluate(self, at: Any, part: slice) -> Any:
        """Objective and scaled constraints at a point, with derivatives if it carries some."""
        try:
            differentiate = np.asarray(at).dtype == object
            x = ExtractValue(at).ravel() if differentiate else np.asarray(at, dtype=float)
            x = np.clip(x, self.form.lower[: self.form.n], self.form.upper[: self.form.n])
            f, c = self.form.evaluate(x)
            if not np.isfinite(f) and len(c) and np.isfinite(c).all():
                f = self.beyond
            values = np.append(f, c)
            good = bool(np.all(np.isfinite(values)))
            values = values if good else np.full(len(values), BAD)
            if not differentiate:
                return values[part]
            slopes = self._differentiate(x) if good else np.zeros((len(values), len(x)))
            return InitializeAutoDiff(values[part], slopes[part] @ ExtractGradient(at)).ravel()
        except BaseException as error:
            self.stop = error
            raise

    def _differentiate(self, x: Array) -> Array:
        """Differentiate at a point, once; a new point is an iteration."""
        key = x.tobytes()
        if key not in self._slopes:
            slopes, n = self.form.slopes(x), self.form.n
            none = np.zeros((1 + self.form.m, n))
            self._slopes = {key: none if slopes is None else np.vstack([slopes.f[:n], slopes.A[:, :n]])}
            self.iterations += 1
            self._visited.append(x)
            if self.progress is not None:
                design = self.form.design(x)[None, :]
                self.progress(Progress(self.iterations, self.settings.iterations, design, self.archive(design)))
        return self._slopes[key]
