"""Beam elements against closed forms: frequencies and their order, deflection, internal forces, spinning."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from linkages.base.errors import InputError
from linkages.mechanics.flexible.beam import Beam, chain
from linkages.mechanics.flexible.modes import eigenvalues

D, L, E, RHO, NU = 0.04, 0.422, 2.06e11, 7850.0, 0.3
AREA, INERTIA = np.pi * D**2 / 4, np.pi * D**4 / 64
ROD = Beam(L, E * AREA, E * INERTIA, RHO * AREA)
SHEAR = 6 * (1 + NU) / (7 + 6 * NU) * E / (2 + 2 * NU) * AREA
THICK = Beam(L, E * AREA, E * INERTIA, RHO * AREA, SHEAR, RHO * INERTIA)


def spectrum(beam: Beam, count: int, held: list[int], axial: bool = False) -> np.ndarray:
    """Angular frequencies of a chain; `held` counts displacements from the start, negative from the end."""
    piece = beam.piece(count)
    k, m = chain(piece.stiffness(), count), chain(piece.mass(), count)
    size = len(k)
    along = set(range(0, size, 3))
    keep = along if axial else set(range(size)) - along
    keep = sorted(keep - {h % size for h in held})
    return np.sqrt(eigh(k[np.ix_(keep, keep)], m[np.ix_(keep, keep)], eigvals_only=True))


def root(f, low: float, high: float) -> float:
    return float(brentq(f, low, high, xtol=1e-14, rtol=1e-14))


CLAMPED_FREE = root(lambda z: np.cos(z) * np.cosh(z) + 1, 1.5, 2.5)
CLAMPED_FREE_2 = root(lambda z: np.cos(z) * np.cosh(z) + 1, 4.0, 5.0)
FIXED_PINNED = root(lambda z: np.tan(z) - np.tanh(z), 3.5, 4.5)


@pytest.mark.parametrize(
    ("held", "mode", "number"),
    [
        ([1, -2], 0, np.pi),
        ([1, -2], 1, 2 * np.pi),
        ([1, 2], 0, CLAMPED_FREE),
        ([1, 2], 1, CLAMPED_FREE_2),
        ([1, 2, -2], 0, FIXED_PINNED),
    ],
    ids=["pinned-pinned 1", "pinned-pinned 2", "clamped-free 1", "clamped-free 2", "fixed-pinned 1"],
)
def test_bending_frequencies_converge_at_fourth_order(held: list[int], mode: int, number: float) -> None:
    exact = (number / L) ** 2 * np.sqrt(ROD.bending / ROD.line_density)
    counts = (mode + 1) * np.array([4, 8, 16])
    error = np.array([spectrum(ROD, n, held)[mode] / exact - 1 for n in counts])
    assert np.all(error > 0)  # a conforming element is too stiff
    order = np.log2(error[:-1] / error[1:])
    np.testing.assert_allclose(order, 4.0, atol=0.1)
    assert error[-1] < 2e-5


def test_one_element_overestimates_the_pinned_coupler_by_eleven_percent() -> None:
    exact = (np.pi / L) ** 2 * np.sqrt(ROD.bending / ROD.line_density)
    factor = spectrum(ROD, 1, [1, -2])[0] / exact
    assert factor == pytest.approx(np.sqrt(120.0) / np.pi**2, rel=1e-12)
    assert round(factor, 4) == 1.1099


def test_axial_frequencies_converge_at_second_order() -> None:
    exact = np.pi / (2 * L) * np.sqrt(ROD.axial / ROD.line_density)
    error = np.array([spectrum(ROD, n, [0], axial=True)[0] / exact - 1 for n in (4, 8, 16)])
    np.testing.assert_allclose(np.log2(error[:-1] / error[1:]), 2.0, atol=0.1)


def test_timoshenko_frequencies_converge_to_the_pinned_closed_form() -> None:
    """Pinned ends: for each half-wave q a quadratic in the squared frequency, the lower root bends."""
    q = np.pi / L
    ei, ga, m, j = THICK.bending, THICK.shear, THICK.line_density, THICK.rotary
    b = ga * q**2 / m + (ei * q**2 + ga) / j
    c = ga * q**2 * ei * q**2 / (m * j)
    exact = np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * c)))
    assert exact < 0.99 * q**2 * np.sqrt(ei / m)
    error = np.array([spectrum(THICK, n, [1, -2])[0] / exact - 1 for n in (16, 32, 64)])
    np.testing.assert_allclose(np.log2(error[:-1] / error[1:]), 2.0, atol=0.1)  # its shear is uniform in an element
    assert 0.0 < error[-1] < 1e-5


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize(("beam", "shear"), [(ROD, 0.0), (THICK, 1.0 / SHEAR)])
def test_cantilever_deflection_is_exact(beam: Beam, shear: float, count: int) -> None:
    load = 100.0
    k = chain(beam.piece(count).stiffness(), count)[3:, 3:]
    force = np.zeros(len(k))
    force[-2] = load
    u = np.linalg.solve(k, force)
    assert u[-2] == pytest.approx(load * L**3 / (3 * E * INERTIA) + load * L * shear, rel=1e-11)
    assert u[-1] == pytest.approx(load * L**2 / (2 * E * INERTIA), rel=1e-11)
    pull = np.zeros(len(k))
    pull[-3] = load
    assert np.linalg.solve(k, pull)[-3] == pytest.approx(load * L / (E * AREA), rel=1e-11)


@pytest.mark.parametrize("beam", [ROD, THICK])
def test_a_beam_moves_rigidly_without_strain_and_with_its_rigid_inertia(beam: Beam) -> None:
    turn = np.array([0.0, 0.0, 1.0, 0.0, L, 1.0])
    fields = np.column_stack([[1.0, 0, 0, 1, 0, 0], [0, 1.0, 0, 0, 1, 0], turn])
    assert np.max(np.abs(beam.stiffness() @ fields)) < 1e-9 * np.max(beam.stiffness())
    mass = beam.line_density * L
    inertia = mass * L**2 / 3 + beam.rotary * L
    want = np.array([[mass, 0, 0], [0, mass, mass * L / 2], [0, mass * L / 2, inertia]])
    np.testing.assert_allclose(fields.T @ beam.mass() @ fields, want, rtol=1e-12, atol=1e-12)


def test_timoshenko_tends_to_euler_bernoulli() -> None:
    stiff = replace(THICK, shear=1e9 * SHEAR, rotary=0.0)
    np.testing.assert_allclose(stiff.stiffness(), ROD.stiffness(), rtol=1e-6, atol=1e-6 * np.max(ROD.stiffness()))
    np.testing.assert_allclose(stiff.mass(), ROD.mass(), rtol=1e-6, atol=1e-9)


def test_spinning_cantilever_stiffens_as_southwell_found() -> None:
    """In-plane bending of a spinning cantilever: p^2 = p_0^2 + 0.193 Omega^2.

    Wright et al. (1982), Table 1: out of plane 3.6817 at Omega = 1, 3.5160 at rest; in plane Omega^2 less.
    """
    count, speed = 16, 1.0
    unit = Beam(1.0, 1e8, 1.0, 1.0)
    piece = unit.piece(count)
    edges = np.arange(count + 1) / count
    k, m = chain(piece.stiffness(), count), chain(piece.mass(), count)
    once, twice = (chain(matrix, count) for matrix in piece.velocity_terms())
    geometric = np.zeros_like(k)
    for n in range(count):
        middle = (edges[n] ** 2 + edges[n] * edges[n + 1] + edges[n + 1] ** 2) / 3.0
        tension = 0.5 * speed**2 * (1.0 - middle)
        at = slice(3 * n, 3 * n + 6)
        geometric[at, at] += tension * piece.geometric_stiffness()
    d = np.zeros_like(k)
    for i in range(0, len(k), 3):
        d[i, i + 1], d[i + 1, i] = 1.0, -1.0
    gyro = 2 * speed * once
    # from plane axes to axes that turn with the beam: U = T'V, T'' etc. from dT/dt = Omega D T
    damping = gyro - 2 * speed * m @ d
    stiffness = k + geometric + speed**2 * twice - speed * gyro @ d + speed**2 * m @ d @ d
    damping, stiffness, m = (matrix[3:, 3:] for matrix in (damping, stiffness, m))
    values = eigenvalues(m, damping, stiffness)
    assert np.max(np.abs(values.real)) < 1e-6 * np.max(np.abs(values))
    first = np.min(np.abs(values.imag))
    assert first**2 == pytest.approx(3.6817**2 - speed**2, abs=2e-3)


@pytest.mark.parametrize("name", ["length", "line_density", "bending"])
def test_beams_need_positive_numbers(name: str) -> None:
    with pytest.raises(InputError, match=f"beam: {name}: is 0; it must be positive"):
        replace(ROD, **{name: 0.0})


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("beam", [ROD, THICK])
def test_internal_forces_of_an_accelerated_cantilever_follow_from_statics(beam: Beam, count: int) -> None:
    """The field a = (c, a_0, 0) + (0, x, 1) e of a rigid body: N and M at x are the inertia of what lies beyond x."""
    c, a0, e = 3.0, 20.0, 70.0
    edges = np.linspace(0.0, L, count + 1)
    one = np.ones(count + 1)
    nodes = np.column_stack([c * one, a0 * one + e * edges, e * one])
    piece = beam.piece(count)
    force = -chain(piece.mass(), count) @ nodes.ravel()
    u = np.concatenate([np.zeros(3), np.linalg.solve(chain(piece.stiffness(), count)[3:, 3:], force[3:])])
    ends = np.concatenate([nodes[:-1], nodes[1:]], axis=1)
    x = np.linspace(0.0, piece.length, 9)
    tension, moment = piece.internal_forces(u.reshape(-1)[3 * np.arange(count)[:, None] + np.arange(6)], ends, x)
    place = edges[:-1, None] + x
    rest = L - place
    want = -beam.line_density * c * rest
    np.testing.assert_allclose(tension, want, atol=1e-9 * np.max(np.abs(want)))
    inertia = beam.line_density * ((a0 + e * place) * rest**2 / 2 + e * rest**3 / 3) + beam.rotary * e * rest
    np.testing.assert_allclose(moment, -inertia, atol=1e-9 * np.max(np.abs(inertia)))
