"""The film with history: exact motions, steady limit, conservation, a loaded journal, the quasi-static map."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from linkages.laws.film.surface import Groove
from linkages.laws.film.surface.balance import Thickness, cell_volumes, make_balance
from linkages.laws.film.surface.cavity import solve
from linkages.laws.film.surface.surface_film import FilmSurface, Pressures, solve_film
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.surface.transient import Journal, at_rest, filling_time, follow, move

GROOVE = Groove(math.pi, math.radians(20.0), 0.8)
RING = Groove(math.pi, math.radians(20.0))  # over the whole length


def bearing(grooves=(GROOVE,), slenderness=1.0, around=36, along=4, **options):
    return FilmSurface(surface_mesh(slenderness, grooves, around=around, along=along), grooves, **options)


def with_history(balance, volumes, oil, time):
    """The balance of an implicit Euler step."""
    return balance._replace(gain=(volumes - oil) / time, most=volumes / time)


class Plates:
    """Parallel surfaces of half length 1 that close and open, ends at a pressure: exact in one dimension.

    Full film: p'' = 12 h'/h^3. The cavity reaches to s(t): p = p' = 0 there while it grows; afterwards the inflow fills
    it, -(h - h_r(s)) ds/dt = h^3 p'(s)/12, h_r(z) the film when it ruptured at z. After Ausas, Jai and Buscaglia,
    J. Tribology 131, 2009, who compare with this solution.
    """

    ambient = 20.0
    period = 0.5

    def h(self, t):
        return 0.375 + 0.125 * math.cos(4.0 * math.pi * t)

    def rate(self, t):
        return -0.5 * math.pi * math.sin(4.0 * math.pi * t)

    def ruptured(self, t):
        """End of the growing cavity."""
        return 1.0 - math.sqrt(self.ambient * self.h(t) ** 3 / (6.0 * self.rate(t)))

    def __init__(self):
        self.first = brentq(self.ruptured, 0.2505, 0.3)
        times = np.linspace(self.first, 0.45, 4000)
        ends = np.array([self.ruptured(t) for t in times])
        self.turn = times[np.argmax(ends)]
        self.largest = ends.max()
        self._times, self._ends = times[times <= self.turn], ends[times <= self.turn]
        late = self.turn + 1e-4, 0.75
        start = self.largest - 0.5 * (self.largest - self.ruptured(late[0]))

        def closed(t, s):
            return s[0] - 1e-3

        closed.terminal = True
        self.filling = solve_ivp(
            self._filling, late, [start], method="Radau", rtol=1e-9, atol=1e-11, dense_output=True, events=closed
        )

    def film_at_rupture(self, z):
        return self.h(np.interp(z, self._ends, self._times))

    def _filling(self, t, s):
        slope = self.ambient / (1.0 - s[0]) - 6.0 * self.rate(t) / self.h(t) ** 3 * (1.0 - s[0])
        return [-(self.h(t) ** 3) * slope / 12.0 / max(self.h(t) - self.film_at_rupture(s[0]), 1e-12)]

    def end(self, t):
        return self.ruptured(t) if t < self.turn else float(self.filling.sol(t)[0])

    def missing(self, t):
        """Volume of the cavity that is not filled, of half the length and a unit of width."""
        return quad(lambda z: self.h(t) - self.film_at_rupture(z), 0.0, self.end(t), limit=200)[0]

    def load(self, t):
        """Integral of the pressure over half the length."""
        s = self.end(t) if self.first < t < self.filling.t[-1] else 0.0
        curve = 6.0 * self.rate(t) / self.h(t) ** 3
        if s == 0.0:  # symmetric: p' = 0 in the middle
            return self.ambient - 2.0 / 3.0 * curve
        slope = self.ambient / (1.0 - s) - curve * (1.0 - s)
        return curve * (1.0 - s) ** 3 / 3.0 + slope * (1.0 - s) ** 2 / 2.0


def solved_plates(plates, times, along, steps):
    """Missing volume and load of the solver at times."""
    mesh = surface_mesh(1.0, (), (0.0, 0.0), 8, along)
    balance, unit = make_balance(mesh, Thickness(0.0, 0.0), speed=0.0), cell_volumes(mesh, Thickness(0.0, 0.0))
    oil, z, found, dt = plates.h(0.0) * unit, None, [], times[-1] / steps
    for k in range(1, steps + 1):
        h = plates.h(k * dt)
        now = balance._replace(around=h**3 * balance.around, along=h**3 * balance.along)
        now = with_history(now, h * unit, oil, dt)
        z = solve(now, plates.ambient, guess=z)
        deficit, p = np.maximum(-z, 0.0), np.maximum(z, 0.0)
        oil = (1.0 - deficit) * h * unit
        if np.abs(k * dt - times).min() < 0.5 * dt:
            width = 2.0 * math.pi
            found.append([(deficit * h * unit).sum() / width, (p * unit).sum() / width])
    return np.array(found)


def test_plates_that_open_and_close_against_the_exact_solution():
    """Rupture, a growing cavity, and its filling: volume of the cavity to 0.3 %, of first order; load to 2 %."""
    plates = Plates()
    times = np.array([0.2, 0.32, 0.36, 0.42, 0.46])
    assert plates.first < 0.3 < plates.turn < 0.36 < 0.46 < plates.filling.t[-1]
    exact = np.array([[plates.missing(t) if t > plates.first else 0.0, plates.load(t)] for t in times])
    coarse, fine = (solved_plates(plates, times, along, steps) for along, steps in ((20, 115), (40, 230)))
    np.testing.assert_allclose(fine[:, 0], exact[:, 0], rtol=3e-3, atol=1e-12)
    np.testing.assert_allclose(fine[:, 1], exact[:, 1], rtol=0.02)
    errors = np.abs(np.array([coarse, fine])[:, 1:, 0] - exact[1:, 0]).mean(axis=1)
    assert 1.6 < errors[0] / errors[1] < 2.4


def test_a_closing_film_fills_and_then_squeezes():
    """Closed form between parallel surfaces: no pressure before the gap is full, 6 (l^2 - z^2) (-h')/h^3 afterwards.

    The gap closes at the rate 1 and ends at h = 1; half of the oil that it lacks at content 0.9 appears in each step.
    """
    lam, ambient = 0.8, 0.0
    mesh = surface_mesh(lam, (), (0.0, 0.0), 24, 40)
    unit, flat = cell_volumes(mesh, Thickness(0.0, 0.0)), make_balance(mesh, Thickness(0.0, 0.0), speed=0.0)
    dt, oil = 0.05, 1.05 * unit
    for h in (1.1, 1.05):
        now = with_history(flat._replace(around=h**3 * flat.around, along=h**3 * flat.along), h * unit, oil, dt)
        z = solve(now, ambient)
        assert z.max() < 1e-9  # full at h = 1.05
        np.testing.assert_allclose(1.0 + np.minimum(z, 0.0), 1.05 / h, rtol=1e-9)
    p = solve(with_history(flat, unit, oil, dt), ambient)
    exact = 6.0 * (lam**2 - mesh.zeta**2)
    np.testing.assert_allclose(p, np.broadcast_to(exact, unit.shape), rtol=1e-4, atol=1e-3)
    assert (flat.along[:, -1] * p[:, -1]).sum() == pytest.approx(2.0 * math.pi * lam, rel=1e-10)


def test_a_centred_ring_fills_at_half_the_speed_of_the_journal():
    """Without pressure the content travels at half the surface speed: full oil behind the groove, 0.4 before it."""
    case, content = bearing((RING,)), 0.4
    start = at_rest(case, (0.0, 0.0), content)
    free = case.mesh.groove < 0
    times = np.arange(1, 41) * 0.1  # the front needs 2 (2 pi - extent) to arrive
    volumes = [m.oil[free].sum() for m in follow(case, start, ((t, (0.0, 0.0), 1.0) for t in times))]
    exact = start.oil[free].sum() + 0.5 * (1.0 - content) * times  # times the half length 1
    np.testing.assert_allclose(volumes, exact, rtol=1e-5)


def test_half_speed_whirl_carries_nothing():
    """The gap travels with the oil: no wedge, no pressure, with history as without; of first order in the step."""
    case, forces = bearing(), []
    for count in (100, 200):
        turns = 0.5 * 10.0 * np.arange(1, count + 1) / count
        orbit = ((2.0 * t, (0.5 * math.cos(t), 0.5 * math.sin(t)), 1.0) for t in turns)
        *_, last = follow(case, at_rest(case, (0.5, 0.0)), orbit)
        forces.append(np.array(last.force))
    steady = solve_film(case, Thickness(0.5, 0.0))
    assert np.hypot(*(2.0 * forces[1] - forces[0])) < 0.02 * math.hypot(*steady.force)


@pytest.mark.parametrize("pressures", [Pressures(), Pressures(-1e5, 1e6)])
def test_at_a_place_it_tends_to_the_steady_film(pressures):
    """And each step conserves the oil: what the grooves give less what the ends lose."""
    case, place = bearing(pressures=pressures), (0.4, 0.3)
    steady, free = solve_film(case, Thickness(*place)), case.mesh.groove < 0
    state = at_rest(case, place)
    for k in range(1, 61):
        before, (state,) = state, follow(case, state, [(0.5 * k, place, 1.0)])
        film = state.film
        gain = 2.0 * (state.oil - before.oil)[free].sum() / 0.5
        assert film.imbalance < 1e-10
        assert gain == pytest.approx(sum(film.groove_flow) - film.end_flow, abs=1e-10)
        assert film.pressure.min() >= pressures.cavity / pressures.unit
        assert 0.0 <= film.content.min() <= film.content.max() <= 1.0
    np.testing.assert_allclose(film.force, steady.force, rtol=1e-6)
    np.testing.assert_allclose(film.content, steady.content, atol=1e-6)


def test_the_error_is_of_first_order_in_the_step():
    case, end = bearing(), 4.0

    def forces(count):
        places = ((end * k / count, (0.5 + 0.2 * math.sin(end * k / count), 0.0), 1.0) for k in range(1, count + 1))
        found = [moment.force for moment in follow(case, at_rest(case, (0.5, 0.0)), places)]
        return np.array(found)[count // 40 - 1 :: count // 40]

    coarse, middle, fine = map(forces, (80, 160, 320))  # over the motion: at one time a front passes a cell
    assert np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine) == pytest.approx(2.0, abs=0.2)


def test_a_loaded_journal_comes_to_its_equilibrium():
    case, place = bearing(), (0.3, 0.4)
    steady = solve_film(case, Thickness(*place))
    journal = Journal(1.0, lambda t: (-steady.force[0], -steady.force[1]), lambda t: 1.0)
    times = 0.4 * np.arange(1, 151)
    *_, last = move(case, at_rest(case, (0.1, 0.1)), journal, times)
    assert last.film.imbalance < 1e-10
    np.testing.assert_allclose(last.place, place, atol=1e-6)
    np.testing.assert_allclose(last.velocity, 0.0, atol=1e-6)


def test_a_journal_follows_newton_s_law():
    """The film's force, the load and the change of momentum balance at each step; the limit without mass too."""
    case = bearing()
    for mass in (0.0, 5.0):
        journal = Journal(mass, lambda t: (2.0 + math.sin(t), 0.5), lambda t: 1.0 + 0.2 * math.cos(t))
        before = at_rest(case, (0.2, 0.0))
        for state in move(case, before, journal, 0.2 * np.arange(1, 11)):
            change = mass * (np.array(state.velocity) - before.velocity) / (state.time - before.time)
            np.testing.assert_allclose(np.add(state.force, journal.load(state.time)), change, atol=1e-6)
            np.testing.assert_allclose(
                np.subtract(state.place, before.place), 0.2 * np.array(state.velocity), atol=1e-9
            )
            before = state


def test_the_filling_time_of_a_film():
    """Longer where less oil flows in; infinite where none does."""
    places = [solve_film(bearing(), Thickness(*place)) for place in ((0.5, 0.3), (-0.5, 0.3))]
    opposite, above = map(filling_time, places)
    assert 0.5 < opposite < 2.0 * math.pi < above
    dry = places[0]._replace(groove_flow=(-1.0,))
    assert filling_time(dry) == math.inf


def test_wrong_motions_are_refused():
    case = bearing()
    start = at_rest(case, (0.1, 0.0))
    with pytest.raises(ValueError, match="time 0: must be above the one before, 0"):
        next(follow(case, start, [(0.0, (0.1, 0.0), 1.0)]))
    with pytest.raises(ValueError, match="touches"):
        next(follow(case, start, [(0.1, (1.0, 0.0), 1.0)]))
