"""Large deflections: links divided into substructures converge to the elastica, at rest and in motion."""

import numpy as np
import pytest
from absolute_beam import AbsoluteBeam, deflection, motion
from machines import elastic_bar, elastic_slider_crank, joint, model, solid
from scipy.integrate import trapezoid
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc
from spun_beams import SPIN, SPUN, spun, tip_of

from linkages import InputError, simulate
from linkages.input.model.beam_interfaces import interfaces
from linkages.mechanics.planar.bodies import make_pose
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.kinematics import body_positions
from linkages.results.outputs.columns import columns
from linkages.system.rigid_segments import segmented

LENGTH = 0.4
CANTILEVER = model("cantilever", elastic_bar("rod", LENGTH, "__model__") + joint("O", "world", "rod"))
UNIT = 2e11 * 0.008**4 / 12 / LENGTH**2  # E I / L2 of the cantilever [N]

HELD = """duration = 1e-4
[drives.O]
speed = 0.0
[forces.P]
point = "rod_tip"
force = [{}, {}]
[links.rod]
model = "flexible"
pieces = {}
axial = 0
"""


def elastica(across, along):
    """Displacements over the length, turn of the tip and strain energy, E I / L, of a cantilever under a tip force.

    The force, in units of E I / L2, has the angle beta against the axis of the straight beam. The tangent's angle psi
    from the thrust's line satisfies psi'^2 = 2 F (cos psi - cos psi_1), psi_1 at the tip: with sin(psi / 2) = k
    sin(phi) all follows by elliptic integrals of modulus k = sin(psi_1 / 2) (Love, A Treatise on the Mathematical
    Theory of Elasticity, sections 262-263).
    """
    root, beta = np.hypot(across, along) ** 0.5, np.pi - np.arctan2(across, along)

    def amplitude(k):
        return np.arcsin(min(np.sin(beta / 2) / k, 1.0))

    def gap(tip):
        k = np.sin(tip / 2)
        return ellipk(k * k) - ellipkinc(amplitude(k), k * k) - root

    tip = brentq(gap, beta * (1 + 1e-14), np.pi - 1e-9, xtol=1e-15)
    k = np.sin(tip / 2)
    m, first = k * k, amplitude(k)
    x = 2 * (ellipe(m) - ellipeinc(first, m)) / root - 1.0  # the arc has the length root / root
    y = 2 * k * np.cos(first) / root
    c, s = np.cos(beta), np.sin(beta)
    return np.array([x * c + y * s - 1, y * c - x * s, tip - beta, root**2 * (x - np.cos(tip))])


def at_rest(system, *names):
    """Outputs of a linkage at rest at its start."""
    q, none = system.assembly.q[None], np.zeros((1, system.tree.size))
    found = columns(system, np.zeros(1), q, none, none, np.zeros((1, 0, WIDTH)))
    return [found[name][0] for name in names]


def bent(system):
    """Displacements over the length, turn of the tip and strain energy over E I / L."""
    x, y, turn, energy = at_rest(system, "rod_tip.x", "rod_tip.y", "rod_tip.angle", "strain_energy")
    return np.array([x / LENGTH - 1, y / LENGTH, turn, energy / (UNIT * LENGTH)])


def test_the_elastica_is_that_of_the_tables():
    """Nine digits by shooting: under E I / L2 across, and under as much along as well."""
    np.testing.assert_allclose(elastica(1.0, 0.0)[:3], [-0.056433236, 0.301720774, 0.461351950], atol=1e-9)
    np.testing.assert_allclose(elastica(1.0, -1.0)[:3], [-0.120001518, 0.429216013, 0.684123922], atol=1e-9)


#: Tip force across and along, in units of E I / L2. A column buckles at pi^2/4; beyond it a small force says to which side.
FORCES = [(1.0, 0.0), (5.0, 0.0), (1.0, 5.0), (0.001, -2.6), (0.001, -4.0)]


@pytest.mark.parametrize(("across", "along"), FORCES)
def test_pieces_become_the_elastica(system_of, across, along):
    """Third-order convergence: a substructure's error is the square of its slope times its part of the rotation."""
    exact, error = elastica(across, along), []
    for count in (4, 8, 16):
        system = system_of(CANTILEVER, HELD.format(along * UNIT, across * UNIT, count))
        error.append(np.max(np.abs(bent(system) - exact)))
        x, y, moment, stress, place = at_rest(
            system, "rod_tip.x", "rod_tip.y", "rod.bending", "rod.stress", "rod.stress_place"
        )
        assert moment == pytest.approx(UNIT * abs(across * x - along * y), rel=1e-6)
        assert stress == pytest.approx(abs(along) * UNIT / 0.008**2 + moment * 6 / 0.008**3, rel=1e-6)
        assert place == pytest.approx(0.0, abs=1e-6)
    order = np.log2(np.array(error[:-1]) / error[1:])
    assert np.all((order > 2.6) & (order < 3.4))
    assert error[-1] < 1e-3 * np.abs(exact).max()


