"""Applied loads: wrenches against virtual work, their derivatives by dual numbers against differences, ideal linkages, refusals."""

from typing import NamedTuple

import numpy as np
import pytest
from machines import bar, circle_intersection, four_bar, joint, model
from scipy.interpolate import PPoly

from linkages import InputError, ideal, load
from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import packed, reference
from linkages.base.kernel.dual import DualArray, dual_array
from linkages.cli.main import main
from linkages.elements.machine import NO_ELEMENTS, add_elements, apart, count, markers_of, tell_elements
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.loads import LOAD_OUTPUTS, load_outputs, load_wrenches
from linkages.mechanics.planar.motion import Motions, constant_rate, function_jet, monotone_table
from linkages.mechanics.planar.newton_euler import generalised_force
from linkages.mechanics.planar.record_types import LOAD

RNG = np.random.default_rng(7)
NO_STATES = np.zeros(0)

PLAY = '[joints.A]\nmodel = "lubricated"\nclearance = 1e-4\nviscosity = 0.1\n'
LOADS = """
[forces.gust]
point = "coupler_tip"
times = [0.0, 0.3, 0.8, 1.5]
forces = [[0.0, 1.0], [2.0, -1.0], [2.5, 4.0], [-1.0, 0.5]]
[forces.thrust]
point = "follower_tip"
axes = "body"
force = [3.0, -2.0]
[torques.brake]
link = "follower"
times = [0.0, 2.0]
torques = [0.4, -0.6]
[torques.steady]
link = "coupler"
torque = 0.7
[springs.inner]
point = "coupler_tip"
to = "crank"
stiffness = 40.0
free_length = 0.15
damping = 3.0
[springs.outer]
point = "coupler"
anchor = [0.1, 0.4]
stiffness = 25.0
free_length = 0.1
damping = 2.0
[torsion_springs.hinge]
joint = "Q"
stiffness = 1.5
free_angle = 0.4
damping = 0.2
[torsion_springs.cross]
links = ["crank", "coupler"]
stiffness = 0.9
free_angle = -0.3
damping = 0.1
"""

#: Weights of eighth-order central differences at 1, 2, 3 and 4 steps.
WEIGHTS = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}


def slope(f, h):
    """Derivative at zero."""
    return sum(w * (f(k * h) - f(-k * h)) for k, w in WEIGHTS.items()) / h


def loaded(system_of, plane="xy", q_axis="0 0 1"):
    sdf = four_bar(plane=plane)
    assert joint("Q", "world", "follower") in sdf
    sdf = sdf.replace(joint("Q", "world", "follower"), joint("Q", "world", "follower", axis=q_axis))
    system = system_of(sdf, "duration = 1.0\n[drives.O]\nspeed=5.0\n" + PLAY + LOADS)
    return system.experiment, system.tree, (system.loads, system.elements)


def add_wrenches(applied, t, pose, vel, wrench):
    """Add the wrenches of loads and elements."""
    loads, elements = applied
    load_wrenches(loads, t, NO_STATES, pose, vel, wrench)
    add_elements(elements, loads[1:], t, NO_STATES, pose, vel, wrench)


def states(tree, q, v):
    pose, vel = np.empty((len(tree.bodies.records), 5)), np.empty((len(tree.bodies.records), 3))
    body_states(tree.bodies, q, v, pose, vel)
    return pose, vel


def place(tree, pose, name):
    """Position of a named point from the body's pose, and angle of its frame."""
    body, x, y = tree.named_marker(name)
    c, s = np.cos(pose[body, 2]), np.sin(pose[body, 2])
    angle = pose[body, 2] + tree.mechanism.point[name].angle
    return pose[body, :2] + [c * x - s * y, s * x + c * y], angle


