"""Films with grooves as maps: nodes, steady motion, stability, passivity, frames, supply pressure, both engines."""

import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from joint_records import map_quantities
from shipped import shipped

import linkages
from linkages.laws import PARAMETERS
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.film_map import GROOVED_CAVITATIONS, MapCase, build_map
from linkages.laws.film.films import MAPPED
from linkages.laws.film.map_nodes import CENTRE, is_symmetric, solve_grooved
from linkages.laws.film.map_table import head_of, ratios, static_film
from linkages.laws.film.surface import Groove
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.equilibrium import coefficients, equilibrium, stability
from linkages.laws.film.surface.surface_film import FilmSurface, Pressures, solve_film
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.journal import clearance_force, end_flow
from linkages.results.joint_validity import film_content, outside

SLENDERNESS, CELLS, NODES = 4.0 / 3.0, (48, 4), (13, 24, 16)
GROOVE = Groove(0.0, math.radians(20.0), 0.8)
#: Two grooves of different lengths, and a hole off the middle: no symmetry.
SEVERAL = (GROOVE._replace(angle=0.3), Groove(2.0, 0.3, 0.5), Groove(-1.0, 0.3, 0.2, position=0.2, hole=True))
rules = pytest.mark.parametrize("rule", GROOVED_CAVITATIONS)


@cache
def small(rule, grooves=(GROOVE,), nodes=NODES):
    """A map with few nodes."""
    return build_map(MapCase(SLENDERNESS, rule, grooves, nodes, CELLS))


def motion(eps, y):
    """deps and ew in the direction y of the map."""
    return math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25


def unit(eps, deps, ew):
    return math.hypot(*half_film_long(eps, deps, ew, 0.0)[:2])


def steady(eps, alpha, rule, grooves=(GROOVE,), cells=CELLS, pressure=0.0, velocity=(0.0, 0.0)):
    """The film of a journal in a bearing at alpha from the first groove, at rest or with a velocity, speed 1."""
    placed = tuple(g._replace(angle=g.angle - grooves[0].angle - alpha, pressure=pressure) for g in grooves)
    mesh = surface_mesh(SLENDERNESS, placed, (eps, 0.0), *cells)
    return solve_film(FilmSurface(mesh, placed), Thickness(eps, 0.0), rule=rule, velocity=velocity)


@pytest.mark.parametrize("grooves", [(GROOVE,), pytest.param(SEVERAL, marks=pytest.mark.slow)])
@rules
def test_a_map_holds_the_solver_s_values_at_its_nodes(rule, grooves):
    """Also those that are mirror images of what was solved, which has other cells."""
    nodes = NODES if len(grooves) == 1 else (11, 18, 12)  # all are solved without symmetry
    table = small(rule, grooves, nodes)
    for i, j, k in ((3, 2, 2), (3, 17, 11), (9, 6, 0)):
        eps, y, alpha = float(ratios(head_of(table))[i]), 2.0 * math.pi * j / nodes[1], 2.0 * math.pi * k / nodes[2]
        placed = tuple(g._replace(angle=g.angle - grooves[0].angle) for g in grooves)
        exact = solve_grooved(eps, SLENDERNESS, placed, alpha, rule, np.array([y]), CELLS)[0]
        f_n, f_t, extent, flow = map_quantities(eps, *motion(eps, y), alpha, table)
        scale = unit(eps, *motion(eps, y))
        found = f_n / scale, f_t / scale, extent * math.sqrt(1.0 - eps * eps), flow
        assert found == pytest.approx(exact, abs=2e-3)


@rules
def test_steady_rotation_of_a_fed_film_is_the_solver_s(rule):
    """Force, flow out of the ends and shear, away from the centre."""
    for eps, alpha in ((0.4, math.pi), (0.6, 2.4), (0.8, -2.4)):
        film = steady(eps, alpha, rule)
        row = solve_grooved(eps, SLENDERNESS, (GROOVE,), alpha, rule, np.array([0.5 * math.pi]), CELLS)[0]
        scale = 0.5 * eps * unit(eps, *motion(eps, 0.5 * math.pi)) * (1.0 - eps * eps) ** 0.25
        found = 2.0 * SLENDERNESS * scale * row[:2]
        assert np.hypot(*(found - film.force)) < (0.01 if rule == "mass-conserving" else 1e-9) * np.hypot(*film.force)
        speed = 0.5 * eps * (1.0 - eps * eps) ** 0.25
        assert speed * row[3] == pytest.approx(film.end_flow, rel=0.03)
        shear = 2.0 * SLENDERNESS * row[2] / math.sqrt(1.0 - eps * eps)
        full = steady(eps, alpha, "reynolds").shear
        share = eps**2 / (eps**2 + CENTRE**2) if rule == "mass-conserving" else 1.0
        assert shear == pytest.approx(share * film.shear + (1.0 - share) * full, rel=1e-9)


