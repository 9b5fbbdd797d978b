"""Modes of a link against closed forms: frequencies, statics with axial force, free vibration, integrals of its motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from linkages.base.errors import InputError
from linkages.mechanics.flexible.beam import Beam
from linkages.mechanics.flexible.component_modes import ComponentModes, component_modes

AXIAL, BENDING, DENSITY = 1.28e7, 2e11 * 0.008**4 / 12, 0.50368  # steel, 8 mm by 8 mm


def modes(start: float, end: float, interfaces: list[float], chord: float | None = None, **counts) -> ComponentModes:
    rod = Beam(end - start, AXIAL, BENDING, DENSITY)
    return component_modes(rod, start, end, interfaces, chord, **counts)


def root(f, low: float, high: float) -> float:
    return float(brentq(f, low, high, xtol=1e-14, rtol=1e-14))


def bent(number: float | np.ndarray, length: float) -> float | np.ndarray:
    """Angular frequency of bending with wave number times length."""
    return (number / length) ** 2 * np.sqrt(BENDING / DENSITY)


#: Chord and tangent frames, an interface within, overhangs, an origin within the beam.
CASES = [
    modes(0.0, 0.3, [0.3], 0.3),
    modes(0.0, 0.3, [0.1, 0.3]),
    modes(-0.05, 0.3, [0.07, 0.25], 0.25, bending=9, axial=5),
    modes(-0.2, 0.1, [-0.2, -0.12, -0.05, 0.1], bending=10, axial=5),
]


@pytest.mark.parametrize(("length", "frequency"), [(0.28, 1465.583876), (0.24, 1994.822498)])
def test_pinned_frequencies_are_those_of_the_exact_dynamic_stiffness(length: float, frequency: float) -> None:
    """Numbers of exact dynamic stiffness matrices, which the sines' closed form confirms."""
    found = modes(0.0, length, [length], length, bending=14).frequencies[:4]
    assert found[0] == pytest.approx(frequency, rel=5e-9)
    np.testing.assert_allclose(found, bent(np.pi * np.arange(1, 5), length), rtol=1e-5)


def test_pinned_frequencies_converge_with_the_modes_of_clamped_interfaces() -> None:
    """One mode more reaches the first frequency to 1e-4, two the second to 1e-3: shapes of either symmetry in turn."""
    exact = bent(np.pi * np.arange(1, 3), 0.3)
    error = np.array([modes(0.0, 0.3, [0.3], 0.3, bending=n).frequencies[:2] / exact - 1 for n in range(2, 9)])
    assert np.all(error > 0.0)
    assert np.all(np.diff(error, axis=0) <= 1e-12)
    np.testing.assert_allclose(error[0], [np.sqrt(120.0) / np.pi**2 - 1, np.sqrt(2520.0) / (4 * np.pi**2) - 1])
    assert np.all(error[[1, 2], [0, 1]] < [1e-4, 1e-3])
    assert np.all(error[-1] < [2e-7, 5e-6])


def test_frequencies_with_free_and_held_ends_are_the_closed_forms() -> None:
    """A beam held at its origin alone has modes of clamped interfaces only; all kept ones are converged."""
    found = modes(0.0, 0.3, [], bending=5, axial=3).frequencies
    clamped = [root(lambda z: np.cos(z) * np.cosh(z) + 1, (k - 1) * np.pi, k * np.pi) for k in range(1, 6)]
    np.testing.assert_allclose(found[:5], bent(np.array(clamped), 0.3), rtol=1e-9)
    waves = (np.arange(3) + 0.5) * np.pi / 0.3
    np.testing.assert_allclose(found[5:], waves * np.sqrt(AXIAL / DENSITY), rtol=1e-9)


