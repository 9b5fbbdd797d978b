"""The Reynolds solver: manufactured solutions, limits, published tables, passivity."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import quad
from scipy.optimize import brentq

from linkages.laws.film.closed_form import half_film_long, short_bearing
from linkages.laws.film.map_nodes import finite_force
from linkages.laws.film.surface import Groove
from linkages.laws.film.surface.balance import Thickness, make_balance
from linkages.laws.film.surface.cavity import solve
from linkages.laws.film.surface.surface_film import outflows
from linkages.laws.film.surface.surface_mesh import surface_mesh

#: An axial line at the widest gap that is held at ambient pressure, seen from the eccentricity.
LINE = (Groove(math.pi, 1e-6),)


def manufactured(part, around):
    """Largest error for p = f(theta)*cos(pi z/2), f = cos or sin, eps = 0.7, L/D = 0.8."""
    mesh = surface_mesh(0.8, (), (0.7, 0.0), around, around // 4)
    t, z = mesh.theta[:, None], mesh.zeta / 0.8
    h = 1.0 - 0.7 * np.cos(t)
    f, df, ddf = (np.cos(t), -np.sin(t), -np.cos(t)) if part == "even" else (np.sin(t), np.cos(t), -np.sin(t))
    around_part = h**3 * ddf + 3.0 * h**2 * 0.7 * np.sin(t) * df
    loss = (around_part - h**3 * (0.5 * math.pi / 0.8) ** 2 * f) * np.cos(0.5 * math.pi * z) / 12.0
    balance = make_balance(mesh, Thickness(0.7, 0.0), speed=0.0)
    p = solve(balance._replace(gain=loss * mesh.width[:, None] * mesh.height), rule="guembel")
    return np.abs(p - f * np.cos(0.5 * math.pi * z)).max()


@pytest.mark.parametrize("part", ["even", "odd"])
def test_second_order_on_a_manufactured_solution(part):
    errors = [manufactured(part, around) for around in (64, 128, 256)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx([2.0, 2.0], abs=0.1)


def test_reynolds_condition_against_the_long_bearing_integrals():
    """Long bearing: h^3 p' = 12 (cos(theta) - cos(theta_2)), p = 0 at the widest gap and at theta_2."""
    eps = 0.6

    def flow(t, end):
        return 12.0 * (math.cos(t) - math.cos(end)) / (1.0 + eps * math.cos(t)) ** 3

    end = brentq(lambda end: quad(flow, 0.0, end, args=(end,))[0], math.pi, 1.9 * math.pi)
    # integrals of p cos and p sin, by parts
    exact = [
        quad(lambda t: -math.sin(t) * flow(t, end), 0.0, end)[0],
        quad(lambda t: math.cos(t) * flow(t, end), 0.0, end)[0],
    ]
    errors = []
    for around in (150, 300, 600):
        mesh = surface_mesh(1.0, LINE, (eps, 0.0), around, 2)
        balance = make_balance(mesh, Thickness(eps, 0.0), speed=1.0 / eps)
        p = np.maximum(solve(balance._replace(along=np.zeros_like(balance.along)), rule="reynolds"), 0.0)[:, 0]
        force = -np.array([np.diff(np.sin(mesh.faces)) @ p, -np.diff(np.cos(mesh.faces)) @ p])
        errors.append(np.hypot(*(force - exact)) / np.hypot(*exact))
    assert errors[-1] < 2e-5
    assert 0.5 * math.log2(errors[0] / errors[-1]) > 1.9  # the end falls between lines


