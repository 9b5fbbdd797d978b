"""The Jacobian of the equations against differences of the equations, extrapolated (Ridders)."""

import numpy as np
import pytest
from linearised import left, right_hand_side, slope
from machines import RUBBING_CRANK, bar, elastic_slider_crank, four_bar, joint, model, slider_crank, solid
from reference_machines import WINDOWS, windows_sdf
from shipped import WORN, shipped
from shipped import run as shipped_run

from linkages import Status, simulate
from linkages.engines.compiled.run.linear import slopes
from linkages.engines.compiled.run.model import _FILM, _TOUCH

#: Error of every entry, in parts of its column: the mechanics are exact, the contacts' laws central differences, of
#: which Newton's method asks no more: an error of 1e-6 is what its correction is out by.
EXACT, LAWS = 1e-11, 1e-6


def ridders(function, x, h, shrink=1.6, rounds=9):
    """Derivative of a vector function, and the error of each entry: central differences, extrapolated to h = 0.

    C. J. F. Ridders, Accurate computation of F'(x) and F'(x) F''(x), Adv. Eng. Software 4 (1982) 75-76.
    """
    table, best, error = [], None, None
    for i in range(rounds):
        row = [(function(x + h) - function(x - h)) / (2.0 * h)]
        for j in range(i):
            factor = shrink ** (2 * (j + 1))
            row.append((factor * row[j] - table[-1][j]) / (factor - 1.0))
            estimate = np.maximum(np.abs(row[-1] - row[-2]), np.abs(row[-1] - table[-1][j]))
            if best is None:
                best, error = row[-1].copy(), estimate.copy()
            better = estimate < error
            best[better], error[better] = row[-1][better], estimate[better]
        table.append(row)
        h /= shrink
    return best, error


def check_residual(problem, t, y, mass):
    """The force residual is the mass times the error of the derivatives: it agrees with the accelerations."""
    right, n = np.zeros(len(y)), len(y) - len(mass)
    right_hand_side(problem, t, y, right)
    lack = np.random.default_rng(1).normal(size=len(y)) * (1.0 + np.abs(right))
    size = np.abs(mass) @ (np.abs(lack[n:]) + np.abs(right[n:]))
    assert np.all(
        np.abs(left(problem, t, y, right - lack) - mass @ lack[n:]) < 1e-11 * size
    )  # stiff modes and films lose some


def check(result, step, reach=0.02, accuracy=LAWS, linear=False):
    """Compare both at a step of a run; entries in parts of the largest of their column and kind of row.

    `reach` is the largest step of a difference in parts of the clearance (without: of the linkage's length); `linear`
    checks the Jacobian of linear models.
    """
    assert result.status is Status.OK
    replay = result.evaluate.function
    steps, runner, m = replay.steps, replay.runner, replay.runner.model
    t, y = steps.times[step], steps.states[step].copy()
    problem = runner.aside()
    problem.work.memory[:, 0] = steps.memory[step]
    n, ny = len(m.free), len(y)
    (found, mass), dy = slope(problem, t, y), np.zeros(ny)
    check_residual(problem, t, y, mass)
    if linear:
        found = slopes(runner, t, y).jacobian

    def at(k):
        def function(value):
            moved = y.copy()
            moved[k] = value
            right_hand_side(problem, t, moved, dy)
            return dy.copy()

        return function

    play = min(m.laws["clearance"], default=np.inf)
    models = runner.system.models
    lengths = [(_TOUCH if model.can_touch else _FILM) * model.clearance for model in models]
    length = min(m.size, *lengths) if lengths else m.size  # see error_scale
    steps = reach * min(play, m.size) / length * runner.scale
    steps[2 * n :] = 1e-3 * np.abs(y[2 * n :])
    worst = 0.0
    for k in range(ny):
        expected, error = ridders(at(k), y[k], steps[k])
        for rows in (slice(0, n), slice(n, 2 * n), slice(2 * n, ny)):
            scale = np.abs(expected[rows]).max(initial=0.0)
            if scale > 0.0:
                assert np.all(error[rows] < accuracy * scale), "the differences have no digits"
                worst = max(worst, np.abs(found[rows, k] - expected[rows]).max() / scale)
    assert worst < accuracy