def test_the_radial_damping_of_a_steady_rotation_is_the_solver_s():
    """Differences over the same velocities, of the film of `linkages.bearing`: 3 % of the damping.

    The content of the whirl alone is 7 to 15 % off.
    """
    y = np.array([0.5 * math.pi - 0.1, 0.5 * math.pi + 0.1])
    for eps, alpha in ((0.5, math.pi), (0.5, 2.4), (0.7, 2.0)):
        sides = []
        for row, angle in zip(
            solve_grooved(eps, SLENDERNESS, (GROOVE,), alpha, "mass-conserving", y, CELLS), y, strict=True
        ):
            deps, ew = motion(eps, angle)
            sides.append(2.0 * SLENDERNESS * unit(eps, deps, ew) * row[:2] * eps / ew)  # speed 1
        velocity = 0.5 * eps * math.tan(0.1) * (1.0 - eps * eps) ** 0.25
        ahead, behind = (
            np.array(steady(eps, alpha, "mass-conserving", velocity=(v, 0.0)).force) for v in (velocity, -velocity)
        )
        assert np.hypot(*(sides[0] - sides[1] - (ahead - behind))) < 0.03 * np.hypot(*(ahead - behind))


@pytest.mark.slow
def test_a_rotor_on_a_map_begins_to_whirl_at_the_mass_of_the_bearing():
    """Stiffness and damping of `linkages.bearing` to 2 % of the largest, the critical mass to 5 %.

    Its mesh is finer; on the mesh of the map its own coefficients differ by 1 %, and the critical mass by up to 3 %.
    """
    groove, diameter, clearance, speed = Groove(-0.5 * math.pi, math.radians(20.0), 0.8), 0.1, 1e-4, 100.0
    table = build_map(MapCase(1.0, "mass-conserving", (groove,)))
    joint = record(radius=0.5 * diameter, length=diameter, viscosity=0.03, groove_angle=groove.angle)

    def force(x, y, vx, vy):
        e, v = (x * clearance, y * clearance), (vx * clearance * speed, vy * clearance * speed)
        return clearance_force(joint, table, *e, *v, 0.0, speed, (0.0, 0.0, 0.0, 0.0), 0.0)[:2]

    for load in (5968.0, 2387.0):  # Sommerfeld numbers 0.2 and 0.5
        point = linkages.bearing(diameter, diameter, clearance, 0.03, speed, load, grooves=[groove])
        x, y = equilibrium(force, load, lambda x, y: 0.99 - math.hypot(x, y), (point.x, point.y))
        found = coefficients(force, x, y, 1e-4 * (1.0 - math.hypot(x, y)))
        mine = found.stiffness / load, found.damping / load
        own = point.coefficients.stiffness, point.coefficients.damping
        exact = own[0] * clearance / load, own[1] * clearance * speed / load
        for one, other in zip(mine, exact, strict=True):
            assert np.abs(one - other).max() < 0.02 * np.abs(other).max()
        assert stability(*mine).critical_mass == pytest.approx(stability(*exact).critical_mass, rel=0.05)


@rules
def test_friction_does_not_depend_on_the_sense_of_rotation(rule):
    """The film of mirrored grooves and a mirrored motion is the mirror image: force, shear and flow.

    The lines of both meshes are interpolated in a table of 4096 angles: they agree to 1e-6.
    """
    mirrored = tuple(groove._replace(angle=-groove.angle) for groove in SEVERAL)
    angles = np.arange(8) * 0.25 * math.pi  # pure squeeze motions, pure rotations, and motions between them
    for eps in (0.3, 0.7):
        film = solve_grooved(eps, SLENDERNESS, SEVERAL, 0.0, rule, angles, CELLS)
        image = solve_grooved(eps, SLENDERNESS, mirrored, 0.0, rule, angles, CELLS)[-np.arange(8) % 8]
        assert image * (1.0, -1.0, 1.0, 1.0) == pytest.approx(film, abs=1e-6)