@pytest.mark.parametrize(("plane", "axis", "sign"), [("xy", "0 0 1", 1.0), ("xz", "0 0 -1", -1.0)])
def test_wrenches_do_the_virtual_work_of_the_written_laws(system_of, plane, axis, sign):
    """J^T w against work written down from lengths, angles and positions, whose variations are differences."""
    experiment, tree, applied = loaded(system_of, plane, axis)
    assert tree.mechanism.joint["Q"].sign == sign
    t = 0.55
    gust = experiment.forces["gust"]
    force = [PPoly(*monotone_table(gust.times, part))(t) for part in zip(*gust.forces, strict=True)]
    brake = 0.4 - 1.0 * t / 2.0
    for _ in range(5):
        q, v, w = RNG.normal(size=(3, tree.size))

        def quantities(q):
            pose, _ = states(tree, q, 0 * q)
            tip, follower = place(tree, pose, "coupler_tip")[0], place(tree, pose, "follower")[1]
            coupler, coupler_angle = place(tree, pose, "coupler")
            crank, crank_angle = place(tree, pose, "crank")
            thrust, axis = place(tree, pose, "follower_tip")
            lengths = [np.linalg.norm(tip - crank), np.linalg.norm(coupler - [0.1, 0.4])]
            drawn = [tree.mechanism.point[name].angle for name in ("follower", "coupler", "crank")]
            angles = [sign * (follower - drawn[0]), (coupler_angle - drawn[1]) - (crank_angle - drawn[2])]
            return np.array([*tip, *thrust, axis, follower, coupler_angle, *lengths, *angles])

        here = quantities(q)
        moved = slope(lambda s, q=q, w=w, at=quantities: at(q + s * w), 1e-2)
        rate = slope(lambda s, q=q, v=v, at=quantities: at(q + s * v), 1e-2)
        c, s = np.cos(here[4]), np.sin(here[4])
        resist = np.array([40.0, 25.0, 1.5, 0.9]) * (here[7:] - [0.15, 0.1, 0.4, -0.3])
        resist += np.array([3.0, 2.0, 0.2, 0.1]) * rate[7:]
        push = [*force, 3 * c + 2 * s, 3 * s - 2 * c]
        expected = push @ moved[:4] + brake * moved[5] + 0.7 * moved[6] - resist @ moved[7:]
        pose, vel = states(tree, q, v)
        wrench, tau = np.zeros_like(vel), np.zeros(tree.size)
        add_wrenches(applied, t, pose, vel, wrench)
        assert np.sum(wrench * states(tree, q, w)[1]) == pytest.approx(expected, rel=1e-9)
        loads, elements = applied
        outputs = np.empty((len(loads[0]) + count(elements), len(LOAD_OUTPUTS)))
        load_outputs(loads, np.zeros(len(loads[0])), t, NO_STATES, pose, vel, outputs)
        tell_elements(elements, loads[1:], t, NO_STATES, len(loads[0]), pose, vel, outputs)
        assert outputs[:, 2].sum() == pytest.approx(np.sum(wrench * vel), rel=1e-12)
        np.testing.assert_allclose(outputs[:4, 0], resist, rtol=1e-9)
        np.testing.assert_allclose(outputs[:4, 1], here[7:], rtol=1e-12)
        generalised_force(tree.bodies, pose, wrench, tau)
        assert tau @ w == pytest.approx(expected, rel=1e-9)


def direction(applied, t, pose, vel):
    """Random changes of poses and velocities, of each body by itself, and the wrenches so many times them away."""
    dpose, dvel = 0.1 * RNG.normal(size=vel.shape), RNG.normal(size=vel.shape)
    dpose[0], dvel[0] = 0.0, 0.0

    def wrench(s):
        result, moved = np.zeros_like(vel), pose.copy()
        moved[:, :2] += s * dpose[:, 1:]
        moved[:, 2] += s * dpose[:, 0]
        moved[:, 3:] = np.column_stack([np.cos(moved[:, 2]), np.sin(moved[:, 2])])
        add_wrenches(applied, t, moved, vel + s * dvel, result)
        return result

    return dpose, dvel, wrench


class Dual(NamedTuple):
    """Poses, velocities and wrenches along one direction."""

    pose: DualArray
    vel: DualArray
    wrench: DualArray