@pytest.mark.parametrize("eps", [0.1, 0.6, 0.95])
def test_long_limit_in_rotation_is_the_half_film(eps):
    """Relative end effects of a film of constant width fall as D/L."""
    errors = []
    for slenderness in (8.0, 16.0, 32.0):
        f_n, f_t = finite_force(eps, slenderness, 0.0, 0.5, cells=(600, 64))
        exact = half_film_long(eps, 0.0, 1.0, slenderness)
        errors.append(math.hypot(f_n - exact[0], f_t - exact[1]) / math.hypot(*exact[:2]))
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("direction", [0.4, 1.6, 2.8])
def test_long_limit_with_squeeze_has_no_mean_axial_flow(direction):
    """The ends fix the constant of the long film's full pressure: its mean weighed with h^3 is zero.

    (The closed form of the half film puts p = 0 at two lines half a turn apart instead: the two differ
    as soon as the journal moves radially.)
    """
    eps, b, w = 0.5, math.cos(direction), math.sin(direction)

    # h^3 p' = 12 (b sin + w cos) + const, both parts integrated: 6 b/(eps h^2) and Sommerfeld's pressure
    def pressure(t):
        h = 1.0 + eps * math.cos(t)
        squeeze = 6.0 * b / eps * (1.0 / h**2 - 1.0 / (1.0 + 1.5 * eps**2))
        return squeeze + 12.0 * w * math.sin(t) * (1.0 + h) / ((2.0 + eps**2) * h**2)

    def component(trig):
        values = [max(pressure(t), 0.0) * trig(t) for t in np.arange(20000) * (math.pi / 10000)]
        return math.fsum(values) * math.pi / 10000

    exact = component(math.cos), component(math.sin)
    near, far = (np.array(finite_force(eps, slenderness, b, w, cells=(400, 48))) for slenderness in (16.0, 32.0))
    limit = 2.0 * far - near  # end effects fall as D/L
    assert math.hypot(limit[0] - exact[0], limit[1] - exact[1]) < 1e-3 * math.hypot(*exact)


@pytest.mark.parametrize("eps", [0.1, 0.5, 0.8])
@pytest.mark.parametrize("direction", [0.0, 0.8, 1.6, 2.4, 3.0])
def test_short_limit_is_ocvirk(eps, direction):
    """The axial parabola is exact for L/D -> 0; the mesh leaves 1e-3."""
    b, w = math.cos(direction), math.sin(direction)
    f_n, f_t = finite_force(eps, 0.01, b, w, cells=(600, 32))
    exact = short_bearing(eps, b, 2.0 * w, 0.01)
    assert math.hypot(f_n - exact[0], f_t - exact[1]) < 1e-3 * math.hypot(*exact[:2])


#: H. J. Butenschoen, Das hydrodynamische, zylindrische Gleitlager endlicher Breite unter instationaerer
#: Belastung, dissertation, Karlsruhe 1976: rotation, ambient axial line at the widest gap, Reynolds'
#: condition. eps; Sommerfeld number So_D = F psi^2/(B D eta omega) and attitude angle [deg] at B/D 1, 1/2, 1/4.
BUTENSCHOEN = [
    (0.1, (0.1196, 0.0368, 0.0098), (79.41, 81.767, 82.481)),
    (0.2, (0.2518, 0.0783, 0.021), (73.858, 75.142, 75.287)),
    (0.3, (0.4091, 0.1304, 0.0354), (68.264, 68.493, 68.204)),
    (0.4, (0.6108, 0.2026, 0.056), (62.571, 61.778, 61.208)),
    (0.5, (0.8903, 0.3124, 0.0888), (56.705, 54.993, 54.069)),
    (0.6, (1.3146, 0.4982, 0.1476), (50.536, 48.049, 46.825)),
    (0.7, (2.0432, 0.8595, 0.2708), (43.859, 40.803, 39.326)),
    (0.8, (3.5663, 1.7339, 0.6043), (36.235, 32.938, 31.249)),
    (0.9, (8.4352, 5.0881, 2.1595), (26.482, 23.566, 21.79)),
    (0.95, (18.7895, 13.3083, 6.9248), (19.45, 17.265, 15.632)),
    (0.96, (24.1172, 17.7934, 9.8517), (17.609, 15.66, 14.109)),
    (0.97, (33.1297, 25.592, 15.2697), (15.484, 13.818, 12.299)),
    (0.98, (51.4774, 41.923, 27.504), (12.903, 11.598, 10.375)),
    (0.99, (107.7868, 93.7881, 70.0359), (9.416, 8.587, 7.703)),
]


@pytest.mark.parametrize(("eps", "sommerfeld", "attitude"), BUTENSCHOEN)
def test_butenschoen(eps, sommerfeld, attitude):
    """To 1 % and 0.1 deg: the tables have 3 to 6 digits, computed on the meshes of 1976."""
    forces = [finite_force(eps, width, 0.0, 0.5 * eps, "reynolds", LINE, (240, 20)) for width in (1.0, 0.5, 0.25)]
    assert [0.5 * math.hypot(f_n, f_t) for f_n, f_t in forces] == pytest.approx(sommerfeld, rel=0.01)
    assert [math.degrees(math.atan2(f_t, -f_n)) for f_n, f_t in forces] == pytest.approx(attitude, abs=0.1)