@pytest.mark.parametrize(("count", "bound"), [(1, 3e-4), (4, 1e-5)])
def test_the_largest_deflection_is_that_along_the_beam(system_of, count, bound):
    """A cantilever under P across has no frame where it bends most: P L3 / (9 sqrt(3) E I) from its chord, at L (1 - 1 / sqrt(3))."""
    system = system_of(CANTILEVER, HELD.format(0.0, 1e-3 * UNIT, count))
    largest, place = at_rest(system, "rod.deflection", "rod.deflection_place")
    assert largest == pytest.approx(1e-3 * LENGTH / (9 * np.sqrt(3)), rel=bound)
    assert place == pytest.approx(LENGTH * (1 - 1 / np.sqrt(3)), abs=LENGTH / (16 * count) ** 2)
    pieces = segmented(system.replaced({"links.rod.segments": 32}))
    largest, place = at_rest(pieces, "rod.deflection", "rod.deflection_place")
    assert largest == pytest.approx(1e-3 * LENGTH / (9 * np.sqrt(3)), rel=1e-2)
    assert place == pytest.approx(LENGTH * (1 - 1 / np.sqrt(3)), abs=LENGTH / 32)


#: A beam of twice the length, held in its middle by a joint that a drive keeps.
SEESAW = model(
    "seesaw",
    elastic_bar("rod", 2 * LENGTH, "__model__")
    + f"""<frame name="middle" attached_to="rod"><pose>{LENGTH} 0 0 0 0 0</pose></frame>
<frame name="pivot" attached_to="world"><pose relative_to="__model__">{LENGTH} 0 0 0 0 0</pose></frame>
{joint("O", "pivot", "middle")}""",
)


@pytest.mark.parametrize(("count", "half", "bound"), [(4, 2, 1e-9), (7, 16, 1e-3)])
def test_a_beam_held_in_its_middle_is_two_cantilevers(system_of, count, half, bound):
    """Pieces go both ways from the one that the joint carries, which holds it at its end (4) or within (7)."""
    toml = (
        HELD.format(0.0, UNIT, count)
        + f"""[forces.Q]
point = "rod"
force = [0.0, {UNIT}]
"""
    )
    system = system_of(SEESAW, toml)
    x, y, turn = bent(system_of(CANTILEVER, HELD.format(0.0, UNIT, half)))[:3]
    names = [f"{end}.{what}" for end in ("rod_tip", "rod") for what in ("x", "y", "angle")]
    expected = [LENGTH * (2 + x), LENGTH * y, turn, -LENGTH * x, LENGTH * y, -turn]
    np.testing.assert_allclose(at_rest(system, *names), expected, rtol=0, atol=bound)
    assert at_rest(system, "rod.stress_place")[0] == pytest.approx(LENGTH, abs=1e-6)
    run = simulate(system, "compiled")  # at rest it stays there
    np.testing.assert_allclose(run["rod_tip.y"], LENGTH * y, rtol=0, atol=bound)


@pytest.mark.slow
@pytest.mark.parametrize("name", SPUN)
def test_beams_that_are_spun_up_are_found_to_the_square_of_their_pieces_slopes(system_of, name):
    """Twice as many substructures reduce the error below a quarter; eight give 1e-4."""
    data, expected, _ = SPUN[name]
    error = []
    for count in (4, 8):
        toml = SPIN.format(keys=f"pieces = {count}")
        run = simulate(system_of(spun(*data), toml, {"solver.accuracy": 1e-8}), "compiled")
        error.append(np.abs(tip_of(run) / expected - 1.0))
    assert np.all(error[1] < error[0] / 4)
    assert np.all(error[1] < 1e-4)


SLIDER_CRANK = """duration = {}
[drives.O]
speed = 150.0
[links.rod]
model = "flexible"
pieces = {}
{}
[solver]
accuracy = {}
"""
SOFT = {"sdf.links.rod.beam.youngs_modulus": 2e10}  # Simeon's rod, ten times softer