@pytest.mark.parametrize("place", ["chord", "tangent", "origin within"])
def test_a_free_beam_vibrates_alike_whatever_its_frame(place: str) -> None:
    """Rigid and modal inertia together: two rigid motions, then cos z cosh z = 1."""
    start, end, chord = {"chord": (0.0, 0.3, 0.3), "tangent": (0.0, 0.3, None), "origin within": (-0.1, 0.2, 0.2)}[
        place
    ]
    beam = modes(start, end, [end], chord, bending=24, axial=0)
    mass, first, second = beam.mass, beam.first_moment, beam.second_moment
    rigid = np.array([[mass, first], [first, second]])
    coupling = np.array([beam.sb, beam.cb])
    m = np.block([[rigid, coupling], [coupling.T, np.diag(beam.m0)]])
    values = eigh(np.diag([0.0, 0.0, *beam.k]), m, eigvals_only=True)
    assert np.all(np.abs(values[:2]) < 1e-9 * values[2])
    free = [root(lambda z: np.cos(z) * np.cosh(z) - 1, k * np.pi + 1.0, k * np.pi + 2.0) for k in range(1, 4)]
    np.testing.assert_allclose(np.sqrt(values[2:5]), bent(np.array(free), 0.3), rtol=3e-5)


@pytest.mark.parametrize(("force", "tension"), [(0.1, 0.0), (0.1, -1.0), (0.1, -2.0), (0.1, 2.0), (0.1, 10.0)])
def test_a_cantilever_under_two_forces_is_the_linear_beam_column(force: float, tension: float) -> None:
    """Forces across and along, in E I / L^2. With twelve modes to 5e-8, of a deflection up to 0.2."""
    length, unit = 0.3, BENDING / 0.09
    beam = modes(0.0, length, [length], bending=12, axial=1)
    a, b, _, h = beam.at(length)
    eta = np.linalg.solve(np.diag(beam.k) + tension * unit * h, force * unit * b + tension * unit * a)
    x = np.sqrt(complex(tension))
    exact = force * (1.0 - np.tanh(x) / x).real / tension if tension else force / 3.0
    assert b @ eta / length == pytest.approx(exact, abs=5e-8 if tension else 1e-12)
    assert a @ eta == pytest.approx(tension * unit * length / AXIAL, rel=1e-12)


def test_an_overhang_bends_under_a_force_at_its_tip() -> None:
    """Pinned at 0 and at p, loaded at the tip: P o^2 (p + o) / (3 E I), by the modes of the interfaces alone."""
    pin, tip = 0.2, 0.3
    beam = modes(0.0, tip, [pin, tip], pin, bending=4)
    b = beam.at(tip)[1]
    flexibility = b @ (b / beam.k)
    assert flexibility == pytest.approx((tip - pin) ** 2 * tip / (3.0 * BENDING), rel=1e-9)
    free = [modes(0.0, tip, [pin], pin, bending=count) for count in (4, 8, 16)]  # without an interface at the tip
    error = [flexibility - beam.at(tip)[1] @ (beam.at(tip)[1] / beam.k) for beam in free]
    assert 0.0 < 4.0 * error[2] < 2.0 * error[1] < error[0] < 0.1 * flexibility


@pytest.mark.parametrize("beam", CASES, ids=["chord", "tangent", "overhangs", "origin within"])
def test_constants_are_the_integrals_of_the_shapes(beam: ComponentModes) -> None:
    """Compare with the midpoint rule, the foreshortening summed from the origin outwards: 3e-6 of the largest."""
    edges = np.linspace(-0.2, 0.3, 10001)
    edges = edges[(edges > beam._bending.nodes[0] - 1e-9) & (edges < beam._bending.nodes[-1] + 1e-9)]
    s, step = 0.5 * (edges[:-1] + edges[1:]), np.diff(edges)
    (a, b), (strain, turn), curvature = beam.shapes(s), beam.shapes(s, 1), beam.shapes(s, 2)[1]
    h = np.concatenate([[np.zeros_like(beam.c)], np.cumsum(step[:, None, None] * turn[:, :, None] * turn[:, None], 0)])
    h -= h[np.argmin(np.abs(edges))]
    for k in range(0, len(edges), 1000):
        np.testing.assert_allclose(beam.at(edges[k])[3], h[k], atol=3e-6 * np.max(np.abs(h)))
        np.testing.assert_array_equal(beam.at(edges[k])[2], beam.shapes(edges[[k]], 1)[1][0])
    middle, mass = 0.5 * (h[:-1] + h[1:]), DENSITY * step
    b_of = np.einsum("q,qi,qj->ij", mass, a, b)
    m = np.einsum("q,qi,qj->ij", mass, a, a) + np.einsum("q,qi,qj->ij", mass, b, b)
    k = AXIAL * np.einsum("q,qi,qj->ij", step, strain, strain)
    k += BENDING * np.einsum("q,qi,qj->ij", step, curvature, curvature)
    for found, integral in (
        (beam.mass, np.sum(mass)), (beam.first_moment, mass @ s), (beam.second_moment, mass @ s**2),
        (beam.sa, mass @ a), (beam.sb, mass @ b), (beam.ca, (mass * s) @ a), (beam.cb, (mass * s) @ b),
        (np.diag(beam.m0), m), (np.diag(beam.k), k), (beam.g, b_of.T - b_of),
        (beam.c, np.einsum("q,qij->ij", mass, middle)), (beam.d, np.einsum("q,qij->ij", mass * s, middle)),
    ):  # fmt: skip
        np.testing.assert_allclose(found, integral, rtol=3e-6, atol=3e-6 * np.max(np.abs(integral)))