def test_short_bearing_coefficients():
    """ROSS 2.3.0 CylindricalBearing: 1500 rpm, 525 N, L 30 mm, D 100 mm, c 0.1 mm, 0.1 Pa s."""
    c, radius, length, omega = 1e-4, 0.05, 0.03, 1500.0 * math.pi / 30.0
    unit = 0.1 * length * radius**3 / c**2

    def force(x, y, vx, vy):
        e = math.hypot(x, y)
        nx, ny = x / e, y / e
        eps, deps, v_t = e / c, (vx * nx + vy * ny) / c, vy * nx - vx * ny
        f_n, f_t, _ = short_bearing(eps, deps, eps * omega - 2.0 * v_t / c, length / (2.0 * radius))
        return unit * np.array([f_n * nx - f_t * ny, f_n * ny + f_t * nx])

    eps = brentq(lambda eps: np.hypot(*force(eps * c, 0.0, 0.0, 0.0)) - 525.0, 0.05, 0.9, xtol=1e-15)
    assert eps == pytest.approx(0.26629750900547683, rel=1e-9)
    f_x, f_y = force(eps * c, 0.0, 0.0, 0.0)
    turn = math.pi / 2.0 - math.atan2(f_y, f_x)  # the film carries the load, which points along -y
    x, y = eps * c * math.cos(turn), eps * c * math.sin(turn)
    at, step = np.array([x, y, 0.0, 0.0]), np.array([1e-9, 1e-9, 1e-7, 1e-7])
    columns = [
        (force(*(at - step * (k == i))) - force(*(at + step * (k == i)))) / (2.0 * step[i])
        for i, k in ((i, np.arange(4)) for i in range(4))
    ]
    stiffness = np.array([[12807959.57740873, 16393593.24867439], [-25060393.27644924, 8815302.74116861]])
    damping = np.array([[232896.92986658, -81924.37052422], [-81924.37052422, 294911.61944048]])
    # finite differences leave 1e-8; the reference's own damping is differenced, 1e-7
    assert np.transpose(columns[:2]) == pytest.approx(stiffness, rel=1e-6)
    assert np.transpose(columns[2:]) == pytest.approx(damping, rel=1e-6)


@njit
def relax(p, along_theta, along_z, source, omega):
    """One sweep of projected SOR over the ring; the largest change of pressure."""
    change = 0.0
    count = len(p)
    for i in range(count):
        east, west, axial = along_theta[i], along_theta[i - 1], along_z[i]
        for j in range(count):
            around = east * p[(i + 1) % count, j] + west * p[i - 1, j]
            balance = around + axial * (p[i, abs(j - 1)] + p[i, j + 1]) - source[i]
            relaxed = max(p[i, j] + omega * (balance / (east + west + 2.0 * axial) - p[i, j]), 0.0)
            change = max(change, abs(relaxed - p[i, j]))
            p[i, j] = relaxed
    return change


def projected_relaxation(eps, slenderness, b, w, n):
    """Reynolds' condition by projected SOR: central differences on n x n uniform steps, periodic in theta.

    Shares nothing with the solver: not the mesh, the differences, nor the method. Returns f_n, f_t.
    """
    dt, dz = 2.0 * math.pi / n, slenderness / n
    theta = np.arange(n) * dt
    along_theta = (1.0 + eps * np.cos(theta + 0.5 * dt)) ** 3 / dt**2
    along_z = (1.0 + eps * np.cos(theta)) ** 3 / dz**2
    source = 12.0 * (b * np.cos(theta) - w * np.sin(theta))
    omega = 2.0 / (1.0 + 0.75 * math.pi / slenderness * min(dt, dz))
    p = np.zeros((n, n + 1))  # p[:, 0] in the middle of the bearing, p[:, n] = 0 at its open end
    while relax(p, along_theta, along_z, source, omega) > 1e-9 * p.max():
        pass
    mean = (p.sum(axis=1) - 0.5 * p[:, 0]) * dt / n
    return mean @ np.cos(theta), mean @ np.sin(theta)


