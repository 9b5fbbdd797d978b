"""One attempted step of the equations of motion, by the implicit or the explicit method."""

from __future__ import annotations

from linkages.engines.compiled.equations import arrive, derivatives, residual
from linkages.engines.compiled.jacobian import jacobian
from linkages.engines.compiled.model import Equations
from linkages.integrate.dormand_prince import dormand_prince
from linkages.integrate.radau import radau
from linkages.integrate.stepper import Stepper
from linkages.kernel import Array, kernel, late_kernel

_radau = radau(derivatives, residual, jacobian, arrive)
_dormand_prince = dormand_prince(derivatives)


@late_kernel
def attempt_radau(equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
    """Attempt a step with Radau IIA, see `linkages.integrate.radau`."""
    return _radau(equations, s, t, h, y, exact)


@late_kernel
def attempt_dormand_prince(
    equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool
) -> tuple[float, float]:
    """Attempt a step with Dormand and Prince's pair, see `linkages.integrate.dormand_prince`."""
    return _dormand_prince(equations, s, t, h, y, exact)


@kernel
def attempt(equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
    """Attempt a step with the method of the equations."""
    if equations.implicit:
        return attempt_radau(equations, s, t, h, y, exact)
    return attempt_dormand_prince(equations, s, t, h, y, exact)