@rules
def test_between_the_nodes(rule):
    """Of |F_long|: the median within 0.3 %, nine of ten within 3 %. Sources are steep near the groove."""
    random, errors = np.random.default_rng(1), []
    for x, y, alpha in random.uniform((0.0, -3.1, -4.0), (3.0, 3.1, 4.0), (60, 3)):
        eps = -math.expm1(-x)
        exact = solve_grooved(eps, SLENDERNESS, (GROOVE,), alpha, rule, np.array([y]), CELLS)[0]
        f_n, f_t, *_ = map_quantities(eps, *motion(eps, y), alpha, small(rule))
        scale = unit(eps, *motion(eps, y))
        errors.append(math.hypot(f_n / scale - exact[0], f_t / scale - exact[1]))
    assert np.median(errors) < 3e-3
    assert np.quantile(errors, 0.9) < 0.03


@rules
def test_a_grooved_film_is_passive_and_homogeneous(rule):
    """f_n deps - f_t ew/2 <= 0 and a factor of the motion, of the map."""
    random = np.random.default_rng(2)
    for x, y, alpha in random.uniform((0.0, -3.14, -4.0), (4.0, 3.14, 4.0), (300, 3)):
        eps = -math.expm1(-x)
        deps, ew = motion(eps, y)
        f_n, f_t, _, flow = map_quantities(eps, deps, ew, alpha, small(rule))
        assert f_n * deps - 0.5 * f_t * ew <= 1e-12 * unit(eps, deps, ew)
        twice = map_quantities(eps, 2.0 * deps, 2.0 * ew, alpha, small(rule))
        assert twice[:2] == pytest.approx((2.0 * f_n, 2.0 * f_t), rel=1e-12)
        assert twice[3] == pytest.approx(2.0 * flow, rel=1e-12)


@rules
def test_a_journal_without_mass_does_not_jump(rule):
    """The velocity of a light journal is stable: eigenvalues of dF/dv have no positive real part."""
    random, worst, size, step = np.random.default_rng(3), [], [], 1e-4
    for x, y, alpha in random.uniform((0.0, -3.14, -3.14), (1.5, 3.14, 3.14), (600, 3)):
        eps = -math.expm1(-x)
        deps, ew = motion(eps, y)

        def force(deps, half_ew, eps=eps, alpha=alpha):
            return np.array(map_quantities(eps, deps, 2.0 * half_ew, alpha, small(rule))[:2])

        slope = np.column_stack([
            force(deps + step, 0.5 * ew) - force(deps - step, 0.5 * ew),
            force(deps, 0.5 * ew - step) - force(deps, 0.5 * ew + step),
        ]) / (2.0 * step)  # fmt: skip
        worst.append(np.linalg.eigvals(slope).real.max())
        size.append(np.linalg.norm(slope, 2))
    assert np.quantile(worst, 0.99) < 0.0
    assert max(worst) < 0.1 * np.median(size)


def record(**values):
    found = np.zeros(1, PARAMETERS)
    given = {"clearance": 1e-4, "radius": 0.015, "length": 0.04, "film": MAPPED, "viscosity": 0.4, "shear": 1}
    for name, value in (given | {"groove_angle": 0.3} | values).items():
        found[0][name] = value
    return found[0]


@rules
def test_the_groove_turns_with_the_bearing(rule):
    """Everything turned by an angle turns the force; the groove alone changes it; any rotating observer sees one force."""
    joint, e, v = record(), np.array([4e-5, -3e-5]), np.array([0.01, 0.02])

    def force(e, v, wb, wj, angle):
        return np.array(clearance_force(joint, small(rule), *e, *v, wb, wj, (0.0, 0.0, 0.0, 0.0), angle)[:2])

    first, turn = force(e, v, 3.0, 40.0, 0.2), 1.3
    matrix = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    np.testing.assert_allclose(force(matrix @ e, matrix @ v, 3.0, 40.0, 0.2 + turn), matrix @ first, rtol=1e-9)
    assert np.hypot(*(force(e, v, 3.0, 40.0, 0.2 + turn) - first)) > 0.01 * np.hypot(*first)
    rate = 17.0  # of the observer: velocities change by rate z x e
    seen = force(e, v + rate * np.array([-e[1], e[0]]), 3.0 + rate, 40.0 + rate, 0.2)
    np.testing.assert_allclose(seen, first, rtol=1e-9)


