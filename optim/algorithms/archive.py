"""`Archive`: every design that an algorithm evaluated in one run, none twice; order by feasibility; first designs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from linkages.base.arrays import Indices
from optim.algorithms.nlp import Array, Ending, Problem, Result, Values
from optim.algorithms.pareto import pareto_front


class Archive:
    """Evaluate populations of a problem, each design once, and remember all.

    Values that are not finite count as failed evaluations: infinite objectives and inequalities. Only a design that
    violates constraints may have infinite objectives: they were not evaluated.

    Parameters
    ----------
    problem : Problem

    Attributes
    ----------
    designs : (k, n) array
        All designs, in the order of their evaluation.
    values : Values
        Values of these designs; missing before the first evaluation.

    Examples
    --------
    >>> import numpy as np
    >>> import optim
    >>> def evaluate(designs):
    ...     m = len(designs)
    ...     return optim.Values(designs**2, np.empty((m, 0)), np.empty((m, 0)), np.zeros(m, dtype=bool))
    >>> archive = optim.Archive(optim.Problem(np.zeros(1), np.ones(1), evaluate))
    >>> found = archive(np.array([[0.5], [0.1], [0.5]]))
    >>> len(archive), archive.designs[archive.best()]
    (2, array([0.1]))
    """

    values: Values

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._rows: dict[bytes, int] = {}
        self._front, self._compared = np.empty(0, dtype=np.intp), 0  # of so many designs
        self.designs = np.empty((0, problem.size))

    def __call__(self, designs: Array) -> Values:
        """Values of designs (m, n): new ones are evaluated in one call, each once."""
        designs = np.atleast_2d(np.asarray(designs, dtype=float)) + 0.0  # + 0.0: -0.0 and 0.0 are one design
        names = [design.tobytes() for design in designs]
        new = {name: i for i, name in enumerate(names) if name not in self._rows}
        if new:
            rows = sorted(new.values())
            values = _finite_or_failed(self.problem.values(designs[rows]))
            for row in rows:
                self._rows[names[row]] = len(self._rows)
            self.values = Values.join([self.values, values]) if len(self.designs) else values
            self.designs = np.concatenate([self.designs, designs[rows]])
        return self.values.take([self._rows[name] for name in names])

    def __len__(self) -> int:
        return len(self._rows)

    def best(self, tolerance: float = 0.0) -> int:
        """Return the row of the best design by the first objective and the rules of feasibility."""
        return int(by_feasibility(self.values, tolerance)[0])

    def front(self, tolerance: float = 0.0) -> Indices:
        """Return the rows of the Pareto front (`pareto_front`) at always the same tolerance."""
        rows = np.concatenate([self._front, np.arange(self._compared, len(self))])
        found = pareto_front(self.values.take(rows), tolerance, len(self._front))
        self._front, self._compared = rows[found], len(self)
        return self._front

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let a KeyboardInterrupt end the block without an error, if there is something to return."""
        try:
            yield
        except KeyboardInterrupt:
            if not len(self):
                raise

    def result(
        self, rows: Any, status: Ending, iterations: int, tolerance: float, runs: Sequence[Result] = ()
    ) -> Result:
        """Return designs by row; unless interrupted, the status holds only if one of them is feasible."""
        values = self.values.take(rows)
        if status is not Ending.INTERRUPTED and not values.feasible(tolerance).any():
            status = Ending.EVALUATION_FAILED if values.failed.all() else Ending.INFEASIBLE
        return Result(self.designs[rows], values, status, iterations, len(self), tuple(runs))


def by_feasibility(values: Values, tolerance: float = 0.0) -> Indices:
    """Sort designs, the best first; return their rows (m,).

    Feasible ones (violations up to the tolerance) by the first objective, then infeasible ones by their violation, then
    failed ones; equal ones in their order. K. Deb, An efficient constraint handling method for genetic algorithms,
    Computer Methods in Applied Mechanics and Engineering 186 (2000) 311-338.
    """
    feasible = values.feasible(tolerance)
    key = np.where(feasible, values.objectives[:, 0], values.violation)
    return np.lexsort((key, ~feasible))


def latin_hypercube(count: int, size: int, rng: np.random.Generator) -> Array:
    """Draw designs (count, size), 0 to 1: each variable has one in each of `count` equal parts of its range.

    The state of the random generator stays the same; each call draws other designs. The numbers come from
    `scipy.stats.qmc.LatinHypercube`; its import takes as long as several hundred runs of a small machine. M. D. McKay,
    R. J. Beckman, W. J. Conover, A comparison of three methods for selecting values of input variables in the analysis
    of output from a computer code, Technometrics 21(2), 1979.

    Examples
    --------
    >>> import numpy as np
    >>> from optim.algorithms.archive import latin_hypercube
    >>> designs = latin_hypercube(4, 2, np.random.default_rng(0))
    >>> np.sort(np.floor(4.0 * designs), axis=0).T.tolist()
    [[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]]
    """
    rng = rng.spawn(1)[0]
    within = rng.uniform(size=(count, size))
    parts = np.tile(np.arange(1, count + 1), (size, 1))
    for one in parts:
        rng.shuffle(one)
    return (parts.T - within) / count


def _finite_or_failed(values: Values) -> Values:
    """Mark rows that hold anything not finite as failed."""
    unasked = np.isposinf(values.objectives) & (values.violation > 0.0)[:, None]
    columns = values.objectives, values.inequalities, values.equalities
    known = np.isfinite(np.hstack([np.where(unasked, 0.0, values.objectives), *columns[1:]]))
    failed = values.failed | ~known.all(axis=1)
    f, g, h = (np.where(failed[:, None], np.inf, column) for column in columns)
    return Values(f, g, h, failed)