@kernel(makes_arrays=True)
def _wrenches_along(loads, elements, t, given):
    pose, vel, wrench = reference(given).pose, reference(given).vel, reference(given).wrench
    load_wrenches(loads, t, np.zeros(0), pose, vel, wrench)
    add_elements(elements, loads[1:], t, np.zeros(0), pose, vel, wrench)


def wrenches_along(applied, t, pose, vel, dpose, dvel):
    """Derivative of the wrenches along changes of poses and velocities, by dual numbers."""
    given = Dual(dual_array(*pose.shape), dual_array(*vel.shape), dual_array(*vel.shape))
    given.pose[..., 0], given.vel[..., 0], given.vel[..., 1] = pose, vel, dvel
    given.pose[:, :2, 1], given.pose[:, 2, 1] = dpose[:, 1:], dpose[:, 0]
    given.pose[:, 3, 1], given.pose[:, 4, 1] = -pose[:, 4] * dpose[:, 0], pose[:, 3] * dpose[:, 0]
    _wrenches_along(*applied, t, packed(given))
    return np.array(given.wrench[..., 1])


def test_dual_numbers_give_the_derivative_of_the_wrenches(system_of):
    """Along directions in which every body turns and moves by itself."""
    _, tree, applied = loaded(system_of)
    for _ in range(10):
        pose, vel = states(tree, *RNG.normal(size=(2, tree.size)))
        dpose, dvel, wrench = direction(applied, 0.4, pose, vel)
        found = wrenches_along(applied, 0.4, pose, vel, dpose, dvel)
        np.testing.assert_allclose(found, slope(wrench, 1e-2), rtol=1e-8, atol=1e-9)


def test_springs_between_links_exert_no_net_force_and_no_net_moment(system_of):
    _, tree, ((_, *functions), elements) = loaded(system_of)
    springs = [one for one in apart(elements) if len(one.springs) or len(one.torsion_springs)]
    inner = [one for one in springs if all(marker["body"] > 0 for marker in markers_of(one))]
    assert len(inner) == 2
    pose, vel = states(tree, *RNG.normal(size=(2, tree.size)))
    wrench = np.zeros_like(vel)
    for one in inner:
        add_elements(one, tuple(functions), 0.0, NO_STATES, pose, vel, wrench)
    size = np.abs(wrench).max()
    assert size > 1e-2
    assert np.abs(wrench[:, 1:].sum(axis=0)).max() < 1e-14 * size
    assert abs(np.sum(wrench[:, 0] + pose[:, 0] * wrench[:, 2] - pose[:, 1] * wrench[:, 1])) < 1e-14 * size


@pytest.mark.parametrize("free", [0.0, 0.02])
def test_at_zero_length_the_force_is_the_mean_of_both_sides(system_of, free):
    """Passing through on a straight line; without a free length force and derivative are continuous there."""
    _, tree, ((_, *functions), elements) = loaded(system_of)
    spring = elements.springs[1:]
    assert spring["b"]["body"][0] == 0
    spring["free"], spring["a"]["x"], spring["a"]["y"] = free, 0.0, 0.0
    elements, loads = NO_ELEMENTS._replace(springs=spring), (np.zeros(0, LOAD), *functions)
    body = spring["a"]["body"][0]
    pose, vel = np.zeros((len(tree.bodies.records), 5)), np.zeros((len(tree.bodies.records), 3))
    pose[:, 3] = 1.0
    at = np.array([0.1, 0.4])
    vel[body, 1:] = [0.3, -0.4]

    def wrench(step):
        pose[body, :2] = at + step * vel[body, 1:]
        result = np.zeros_like(vel)
        add_elements(elements, tuple(functions), 0.0, NO_STATES, pose, vel, result)
        return result[body, 1:]

    before, there, after = wrench(-1e-9), wrench(0.0), wrench(1e-9)
    np.testing.assert_allclose(there, 0.5 * (before + after), atol=1e-12)
    np.testing.assert_allclose(there, -2.0 * vel[body, 1:], atol=1e-15)  # its damping
    assert np.linalg.norm(after - before) == pytest.approx(2 * 25.0 * free, abs=1e-6)
    pose[body, :2] = at
    direction = np.zeros_like(vel)
    direction[body, 1:] = [0.6, -0.8]
    found = wrenches_along((loads, elements), 0.0, pose, vel, direction, np.zeros_like(vel))
    np.testing.assert_allclose(found[body, 1:], [-25.0 * 0.6, 25.0 * 0.8], atol=1e-12)


