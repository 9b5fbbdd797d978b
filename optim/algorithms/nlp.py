"""`Problem`, the input of an algorithm: bounds and a function of populations; `Result`, its output."""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arguments import shaped
from linkages.base.arrays import Array
from linkages.base.errors import InputError


class Ending(enum.StrEnum):
    """Why an algorithm stopped; the value is the name used in files, `remedy` is what to try."""

    CONVERGED = "converged"
    BUDGET_USED = "budget-used"
    NO_PROGRESS = "no-progress"
    INFEASIBLE = "infeasible"
    EVALUATION_FAILED = "evaluation-failed"
    INTERRUPTED = "interrupted"

    @property
    def words(self) -> str:
        """Return a text for readers."""
        return _TEXTS[self][0]

    @property
    def remedy(self) -> str:
        """Return the advice for the user, in one sentence."""
        return _TEXTS[self][1]


#: Text and remedy of each ending.
_TEXTS = {
    Ending.CONVERGED: ("converged", "nothing: the conditions of optimality hold within the tolerance"),
    Ending.BUDGET_USED: ("all iterations made", "all iterations were made: more of them may find a better design"),
    Ending.NO_PROGRESS: (
        "no further progress",
        "no step betters the objective: if it is rough, take a longer difference step or an algorithm without"
        " gradients; if it is smooth, this is the optimum as far as it can be resolved",
    ),
    Ending.INFEASIBLE: (
        "no feasible design found",
        "no design near the last one violates the constraints less: start elsewhere, take several starts, or loosen"
        " the constraints",
    ),
    Ending.EVALUATION_FAILED: (
        "an evaluation failed",
        "there is no value at the start, or around a design that was reached: start elsewhere or tighten the bounds",
    ),
    Ending.INTERRUPTED: ("interrupted", "the run was stopped by the user; the results up to then are kept"),
}


@dataclass(frozen=True)
class Values:
    """Objectives and constraints of m designs.

    Attributes
    ----------
    objectives : (m, no) array
        Smaller is better; infinite where the evaluation failed, or was not made because constraints are violated.
    inequalities : (m, ni) array
        Satisfied where <= 0; infinite where the evaluation failed.
    equalities : (m, ne) array
        Satisfied where = 0.
    failed : (m,) array of bool
        Where there is no value: the run did not reach its end, or the linkage could not be assembled.

    Examples
    --------
    >>> import numpy as np
    >>> from optim import Values
    >>> values = Values(np.array([[3.0], [1.0]]), np.array([[-1.0], [0.5]]), np.empty((2, 0)), np.zeros(2, dtype=bool))
    >>> values.violation, values.feasible()
    (array([0. , 0.5]), array([ True, False]))
    """

    objectives: Array
    inequalities: Array
    equalities: Array
    failed: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.objectives)

    @property
    def violation(self) -> Array:
        """Return the sum of all violated constraints, (m,); zero if feasible, infinite if the evaluation failed."""
        total = np.maximum(self.inequalities, 0.0).sum(axis=1) + np.abs(self.equalities).sum(axis=1)
        return np.where(self.failed, np.inf, total)

    def feasible(self, tolerance: float = 0.0) -> NDArray[np.bool_]:
        """Tell where every constraint holds within a tolerance, in its own unit, (m,)."""
        residuals = np.hstack([self.inequalities, np.abs(self.equalities)])
        return ~self.failed & (residuals.max(axis=1, initial=0.0) <= tolerance)

    def take(self, rows: Any) -> Values:
        """Return the values of some designs, by a list or array of indices, or a mask."""
        return Values(*(column[rows] for column in vars(self).values()))

    @staticmethod
    def join(parts: Sequence[Values]) -> Values:
        """Join the values of several populations, one below the other."""
        return Values(*map(np.concatenate, zip(*(vars(part).values() for part in parts), strict=True)))


