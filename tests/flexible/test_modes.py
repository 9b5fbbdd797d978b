"""Eigenproblems against closed forms, dense against sparse, and modes followed where frequencies cross or veer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import brentq

from linkages.mechanics.flexible.beam import Beam, chain
from linkages.mechanics.flexible.modes import ModesAt, dense_modes, eigenvalues, mac, sparse_modes, track


def test_dense_and_sparse_modes_of_a_free_beam_agree() -> None:
    """Three rigid modes, then cos z cosh z = 1."""
    count = 24
    piece = Beam(1.0, 1e6, 1.0, 1.0).piece(count)
    k, m = chain(piece.stiffness(), count), chain(piece.mass(), count)
    values, shapes = dense_modes(k[None], m[None], 6)
    thin, forms = sparse_modes(sparse.csc_matrix(k), sparse.csc_matrix(m), 6)
    z = brentq(lambda z: np.cos(z) * np.cosh(z) - 1, 4.0, 5.0)
    assert np.all(np.abs(values[0, :3]) < 1e-6 * values[0, 3])
    assert np.sqrt(values[0, 3]) == pytest.approx(z**2, rel=1e-5)
    np.testing.assert_allclose(thin[3:], values[0, 3:], rtol=1e-7)
    np.testing.assert_allclose(forms.T @ m @ forms, np.eye(6), atol=1e-9)
    np.testing.assert_allclose(shapes[0].T @ m @ shapes[0], np.eye(6), atol=1e-9)
    np.testing.assert_allclose(np.diag(mac(shapes[0, :, 3:], forms[:, 3:], m)), 1.0, rtol=1e-9)


def test_eigenvalues_of_a_damped_oscillator() -> None:
    found = eigenvalues(np.array([[2.0]]), np.array([[0.4]]), np.array([[18.0]]))
    np.testing.assert_allclose(np.sort_complex(found), -0.1 + 1j * np.sqrt(9.0 - 0.01) * np.array([-1, 1]))


def test_modes_are_followed_where_frequencies_cross() -> None:
    """Uncoupled, the modes keep their shapes and exchange their order: p^2 = 1 + t and 2 - t."""
    mass = np.diag([2.0, 3.0])

    def at(t: float) -> ModesAt:
        values, shapes = dense_modes((mass @ np.diag([1.0 + t, 2.0 - t]))[None], mass[None], 2)
        return ModesAt(t, values[0], shapes[0], mass)

    times = np.linspace(0.0, 1.0, 8)
    values, shapes, quality = track(map(at, times), at, 2)
    np.testing.assert_allclose(values, np.column_stack([1.0 + times, 2.0 - times]), rtol=1e-12)
    np.testing.assert_allclose(shapes, np.tile(shapes[0], (8, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(quality, 1.0, rtol=1e-12)


def test_a_step_into_a_veering_is_halved() -> None:
    """Weakly coupled, the modes keep their order and exchange their shapes, within far less than a step."""

    def at(t: float) -> ModesAt:
        values, shapes = dense_modes(np.array([[[1.0 + t, 0.05], [0.05, 2.0 - t]]]), np.eye(2)[None], 2)
        return ModesAt(t, values[0], shapes[0], np.eye(2))

    values, shapes, quality = track(map(at, [0.0, 0.5, 1.0]), at, 2)
    np.testing.assert_allclose(values[2], 1.5 + np.hypot(0.5, 0.05) * np.array([-1.0, 1.0]), rtol=1e-12)
    assert 0.9 <= np.min(quality) < 1.0
    assert mac(shapes[0], shapes[2], np.eye(2))[0, 0] < 0.05
