"""Least squares from one start: SciPy's trust region, with factors and biases eliminated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from linkages.base.arrays import Array
from optim.identify.algebra import complement
from optim.identify.numerics import SEARCH_ENOUGH, SEARCH_HELD, SEARCH_HELD_SENSOR
from optim.identify.residuals import Evaluated, Residuals

MOST = 60  # runs in a window


class Search:
    """Least squares over the values that move, with one run for residuals and derivatives.

    Factors and biases are eliminated: each design has its best ones, by linear regression (variable projection, Golub
    and Pereyra 1973; the Jacobian as Kaufman 1975). A design that does not run shortens the step.

    `moving` (k,) marks the values that move; the others stay as in `z`. `known` are the residuals at values of this
    horizon, with their best factors and biases.
    """

    def __init__(
        self, residuals: Residuals, z: Array, horizon: float, moving: NDArray[np.bool_] | None = None,
        known: Evaluated | None = None,
    ) -> None:  # fmt: skip
        self.residuals, self.horizon, self.runs = residuals, horizon, 0
        moving = np.ones(len(z), np.bool_) if moving is None else moving
        self.z, self.linear, self.moving = z.copy(), residuals.linear & moving, moving & ~residuals.linear
        self._latest = known
        self._best = None if known is None or known.reason else known

    def at(self, x: Array) -> Evaluated:
        """Evaluate the residuals, once for equal values."""
        for one in (self._latest, self._best):
            if one is not None and np.array_equal(one.z[self.moving], x):
                return one
        if self._best is not None and self.residuals.budget.late:
            raise _TimeIsUpError
        z = self.z.copy()
        z[self.moving] = x
        found = self.residuals(z, self.horizon, self.linear)
        self._latest, self.runs = found, self.runs + 1
        if self._best is None or np.sum(found.residual**2) < np.sum(self._best.residual**2):
            self._best = found
        return found

    def _projected(self, x: Array) -> Array:
        """Return the derivatives of the residuals with the best factors and biases of each design."""
        jacobian = self.at(x).jacobian
        if not self.linear.any():
            return jacobian[:, self.moving]
        return complement(jacobian[:, self.linear], jacobian[:, self.moving])

    def solve(self, most: int = MOST) -> Evaluated:
        """Minimise the sum of squares; return the residuals there, and all values."""
        moving, residuals = self.moving, self.residuals
        room = 1e-9 * np.where(np.isfinite(residuals.upper), residuals.upper - residuals.lower, 1.0)
        x = np.clip(self.z, residuals.lower + room, residuals.upper - room)[moving]
        if not len(x) or self.at(x).reason:
            return self.at(x)
        held, first = np.diag(self._weights(self._projected(x))), x
        try:
            found = least_squares(
                lambda x: np.append(self.at(x).residual, held @ (x - first)), x,
                lambda x: np.vstack([self._projected(x), held]), x_scale="jac",
                bounds=(residuals.lower[moving], residuals.upper[moving]), ftol=SEARCH_ENOUGH, xtol=SEARCH_ENOUGH,
                gtol=None, max_nfev=most,
            )  # fmt: skip
            return self.at(found.x)
        except _TimeIsUpError:
            assert self._best is not None
            return self._best

    def _weights(self, jacobian: Array) -> Array:
        """Return weights that hold values on which no residual depends; SciPy's steps are too long otherwise."""
        room = (self.residuals.upper - self.residuals.lower)[self.moving]
        size = np.linalg.norm(jacobian, axis=0)
        return np.where(np.isfinite(room), SEARCH_HELD / room, np.where(size > 0.0, SEARCH_HELD_SENSOR * size, 1.0))


class _TimeIsUpError(Exception):
    """The limit of time is reached within a search."""
