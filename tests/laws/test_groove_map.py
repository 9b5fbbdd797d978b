"""Films with a groove as maps: nodes, smoothness, passivity, frames, both engines."""

import math
from functools import cache

import numpy as np
import pytest
from shipped import shipped

import linkages
from linkages.laws import PARAMETERS
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.films import MAPPED
from linkages.laws.film.groove_map import RULES, build_groove_map, grooved_film, solve_grooved
from linkages.laws.film.surface import Groove
from linkages.laws.journal import clearance_force
from linkages.results.joint_validity import outside

SLENDERNESS, CELLS, NODES = 4.0 / 3.0, (48, 4), (11, 24, 12)
GROOVE = Groove(0.0, math.radians(20.0), 0.8)
rules = pytest.mark.parametrize("rule", RULES)


@cache
def small(rule):
    """A map with few nodes."""
    return build_groove_map(SLENDERNESS, GROOVE, rule, nodes=NODES, cells=CELLS)


def motion(eps, y):
    """deps and ew in the direction y of the map."""
    return math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25


def unit(eps, deps, ew):
    return math.hypot(*half_film_long(eps, deps, ew, 0.0)[:2])


@rules
def test_a_map_holds_the_solver_s_values_at_its_nodes(rule):
    """Also those that are mirror images of what was solved."""
    eps = 1.0 - math.exp(-4.0 * math.log(100.0) / 10.0)
    for j, k in ((3, 2), (17, 9), (0, 6)):
        y, alpha = 2.0 * math.pi * j / NODES[1], 2.0 * math.pi * k / NODES[2]
        exact = solve_grooved(eps, SLENDERNESS, GROOVE, rule, alpha, np.array([y]), CELLS)[0]
        deps, ew = motion(eps, y)
        f_n, f_t, extent = grooved_film(eps, deps, ew, alpha, small(rule))
        found = f_n / unit(eps, deps, ew), f_t / unit(eps, deps, ew), extent * math.sqrt(1.0 - eps * eps)
        assert found == pytest.approx(exact, abs=2e-3)  # the mirror image has other cells


@rules
def test_between_the_nodes(rule):
    """Of |F_long|: the median within 0.3 %, nine of ten within 3 %; a fine map halves it. Content is steep near the centre."""
    random, errors = np.random.default_rng(1), []
    for x, y, alpha in random.uniform((0.0, -3.1, -4.0), (3.0, 3.1, 4.0), (60, 3)):
        eps = -math.expm1(-x)
        deps, ew = motion(eps, y)
        exact = solve_grooved(eps, SLENDERNESS, GROOVE, rule, alpha, np.array([y]), CELLS)[0]
        f_n, f_t, _ = grooved_film(eps, deps, ew, alpha, small(rule))
        scale = unit(eps, deps, ew)
        errors.append(math.hypot(f_n / scale - exact[0], f_t / scale - exact[1]))
    assert np.median(errors) < 3e-3
    assert np.quantile(errors, 0.9) < 0.03


@rules
def test_a_grooved_film_is_passive_and_homogeneous(rule):
    """f_n deps - f_t ew/2 <= 0, of the solver and of the map."""
    random = np.random.default_rng(2)
    for x, y, alpha in random.uniform((0.0, -3.14, -4.0), (4.0, 3.14, 4.0), (300, 3)):
        eps = -math.expm1(-x)
        deps, ew = motion(eps, y)
        f_n, f_t, _ = grooved_film(eps, deps, ew, alpha, small(rule))
        assert f_n * deps - 0.5 * f_t * ew <= 1e-12 * unit(eps, deps, ew)
        twice = grooved_film(eps, 2.0 * deps, 2.0 * ew, alpha, small(rule))
        assert twice[:2] == pytest.approx((2.0 * f_n, 2.0 * f_t), rel=1e-12)
    for eps, deps, ew, alpha in ((0.3, 0.5, 0.8, 1.0), (0.7, -0.4, 0.9, -2.0), (0.1, -0.2, -0.7, 3.0)):
        exact = solve_grooved(eps, SLENDERNESS, GROOVE, rule, alpha, np.array([math.atan2(ew, deps)]), CELLS)[0]
        y = math.atan2(ew, deps)
        half_ew = math.sin(y) / (1.0 - eps * eps) ** 0.25
        assert exact[0] * math.cos(y) - exact[1] * half_ew <= 1e-12


