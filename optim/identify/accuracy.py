"""The error of the runs themselves: how far it shifts the values of a fit, and runs that are accurate enough."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.writing import finite
from optim.identify.algebra import inverse
from optim.identify.budget import USUAL
from optim.identify.fit import Fitted, fit_again, refine
from optim.identify.numerics import (
    ACCURACY_ENOUGH,
    ACCURACY_FINER,
    ACCURACY_FINEST,
    ACCURACY_ROUNDS,
    ACCURACY_SAFETY,
    TINY,
)
from optim.identify.residuals import Residuals
from optim.identify.result import Accuracy
from optim.identify.statistics import Statistics


@dataclass(frozen=True, eq=False)
class ErrorOfRuns:
    """The effect of the error of the runs on the values of a fit.

    Attributes
    ----------
    accuracy : float
        Of the runs.
    given : float
        The accuracy of the file.
    shift : (k,) array
        Estimated error of the scaled values; NaN if more accurate runs fail.
    worst : float
        Largest shift in deviations of white residuals.
    ended : bool
        Whether the limit of time ended the search, or the accurate runs after it.
    """

    accuracy: float
    given: float
    shift: Array
    worst: float
    ended: bool = False

    def described(self) -> Accuracy:
        """Return the error as in a result."""
        return Accuracy(given=self.given, used=self.accuracy, largest_shift=finite(self.worst))

    def warnings(self, seconds: float | None) -> list[str]:
        """Return the notes on the runs after a limit of time [s]."""
        said = []
        if self.ended:
            said.append(
                f"the limit of time, {seconds or USUAL:g} s, ended the fit: these are its best values; fit.time raises"
                " it"
            )
        if math.isnan(self.worst) and self.ended:
            said.append("the error of the runs is not known: the limit of time left no more accurate run")
        elif math.isnan(self.worst):
            said.append("the error of the runs is not known: more accurate runs do not reach their end")
        elif self.worst > ACCURACY_ENOUGH:
            said.append(
                f"the error of the runs shifts values by up to {self.worst:.2g} deviations at solver.accuracy ="
                f" {self.accuracy:.0e}; the intervals contain it"
            )
        return said


def accurate(
    residuals: Residuals, found: Fitted, show: Callable[[str], None] = lambda text: None, converged: bool = True
) -> tuple[Residuals, Fitted, ErrorOfRuns]:
    """Repeat a fit with more accurate runs until their error shifts no value by more than a tenth of its deviation.

    The shift follows from the residuals of ten times more accurate runs with the same values: the change of the least
    squares. A search that has not converged is not repeated.
    """
    given = residuals.accuracy()
    if isinstance(residuals, Statistics):  # the scatter of its runs contains their error
        return residuals, found, ErrorOfRuns(given, given, np.zeros(len(found.z)), 0.0)
    shift, worst, ended = np.full(len(found.z), np.nan), math.nan, False
    for _ in range(ACCURACY_ROUNDS):
        ended = residuals.budget.late
        if ended:
            break
        shift, worst = shifted(residuals, found)
        accuracy = residuals.accuracy()
        if not worst > ACCURACY_ENOUGH or accuracy <= ACCURACY_FINEST or not converged:
            break
        ended = residuals.budget.late
        if ended:
            break
        wanted = accuracy * min(ACCURACY_SAFETY * ACCURACY_ENOUGH / worst, ACCURACY_FINER)
        finer = residuals.at_accuracy(max(10.0 ** math.floor(math.log10(wanted)), ACCURACY_FINEST))
        again = refine(finer, fit_again(finer, found))
        if again.evaluated.reason:
            break
        residuals, found = finer, again
        show(f"solver.accuracy {residuals.accuracy():.0e}, {found.runs} runs")
    return residuals, found, ErrorOfRuns(residuals.accuracy(), given, shift, worst, ended)


def shifted(residuals: Residuals, found: Fitted) -> tuple[Array, float]:
    """Return the shift of the scaled values (k,) by the error of the runs, and the largest one in deviations."""
    finer = residuals.at_accuracy(ACCURACY_FINER * residuals.accuracy())
    other = finer(found.z, found.horizon, derivatives=False)
    if other.reason:
        return np.full(len(found.z), np.nan), math.nan
    sides, root = inverse(found.evaluated.jacobian)
    shift = -root @ (sides.T @ (other.residual - found.evaluated.residual))
    deviations = np.maximum(np.linalg.norm(root, axis=1), TINY)
    return shift, float(np.max(np.abs(shift) / deviations, initial=0.0))
