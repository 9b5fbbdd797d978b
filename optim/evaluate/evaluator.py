"""`Evaluator`: designs, their runs at every operating point, objectives and constraints; failures are explicit.

`Screened`: designs that formulas show to be infeasible, or without a value, are not run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial

import numpy as np

from linkages.base.arguments import Count, Lines, fitting, validated
from linkages.results.outputs.registry import IDEAL
from optim.evaluate.evaluations import INFEASIBLE, NO_VALUE, OK, Evaluations
from optim.evaluate.limits import FEASIBLE, limits
from optim.evaluate.machines import Machines
from optim.evaluate.remote import Dispatcher, Parcel, shared_part
from optim.evaluate.requests import STATISTICS, Request, RequestEngine, Statistics, run_compiled, run_parts
from optim.problem.schema import LIFE, StudyQuantity, Term
from optim.problem.study import Array, OperatingPoint, Study

#: From `STATISTICS` by name, (m, nw) each, and lengths of the windows, (nw,) [s].
_FUNCTIONALS: dict[str, Callable[[dict[str, Array], Array], Array]] = {
    "peak": lambda x, span: np.maximum(np.abs(x["minimum"]), np.abs(x["maximum"])),
    "max": lambda x, span: x["maximum"],
    "min": lambda x, span: x["minimum"],
    "range": lambda x, span: x["maximum"] - x["minimum"],
    "fluctuation": lambda x, span: (x["maximum"] - x["minimum"]) / np.abs(x["mean"]),
    "mean": lambda x, span: x["mean"],
    "rms": lambda x, span: x["rms"],
    "integral": lambda x, span: x["mean"] * span,
}


class Evaluator:
    """Evaluates designs of a study.

    Parameters
    ----------
    study : Study
    executor : Executor, optional
        Where requests are answered; default here.
    parts : int or callable
        Requests, at most, that an executor gets of a population at each operating point, or a function that returns
        them for the workers there are now; the values do not depend on it.
    threads : int, optional
        Threads of the compiled engine; default all there are.
    engine : callable, optional
        Answers a request; default the compiled engine's batch.
    progress : callable, optional
        Called with the finished fraction of each batch, without an executor.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> found = optim.Evaluator(study)(study.nominal[None])
    >>> found.status, float(found.objectives[0, 0].round(3))
    (('ok',), 2.913)
    """

    @validated
    def __init__(
        self,
        study: Study,
        executor: Executor | None = None,
        parts: int | Callable[[], int] = 1,
        threads: Count | None = None,
        engine: RequestEngine | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        searched = study.scatter is not None and not study.file.sampled
        self._machines = Machines(study) if searched else None
        self._size = len(study.names)
        self.study = study.with_machines() if searched else study
        self.executor = executor
        self._dispatcher = None if executor is None else Dispatcher(executor, parts)
        self._shared: dict[int, Parcel] = {}  # by operating point
        self.threads = threads
        self.engine = engine or run_compiled
        self.progress = progress if executor is None else None
        terms = [term for _, _, quantity in study.quantities for term in quantity.terms or ()]
        self._outputs = tuple(dict.fromkeys(term.output for term in terms))
        self._used = tuple(dict.fromkeys(term.window for term in terms))

    @validated
    def __call__(self, designs: Lines) -> Evaluations:
        """Evaluate designs (m, n), in SI units; a design's values do not depend on the others."""
        return self.begin(designs)()

    @validated
    def begin(self, designs: Lines) -> Callable[[], Evaluations]:
        """Send designs (m, n) to the executor; the returned function waits for the answers, and without one runs them.

        Populations may be begun before earlier ones have ended, so that no worker waits.
        """
        fitting(designs, self._size, "designs", "variables")
        if self._machines is None:
            answers = self._begin(designs)
            return lambda: self._evaluate(designs, answers())
        machines, rows = self._machines, self._machines.rows(designs)
        answers = self._begin(rows)
        return lambda: machines.combined(self._evaluate(rows, answers()))

    def population(self, least: int) -> int:
        """Return how many designs are work enough for all workers, a multiple of `least`; `least` without executor."""
        return least if self._dispatcher is None else self._dispatcher.population(least)

    def _evaluate(self, designs: Array, points: Sequence[Statistics]) -> Evaluations:
        study = self.study
        table = np.column_stack(
            [self._quantity(name, quantity, designs, points) for _, name, quantity in study.quantities]
        )
        failed = ~np.isfinite(table).all(axis=1)
        for found in points:
            failed |= np.array([state != OK for state in found.status])
        status, reason = [OK] * len(table), [""] * len(table)
        for i in np.flatnonzero(failed):
            status[i], reason[i] = self._failure(int(i), table[i], points)
        table[failed] = np.nan
        split = len(study.file.objectives)
        return Evaluations(table[:, :split], table[:, split:], tuple(status), tuple(reason))

    def _begin(self, designs: Array) -> Callable[[], list[Statistics]]:
        """Send designs to the executor at every operating point; the function returns their statistics."""
        dispatcher, points = self._dispatcher, self.study.points if self._outputs else ()
        if dispatcher is None or not points:
            return lambda: [run_parts(self._engines(), self._request(point, designs)) for point in points]
        sent = [dispatcher.send(self._parcel(k), self._values(point, designs)) for k, point in enumerate(points)]
        return lambda: dispatcher.receive(sent)

    def _parcel(self, k: int) -> Parcel:
        """Return what all requests at an operating point share."""
        if k not in self._shared:
            none = np.empty((0, self._size))
            self._shared[k] = shared_part(self._engines(), self._request(self.study.points[k], none))
        return self._shared[k]

    def _engines(self) -> dict[str, RequestEngine]:
        """Return what answers for outputs, by what their names begin with."""
        engines = {"": self.engine}
        if any(output.startswith((IDEAL, LIFE)) for output in self._outputs):
            from optim.evaluate.single_runs import run_ideal, run_lives

            engines |= {IDEAL: run_ideal, LIFE: partial(run_lives, lives=self.study.file.lives)}
        return engines

    def _request(self, point: OperatingPoint, designs: Array) -> Request:
        values, limits = (self._values(point, table) for table in (designs, (self.study.lower, self.study.upper)))
        windows = np.vstack([point.windows[name] for name in self._used])
        return Request(point, values, limits, self._outputs, windows, self.threads, self.progress)

    def _values(self, point: OperatingPoint, designs: Sequence[Array] | Array) -> Array:
        """Return the values of a point's paths for designs, (m, np)."""
        return np.array([self.study.row(design, point) for design in designs])

    def _quantity(self, name: str, quantity: StudyQuantity, designs: Array, points: Sequence[Statistics]) -> Array:
        """Weighted terms, summed or the extreme one, or a formula, (m,)."""
        if quantity.terms is None:
            formula = self.study.formulas[name]
            return np.array([formula(self.study.named(design)) for design in designs])
        return _aggregate(quantity.over_terms, [term.weight * self._term(term, points) for term in quantity.terms])

    def _term(self, term: Term, points: Sequence[Statistics]) -> Array:
        """Functional of an output over windows and points, (m,)."""
        k, w, by_point = self._outputs.index(term.output), self._used.index(term.window), []
        for point, found in zip(self.study.points, points, strict=True):
            ends = np.cumsum([len(point.windows[name]) for name in self._used])
            values = np.split(found.values[..., k], ends[:-1], axis=2)[w]
            statistics = dict(zip(STATISTICS, values, strict=True))
            spans = np.ptp(point.windows[term.window], axis=1)
            with np.errstate(invalid="ignore"):  # runs that failed
                values = _FUNCTIONALS[term.functional](statistics, spans)
            by_point.append(_aggregate(term.over_windows, values.T))
        return _aggregate(term.over_points, by_point)

    def _failure(self, i: int, row: Array, points: Sequence[Statistics]) -> tuple[str, str]:
        """Status and reason of design i, which failed at a point, or lacks a value."""
        several = len(points) > 1
        for point, found in zip(self.study.points, points, strict=False):
            if found.status[i] != OK:
                return found.status[i], (f"{point.name}: " if several else "") + found.reason[i]
        names = [name for _, name, _ in self.study.quantities]
        return NO_VALUE, f"{names[np.isfinite(row).argmin()]} has no finite value"


