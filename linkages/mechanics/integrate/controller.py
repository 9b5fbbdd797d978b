"""Step-size control: the ratio of the next step size to the present one, from the error estimates."""

from __future__ import annotations

from typing import Any, NamedTuple

from linkages.base.kernel import inlined_kernel

_LEAST_ERROR = 1e-10  # smaller errors count as this one


class Controller(NamedTuple):
    """Settings of a controller; errors are relative to the tolerance.

    The ratio is ``safety * error**-proportional * previous**integral``, within limits. After a rejected step it is
    ``safety * error**-rejected``.
    """

    proportional: float
    integral: float
    rejected: float
    smallest: float
    largest: float


#: PI controller of an explicit pair of order 5(4): E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential
#: Equations I, 2nd ed., section II.4, with beta = 0.04.
PI_5_4 = Controller(0.17, 0.04, 0.2, 0.2, 8.0)

#: Controller for an error estimate of order 3: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd
#: ed., section IV.8.
ELEMENTARY_3 = Controller(0.25, 0.0, 0.25, 0.1, 8.0)


def controller(settings: Controller) -> Any:
    """Make the compiled function that computes the ratio."""
    proportional, integral, rejected, smallest, largest = settings

    @inlined_kernel
    def ratio(error: float, previous: float, safety: float) -> float:
        """Compute the next step size over the present one from the errors of this step and of the one before."""
        if error > 1.0:
            return max(smallest, safety * error**-rejected)
        return min(largest, max(smallest, safety * max(error, _LEAST_ERROR) ** -proportional * previous**integral))

    return ratio


@inlined_kernel
def predictive_limit(ratio: float, h: float, last: float, error: float, previous: float) -> float:
    """Limit the ratio by the trend of the error over two steps of sizes `last` and h.

    K. Gustafsson, Control-theoretic techniques for stepsize selection in implicit Runge-Kutta methods, ACM Transactions
    on Mathematical Software 20 (1994) 496-517.
    """
    trend = h / last * (previous / error) ** 0.25
    return min(ratio, ratio * trend)