@pytest.mark.parametrize(
    ("slenderness", "eps", "direction"),
    [
        (1.0, 0.7, 1.57), (3.0, 0.7, 0.8), (4.0, 0.7, 1.57), (6.0, 0.7, 1.57), (8.0, 0.3, 0.8),
        (8.0, 0.7, 1.57), (16.0, 0.3, 1.57), (16.0, 0.7, 0.8), (16.0, 0.7, 2.5),
    ],
)  # fmt: skip
def test_reynolds_condition_against_projected_relaxation(slenderness, eps, direction):
    """A long bearing is wet all around in its middle, where the opening film holds pressure too."""
    b, w = math.cos(direction), math.sin(direction)
    coarse, middle, fine = (np.array(projected_relaxation(eps, slenderness, b, w, n)) for n in (32, 64, 128))
    assert np.hypot(*(middle - coarse)) > 2.5 * np.hypot(*(fine - middle))  # it converges
    exact = fine + (fine - middle) / 3.0  # and in second order
    force = np.array(finite_force(eps, slenderness, b, w, "reynolds", cells=(480, 32)))
    assert np.hypot(*(force - exact)) < 5e-4 * np.hypot(*exact)


@pytest.mark.parametrize("direction", [0.4, 1.6, 2.8])
def test_long_limit_of_reynolds_condition_is_the_full_film(direction):
    """No film that is cut off by p = dp/dn = 0 balances its flow around a ring: the ends lift it all.

    Sommerfeld's full film, by residues: integral of p cos = -12 pi b / q^(3/2), of p sin = 24 pi w /
    ((2 + eps^2) q^(1/2)); the constant of its pressure carries no load.
    """
    eps, b, w = 0.5, math.cos(direction), math.sin(direction)
    q = 1.0 - eps * eps
    exact = -12.0 * math.pi * b / q**1.5, 24.0 * math.pi * w / ((2.0 + eps * eps) * math.sqrt(q))
    near, far = (
        np.array(finite_force(eps, slenderness, b, w, "reynolds", cells=(360, 48))) for slenderness in (32.0, 64.0)
    )
    limit = 2.0 * far - near  # end effects fall as D/L
    assert math.hypot(limit[0] - exact[0], limit[1] - exact[1]) < 1e-3 * math.hypot(*exact)


@pytest.mark.parametrize(
    ("eps", "slenderness", "direction"), [(0.3, 4.0, 0.8), (0.93949, 50.4396, 0.1353), (0.717, 693.3, 2.5162)]
)
def test_reynolds_condition_settles(eps, slenderness, direction):
    """Also where the first guess is far off, and where cells of the middle differ by round-off."""
    f_n, f_t = finite_force(eps, slenderness, math.cos(direction), math.sin(direction), "reynolds")
    assert f_n * math.cos(direction) - f_t * math.sin(direction) < 0.0


STATES = {"eps": st.floats(0.0, 0.99), "slenderness": st.floats(0.1, 16.0), "direction": st.floats(-math.pi, math.pi)}


@settings(max_examples=25)
@given(**STATES)
def test_complementarity_passivity_and_symmetry(eps, slenderness, direction):
    b, w = math.cos(direction), math.sin(direction)
    mesh = surface_mesh(slenderness, (), (eps, 0.0), 96, 8)
    balance = make_balance(mesh, Thickness(eps, 0.0), (b, -w), speed=0.0)  # from an observer who turns with the film
    p = np.maximum(solve(balance, rule="reynolds"), 0.0)
    out, _ = outflows(balance, 0.0, p, np.ones_like(p))
    excess, small = out + balance.gain, 1e-10 * np.abs(balance.gain).max()
    assert excess.min() > -small
    assert np.abs(excess[p > 0.0]).max() < small
    force, mirrored, double = (
        np.array(finite_force(eps, slenderness, *motion, "reynolds", cells=(96, 8)))
        for motion in ((b, w), (b, -w), (2.0 * b, 2.0 * w))
    )
    assert force @ (b, -w) < 0.0
    size = np.hypot(*force)
    assert mirrored * (1.0, -1.0) == pytest.approx(force, abs=1e-8 * size)
    assert double == pytest.approx(2.0 * force, abs=1e-8 * size)
    assert np.dot(finite_force(eps, slenderness, b, w, cells=(96, 8)), (b, -w)) < 0.0


def test_a_guess_changes_nothing():
    mesh = surface_mesh(1.0, (), (0.7, 0.0), 96, 8)
    near, film = (make_balance(mesh, Thickness(0.7, 0.0), motion, speed=0.0) for motion in ((0.2, -0.5), (0.3, -0.4)))
    alone = solve(film, rule="reynolds")
    assert np.array_equal(solve(film, rule="reynolds", guess=solve(near, rule="reynolds")), alone)


@pytest.mark.parametrize(
    ("arguments", "message"), [((0.0,), "slenderness"), ((1.0, (), (0.5, 0.0), 7, 4), "mesh 7 x 4")]
)
def test_bad_meshes_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        surface_mesh(*arguments)