class Screened:
    """Evaluates designs of a study, but runs only designs that satisfy its constraints as far as formulas tell.

    By the rules of feasibility an infeasible design is judged by its violation alone, and runs of linkages that cannot
    turn are slow. The nominal design is run in any case: others are measured by it.

    Parameters
    ----------
    study : Study
    evaluate : callable
        Returns evaluations of designs (m, n), by runs.
    step : float, optional
        Step of an algorithm's differences, relative to the bounds [1]. It reaches beyond the constraints, so designs
        one or two steps along a variable from one that satisfies them are run too, but not beyond a hard constraint.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> evaluate = optim.Screened(study, optim.Evaluator(study))
    >>> evaluate(study.nominal[None]).status
    ('ok',)
    """

    def __init__(self, study: Study, evaluate: Callable[[Array], Evaluations], step: float | None = None) -> None:
        self.study, self.evaluate = study, evaluate
        spans = np.diag(study.upper - study.lower)
        self._steps = [] if step is None else [k * step * span for k in (-2, -1, 1, 2) for span in spans]
        self._names = [name for _, name, _ in study.quantities]
        self._scales = {
            name: study.formulas[name](study.named(study.nominal)) if quantity.relative else 1.0
            for _, name, quantity in study.quantities
            if name in study.formulas and quantity.over_scatter is None
        }

    def __call__(self, designs: Array) -> Evaluations:
        """Evaluate designs (m, n)."""
        if not self._scales:
            return self.evaluate(designs)
        table = np.full((len(designs), len(self._names)), np.nan)
        verdicts = [self._verdict(design, row) for design, row in zip(designs, table, strict=True)]
        split = len(self.study.file.objectives)
        objectives, constraints = np.full((len(designs), split), np.nan), table[:, split:]
        rows = [i for i, (status, _) in enumerate(verdicts) if status == OK]
        if rows:
            found = self.evaluate(designs[rows])
            objectives[rows], constraints[rows] = found.objectives, found.constraints
            for i, state, why in zip(rows, found.status, found.reason, strict=True):
                verdicts[i] = state, why
        status, reason = zip(*verdicts, strict=True)
        return Evaluations(objectives, constraints, status, reason)

    def _verdict(self, design: Array, row: Array) -> tuple[str, str]:
        """Status and reason of a design, `OK` if it should be run; its constraints by formula go into `row`."""
        if np.array_equal(design, self.study.nominal):
            return OK, ""
        values = self._values(design)
        for name, value in values.items():
            if not np.isfinite(value):
                return NO_VALUE, f"{name} has no finite value"
        row[:] = [values.get(name, np.nan) for name in self._names]
        violated = self._violated(values)
        if not violated or self._near(design, violated):
            return OK, ""
        return INFEASIBLE, f"violates {violated[0]}"

    def _near(self, design: Array, violated: list[str]) -> bool:
        """Whether a difference step from a feasible design may reach a design that violates these limits."""
        hard = any(self.study.file.constraints[key.rpartition(".")[0]].hard for key in violated)
        return not hard and any(not self._violated(self._values(design + step)) for step in self._steps)

    def _values(self, design: Array) -> dict[str, float]:
        named = self.study.named(design)
        return {name: self.study.formulas[name](named) for name in self._scales}

    def _violated(self, values: dict[str, float]) -> list[str]:
        """Names of the limits that are violated, or not known to hold."""
        found = []
        for limit in limits(self.study):
            if limit.name in values and self._scales[limit.name] != 0.0:
                excess = limit.excess(values[limit.name] / self._scales[limit.name])
                if not (abs(excess) if limit.equality else excess) <= FEASIBLE:
                    found.append(limit.key)
        return found


def _aggregate(how: str, values: Sequence[Array] | Array) -> Array:
    """Largest, smallest, mean or sum of k numbers (k, m), (m,); NaN if any is not finite. Sums are exact."""
    numbers = np.asarray(values)
    known = np.isfinite(numbers).all(axis=0)
    numbers = np.where(known, numbers, 0.0)
    if how in ("max", "min"):
        found = numbers.max(axis=0) if how == "max" else numbers.min(axis=0)
    else:
        found = np.array([math.fsum(column) for column in numbers.T.tolist()])
        found = found / len(numbers) if how == "mean" else found
    return np.where(known, found, np.nan)
