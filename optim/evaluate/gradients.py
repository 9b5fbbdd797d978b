"""`Gradients`: derivatives of a study's objectives and constraints by sensitivities of its runs.

A run gives the derivatives of its outputs with respect to all design variables (`linkages.simulate` with ``wrt``), and
these the derivatives of functionals (`linkages.results.statistic_derivatives`). Formulas of the design are
differentiated by central differences.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from linkages import Direction, InputError, RunError, Status, Trajectory
from linkages.base.arguments import Count, Vector, fitting, validated
from linkages.engines.assessment import differentiated
from linkages.engines.threads import in_threads
from linkages.results.outputs.registry import IDEAL
from linkages.results.statistic_derivatives import Wanted, differentiate_statistics
from optim.evaluate.evaluations import Evaluations
from optim.evaluate.limits import limits, scales
from optim.problem.schema import LIFE, StudyQuantity, Term
from optim.problem.study import Array, OperatingPoint, Study

_STEP = 1e-6  # of central differences of formulas, in parts of the range of a variable
_STATISTICS = {"max": "maximum", "min": "minimum"}  # of functionals with another name

#: By output, window and functional: in each window the number and its derivatives, (nw, 1 + n).
_Functionals = dict[tuple[str, str, str], Array]


class Gradients:
    """Differentiates objectives and limits as an algorithm sees them; see `optim.Problem`.

    Parameters
    ----------
    study : Study
    evaluate : callable
        From designs (m, n) to their evaluations: the function of the problem, a `Screened` one if the problem has one.
        Else designs that the problem does not run get derivatives of limits that it does not know.
    nominal : Evaluations
        Evaluation of the nominal design, by which relative quantities are divided.
    threads : int, optional
        Threads in which operating points are run; default: number of processors.

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

    @validated
    def __init__(
        self, study: Study, evaluate: Callable[[Array], Evaluations], nominal: Evaluations, threads: Count | None = None
    ) -> None:
        check_sensitivities(study)
        self.study, self._evaluate, self._scales = study, evaluate, scales(study, nominal)
        self._threads = threads
        self._terms = {
            (term.output, term.window, term.functional): None
            for _, _, quantity in study.quantities
            for term in quantity.terms or ()
        }

    @validated
    def __call__(self, design: Vector) -> Array:
        """Differentiate at a design (n,): rows of objectives, inequalities, equalities, (no + ni + ne, n).

        Entries without a derivative are NaN: the run failed, it went beyond the horizon of predictability, or an
        extreme is at a jump of its output, whose time changes with the design. At a design that was not run, because
        formulas exclude it, derivatives of numbers of runs are zero.
        """
        study, rows = self.study, self.rates(design)
        names = [name for _, name, _ in study.quantities]
        bounded = [limit.sign * rows[names.index(limit.name)] / limit.size for limit in limits(study)]
        return np.vstack([rows[: len(study.signs)] * np.array(study.signs)[:, None], *bounded])

    def rates(self, design: Vector) -> Array:
        """Differentiate the objectives, then the constraints, in the units of the file; entries as of a call."""
        study = self.study
        state = self._evaluate(fitting(design, len(study.names), "design", "variables")[None])
        absent = 0.0 if state.unrun[0] else np.nan
        points: list[_Functionals] = [{} for _ in study.points]
        if not (state.failed[0] or state.unrun[0]):
            points = in_threads(lambda k: self._run(design, study.points[k]), len(points), self._threads)
        rows = np.array([self._quantity(name, each, design, points, absent) for _, name, each in study.quantities])
        return rows / self._scales[:, None]

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
            run = differentiated(study.system(design, point), outputs, wrt)
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
        self, name: str, quantity: StudyQuantity, design: Array, points: Sequence[_Functionals], absent: float
    ) -> Array:
        """Return the derivatives of a quantity, (n,)."""
        if quantity.terms is None:
            formula, study = self.study.formulas[name], self.study
            changes = self._changes(lambda one: {name: formula(study.named(one))}, design)
            return np.array([change[name] for change in changes])
        rows = [term.weight * _term(term, points, np.full(1 + len(design), absent)) for term in quantity.terms]
        return _aggregate(quantity.over_terms, rows)[1:]


def check_sensitivities(study: Study) -> None:
    """Refuse a study with a quantity that has no sensitivities: of machines, a service life, the ideal linkage."""
    if study.scatter is not None and not study.file.sampled:
        raise InputError(
            study.source, "algorithm.derivatives", 'has no sensitivities over [scatter]; give "differences"'
        )
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
    wanted = {
        (term, k): Wanted(term[0], _STATISTICS.get(term[2], term[2]), float(start), float(end))
        for term in terms
        for k, (start, end) in enumerate(windows[term[1]])
    }
    found = dict(zip(wanted, differentiate_statistics(run, list(wanted.values())), strict=True))
    rows = {key: np.array([one.number, *np.where(one.jump, np.nan, one.rates)]) for key, one in found.items()}
    return {term: np.array([rows[term, k] for k in range(len(windows[term[1]]))]) for term in terms}