def test_tables_of_loads_stay_within_their_values_and_are_found_by_bisection():
    times = np.sort(RNG.uniform(0.0, 2.0, 40))
    values = np.where(np.arange(40) % 7 < 3, 5.0, 0.0)  # a press: load, no load
    pieces = [constant_rate(1.5, 0.0), monotone_table(times, values)]
    motions = Motions(pieces)
    at = np.concatenate([times, RNG.uniform(times[0], times[-1], 500), [-1.0, 3.0]])
    for i, piece in enumerate(pieces):
        found = [function_jet(motions.arrays, i, np.array([[t, 1.0, 0.0]]))[0] for t in at]
        np.testing.assert_allclose(found, PPoly(*piece)(at), atol=1e-12)
    inside = PPoly(*pieces[1])(at[:-2])
    assert inside.min() >= 0.0
    assert inside.max() <= 5.0 + 1e-12
    np.testing.assert_allclose(inside[:40], values, atol=1e-12)


def test_a_slow_linkage_balances_its_loads_by_virtual_work(system_of):
    """Drive torque from free bodies against power: torque of the drive times its speed plus power of the loads is zero."""
    speed = 1e-4  # inertia forces are of the order 1e-9
    toml = f"""duration = 6e4
[drives.O]
speed = {speed}
[forces.P]
point = "follower_tip"
force = [2.0, -5.0]
[springs.S]
point = "coupler_tip"
anchor = [-0.1, 0.1]
stiffness = 30.0
free_length = 0.05
"""
    columns = ideal(system_of(four_bar(), toml)).evaluate(np.linspace(10.0, 5.9e4, 60))

    def tip(t):
        crank = 0.1 * np.array([np.cos(speed * t), np.sin(speed * t)])
        return np.array([circle_intersection(p, 0.25, (0.3, 0.0), 0.2) for p in crank.T])

    t = columns["time"]
    velocity = np.tensordot([-0.5, 0.5], [tip(t - 1.0), tip(t + 1.0)], 1)  # second order: 1e-8 of the speed
    to_anchor = tip(t) - [-0.1, 0.1]
    length = np.linalg.norm(to_anchor, axis=1)
    force = np.array([2.0, -5.0]) - (30.0 * (length - 0.05) / length)[:, None] * to_anchor
    torque = -np.sum(force * velocity, axis=1) / speed
    np.testing.assert_allclose(columns["O.torque"], torque, atol=1e-7 * np.abs(torque).max())
    np.testing.assert_allclose(columns["S.length"], length, rtol=1e-12)
    np.testing.assert_allclose(columns["S.force"], 30.0 * (length - 0.05), rtol=1e-12)
    np.testing.assert_allclose(columns["potential_energy"], 15.0 * (length - 0.05) ** 2, rtol=1e-12)
    power = columns["P.power"] + columns["S.power"]
    np.testing.assert_allclose(columns["O.torque"] * speed, -power, atol=1e-7 * np.abs(power).max() + 1e-12)


