"""Films on a developed surface: exact cases, an independent solver, conservation, limits, order of convergence."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkages.laws.film.surface.balance import Balance, Thickness, make_balance
from linkages.laws.film.surface.cavity import RULES, eliminate, solve
from linkages.laws.film.surface.grooves import Groove, check_grooves
from linkages.laws.film.surface.surface_film import (
    FilmSurface,
    Pressures,
    friction_torque,
    largest_pressure,
    solve_film,
)
from linkages.laws.film.surface.surface_mesh import surface_mesh

TURN = 2.0 * math.pi
TOP = Groove(math.pi, math.radians(20.0), 1.0)  # opposite the load


AMBIENT = Pressures()


def film_of(
    eps, psi, grooves, slenderness=1.0, around=96, along=8, tilt=(0.0, 0.0), half=None, pressures=AMBIENT, **options
):
    """A film whose eccentricity points to psi."""
    x, y = eps * math.cos(psi), eps * math.sin(psi)
    mesh = surface_mesh(slenderness, grooves, (x, y), around, along, half=half)
    return solve_film(FilmSurface(mesh, grooves, pressures), Thickness(x, y, *tilt), **options)


def size(film):
    return math.hypot(*film.force)


def pocketed_slider(cells):
    """Fowell's slider: flow [m2/s], end of the cavity [m], pressure at 1, 4, 6, 8 mm and its maximum [Pa]."""
    length, speed, mu, ambient = 10e-3, 1.0, 0.01, 1e5
    faces = np.linspace(0.0, length, cells + 1)
    centres = 0.5 * (faces[1:] + faces[:-1])

    def integral(low, high, power):
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        nodes = middle + half * np.array([[-math.sqrt(0.6)], [0.0], [math.sqrt(0.6)]])
        h = 1.05e-6 - 0.05e-6 * nodes / length + np.where((nodes > 2e-3) & (nodes < 5e-3), 1e-6, 0.0)
        return half * (np.array([5.0, 8.0, 5.0]) / 9.0 @ h**power)

    def between(power):  # a last cell holds both ends at ambient pressure: it closes the ring
        left, right = integral(faces[:-1], centres, power), integral(centres, faces[1:], power)
        return (np.append(right, 0.0) + np.roll(np.append(left, 0.0), -1))[:, None]

    nothing = np.zeros((cells + 1, 1))
    known = np.full((cells + 1, 1), -1.0)
    known[-1] = ambient
    around, carried = 1.0 / (12.0 * mu * between(-3)), 0.5 * speed * between(-2) / between(-3)
    z = solve(Balance(around, carried, np.zeros((cells + 1, 2)), nothing, nothing, nothing, known))[:, 0]
    p, deficit = np.maximum(z, 0.0), np.maximum(-z, 0.0)
    flow = carried[-1, 0] - around[-1, 0] * (p[0] - ambient)
    cavity = np.flatnonzero(deficit > 0.0)
    # the last cell of the cavity is partly filled: its deficit over the cavity's places the front within it
    part = deficit[cavity[-1]] / deficit[cavity[-2]]
    front = faces[cavity[-1]] + part * length / cells
    return flow, faces[cavity[0]], front, np.interp([1e-3, 4e-3, 6e-3, 8e-3], centres, p[:-1]), p.max()


def test_rupture_and_re_formation_against_an_exact_solution():
    """Fowell, Olver, Gosman, Spikes and Pegg, J. Tribology 129, 2007: pocketed slider, exact in one dimension.

    The scheme is of first order there, as the film ruptures at the step: measured on four meshes.
    """
    flow, start, front, pressures, highest = pocketed_slider(6400)
    assert flow == pytest.approx(5.229635023923e-7, rel=1e-5)
    assert start == pytest.approx(2e-3, abs=1e-5)
    assert front == pytest.approx(3.61126266e-3, abs=1e-3 * 10e-3)
    assert highest == pytest.approx(9.808818754e6, rel=1e-4)
    exact = [0.181803e6, 2.742533e6, 8.493604e6, 4.941483e6]
    np.testing.assert_allclose(pressures, exact, rtol=1e-3)
    # near the rupture most remains: p = 0 is held at the middle of the first cavity cell, half a cell too late
    coarse = pocketed_slider(3200)[3]
    np.testing.assert_allclose((pressures - exact) / (coarse - exact), 0.5, atol=0.01)
    np.testing.assert_allclose(2.0 * pressures - coarse, exact, rtol=1e-5)
    errors = [pocketed_slider(n)[0] / 5.229635023923e-7 - 1.0 for n in (200, 400, 800, 1600)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 1.0, atol=0.05)