@pytest.mark.slow
def test_a_soft_rod_moves_as_an_exact_beam(system_of):
    """Slopes reach 0.22: an undivided link has an error of 2 % of the largest deflection, eight parts 2e-4."""
    radius, rod, rate, damping = 0.15, 0.3, 150.0, 1.5e-4
    exact = AbsoluteBeam(rod, 1.28e6, 2e10 * 0.008**4 / 12, 0.50368, 8, damping)
    q, v = exact.straight(np.array([radius, 0.0])), np.zeros((9, 4))
    v[:, 1], v[:, 3] = radius * rate * np.linspace(1.0, 0.0, 9), -radius * rate / rod

    def path(t):  # the crank's pin, and the slider's height
        x, y = radius * np.cos(rate * t), radius * np.sin(rate * t)
        return np.array([[x, y, 0.0], [-rate * y, rate * x, 0.0], [-(rate**2) * x, -(rate**2) * y, 0.0]])

    times = np.linspace(0.0, 0.02, 9)
    moved = motion(exact, (q, v.ravel()), [0, 1, exact.size - 3], path, times, {exact.size - 4: 0.075552}, 1e-6)
    expected, slider = deflection(exact, moved), moved[:, -4]
    error, keys = [], f'start = "undeformed"\nstiffness_damping = {damping}'
    for count in (4, 8):
        found = simulate(
            system_of(elastic_slider_crank(), SLIDER_CRANK.format(0.02, count, keys, 1e-7), SOFT), "compiled"
        ).evaluate(times)
        error.append(np.abs(found["middle.deflection"] - expected).max() / np.abs(expected).max())
        np.testing.assert_allclose(found["slider.x"], slider, rtol=0, atol=2e-6)
    assert error[0] < 1e-3
    assert error[1] < 2e-4


@pytest.mark.slow
def test_energy_goes_where_it_is_accounted_for(system_of):
    """Work of the drive is kinetic and strain energy, and what film and material take: to 1e-6 of that work."""
    film = """[joints.B]
model = "lubricated"
clearance = 1e-4
viscosity = 0.1
"""
    system = system_of(elastic_slider_crank(), SLIDER_CRANK.format(0.02, 3, "damping = 0.01", 1e-9) + film, SOFT)
    times = np.linspace(0.0, 0.02, 8001)
    found = simulate(system, "compiled").evaluate(times)
    power = found["O.power"] + found["B.power"] - found["damping_power"]
    stored = found["kinetic_energy"] + found["potential_energy"]
    work = np.cumsum(power[1:-1:2] * 4 + power[:-2:2] + power[2::2]) * (times[2] - times[0]) / 6
    exchanged = trapezoid(np.abs(found["O.power"]), times)
    assert exchanged > 5.0
    assert found["strain_energy"].max() > 1.0
    np.testing.assert_allclose(stored[2::2] - stored[0], work, rtol=0, atol=1e-6 * exchanged)


@pytest.mark.parametrize("count", ["0", "-1", "1.5", "1000", '"two"'])
def test_other_numbers_of_pieces_are_refused_in_one_line(system_of, count):
    with pytest.raises(InputError, match=r"links\.rod\.pieces: ") as refused:
        system_of(CANTILEVER, HELD.format(0.0, 0.0, count))
    assert "\n" not in str(refused.value)


def test_each_piece_needs_the_modes_of_its_ends(system_of):
    with pytest.raises(
        InputError, match=r"links\.rod\.bending: is 1; its 2 joints, loads and ends of a substructure need 2"
    ):
        system_of(CANTILEVER, HELD.format(0.0, 0.0, 4) + "bending = 1\n")


def test_rigid_segments_stand_where_pieces_do(system_of):
    """Drake and the animation use rigid segments; their hinges follow the substructures' sections."""
    own, other = (segmented(system_of(CANTILEVER, HELD.format(0.0, UNIT, count))) for count in (1, 8))
    assert own.tree.coordinates == other.tree.coordinates
    tip = other.tree.index["rod/piece8"]
    pose = make_pose(other.tree.bodies)
    body_positions(other.tree.bodies, other.assembly.q, pose)
    assert pose[tip, 2] == pytest.approx(elastica(1.0, 0.0)[2], abs=1e-4)


def test_a_frame_with_a_line_is_an_interface_of_its_link(system_of):
    """What touches the line pushes the link there."""
    frame = '<frame name="wall" attached_to="rod"><pose>0.3 0 0 0 0 0</pose></frame>'
    ball = solid("ball", 1.0, pose="0.3 0.1 0 0 0 0") + joint("slide", "world", "ball", "prismatic", "0 1 0")
    toml = (
        HELD.format(0.0, UNIT, 1)
        + """[contacts.touch]
point = "ball"
line = "wall"
[contacts.touch.contact]
law = "hunt-crossley"
stiffness = 1e6
restitution = 0.5
"""
    )
    system = system_of(CANTILEVER.replace("</model>", frame + ball + "</model>"), toml)
    assert interfaces(system.mechanism, system.experiment, "rod") == pytest.approx((0.0, 0.3, LENGTH))