@pytest.mark.parametrize("beam", CASES, ids=["chord", "tangent", "overhangs", "origin within"])
def test_shapes_hold_the_frame_and_are_one_where_largest(beam: ComponentModes) -> None:
    a, b, slope, h = beam.at(0.0)
    away = slope if beam is CASES[1] or beam is CASES[3] else beam.at({0: 0.3, 2: 0.25}[CASES.index(beam)])[1]
    for held in (a, b, away, h):
        np.testing.assert_allclose(held, 0.0, atol=1e-12)
    nodes = beam._bending.nodes
    along, across = beam.shapes(np.union1d(np.linspace(*nodes[[0, -1]], 20001), nodes))  # kinks are at nodes
    values = along + across
    np.testing.assert_allclose(np.max(np.abs(values), axis=0), 1.0, atol=1e-4)
    assert np.all(np.max(values, axis=0) > 0.9999)
    assert np.all(np.diff(beam.frequencies[: beam.bending]) > 0.0)
    assert np.all(np.diff(beam.frequencies[beam.bending :]) > 0.0)


def test_the_modes_by_default_are_those_of_the_interfaces_and_two_more() -> None:
    assert modes(0.0, 0.3, [0.3], 0.3).names == ("bending1", "bending2", "bending3", "bending4", "axial1")
    assert modes(0.0, 0.3, [0.1, 0.3]).names == (*(f"bending{k}" for k in range(1, 7)), "axial1", "axial2")
    rigid = modes(0.0, 0.3, [0.3], 0.3, bending=0, axial=0)
    assert rigid.names == ()
    assert (rigid.mass, rigid.second_moment) == pytest.approx((DENSITY * 0.3, DENSITY * 0.009))


def test_without_stiffening_nothing_shortens() -> None:
    with_h, without = (modes(0.0, 0.3, [0.3], 0.3, stiffening=stiffening) for stiffening in (True, False))
    for part in (without.c, without.d, without.at(0.2)[3]):
        np.testing.assert_array_equal(part, 0.0)
    np.testing.assert_array_equal(with_h.cb, without.cb)
    assert np.max(with_h.c) > 0.0


@pytest.mark.parametrize(
    ("counts", "interfaces", "problem"),
    [
        ({"bending": 1}, [0.3], "beam: bending: is 1; 2 joints and loads need 2 such modes or more, or 0"),
        ({"axial": 1}, [0.1, 0.3], "beam: axial: is 1; 3 joints and loads need 2 such modes or more, or 0"),
        ({}, [0.31], "beam: interfaces: 0.31 m lies outside the beam from 0 to 0.3 m"),
    ],
)
def test_what_cannot_be_is_refused(counts: dict, interfaces: list[float], problem: str) -> None:
    with pytest.raises(InputError) as info:
        modes(0.0, 0.3, interfaces, **counts)
    assert str(info.value) == problem


def test_a_beam_with_shear_is_refused() -> None:
    with pytest.raises(InputError, match="Euler-Bernoulli"):
        component_modes(Beam(0.3, AXIAL, BENDING, DENSITY, shear=1e6), 0.0, 0.3, [0.3])