@dataclass(frozen=True)
class Problem:
    """Minimise objectives over a box, subject to constraints; `optim.problem_of` makes one from a study.

    Attributes
    ----------
    lower, upper : (n,) arrays
        Bounds of the variables.
    evaluate : callable
        Gives the `Values` of designs (m, n); deterministic, and the same for a design whatever population it comes in.
    objectives, inequalities, equalities : tuples of str
        Names, in the order of the columns of `Values`.
    start : (n,) array or None
        The nominal design.
    jacobian : callable or None
        Gives the derivatives at a design (n,), as (no + ni + ne, n): rows of the objectives, inequalities, equalities.
        Without it, and where it is not finite, gradient methods take differences.
    constraints : callable or None
        Gives inequalities and equalities at a design (n,), as (ni + ne,), if they are known without an evaluation; a
        method that returns to the constraints then evaluates only where they hold.
    """

    lower: Array
    upper: Array
    evaluate: Callable[[Array], Values]
    objectives: tuple[str, ...] = ("objective",)
    inequalities: tuple[str, ...] = ()
    equalities: tuple[str, ...] = ()
    start: Array | None = None
    jacobian: Callable[[Array], Array] | None = None
    constraints: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "start"):
            if (given := getattr(self, name)) is not None:
                found = shaped(given, (np.size(self.lower),), name, "numbers")
                object.__setattr__(self, name, found)

    def values(self, designs: Array) -> Values:
        """Evaluate designs (m, n); InputError if the result of the function does not fit them."""
        found, m = self.evaluate(designs), len(designs)
        if not isinstance(found, Values):
            raise InputError("problem", "evaluate", f"returned a {type(found).__name__}; it must be a Values of optim")
        for name in ("objectives", "inequalities", "equalities"):
            shaped(getattr(found, name), (m, len(getattr(self, name))), "evaluate", name)
        shaped(found.failed, (m,), "evaluate", "failed")
        return found

    def derivatives(self, x: Array) -> Array | None:
        """Compute the derivatives at a design (n,) where the problem has them; InputError for another shape."""
        if self.jacobian is None:
            return None
        rows = len(self.objectives) + len(self.inequalities) + len(self.equalities)
        return shaped(self.jacobian(x), (rows, self.size), "jacobian", "derivatives")

    @property
    def size(self) -> int:
        """Return the number of variables."""
        return len(self.lower)

    @property
    def first(self) -> Array:
        """Return the point where a local method begins: the start, within the bounds; without one their middle."""
        start = (self.lower + self.upper) / 2.0 if self.start is None else self.start
        return np.clip(np.asarray(start, dtype=float), self.lower, self.upper)


@dataclass(frozen=True)
class Progress:
    """State of an algorithm after an iteration (a generation, a line search), for the `progress` of `optim.minimise`.

    Attributes
    ----------
    iteration, iterations : int
        Number of this iteration, the first being 1, and the largest number.
    best : (k, n) array
        The best design so far; of several objectives, the Pareto front.
    values : Values
        Values of these designs.
    state : dict
        Population and states of the random generators, as JSON types. For the record: a run is resumed by running the
        algorithm again on stored values.
    """

    iteration: int
    iterations: int
    best: Array
    values: Values
    state: dict[str, Any] = field(default_factory=dict)


#: Called after each iteration; if it raises KeyboardInterrupt, the best design so far is returned.
Report = Callable[[Progress], None]


@dataclass(frozen=True)
class Result:
    """Output of an algorithm; made by `optim.minimise`.

    Attributes
    ----------
    x : (k, n) array
        The best design; of several objectives, the Pareto front.
    values : Values
        Values of these designs.
    status : Ending
        Why the algorithm stopped.
    iterations, evaluations : int
        Evaluations count each design once.
    runs : tuple of Result
        The parts of an algorithm that starts several times.
    """

    x: Array
    values: Values
    status: Ending
    iterations: int
    evaluations: int
    runs: tuple[Result, ...] = ()