def record(groove_angle=0.3):
    found = np.zeros(1, PARAMETERS)
    values = {"clearance": 1e-4, "radius": 0.015, "length": 0.04, "film": MAPPED, "viscosity": 0.4, "shear": 1}
    for name, value in (values | {"groove_angle": groove_angle}).items():
        found[0][name] = value
    return found[0]


@rules
def test_the_groove_turns_with_the_bearing(rule):
    """Everything turned by an angle turns the force; the groove alone changes it; any rotating observer sees one force."""
    joint, e, v = record(), np.array([4e-5, -3e-5]), np.array([0.01, 0.02])

    def force(e, v, wb, wj, angle):
        return np.array(clearance_force(joint, small(rule), *e, *v, wb, wj, 0.0, 0.0, angle)[:2])

    first, turn = force(e, v, 3.0, 40.0, 0.2), 1.3
    matrix = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    np.testing.assert_allclose(force(matrix @ e, matrix @ v, 3.0, 40.0, 0.2 + turn), matrix @ first, rtol=1e-9)
    assert np.hypot(*(force(e, v, 3.0, 40.0, 0.2 + turn) - first)) > 0.01 * np.hypot(*first)
    rate = 17.0  # of the observer: velocities change by rate z x e
    seen = force(e, v + rate * np.array([-e[1], e[0]]), 3.0 + rate, 40.0 + rate, 0.2)
    np.testing.assert_allclose(seen, first, rtol=1e-9)


def test_steady_rotation_is_that_of_the_bearing_command():
    """Mass-conserving, eps 0.6, groove opposite the eccentricity: the map's force by the solver of `linkages.bearing`."""
    from linkages.laws.film.surface.balance import Thickness
    from linkages.laws.film.surface.surface_film import solve_film
    from linkages.laws.film.surface.surface_mesh import surface_mesh

    placed = (GROOVE._replace(angle=math.pi),)
    mesh = surface_mesh(SLENDERNESS, placed, (0.6, 0.0), *CELLS)
    film = solve_film(mesh, Thickness(0.6, 0.0), placed)
    f_n, f_t, _ = grooved_film(0.6, 0.0, 0.6, math.pi, small("mass-conserving"))
    scale = 2.0 * SLENDERNESS
    assert (scale * f_n, scale * f_t) == pytest.approx(film.force, rel=0.02)


GROOVED = {"joints.A.cavitation": "mass-conserving", "joints.A.film": "finite"}


@pytest.mark.slow
def test_both_engines_move_alike():
    """The press with a groove in joint A, 0.1 s: orbit and forces of both engines; the film differs from the plain one."""
    groove = {"joints.A.groove": {"angle": 0.5, "extent": 0.35, "length": 0.8}}
    system = shipped("seven_bar", duration=0.1, **GROOVED, **groove)
    runs = [linkages.simulate(system, engine) for engine in ("compiled", "drake")]
    for name in ("A.eccentricity_ratio", "A.force"):
        peaks = [np.abs(run[name]).max() for run in runs]
        assert peaks[0] == pytest.approx(peaks[1], rel=1e-3)
    assert any("has no history" in entry["what"] for entry in outside(system, runs[0], ()))
    plain = linkages.simulate(shipped("seven_bar", duration=0.1, **{"joints.A.film": "finite"}), "compiled")
    assert plain["A.eccentricity_ratio"].max() != pytest.approx(runs[0]["A.eccentricity_ratio"].max(), rel=0.02)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({}, "add a groove, or choose cavitation guembel or reynolds"),
        ({"joints.A.groove": {"angle": 0.0, "extent": 7.0}}, "extent 7 rad: must be from 0 to a turn"),
        ({"joints.A.groove": {"angle": 0.0, "extent": 0.3, "length": 1.5}}, "length"),
        (
            {"joints.A.groove": {"angle": 0.0, "extent": 0.3}, "joints.A.cavitation": "guembel"},
            "groove needs cavitation",
        ),
        ({"joints.A.groove": {"angle": 0.0, "extent": 0.3}, "joints.A.film": "long"}, 'film "finite"'),
    ],
)
def test_impossible_joints_are_refused(values, text):
    with pytest.raises(linkages.InputError, match=text):
        shipped("seven_bar", **(GROOVED | values))
