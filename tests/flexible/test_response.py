"""Generalised-alpha and the exact step of a mode against known solutions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from linkages.base.errors import InputError
from linkages.mechanics.flexible.response import generalised_alpha, modal_step


@pytest.mark.parametrize("radius", [0.0, 0.5, 0.9, 1.0])
def test_generalised_alpha_is_of_second_order(radius: float) -> None:
    """A made-up solution of equations whose mass, damping and stiffness all change with time."""
    rng = np.random.default_rng(4)
    base = [a @ a.T + 3.0 * np.eye(3) for a in rng.normal(size=(3, 3, 3))]

    def exact(t: np.ndarray) -> list[np.ndarray]:
        w = np.array([1.0, 1.7, 2.3])
        a = np.outer(t, w)
        return [np.sin(a), w * np.cos(a), -(w**2) * np.sin(a)]

    def matrices(t: np.ndarray) -> tuple[np.ndarray, ...]:
        m = base[0] * (1.0 + 0.3 * np.sin(t))[:, None, None]
        c = 0.1 * base[1] * (1.0 + 0.5 * np.cos(2 * t))[:, None, None]
        k = base[2] * (1.0 + 0.4 * np.cos(t))[:, None, None]
        u, v, a = exact(t)
        return m, c, k, sum(np.einsum("nij,nj->ni", x, y) for x, y in ((m, a), (c, v), (k, u)))

    errors = []
    for steps in (200, 400, 800):
        times = np.linspace(0.0, 5.0, steps + 1)
        start = exact(times[:1])
        u = np.vstack([part[0] for part in generalised_alpha(matrices, times, start[0][0], start[1][0], radius)])
        errors.append(np.max(np.abs(u - exact(times)[0])))
    np.testing.assert_allclose(np.log2(np.array(errors)[:-1] / np.array(errors)[1:]), 2.0, atol=0.1)


@pytest.mark.parametrize("radius", [-0.1, 1.1])
def test_the_spectral_radius_has_its_range(radius: float) -> None:
    with pytest.raises(InputError, match="generalised-alpha: radius"):
        next(generalised_alpha(lambda t: (t, t, t, t), np.array([0.0, 1.0]), np.zeros(1), np.zeros(1), radius))


@pytest.mark.parametrize("beta", [0.0, 1e-3, 1.0], ids=["undamped", "underdamped", "overdamped"])
@pytest.mark.parametrize("square", [40.0, 1e-6, 0.0, -1e-10])
def test_the_step_of_a_mode_is_exact(beta: float, square: float) -> None:
    """Against the matrix exponential of (q, q', force), without stiffness too, but for rounding."""
    alpha, step = 0.3 if beta else 0.0, 0.37
    q, dq, force = 0.2, -1.1, 5.0
    system = np.array([[0.0, 1.0, 0.0], [-square, -(alpha + beta * square), 1.0], [0.0, 0.0, 0.0]])
    want = expm(step * system) @ [q, dq, force]
    found = modal_step(np.array([square]), alpha, beta, np.array([q]), np.array([dq]), np.array([force]), step)
    np.testing.assert_allclose(np.ravel(found), want[:2], rtol=1e-12 if square == 40.0 else 1e-8)


def test_a_stiff_mode_creeps_to_its_static_place() -> None:
    """Damping beta K: the slow root is -1/beta; the fast one, -beta p^2, is far below the range of exp."""
    square, beta, q, force = 1e12, 0.5, 0.2, 5.0
    with np.errstate(all="raise", under="ignore"):
        found, rate = modal_step(np.array([square]), 0.0, beta, np.array([q]), np.array([3.0]), np.array([force]), 0.4)
    assert found[0] == pytest.approx(q * np.exp(-0.8), rel=1e-10)
    assert rate[0] == pytest.approx(-q / beta * np.exp(-0.8), rel=1e-10)
