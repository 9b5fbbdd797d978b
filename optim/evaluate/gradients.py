"""`Gradients`: derivatives of a study's objectives and constraints by sensitivities of its runs.

A run gives the derivatives of its outputs with respect to all design variables (`linkages.simulate` with ``wrt``);
the derivative of an extreme is that at its time, of a mean or root mean square an integral. Formulas of the design are
differentiated by central differences.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from linkages import Direction, InputError, RunError, Status, Trajectory, extremes, integral, simulate
from linkages.outputs.registry import IDEAL
from linkages.results.extremes import Extremes
from optim.evaluate.evaluations import Evaluations
from optim.evaluate.limits import limits, scales
from optim.problem.schema import LIFE, Quantity, Term
from optim.problem.study import Array, OperatingPoint, Study

_STEP = 1e-6  # of central differences of formulas, in parts of the range of a variable
_EXTREMES = ("max", "min", "peak", "range")

#: By output, window and functional: in each window the number and its derivatives, (nw, 1 + n).
_Functionals = dict[tuple[str, str, str], Array]


class Gradients:
    """Differentiates objectives and limits as an algorithm sees them; see `optim.Problem`.

    Parameters
    ----------
    study : Study
    evaluate : callable
        From designs (m, n) to their evaluations.
    nominal : Evaluations
        Evaluation of the nominal design, by which relative quantities are divided.

    Raises
    ------
    InputError
        If an output of the study has no sensitivities: a service life, or one of the ideal linkage.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> evaluate = optim.Evaluator(study)
    >>> gradients = optim.Gradients(study, evaluate, evaluate(study.nominal[None]))
    >>> gradients(study.nominal).shape  # one objective, six variables
    (1, 6)
    """

    def __init__(self, study: Study, evaluate: Callable[[Array], Evaluations], nominal: Evaluations) -> None:
        self.study, self._evaluate, self._scales = study, evaluate, scales(study, nominal)
        self._terms = {
            (term.output, term.window, term.functional): None
            for _, _, quantity in study.quantities
            for term in quantity.terms or ()
        }
        check_sensitivities(study)

    def __call__(self, design: Array) -> Array:
        """Differentiate at a design (n,): rows of objectives, inequalities, equalities, (no + ni + ne, n).

        Entries without a derivative are NaN: the run failed, or went beyond the horizon of predictability. At a design
        that was not run, because formulas exclude it, derivatives of numbers of runs are zero.
        """
        study, state = self.study, self._evaluate(design[None])
        absent = 0.0 if state.unrun[0] else np.nan
        points = [{} if state.failed[0] or state.unrun[0] else self._run(design, point) for point in study.points]
        names = [name for _, name, _ in study.quantities]
        rows = np.array([self._quantity(name, each, design, points, absent) for _, name, each in study.quantities])
        rows = rows / self._scales[:, None]
        parts: dict[bool, list[Array]] = {False: [], True: []}
        for key, name, limit, sign in limits(study):
            parts[key.endswith(".equals")].append(sign * rows[names.index(name)] / (abs(limit) or 1.0))
        return np.vstack([rows[: len(study.signs)] * np.array(study.signs)[:, None], *parts[False], *parts[True]])

    def _run(self, design: Array, point: OperatingPoint) -> _Functionals:
        """Run a design at an operating point, with derivatives; empty if there is no run."""
        study, outputs = self.study, list(dict.fromkeys(output for output, _, _ in self._terms))
        if not outputs:
            return {}
        rates = self._changes(lambda one: dict(zip(point.paths, study.row(one, point), strict=True)), design)
        wrt = [
            Direction(name, float(x), {path: rate for path, rate in each.items() if rate != 0.0})
            for name, x, each in zip(study.names, design, rates, strict=True)
        ]
        try:
            run = simulate(study.system(design, point), outputs=outputs, wrt=wrt)
        except (InputError, RunError):
            return {}
        return _functionals(run, point.windows, list(self._terms)) if run.status is Status.OK else {}

    def _changes(self, numbers: Callable[[Array], Mapping[str, float]], design: Array) -> list[dict[str, float]]:
        """Differentiate named numbers of a design with respect to each variable, by central differences."""
        found = []
        for k, span in enumerate(self.study.upper - self.study.lower):
            low, high = design.copy(), design.copy()
            h = _STEP * (span if span > 0.0 else abs(design[k]) or 1.0)
            low[k], high[k] = design[k] - h, design[k] + h
            before, after = numbers(low), numbers(high)
            found.append({key: (after[key] - x) / (high[k] - low[k]) for key, x in before.items()})
        return found

    def _quantity(
        self, name: str, quantity: Quantity, design: Array, points: Sequence[_Functionals], absent: float
    ) -> Array:
        """Return the derivatives of a quantity, (n,)."""
        if quantity.terms is None:
            formula, study = self.study.formulas[name], self.study
            changes = self._changes(lambda one: {name: formula(study.named(one))}, design)
            return np.array([change[name] for change in changes])
        rows = [term.weight * _term(term, points, np.full(1 + len(design), absent)) for term in quantity.terms]
        return _aggregate(quantity.over_terms, rows)[1:]


def check_sensitivities(study: Study) -> None:
    """Check that every output of a study has sensitivities.

    Raises
    ------
    InputError
        If one is a service life or belongs to the ideal linkage.
    """
    for _, _, quantity in study.quantities:
        for term in quantity.terms or ():
            if term.output.startswith((LIFE, IDEAL)):
                problem = f'{term.output} has no sensitivities; give "differences"'
                raise InputError(study.source, "algorithm.derivatives", problem)


def _term(term: Term, points: Sequence[_Functionals], absent: Array) -> Array:
    """Return a functional and its derivatives over windows and operating points, (1 + n,)."""
    key, found = (term.output, term.window, term.functional), []
    for point in points:
        found.append(_aggregate(term.over_windows, point[key]) if key in point else absent)
    return _aggregate(term.over_points, found)


def _aggregate(how: str, rows: Sequence[Array] | Array) -> Array:
    """Combine numbers with their derivatives as the evaluator combines numbers."""
    table = np.array(rows)
    if how in ("max", "min"):
        return np.asarray(table[np.argmax(table[:, 0]) if how == "max" else np.argmin(table[:, 0])])
    return np.asarray(table.sum(axis=0) if how == "sum" else table.mean(axis=0))


def _functionals(run: Trajectory, windows: Mapping[str, Array], terms: Sequence[tuple[str, str, str]]) -> _Functionals:
    """Compute functionals of a run with their derivatives."""
    parts = {(name, k): _part(run, *ends) for _, name, _ in terms for k, ends in enumerate(windows[name])}
    tops: dict[tuple[str, str, int], Extremes] = {}
    for output, name, functional in terms:
        for k in range(len(windows[name])) if functional in _EXTREMES else ():
            tops[output, name, k] = extremes(parts[name, k], [output])[output]
    times = np.unique([t for top in tops.values() for t in (top.time_min, top.time_max)])
    at_tops = run.sensitivity.evaluate(times) if len(times) else {}

    def at(output: str, value: float, time: float) -> Array:
        return np.array([value, *(column[output][np.searchsorted(times, time)] for column in at_tops.values())])

    found: _Functionals = {}
    for output, name, functional in terms:
        rows = []
        for k in range(len(windows[name])):
            if functional in _EXTREMES:
                top = tops[output, name, k]
                low, high = at(output, top.min, top.time_min), at(output, top.max, top.time_max)
                peak = high if top.max >= -top.min else -low
                rows.append({"max": high, "min": low, "peak": peak, "range": high - low}[functional])
            else:
                rows.append(_average(parts[name, k], output, functional))
        found[output, name, functional] = np.array(rows)
    return found


def _part(run: Trajectory, start: float, end: float) -> Trajectory:
    """Return the run between two times, with its sensitivities."""
    end = min(end, float(run.time[-1]))
    if start <= run.time[0] and end >= run.time[-1]:
        return run
    assert run.evaluate is not None
    times = np.union1d(run.time[(run.time >= start) & (run.time <= end)], [start, end])
    columns = {"time": times, **run.evaluate(times)}
    rates = replace(run.sensitivity, columns=run.sensitivity.evaluate(times))
    return Trajectory(times, columns, run.status, {}, run.evaluate, sensitivity=rates)


def _average(part: Trajectory, output: str, functional: str) -> Array:
    """Mean, integral or root mean square of an output, and its derivatives."""
    span, column = float(np.ptp(part.time)), part[output]
    rates = [columns[output] for columns in part.sensitivity.values()]
    if functional == "rms":
        squares = np.array([integral(part, x) for x in (column**2, *(2.0 * column * rate for rate in rates))]) / span
        rms = np.sqrt(max(squares[0], 0.0))
        return np.array([rms, *(squares[1:] / (2.0 * rms) if rms > 0.0 else np.full(len(rates), np.nan))])
    found = np.array([integral(part, x) for x in (column, *rates)])
    return found / span if functional == "mean" else found