def test_squeeze_between_parallel_surfaces_flows_out_of_the_ends():
    """A centred film that closes everywhere alike: p = p_a + 6 (-dh/dt) (l^2 - z^2)/h^3, flow = area (-dh/dt).

    With dh/dt = -1 in the units of the solver; l = L/(2 R).
    """
    lam, rate, ambient = 0.8, 1.0, 0.3
    mesh = surface_mesh(lam, (), (0.0, 0.0), 24, 40)
    balance = make_balance(mesh, Thickness(0.0, 0.0), speed=0.0)
    squeeze = -rate * mesh.width[:, None] * mesh.height
    p = solve(balance._replace(gain=squeeze), ambient, rule="reynolds")
    exact = ambient + 6.0 * rate * (lam**2 - mesh.zeta**2)
    np.testing.assert_allclose(p, np.broadcast_to(exact, p.shape), rtol=1e-4, atol=1e-3)
    flow = (balance.along[:, -1] * (p[:, -1] - ambient)).sum()
    assert flow == pytest.approx(rate * TURN * lam, rel=1e-10)


#: An independent solver with mass conservation (Jakobsson-Floberg-Olsson), grid-converged: D 0.1 m, c 50 um,
#: mu 0.03 Pa s, 100 rad/s, L/D 1, eps 0.5, grooves of 20 degrees. Two grooves at +-90 degrees from the load, 80 % long,
#: supply 1e5 Pa; one opposite the load, full length, supply 0: load [N], attitude [deg], end flow [m3/s], torque [N m],
#: largest pressure [Pa].
PAIR = (Groove(0.5 * math.pi, math.radians(20.0), 0.8, 1e5), Groove(-0.5 * math.pi, math.radians(20.0), 0.8, 1e5))
GROOVED = [(PAIR, 24087.0, 47.695, 5.2982e-6, 4.9933, 5.6462e6), ((TOP,), 26765.0, 57.618, 9.9664e-6, 5.2936, 5.9398e6)]


@pytest.mark.parametrize(("grooves", "load", "angle", "flow", "torque", "highest"), GROOVED)
def test_grooved_bearings_against_an_independent_solver(grooves, load, angle, flow, torque, highest):
    """Within 0.5 %, the accuracy of both meshes."""
    c, mu, omega, radius = 50e-6, 0.03, 100.0, 0.05
    unit = mu * omega * (radius / c) ** 2
    film = film_of(0.5, math.radians(angle), grooves, around=200, along=16, pressures=Pressures(0.0, unit))
    assert size(film) * unit * radius**2 == pytest.approx(load, rel=5e-3)
    place = math.atan2(film.thickness.y, film.thickness.x)  # from the load, which is opposite to the force
    attitude = math.remainder(place - math.atan2(-film.force[1], -film.force[0]), TURN)
    assert math.degrees(attitude) == pytest.approx(angle, abs=0.1)
    assert film.end_flow * c * radius**2 * omega == pytest.approx(flow, rel=5e-3)
    assert friction_torque(film) * mu * omega * radius**4 / c == pytest.approx(torque, rel=5e-3)
    assert largest_pressure(film) * unit == pytest.approx(highest, rel=5e-3)


