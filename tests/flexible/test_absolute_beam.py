"""The geometrically exact beam of the tests against the elastica, and the reference motion of an elastic rod."""

from __future__ import annotations

import numpy as np
import pytest
from absolute_beam import AbsoluteBeam, deflection, motion
from floating_frame import slider_crank
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from linkages.mechanics.flexible.beam import Beam
from linkages.mechanics.flexible.component_modes import component_modes

OMEGA, CRANK, ROD = 150.0, 0.15, 0.30  # rad/s, m: the test set's slider-crank
AXIAL = 1e3  # E A L^2 / E I of the cantilever: elements of a thinner one lock until they are short


def bent_by(force: float, elements: int) -> np.ndarray:
    """Displacements along and across, and the turn, of the tip of a unit cantilever."""
    beam = AbsoluteBeam(1.0, AXIAL, 1.0, 1.0, elements)
    free, still = np.arange(4, beam.size), np.zeros(beam.size)
    q, load = beam.straight(np.zeros(2)), np.zeros(beam.size)
    for step in np.linspace(0.1, 1.0, 10):
        load[-3] = step * force
        for _ in range(20):  # Newton's method; the tangent by central differences
            columns = [beam.forces(q + d, still) - beam.forces(q - d, still) for d in 1e-6 * np.eye(beam.size)[4:]]
            change = np.linalg.solve(np.array(columns).T[free] / 2e-6, (beam.forces(q, still) + load)[free])
            q[free] -= change
            if np.max(np.abs(change)) < 1e-10:
                break
    return np.array([q[-4] - 1.0, q[-3], np.arctan2(q[-1], q[-2])])


def elastica(force: float, axial: float = AXIAL) -> np.ndarray:
    """The same by theta'' = -P (1 + eps) cos theta, eps = P sin theta / E A, theta(0) = 0, theta'(1) = 0."""

    def rates(s: float, y: np.ndarray) -> list[float]:
        length = 1.0 + force * np.sin(y[0]) / axial
        return [y[1], -force * length * np.cos(y[0]), length * np.cos(y[0]) - 1.0, length * np.sin(y[0])]

    def shot(start: float) -> np.ndarray:
        return solve_ivp(rates, (0.0, 1.0), [0.0, start, 0.0, 0.0], rtol=1e-12, atol=1e-14).y[:, -1]

    end = shot(brentq(lambda start: shot(start)[1], 0.0, 2.0 * force, xtol=1e-14))
    return end[[2, 3, 0]]


def test_a_cantilever_bends_into_the_elastica_at_fourth_order() -> None:
    """A tip force of E I / L^2 bends by 0.3 of the length: the linear beam's 1/3 is 10 % off."""
    assert elastica(1.0, 1e12)[1] == pytest.approx(0.301720774, abs=1e-9)  # inextensible
    exact = elastica(1.0)
    error = np.array([np.max(np.abs(bent_by(1.0, n) - exact)) for n in (2, 4, 8)])
    assert np.all(np.log2(error[:-1] / error[1:]) > 3.5)
    assert error[-1] < 1e-6


@pytest.mark.slow
def test_an_elastic_rod_moves_as_another_code_of_such_beams_found() -> None:
    """Slider-crank of the test set for initial value problems, its rod straight at first, damped by 1.5e-5 s.

    The numbers, mid-span deflection [mm] and slider [m], come from an independent code with the same elements and
    another integration method; they differ from 16 elements by 1.2e-4 mm at most.
    """
    beam = AbsoluteBeam(ROD, 1.28e7, 2e11 * 0.008**4 / 12, 0.50368, 8, 1.5e-5)
    q = beam.straight(np.array([CRANK, 0.0]))
    v = np.zeros((9, 4))
    v[:, 1], v[:, 3] = CRANK * OMEGA * np.linspace(1.0, 0.0, 9), -CRANK * OMEGA / ROD
    c, s = lambda t: CRANK * np.cos(OMEGA * t), lambda t: CRANK * np.sin(OMEGA * t)

    def path(t: float) -> np.ndarray:  # the crank's pin, and the slider's height
        return np.array(
            [[c(t), s(t), 0.0], [-OMEGA * s(t), OMEGA * c(t), 0.0], [-(OMEGA**2) * c(t), -(OMEGA**2) * s(t), 0.0]]
        )

    times = np.array([0.0, 0.01, 0.02, 0.03595, 0.04, 0.06, 0.08, 0.1])
    found = motion(beam, (q, v.ravel()), [0, 1, beam.size - 3], path, times, {beam.size - 4: 0.075552}, 1e-6)
    bent = [0.0, 0.7281773, -0.0511418, -1.7510299, -0.8966812, -0.0110375, -1.4493153, 0.1432937]
    np.testing.assert_allclose(deflection(beam, found) * 1e3, bent, atol=1e-6)
    slider = [0.45, 0.270623094, 0.150746248, 0.441092782, 0.156884564, 0.415575358, 0.169737082]
    np.testing.assert_allclose(np.delete(found[:, -4], 3), slider, atol=1e-8)


@pytest.mark.slow
def test_a_floating_frame_moves_that_rod_alike() -> None:
    """Component modes and their foreshortening, with exact kinematics of sections: another code's numbers to 1e-4.

    Its eight sines and two axial modes are another space; the geometrically exact beam is 2.2e-4 off, about half the
    square of the slope of 0.018. Without stiffening the rod bends 5 % too far.
    """
    rod, times = Beam(ROD, 1.28e7, 2e11 * 0.008**4 / 12, 0.50368), np.array([0.0, 0.01])
    x, weight = np.polynomial.legendre.leggauss(12)
    points = 0.5 * ROD * (x + 1.0), 0.5 * ROD * weight * rod.line_density

    def bent(stiffening: bool) -> np.ndarray:
        modes = component_modes(rod, 0.0, ROD, [ROD], ROD, 8, 2, stiffening)
        eta = slider_crank(modes, ROD, points, CRANK, OMEGA, 0.075552, 1.5e-5, times)
        return 1e3 * (eta @ modes.shapes(np.array([0.5 * ROD]))[1][0])

    largest, found = 1.7511968, bent(True)
    np.testing.assert_allclose(found, [0.0, 0.7286067], atol=1e-4 * largest)
    np.testing.assert_allclose(found, [0.0, 0.728228], atol=3e-4 * largest)
    assert bent(False)[1] > 1.05 * found[1]