@pytest.mark.parametrize("film", ["pinkus-sternlicht", "long", "short", "finite"])
def test_films(film):
    changes = {"duration": 0.35} | {f"joints.{name}.film": film for name in "AB"}
    changes |= {f"joints.{name}.shear_torque": True for name in "AB"}
    result = shipped_run("compiled", "seven_bar", **changes)
    for step in (len(result.time) // 2, len(result.time) - 1):
        check(result, step, 1e-3 if film == "finite" else 0.02)  # within a cell of the finite film's map


@pytest.mark.parametrize("film", ["pinkus-sternlicht", "finite"])
def test_linear_models_have_more_digits_of_films_than_steps(film):
    result = shipped_run("compiled", "seven_bar", duration=0.35, **{f"joints.{name}.film": film for name in "AB"})
    check(result, len(result.time) - 1, 1e-3, accuracy=1e-7, linear=True)


LOADED = """duration = 0.3
gravity = [0.0, -9.81, 0.0]
[drives.O]
torque = 0.5
speed = 4.0
[joints.A]
model = "ideal"
[joints.B]
model = "ideal"
[forces.P]
point = "coupler_tip"
force = [3.0, -2.0]
axes = "body"
[forces.R]
point = "follower"
times = [0.0, 0.2, 0.5]
forces = [[0.0, 1.0], [3.0, 1.0], [4.0, 0.0]]
[torques.load]
link = "follower"
torque = -0.1
[springs.S]
point = "coupler_tip"
to = "crank"
stiffness = 50.0
free_length = 0.1
damping = 2.0
[torsion_springs.T]
joint = "A"
stiffness = 0.3
free_angle = 0.2
damping = 0.01
"""


def test_ideal_loops_with_gravity_springs_and_turned_forces(system_of):
    result = simulate(system_of(four_bar(), LOADED), "compiled")
    for step in (len(result.time) // 3, len(result.time) - 1):
        check(result, step, accuracy=EXACT)


def test_many_loops(system_of):
    """More closure rows than are pivoted by size; many derivatives are zero, so that all count by the largest."""
    result = simulate(system_of(windows_sdf(6), f"duration = 0.2\n{WINDOWS}"), "compiled")
    replay = result.evaluate.function
    t, y, problem = replay.steps.times[-1], replay.steps.states[-1].copy(), replay.runner.aside()
    (found, _), h, sides = slope(problem, t, y), 1e-4, np.zeros((2, len(y)))
    expected = np.empty_like(found)
    for k in range(len(y)):
        for side, sign in zip(sides, (1.0, -1.0), strict=True):
            moved = y.copy()
            moved[k] += sign * h
            right_hand_side(problem, t, moved, side)
        expected[:, k] = (sides[0] - sides[1]) / (2.0 * h)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())  # differences err by h^2


def test_open_chain_with_a_slide_on_a_moving_body(system_of):
    """A block on a slide along a swinging bar, and a bar that hangs from the block."""
    block = solid("block", 0.5, 1e-3, "0 0 0 0 0 0.3", "arm_tip", "0.02 0.01 0 0 0 0")
    body = bar("arm", 0.4, "__model__", 0.3) + block + bar("hung", 0.2, "block", -1.0)
    body += joint("O", "world", "arm") + joint("slide", "arm_tip", "block", "prismatic", "1 0.5 0")
    body += joint("H", "block", "hung")
    text = """duration = 0.4
gravity = [0.0, -9.81, 0.0]
[springs.S]
point = "block"
to = "arm"
stiffness = 40.0
free_length = 0.3
[torsion_springs.T]
joint = "slide"
stiffness = 30.0
free_angle = 0.2
damping = 0.7
[torsion_springs.U]
links = ["arm", "hung"]
stiffness = 0.3
free_angle = 0.1
damping = 0.02
"""
    result = simulate(system_of(model("slide", body), text), "compiled")
    check(result, len(result.time) - 1, accuracy=EXACT)


def test_a_small_machine_whose_rows_differ_by_orders_of_magnitude(system_of):
    """The guide is cut: its angle answers to a unit reaction 1e6 times as much as its place does, nowhere singular."""
    text = "duration = 0.02\ngravity = [0.0, -9.81, 0.0]\n[drives.O]\ntorque = 1e-5\nspeed = 30.0\n"
    result = simulate(system_of(slider_crank(crank=5e-4, rod=1.2e-3), text), "compiled")
    check(result, len(result.time) // 2, accuracy=1e-9)


def test_gears_of_a_slide_on_a_moving_body_and_in_a_loop(system_of):
    """A block's way along the crank goes with the follower's angle; another gear joins it to a wheel on the block."""
    block = solid("block", 0.5, 1e-3, "0 0 0 0 0 0.3", "crank_tip", "0.02 0.01 0 0 0 0")
    extra = block + joint("slide", "crank_tip", "block", "prismatic", "1 0.5 0")
    extra += bar("wheel", 0.1, "block", 1.0) + joint("W", "block", "wheel", axis="0 0 -1")
    text = """duration = 0.3
gravity = [0.0, -9.81, 0.0]
[drives.O]
torque = 0.5
speed = 4.0
[gears.screw]
joints = ["Q", "slide"]
ratio = 0.05
mimic = true
[gears.mesh]
joints = ["slide", "W"]
ratio = 30.0
"""
    result = simulate(system_of(four_bar(extra=extra), text), "compiled")
    assert np.ptp(result["q.W"]) > 0.1
    for step in (len(result.time) // 3, len(result.time) - 1):
        check(result, step, accuracy=2e-10)  # rounding: of the rows' responses one is 500 times the other


def test_loads_that_depend_on_positions_and_speeds(system_of):
    """Of points and joints, one of which slides along a turning bar; the loads act on a loop and on a chain."""
    block = solid("block", 0.5, 1e-3, "0 0 0 0 0 0.3", "crank_tip")
    sdf = four_bar(extra=block + joint("slide", "crank_tip", "block", "prismatic", "1 0.5 0"))
    text = """duration = 0.3
[drives.O]
torque = 0.5
speed = 4.0
[forces.drag]
point = "coupler_tip"
formula = ["-2*coupler_tip.vx*hypot(coupler_tip.vx, coupler_tip.vy)", "20*slide.coordinate*t"]
[forces.jet]
point = "follower_tip"
axes = "body"
formula = ["1.5*follower_tip.y*slide.rate", "block.x*O.rate"]
[frictions.slip]
joint = "slide"
constant = 0.5
speed = 2.0
[frictions.pin]
joint = "B"
constant = 0.05
viscous = 0.01
speed = 5.0
[torques.motor]
joint = "Q"
over = "slide.rate"
at = [-30.0, 0.0, 30.0]
torques = [2.0, 0.0, -1.0]
[torques.fan]
link = "follower"
formula = "-0.002*follower.omega**2"
"""
    result = simulate(system_of(sdf, text), "compiled")
    assert np.abs(result["q.slide"]).max() > 1e-3
    assert result["follower.omega"].min() < 0.0  # a power of a negative number
    for step in (len(result.time) // 3, len(result.time) - 1):
        check(result, step, accuracy=EXACT)


def test_friction_from_the_forces_in_all_joints_of_a_loop(system_of):
    """In joints of the tree and in the cut one, with Stribeck's law and the moment of the guide."""
    result = simulate(system_of(slider_crank(), RUBBING_CRANK), "compiled")
    for step in (len(result.time) // 3, len(result.time) - 1):
        check(result, step, accuracy=1e-9)  # rounding: changes of joint forces are small differences of two solutions


def deepest(result, names):
    """Step of the deepest penetration while the contact closes: no clipped ratio, no kink near."""
    depth = np.max([np.where(result[f"{n}.closing"] > 0, result[f"{n}.penetration"], -1.0) for n in names], axis=0)
    step = int(np.argmax(depth))
    assert depth[step] > 0.0
    return step


def test_dry_contact_of_a_journal():
    result = shipped_run("compiled", "slider_crank_dry", duration=4e-4)
    check(result, deepest(result, ["B"]), reach=5e-3)


def test_dry_contact_of_a_worn_journal_in_a_worn_bearing():
    """The profiles turn with their parts: the force depends on the angles too."""
    result = simulate(shipped("slider_crank_wear", duration=6e-4, **WORN), "compiled")
    check(result, deepest(result, ["B"]), reach=5e-3)


def test_corners_of_a_guide_in_contact():
    result = shipped_run("compiled", "slider_crank_guide", duration=1.1e-3)
    check(result, deepest(result, [f"guide.corner{i}" for i in (1, 2, 3, 4)]), reach=2e-3)


@pytest.mark.parametrize(
    "law", ["law = 'flores'\nrestitution = 0.6", "law = 'kelvin-voigt'\nrestitution = 0.6\ndamping = 0.5"]
)
def test_a_stop_of_a_turning_joint_between_two_links_in_contact(system_of, law):
    """Jacobian of a driven loop at the joint between crank and coupler."""
    text = "duration = 0.05\n[drives.O]\ntorque = 3.0\nspeed = 10.0\n"
    text += f"[stops.end]\njoint='A'\nside='lower'\nlimit=-0.15\n[stops.end.contact]\n{law}\nstiffness = 400.0\n"
    result = simulate(system_of(four_bar(), text), "compiled")
    on_the_way = deepest(result, ["end"]) - 5  # at rest the velocities of two links have little effect
    check(result, on_the_way, reach=1e-2)


def test_a_point_at_a_line_on_another_link_in_contact(system_of):
    """Two bars that hang from a cart: one has the wall, the tip of the other meets it, with friction."""
    wall = '<frame name="wall" attached_to="board"><pose>0.2 0.05 0 0 0 0.1</pose></frame>'
    body = solid("cart", 3.0) + wall + bar("rod", 0.3, "cart", -1.2) + bar("board", 0.4, "cart", -1.7)
    body += (
        joint("slide", "world", "cart", "prismatic", "1 0 0") + joint("O", "cart", "rod") + joint("P", "cart", "board")
    )
    text = """duration = 0.06
[drives.O]
torque = 0.0
speed = -8.0
[contacts.tip]
point = "rod_tip"
line = "wall"
[contacts.tip.contact]
law = "flores"
restitution = 0.6
stiffness = 1e5
[contacts.tip.friction]
law = "coulomb"
coefficient = 0.2
v_0 = 1e-2
v_1 = 1.0
"""
    result = simulate(system_of(model("cart", body), text), "compiled")
    check(result, deepest(result, ["tip"]), reach=2e-3)


def test_mixed_joints_in_contact():
    result = shipped_run("compiled", "seven_bar_mixed", duration=0.09)
    assert result["A.penetration"][-1] > 0.0
    check(result, len(result.time) - 1, reach=1e-4)


LUGRE = """duration = 0.02
gravity = [0.0, -9.81, 0.0]
[drives.O]
speed = 10.0
[joints.B]
model = "dry"
clearance = 1e-4
[joints.B.contact]
law = "flores"
restitution = 0.3
youngs_modulus = 2e9
[joints.B.friction]
law = "lugre"
coefficient = 0.1
bristle_stiffness = 1e4
"""


def test_bristles(system_of):
    result = simulate(system_of(slider_crank(), LUGRE), "compiled")
    step = deepest(result, ["B"])
    assert result.evaluate.function.steps.states[step, -1] != 0.0
    check(result, step, reach=2e-3)


@pytest.mark.parametrize("film", [False, True], ids=["ideal", "film"])
def test_links_that_bend(system_of, film):
    """With stiff modes the differences have fewer correct digits than with rigid links."""
    toml = """duration = 0.02
[drives.O]
speed = 150.0
[links.rod]
model = "flexible"
bending = 4
axial = 1
"""
    joint = """[joints.B]
model = "lubricated"
film = "long"
clearance = 1e-4
viscosity = 0.1
shear_torque = true
"""
    result = simulate(system_of(elastic_slider_crank(), toml + joint * film), "compiled")
    for step in (3, len(result.time) - 1):
        check(result, step, 0.02 if film else 1e-3, LAWS if film else 1e3 * EXACT)