def test_order_of_convergence():
    """Differences between meshes that are each twice as fine: about second order, the cavity's front disturbs it."""
    loads = [size(film_of(0.6, 0.9, (TOP,), around=n, along=n // 12)) for n in (48, 96, 192)]
    first, second = np.abs(np.diff(loads))
    assert math.log2(first / second) > 1.5


@pytest.mark.parametrize("eps", [0.01, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("rule", RULES)
def test_balance_and_bounds(eps, rule):
    for grooves, pressures in (((TOP,), Pressures()), (PAIR, Pressures(-0.5e5, 1e7)), ((), Pressures(-1e5, 1e6))):
        film = film_of(eps, 0.7, grooves, rule=rule, pressures=pressures)
        assert film.imbalance < 1e-10 or rule == "guembel"
        assert film.pressure.min() >= pressures.cavity / pressures.unit
        assert film.content.min() >= 0.0
        assert film.content.max() <= 1.0
        if rule == "mass-conserving":
            assert not ((film.pressure > pressures.cavity / pressures.unit) & (film.content < 1.0)).any()
            assert sum(film.groove_flow) == pytest.approx(film.end_flow, abs=1e-10)


@given(
    eps=st.floats(0.02, 0.97),
    psi=st.floats(-3.0, 3.0),
    slenderness=st.floats(0.1, 4.0),
    grooves=st.lists(
        st.builds(
            Groove, st.floats(-3.0, 3.0), st.floats(0.05, 1.5), st.floats(0.1, 1.0), st.floats(0.0, 0.0),
            st.just(0.0), st.booleans(),
        ),
        min_size=1, max_size=3,
    ),
    cavity=st.sampled_from([0.0, -0.1]),
)  # fmt: skip
@settings(max_examples=40)
def test_any_geometry_conserves_mass_and_dissipates(eps, psi, slenderness, grooves, cavity):
    """The journal delivers the film's shear and pressure power: the torque never drives it."""
    film = film_of(eps, psi, tuple(grooves), slenderness, 48, 6, pressures=Pressures(cavity, 1.0))
    assert film.imbalance < 1e-10
    assert film.pressure.min() >= cavity
    assert sum(film.groove_flow) == pytest.approx(film.end_flow, abs=1e-9)
    assert friction_torque(film) > 0.0


def test_a_turned_frame_turns_the_force():
    film = film_of(0.6, 0.4, (Groove(2.0, 0.4, 0.7),))
    turned = film_of(0.6, 0.4 + 1.1, (Groove(2.0 + 1.1, 0.4, 0.7),))
    angle = math.atan2(*turned.force[::-1]) - math.atan2(*film.force[::-1])
    assert math.remainder(angle - 1.1, TURN) == pytest.approx(0.0, abs=1e-9)
    assert size(turned) == pytest.approx(size(film), rel=1e-9)


def test_a_tilt_of_nothing_over_the_whole_length():
    whole = film_of(0.6, 0.4, (TOP,), half=False)
    assert size(whole) == pytest.approx(size(film_of(0.6, 0.4, (TOP,))), rel=1e-5)  # lines lie a little otherwise
    assert whole.moment == pytest.approx((0.0, 0.0), abs=1e-9)


def test_elimination_solves_a_banded_system():
    """Dominant columns, against a dense solution."""
    count, width, random = 30, 4, np.random.default_rng(1)
    row, column = np.indices((count, count))
    matrix = np.where(abs(row - column) <= width, -random.random((count, count)), 0.0)
    matrix[row == column] = 1.1 * np.abs(matrix).sum(axis=0)
    band, right = np.zeros((count, 2 * width + 1)), random.random(count)
    inside = matrix != 0.0
    band[row[inside], (width + column - row)[inside]] = matrix[inside]
    exact = np.linalg.solve(matrix, right)
    eliminate(band, right, width)
    np.testing.assert_allclose(right, exact, rtol=1e-13)


def test_a_film_without_groove_and_cavity_at_ambient_carries_nothing():
    """The balance of any ring gives p = 0 everywhere; `linkages.bearing` and experiments refuse such films."""
    assert size(film_of(0.6, 0.4, ())) < 1e-9
    fed = film_of(0.6, 0.4, (), pressures=Pressures(-1e5, 1e6))  # the ends feed the cavity
    assert size(fed) > 0.1


@pytest.mark.parametrize("slenderness", [16.0, 0.02])
def test_long_and_short_limits(slenderness):
    """Long: one-dimensional, the force per length no longer changes. Short: Ocvirk's pressure, which falls with L^3."""
    near, far = (size(film_of(0.5, 0.6, (TOP,), factor * slenderness, along=10)) for factor in (1.0, 2.0))
    assert far / near == pytest.approx(2.0 if slenderness > 1.0 else 8.0, rel=0.05)


def test_a_tilted_journal_feels_a_moment_that_rights_it():
    """The end that comes nearer to the wall carries more: the moment turns the journal back, odd in the tilt."""
    one, other = (film_of(0.5, 0.0, (TOP,), tilt=(tilt, 0.0), half=False) for tilt in (0.2, -0.2))
    assert one.moment[1] == pytest.approx(-other.moment[1], rel=1e-9)
    assert size(one) == pytest.approx(size(other), rel=1e-9)
    # force -x grows where zeta > 0: the moment about y, z F_x, is negative for a positive tilt
    assert one.moment[1] < 0.0
    assert size(one) > size(film_of(0.5, 0.0, (TOP,)))


@pytest.mark.parametrize(
    ("groove", "cavity", "text"),
    [
        (Groove(0.0, 0.3, 1.2), 0.0, "at most 1, the length of the bearing"),
        (Groove(0.0, 0.3, 0.0), 0.0, "length 0: must be above 0"),
        (Groove(0.0, 0.0), 0.0, "extent 0 rad: must be above 0"),
        (Groove(0.0, 1e-300), 0.0, "extent 1e-300 rad: must be above 0"),
        (Groove(0.0, 7.0), 0.0, "at most a turn"),
        (Groove(180.0, 0.3), 0.0, "angle 180 rad: must be within a turn; give degrees with their unit"),
        (Groove(0.0, TURN), 0.0, "covers the whole bearing"),
        (Groove(0.0, 0.3, 0.5, -2e5), -1e5, "must not be below the cavity pressure"),
        (Groove(0.0, 0.3, 0.5, 0.0, 0.4), 0.0, "reaches beyond the bearing"),
        (Groove(0.0, 0.3), 1.0, "must not be above ambient"),
    ],
)
def test_impossible_grooves_are_refused(groove, cavity, text):
    with pytest.raises(ValueError, match=text):
        check_grooves((groove,), cavity)


@pytest.mark.parametrize("groove", [Groove(1.0, 0.0), Groove(1.0, 0.3, 0.0), Groove(1.0, -0.3), Groove(1.0, math.nan)])
def test_a_mesh_has_no_groove_without_area(groove):
    with pytest.raises(ValueError, match=r"groove 2: .* must be above 0"):
        surface_mesh(1.0, (TOP, groove))
