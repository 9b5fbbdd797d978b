"""Designs -> runs at every operating point -> objectives and constraints; failures are explicit."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from linkages.errors import RunError
from optim.evaluations import NO_VALUE, OK, Evaluations
from optim.nlp import Values
from optim.outputs import IDEAL
from optim.problem import OperatingPoint, Study, quantities
from optim.schema import Quantity, Term

Array = NDArray[np.float64]

#: From minimum, maximum, mean and rms, (m, nw), and lengths of the windows, (nw,) [s].
_FUNCTIONALS: dict[str, Callable[[Array, Array, Array, Array, Array], Array]] = {
    "peak": lambda low, high, mean, rms, span: np.maximum(np.abs(low), np.abs(high)),
    "max": lambda low, high, mean, rms, span: high,
    "min": lambda low, high, mean, rms, span: low,
    "range": lambda low, high, mean, rms, span: high - low,
    "mean": lambda low, high, mean, rms, span: mean,
    "rms": lambda low, high, mean, rms, span: rms,
    "integral": lambda low, high, mean, rms, span: mean * span,
}

# compiled loops use all threads already, and must not be entered by two threads of a worker at once
_ONE_BATCH = threading.Lock()


@dataclass(frozen=True)
class Batch:
    """Runs of some designs at one operating point: what a process, or a machine, is asked for."""

    point: OperatingPoint
    values: Array
    outputs: tuple[str, ...]
    windows: Array
    threads: int | None


@dataclass(frozen=True)
class Statistics:
    """Of each output in each window, (m, nw, no): what functionals are made of."""

    minimum: Array
    maximum: Array
    mean: Array
    rms: Array
    status: list[str]
    reason: list[str]


def run_batch(batch: Batch) -> Statistics:
    """Run designs through the compiled engine."""
    from linkages.compiled import simulate_batch

    with _ONE_BATCH:
        found = simulate_batch(
            batch.point.mechanism,
            batch.point.experiment,
            batch.point.paths,
            batch.values,
            outputs=batch.outputs,
            windows=batch.windows,
            threads=batch.threads,
        )
    status = [state.value for state in found.status]
    return Statistics(found.minimum, found.maximum, found.mean, found.rms, status, list(found.reason))


class Evaluator:
    """Evaluates designs of a study.

    Parameters
    ----------
    study : Study
    executor : Executor, optional
        Where batches run; default: here.
    parts : int
        Batches that a population is divided into; it does not change the values.
    threads : int, optional
        Of the compiled engine.
    engine : callable, optional
        Runs a batch; default `run_batch`.
    """

    def __init__(
        self,
        study: Study,
        executor: Executor | None = None,
        parts: int = 1,
        threads: int | None = None,
        engine: Callable[[Batch], Statistics] | None = None,
    ) -> None:
        self.study = study
        self.executor = executor
        self.parts = max(parts, 1)
        self.threads = threads
        self.engine = engine or run_batch
        terms = [term for _, _, quantity in quantities(study.file) for term in quantity.terms or ()]
        self.outputs = tuple(dict.fromkeys(term.output for term in terms))
        self._used = tuple(dict.fromkeys(term.window for term in terms))

    def __call__(self, designs: Array) -> Evaluations:
        """Evaluate designs (m, n); a design's values do not depend on the others."""
        study = self.study
        if self.outputs:
            points = self._run(designs)
        else:  # formulas alone
            nothing = np.empty((len(designs), 0, 0))
            blank = [""] * len(designs)
            points = [Statistics(nothing, nothing, nothing, nothing, [OK] * len(designs), blank)]
        table = np.column_stack(
            [
                self._formula(name, designs) if quantity.terms is None else self._quantity(quantity, points)
                for _, name, quantity in quantities(study.file)
            ]
        )
        status, reason = [], []
        for i, row in enumerate(table):
            verdict = self._verdict(i, row, points)
            status.append(verdict[0])
            reason.append(verdict[1])
        table[[state != OK for state in status]] = np.nan
        split = len(study.file.objectives)
        return Evaluations(table[:, :split], table[:, split:], tuple(status), tuple(reason))

    # -- runs --------------------------------------------------------------------------------------

    def _run(self, designs: Array) -> list[Statistics]:
        """Run designs at every operating point."""
        size = max(1, -(-len(designs) // self.parts))
        batches = [
            self._batch(point, designs[i : i + size])
            for point in self.study.points
            for i in range(0, len(designs), size)
        ]
        run: Callable[..., Iterable[Statistics]] = map if self.executor is None else self.executor.map
        engine: Callable[[Batch], Statistics] = self.engine
        if any(output.startswith(IDEAL) for output in self.outputs):
            from optim.ideal_runs import run_parts

            engine = partial(run_parts, engine)
        found = list(run(engine, batches))
        each = len(found) // len(self.study.points)
        return [_joined(found[i : i + each]) for i in range(0, len(found), each)]

    def _batch(self, point: OperatingPoint, designs: Array) -> Batch:
        linked = [[link(self.study.named(design)) for link in point.links] for design in designs]
        values = np.column_stack([designs, np.array(linked).reshape(len(designs), len(point.links))])
        windows = np.vstack([point.windows[name] for name in self._used])
        return Batch(point, values, self.outputs, windows, self.threads)

    def _rows(self, term: Term, point: OperatingPoint) -> slice:
        """Windows of a term among those of the batch."""
        before = 0
        for name in self._used:
            count = len(point.windows[name])
            if name == term.window:
                return slice(before, before + count)
            before += count
        raise KeyError(term.window)

    # -- numbers -----------------------------------------------------------------------------------

    def _quantity(self, quantity: Quantity, points: Sequence[Statistics]) -> Array:
        """Weighted terms, summed or the extreme one, (m,)."""
        terms = quantity.terms or ()
        columns = [[term.weight * x for x in self._term(term, points)] for term in terms]
        return np.array([_aggregate(quantity.over_terms, row) for row in zip(*columns, strict=True)])

    def _term(self, term: Term, points: Sequence[Statistics]) -> list[float]:
        k = self.outputs.index(term.output)
        by_point = []
        for point, found in zip(self.study.points, points, strict=True):
            rows = self._rows(term, point)
            spans = np.ptp(point.windows[term.window], axis=1)
            with np.errstate(invalid="ignore"):  # runs that failed
                values = _FUNCTIONALS[term.functional](
                    found.minimum[:, rows, k],
                    found.maximum[:, rows, k],
                    found.mean[:, rows, k],
                    found.rms[:, rows, k],
                    spans,
                )
            by_point.append([_aggregate(term.over_windows, row) for row in values])
        return [_aggregate(term.over_points, row) for row in zip(*by_point, strict=True)]

    def _formula(self, name: str, designs: Array) -> Array:
        found = self.study.formulas[name]
        return np.array([found(self.study.named(design)) for design in designs])

    def _verdict(self, i: int, row: Array, points: Sequence[Statistics]) -> tuple[str, str]:
        """Status and reason of design i."""
        several = len(points) > 1
        for point, found in zip(self.study.points, points, strict=False):
            if found.status[i] != OK:
                return found.status[i], (f"{point.name}: " if several else "") + found.reason[i]
        for (_, name, _), value in zip(quantities(self.study.file), row, strict=True):
            if not math.isfinite(value):
                return NO_VALUE, f"{name} has no finite value"
        return OK, ""


def inequality_names(study: Study) -> tuple[str, ...]:
    """Names of the inequalities g <= 0, one for each limit."""
    return tuple(name for name, _, _, _ in limits(study) if not name.endswith(".equals"))


def equality_names(study: Study) -> tuple[str, ...]:
    """Names of the equalities h = 0."""
    return tuple(name for name, _, _, _ in limits(study) if name.endswith(".equals"))


def values_of(study: Study, found: Evaluations, nominal: Evaluations) -> Values:
    """Make of quantities what an algorithm sees: all to be minimised, limits as g <= 0 and h = 0.

    Relative quantities are divided by the nominal design's. A limit L of a value f becomes (f - L)/|L|, or f if
    L = 0, so that violations of different constraints can be summed.

    Parameters
    ----------
    found : Evaluations
        Of m designs.
    nominal : Evaluations
        Of the nominal design alone.
    """
    objectives, constraints = in_units(study, found, nominal)
    signs = [-1.0 if objective.maximise else 1.0 for objective in study.file.objectives.values()]
    columns: dict[bool, list[Array]] = {False: [], True: []}
    order = list(study.file.constraints)
    for key, name, limit, sign in limits(study):
        excess = sign * (constraints[:, order.index(name)] - limit) / (abs(limit) or 1.0)
        # of a design that was not run, what is not known counts for nothing
        columns[key.endswith(".equals")].append(np.where(found.unrun & np.isnan(excess), 0.0, excess))
    failed = found.failed[:, None]
    empty = np.empty((len(found), 0))
    return Values(
        np.where(failed | found.unrun[:, None], np.inf, objectives * signs),
        np.where(failed, np.inf, np.column_stack([empty, *columns[False]])),
        np.where(failed, np.inf, np.column_stack([empty, *columns[True]])),
        found.failed,
    )


def in_units(study: Study, found: Evaluations, nominal: Evaluations) -> tuple[Array, Array]:
    """Objectives and constraints as the file means them: relative ones divided by the nominal design's.

    Raises
    ------
    RunError
        If they are to be divided by what is zero, or is not there.
    """
    scales = np.ones(found.objectives.shape[1] + found.constraints.shape[1])
    reference = np.concatenate([nominal.objectives[0], nominal.constraints[0]])
    for k, (kind, name, quantity) in enumerate(quantities(study.file)):
        if not quantity.relative:
            continue
        if nominal.failed[0] or reference[k] == 0.0:
            why = nominal.reason[0] or "it is zero there"
            raise RunError(
                f"{study.source.name}: {kind}.{name} is relative to the nominal design, which has no value: {why}"
            )
        scales[k] = reference[k]
    split = found.objectives.shape[1]
    return found.objectives / scales[:split], found.constraints / scales[split:]


def limits(study: Study) -> Iterable[tuple[str, str, float, float]]:
    """Every limit: its name, its constraint's, value, sign of what must not be positive."""
    for name, constraint in study.file.constraints.items():
        for key, sign in (("at_most", 1.0), ("at_least", -1.0), ("equals", 1.0)):
            limit = getattr(constraint, key)
            if limit is not None:
                yield f"{name}.{key}", name, limit, sign


def _aggregate(how: str, values: Iterable[float]) -> float:
    """Largest, smallest, mean or sum of some numbers; NaN if any is not finite. Sums are exact, in any layout."""
    numbers = [float(x) for x in values]
    if not all(math.isfinite(x) for x in numbers):
        return math.nan
    total = math.fsum(numbers)
    return {"max": max(numbers), "min": min(numbers), "mean": total / len(numbers), "sum": total}[how]


def _joined(parts: Iterable[Statistics]) -> Statistics:
    """Put batches of one operating point together again."""
    found = list(parts)

    def joined(key: str) -> Array:
        return np.concatenate([getattr(part, key) for part in found])

    return Statistics(
        joined("minimum"),
        joined("maximum"),
        joined("mean"),
        joined("rms"),
        [state for part in found for state in part.status],
        [reason for part in found for reason in part.reason],
    )