def test_a_thrust_turns_with_its_body(system_of):
    """A crank at constant speed: the drive holds against the thrust's constant moment, the pin against the thrust."""
    sdf = model("crank", bar("crank", 0.1, "__model__") + joint("O", "world", "crank"))
    toml = 'duration = 1.0\n[drives.O]\nspeed = 4.0\n[forces.T]\npoint="crank_tip"\naxes="body"\nforce=[1.0, 3.0]\n'
    times = np.linspace(0.0, 1.0, 11)
    columns = ideal(system_of(sdf, toml)).evaluate(times)
    c, s = np.cos(4.0 * times), np.sin(4.0 * times)
    np.testing.assert_allclose(columns["O.torque"], -0.3, rtol=1e-12)
    np.testing.assert_allclose(columns["T.fx"], c - 3 * s, atol=1e-13)
    inertia = -0.2 * 0.05 * 16.0  # mass times centripetal acceleration, along the crank
    np.testing.assert_allclose(columns["O.fx"], (inertia - 1.0) * c + 3 * s, atol=1e-12)
    np.testing.assert_allclose(columns["O.fy"], (inertia - 1.0) * s - 3 * c, atol=1e-12)
    np.testing.assert_allclose(columns["T.power"], 0.3 * 4.0, rtol=1e-12)


GOOD = "duration = 1.0\n[drives.O]\nspeed = 5.0\n"
FORCE = '[forces.P]\npoint = "follower_tip"\nforce = [1.0, 0.0]\n'
SPRING = '[springs.S]\npoint = "follower_tip"\nto = "pivot"\nstiffness = 5.0\nfree_length = 0.1\n'
TORSION = '[torsion_springs.T]\njoint = "Q"\nstiffness = 5.0\nfree_angle = 0.1\n'