def test_a_journal_at_rest_floats_on_the_supply_pressure():
    """Force and flow of a film without motion, in Pa and m3/s, are those of the solver; a half pressure gives half."""
    grooves = tuple(groove._replace(pressure=2e5) for groove in (GROOVE, Groove(math.pi / 2, 0.35, 0.5)))
    table, eps = small("reynolds", grooves), 0.35
    joint = record(supply_pressure=2e5, groove_angle=0.0)
    e = np.array([0.0, eps * 1e-4])  # at 90 degrees from the first groove
    fx, fy, *_ = clearance_force(joint, table, *e, 0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0))
    mesh = surface_mesh(SLENDERNESS, grooves, (0.0, eps), *CELLS)
    surface = FilmSurface(mesh, grooves, Pressures(unit=0.4 * (0.015 / 1e-4) ** 2))
    film = solve_film(surface, Thickness(0.0, eps), rule="reynolds", speed=0.0)
    force = 0.4 * 0.015**4 / 1e-4**2 * np.array(film.force)
    assert np.hypot(*(force - (fx, fy))) < 0.01 * np.hypot(*force)
    flow = 1e-4 * 0.015**2 * film.end_flow
    assert end_flow(joint, table, *e, 0.0, 0.0, 0.0, 0.0) == pytest.approx(flow, rel=0.01)
    assert np.hypot(*force) > 10.0
    half = record(supply_pressure=1e5, groove_angle=0.0)
    found = clearance_force(half, table, *e, 0.0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0))[:2]
    assert found == pytest.approx((0.5 * fx, 0.5 * fy), rel=1e-9)
    assert static_film(0.3, 0.0, small("reynolds")) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("last", "said"), [(0.5, ""), (0.1, "50% of its cavity counts as full at the last ratio, 0.1")]
)
def test_the_warning_states_the_error_near_the_centre(last, said):
    """The content fades by 1/(1 + (eps/0.1)^2)."""
    model = SimpleNamespace(has_film=True, feed=(GROOVE,), cavitation="mass-conserving", has_history=False)
    run = {"A.eccentricity_ratio": np.array([0.0, 0.7, last])}
    case = SimpleNamespace(joint=SimpleNamespace(name="A"), model=model, run=run)
    finding = film_content(case)
    assert finding.value == 0.7
    assert said in finding.limit
    assert ("counts as full" in finding.limit) == bool(said)


def test_symmetry_of_grooves():
    assert is_symmetric((GROOVE, Groove(0.5, 0.2), Groove(-0.5, 0.2)))
    assert is_symmetric((GROOVE, Groove(math.pi, 0.2)))
    assert not is_symmetric((GROOVE, Groove(0.5, 0.2), Groove(-0.5, 0.2, 0.5)))
    ring = (Groove(0.0, 2.0 * math.pi, 0.2),)
    assert len(small("mass-conserving", ring)) < len(small("reynolds")) / 10  # one angle
    first, other = (map_quantities(0.5, 0.1, 0.4, alpha, small("mass-conserving", ring)) for alpha in (0.0, 2.0))
    assert first == other


GROOVED = {"joints.A.cavitation": "mass-conserving", "joints.A.film": "finite"}
FED = {"joints.A.groove": {"angle": 0.5, "extent": 0.35, "length": 0.8, "pressure": 1e4}}


@pytest.mark.slow
def test_both_engines_move_alike():
    """The press with a groove in joint A, 0.1 s: orbit and forces of both engines; the film differs from the plain one."""
    system = shipped("seven_bar", duration=0.1, **GROOVED, **FED)
    runs = [linkages.simulate(system, engine) for engine in ("compiled", "drake")]
    for name in ("A.eccentricity_ratio", "A.force", "A.flow", "A.friction_torque"):
        peaks = [np.abs(run[name]).max() for run in runs]
        assert peaks[0] == pytest.approx(peaks[1], rel=1e-3)
    assert runs[0]["A.flow"].min() > 0.0
    assert any("has no history" in entry["what"] for entry in outside(system, runs[0], ()))
    plain = linkages.simulate(shipped("seven_bar", duration=0.1, **{"joints.A.film": "finite"}), "compiled")
    assert plain["A.eccentricity_ratio"].max() != pytest.approx(runs[0]["A.eccentricity_ratio"].max(), rel=0.02)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({}, "add a groove, or choose cavitation guembel or reynolds"),
        ({"joints.A.groove": {"angle": 0.0, "extent": 7.0}}, "extent 7 rad: must be above 0 .* at most a turn"),
        ({"joints.A.groove": {"angle": 0.0, "extent": 0.3, "length": 1.5}}, "length"),
        ({"joints.A.groove": {"angle": 0.0, "extent": 0.3, "position": 0.2}}, "reaches beyond the bearing"),
        ({"joints.A.groove": {"angle": 0.0, "extent": 0.3, "pressure": -1.0}}, "pressure"),
        (FED | {"joints.A.grooves": {"B": {"angle": 0.6, "extent": 0.3}}}, "groove 2: overlaps another one"),
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
