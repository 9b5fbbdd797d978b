"""The stiff problems themselves: SciPy's Radau reaches the published end values, the Jacobians belong to the rates."""

import numpy as np
import pytest
from ivp_problems import PROBLEMS
from scipy.integrate import solve_ivp

TOLERANCE = 1e-10  # of Radau; every problem damps errors, so that its end value is better than a step


def filled(function, case, t, y, *shape):
    out = np.full(shape, np.nan)
    function(case.problem, t, y, out)
    return out


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
def test_radau_reaches_the_published_end_values(name):
    case = PROBLEMS[name]
    n = len(case.start)
    run = solve_ivp(
        lambda t, y: filled(case.rhs, case, t, y, n),
        (0.0, case.end),
        case.start,
        method="Radau",
        jac=lambda t, y: filled(case.jacobian, case, t, y, n, n),
        rtol=TOLERANCE,
        atol=TOLERANCE * case.scale,
    )
    assert run.success
    np.testing.assert_allclose(run.y[:, -1], case.reference, rtol=TOLERANCE)


@pytest.mark.parametrize("name", PROBLEMS)
def test_jacobian_is_that_of_the_rates(name):
    """Central differences are exact for polynomials of degree two; van der Pol's cubic leaves the square of the step."""
    case = PROBLEMS[name]
    n = len(case.start)
    for y in (case.start, case.reference, 0.7 * case.start + 0.3):
        exact = filled(case.jacobian, case, 0.0, y, n, n)
        for j in range(n):
            step = np.zeros(n)
            step[j] = 1e-4 * max(abs(y[j]), 1e-3)
            up, down = (filled(case.rhs, case, 0.0, y + sign * step, n) for sign in (1.0, -1.0))
            difference = (up - down) / (2.0 * step[j])
            np.testing.assert_allclose(difference, exact[:, j], rtol=1e-6, atol=1e-7 * np.abs(exact).max())