#: case -> (text, expected part of the message)
REFUSED = {
    "unknown point": (FORCE.replace("follower_tip", "folower_tip"), 'did you mean "follower_tip"?'),
    "point of the world": (FORCE.replace("follower_tip", "pivot"), '"pivot" is fixed to the world'),
    "the world": (FORCE.replace("follower_tip", "world"), "name a frame, or give a spring an anchor"),
    "three components": (FORCE.replace("0.0]", "0.0, 0.0]"), "forces.P.force"),
    "no force": (FORCE.replace("force =", "# force ="), "give either force, or times with forces, or over"),
    "two kinds of force": (
        FORCE + "times=[0.0, 1.0]\nforces=[[0.0, 0.0], [1.0, 1.0]]\n",
        "give either force, or times with forces, or over",
    ),
    "no times": (FORCE.replace("force = [1.0, 0.0]", "forces = [[1.0, 0.0], [1.0, 0.0]]"), "times go with"),
    "a table of one": (
        FORCE.replace("force = [1.0, 0.0]", "times = [0.0]\nforces = [[1.0, 0.0]]"),
        "two or more of each",
    ),
    "table too short": (
        FORCE.replace("force = [1.0, 0.0]", "times = [0.0, 0.9]\nforces = [[1.0, 0.0], [1.0, 0.0]]"),
        "forces.P.times: end at 0.9 s, before the duration of 1 s",
    ),
    "table starts late": (
        FORCE.replace("force = [1.0, 0.0]", "times = [0.1, 2.0]\nforces = [[1.0, 0.0], [1.0, 0.0]]"),
        "times must start at 0 or before",
    ),
    "unknown axes": (FORCE + 'axes = "link"\n', "'plane' or 'body'"),
    "unknown key": (FORCE + 'frame = "body"\n', "forces.P.frame: unknown key"),
    "unknown link": ('[torques.M]\nlink = "crnk"\ntorque = 1.0\n', 'did you mean "crank"?'),
    "torque over decreasing times": (
        '[torques.M]\nlink = "crank"\ntimes = [0.0, 2.0, 1.0]\ntorques = [0.0, 1.0, 2.0]\n',
        "times must increase",
    ),
    "negative stiffness": (SPRING.replace("= 5.0", "= -5.0"), "springs.S.stiffness: is -5.0"),
    "negative free length": (SPRING.replace("= 0.1", "= -0.1"), "springs.S.free_length: is -0.1"),
    "no free length": (SPRING.replace("free_length", "# "), "springs.S.free_length: is missing"),
    "no other end": (SPRING.replace("to =", "# to ="), "either to, a link or frame, or anchor"),
    "two other ends": (SPRING + "anchor = [0.0, 0.0]\n", "either to, a link or frame, or anchor"),
    "unknown other end": (SPRING.replace("pivot", "pivott"), 'springs.S.to: "pivott" is not in machine.sdf'),
    "spring within a link": (SPRING.replace("pivot", "follower"), 'the same link, "follower"'),
    "coincident points": (SPRING.replace("follower_tip", "follower"), "springs.S: its points coincide at t = 0"),
    "torsion of nothing": (TORSION.replace("joint =", "# joint ="), "give either joint or links"),
    "torsion of an unknown joint": (TORSION.replace('"Q"', '"P"'), 'torsion_springs.T.joint: "P"'),
    "torsion of one link": (TORSION.replace('joint = "Q"', 'links = ["crank", "crank"]'), "are the same link"),
    "torsion of an unknown link": (
        TORSION.replace('joint = "Q"', 'links = ["world", "cranc"]'),
        'did you mean "crank"?',
    ),
    "name of a joint": (FORCE.replace("forces.P", "forces.Q"), "also the name of a link, frame, joint or load"),
    "name of another load": (FORCE + SPRING.replace("springs.S", "springs.P"), "springs.P: is also the name of"),
    "name with a dot": (FORCE.replace("forces.P", 'forces."a.b"'), "has a dot in its name"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_loads_are_refused_in_one_line(experiment_file, tmp_path, capsys, case):
    text, reason = REFUSED[case]
    out = tmp_path / "out"
    assert main(["simulate", str(experiment_file(four_bar(), GOOD + text)), "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert reason in error
    assert not out.exists()


@pytest.mark.parametrize(
    ("kind", "values", "problem"),
    [
        ("prismatic", "stiffness = '2 kN/m'\nfree_angle = '100 mm'\ndamping = '3 N s/m'", ""),
        ("prismatic", "stiffness = '2 kN/m'\nfree_angle = '5 deg'", "torsion_springs.T.free_angle: is \"5 deg\"; it must be measured in m"),
        ("revolute", "stiffness = '2 kN m/rad'\nfree_angle = '100 mm'", 'torsion_springs.T.free_angle: is "100 mm"; it must be measured in rad'),
        ("fixed", "stiffness = 2.0\nfree_angle = 0.1", 'torsion_springs.T.joint: "O" is a fixed joint and cannot move'),
    ],
)  # fmt: skip
def test_units_of_a_spring_in_a_joint_are_of_its_coordinate(experiment_file, kind, values, problem):
    body = bar("block", 0.1, "__model__") + bar("other", 0.1, "__model__") + joint("P", "world", "other")
    sdf = model("slide", body + joint("O", "world", "block", kind, "1 0 0" if kind == "prismatic" else "0 0 1"))
    path = experiment_file(sdf, f'duration = 1.0\n[torsion_springs.T]\njoint = "O"\n{values}\n')
    if problem:
        with pytest.raises(InputError, match=problem):
            load(path)
        return
    spring = load(path).experiment.torsion_springs["T"]
    assert (spring.stiffness, spring.free_angle, spring.damping) == (2000.0, 0.1, 3.0)


def test_a_frame_fixed_to_the_world_is_an_anchor(system_of):
    text = GOOD + SPRING
    texts = text, text.replace('to = "pivot"', "anchor = [0.3, 0.0]")
    frame, anchor = (system_of(four_bar(), toml).elements.springs for toml in texts)
    assert frame["b"]["x"] == pytest.approx(anchor["b"]["x"], abs=1e-15)  # frames lie on the machine's grid
    frame["b"]["x"] = anchor["b"]["x"]
    assert frame == anchor


def test_loads_are_replaced_by_path_and_kept_in_the_ideal_linkage(system_of):
    changes = {"springs.S.stiffness": "7.5", "forces.P.force": "[0.0, 2.0]"}
    experiment = system_of(four_bar(), GOOD + FORCE + SPRING, changes).experiment
    assert experiment.ideal().springs["S"].stiffness == 7.5
    assert experiment.replaced({"forces.P.axes": "body"}).forces["P"].force == [0.0, 2.0]
    assert experiment.sources["springs.S.stiffness"] == "argument"
