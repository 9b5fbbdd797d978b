"""One attempted step of the equations of motion, by the implicit or the explicit method."""

from __future__ import annotations

from linkages.base.kernel import Array, kernel, lazy_kernel
from linkages.engines.compiled.run.equations import arrive, derivatives, residual
from linkages.engines.compiled.run.jacobian import jacobian
from linkages.engines.compiled.run.model import Equations
from linkages.mechanics.integrate.explicit import explicit
from linkages.mechanics.integrate.implicit import implicit
from linkages.mechanics.integrate.stepper import Stepper
from linkages.mechanics.integrate.tableau import DORMAND_PRINCE_5_4, RADAU_IIA_5

_radau_iia_5 = implicit(RADAU_IIA_5, derivatives, residual, jacobian, arrive)
_dormand_prince_5_4 = explicit(DORMAND_PRINCE_5_4, derivatives)


@lazy_kernel
def attempt_radau_iia_5(
    equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool
) -> tuple[float, float]:
    """Attempt a step of Radau IIA of order 5, see `linkages.mechanics.integrate.implicit`."""
    return _radau_iia_5(equations, s, t, h, y, exact)


@lazy_kernel
def attempt_dormand_prince_5_4(
    equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool
) -> tuple[float, float]:
    """Attempt a step of the pair of Dormand and Prince, see `linkages.mechanics.integrate.explicit`."""
    return _dormand_prince_5_4(equations, s, t, h, y, exact)


@kernel
def attempt(equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
    """Attempt a step with the method of the equations."""
    if equations.implicit:
        return attempt_radau_iia_5(equations, s, t, h, y, exact)
    return attempt_dormand_prince_5_4(equations, s, t, h, y, exact)
