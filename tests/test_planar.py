"""The planar kernels against Drake's plant, against each other, and against laws of nature."""

import numpy as np
import pytest
from machines import four_bar, slider_crank
from newton_euler import free_bodies

from linkages import simulate
from linkages.base.kernel.by_reference import packed
from linkages.mechanics.planar.closure import closure_jacobian
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_acceleration, row_rate, row_value
from linkages.mechanics.planar.contacts import WIDTH, clearance_wrenches
from linkages.mechanics.planar.kinematics import body_accelerations, body_positions, body_states, body_velocities
from linkages.mechanics.planar.loop_dynamics import correct
from linkages.mechanics.planar.markers import turned
from linkages.mechanics.planar.motion import Motions, constant_rate, ramped_rate, table
from linkages.mechanics.planar.singularities import constrained_dynamics
from linkages.mechanics.planar.workspace import make_workspace
from linkages.results.outputs.columns import columns
from linkages.system.spanning import spanning_tree

RNG = np.random.default_rng(1)


def random_state(tree):
    return RNG.normal(size=tree.size), RNG.normal(size=tree.size)


def drake_plant(tree, gravity=(0.0, 0.0, 0.0)):
    from pydrake.multibody.plant import MultibodyPlant

    from linkages.engines.drake.plant import add_tree, state_place

    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    instance = add_tree(plant, tree)
    plant.Finalize()
    return plant, state_place(plant, tree, instance)


CASES = {
    "four-bar": (four_bar(), ("A",), ("O",)),
    "four-bar, oblique plane": (four_bar(plane="oblique"), ("B",), ("O",)),
    "four-bar, vertical": (four_bar(plane="xz"), ("A",), ("O",)),
    "slider-crank, floating rod": (slider_crank(), ("A", "B"), ("O",)),
    "slider-crank, floating rod, oblique": (slider_crank(plane="oblique"), ("A", "B"), ("O",)),
    "slider-crank, cut at A": (slider_crank(plane="yz"), ("A",), ("O",)),
}


@pytest.mark.parametrize("case", CASES)
def test_positions_velocities_and_dynamics_agree_with_drakes_plant(mechanism_of, case):
    """Random states, forces and gravity: every body pose and velocity, every acceleration, every drive force."""
    text, play, driven = CASES[case]
    mechanism = mechanism_of(text)
    tree = spanning_tree(mechanism, play, driven)
    gravity = RNG.normal(size=3)
    plant, place = drake_plant(tree, gravity)
    context = plant.CreateDefaultContext()
    q, v = random_state(tree)
    full_q, full_v = np.zeros(plant.num_positions()), np.zeros(plant.num_velocities())
    full_q[place.positions], full_v[place.velocities] = q, v
    plant.SetPositions(context, full_q)
    plant.SetVelocities(context, full_v)
    nb = len(tree.bodies.records)
    pose, vel = np.empty((nb, 5)), np.empty((nb, 3))
    body_states(tree.bodies, q, v, pose, vel)
    for link in mechanism.links:
        i, x, y = tree.named_marker(link.name)
        arm = np.array(turned(pose, i, x, y))
        body = plant.GetBodyByName(link.name)
        X, V = plant.EvalBodyPoseInWorld(context, body), plant.EvalBodySpatialVelocityInWorld(context, body)
        in_plane = mechanism.basis[:, :2].T
        np.testing.assert_allclose(pose[i, :2] + arm, in_plane @ X.translation(), atol=1e-13)
        np.testing.assert_allclose(vel[i, 0], mechanism.basis[:, 2] @ V.rotational(), atol=1e-13)
        velocity = vel[i, 1:] + vel[i, 0] * np.array([-arm[1], arm[0]])
        np.testing.assert_allclose(velocity, in_plane @ V.translational(), atol=1e-13)
    # prescribed accelerations of driven joints, forces on free ones
    tau, acceleration = RNG.normal(size=tree.size), RNG.normal(size=tree.size)
    none = tree.loop_rows[:0]
    plane_gravity = mechanism.basis[:, :2].T @ gravity
    work = tree.workspace(none)
    work.q[:], work.v[:], work.tau[:], work.a[tree.driven_dofs] = q, v, tau, acceleration[tree.driven_dofs]
    constrained_dynamics(tree.bodies, none, 0, 1.0, 0.0, plane_gravity, work, np.empty(tree.size))
    needed, found = work.tau, work.a
    full_a = np.zeros(plant.num_velocities())
    full_a[place.velocities] = found
    M = plant.CalcMassMatrix(context)
    bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
    np.testing.assert_allclose((M @ full_a + bias)[place.velocities], needed, rtol=1e-9, atol=1e-11)
    np.testing.assert_array_equal(found[tree.driven_dofs], acceleration[tree.driven_dofs])
    np.testing.assert_array_equal(needed[tree.free_dofs], tau[tree.free_dofs])


@pytest.mark.parametrize("text", [four_bar(), slider_crank(), slider_crank(offset=0.02)])
def test_closure_rows_derivatives_and_reactions_are_consistent(mechanism_of, text):
    """Rates and accelerations of every kind of row against differences in time; wrenches against virtual work."""
    mechanism = mechanism_of(text)
    tree = spanning_tree(mechanism, ("A",), ())
    for rows in (tree.closure_rows, _all_rows(mechanism)):
        q, v = random_state(tree)
        a = RNG.normal(size=tree.size)
        nb, n = len(tree.bodies.records), tree.size

        def at(t, rows=rows, q=q, v=v, a=a, nb=nb):
            pose, vel, acc = np.empty((nb, 5)), np.empty((nb, 3)), np.empty((nb, 3))
            qt, vt = q + t * v + t * t / 2 * a, v + t * a
            body_states(tree.bodies, qt, vt, pose, vel)
            body_accelerations(tree.bodies, pose, vel, vt, a, acc)
            return (
                np.array([row_value(r, pose) for r in rows]),
                np.array([row_rate(r, pose, vel) for r in rows]),
                np.array([row_acceleration(r, pose, vel, acc) for r in rows]),
            )

        h = 1e-5
        (y0, r0, _), (y1, r1, _), (_, rate, acceleration) = at(-h), at(h), at(0.0)
        np.testing.assert_allclose(rate, (y1 - y0) / (2 * h), atol=1e-8)  # second differences of order h^2
        np.testing.assert_allclose(acceleration, (r1 - r0) / (2 * h), atol=1e-7)
        pose, vel = np.empty((nb, 5)), np.empty((nb, 3))
        body_positions(tree.bodies, q, pose)
        jacobian = np.empty((len(rows), n))
        closure_jacobian(tree.bodies, rows, pose, jacobian)
        np.testing.assert_allclose(jacobian @ v, rate, atol=1e-12)
        body_velocities(tree.bodies, pose, v, vel)
        for row, r in zip(rows, rate, strict=True):
            wrench = np.zeros((nb, 3))
            add_row_wrench(row, pose, 1.7, wrench)
            assert np.sum(wrench * vel) == pytest.approx(1.7 * r, abs=1e-12)


def _all_rows(mechanism):
    """Rows of every joint of the mechanism, whether cut or not: prismatic ones too."""
    tree = spanning_tree(mechanism, ("A",), ())
    return tree._rows([joint.name for joint in mechanism.joints])


def test_pair_of_a_clearance_joint_has_no_net_force_and_no_net_moment(system_of):
    """Momentum and angular momentum of an isolated pair are constant to round-off, whatever the state."""
    toml = "duration = 1.0\n[joints.A]\nmodel='lubricated'\nclearance=1e-3\nviscosity=0.1\n"
    toml += "[joints.B]\nmodel='lubricated'\nclearance=1e-3\nviscosity=0.1\nshear_film='half'\n"
    system, memory = system_of(slider_crank(), toml), np.zeros((2, 2))
    tree = system.tree
    assert tree.play == ("A", "B")
    for _ in range(50):
        q, v = 1e-4 * RNG.normal(size=tree.size), RNG.normal(size=tree.size)
        nb = len(tree.bodies.records)
        pose, vel, wrench, out = np.empty((nb, 5)), np.empty((nb, 3)), np.zeros((nb, 3)), np.empty((2, WIDTH))
        body_states(tree.bodies, q, v, pose, vel)
        clearance_wrenches(tree.ends, system.laws, system.tables, memory, pose, vel, wrench, out)
        net = wrench[:, 1:].sum(axis=0)
        moment = np.sum(wrench[:, 0] + pose[:, 0] * wrench[:, 2] - pose[:, 1] * wrench[:, 1])
        size = np.abs(wrench).max()
        assert size > 1e-3
        assert np.abs(net).max() < 1e-14 * size * 10
        assert abs(moment) < 1e-14 * size * 10


def test_loop_multipliers_equal_newton_euler_reactions(seven_bar):
    """Two formulations: tree with multipliers, and free bodies in absolute coordinates; drive torques too."""
    system = seven_bar.ideal()
    tree = system.tree
    assert tree.loops
    assert tree.driven == ("O1", "O4")
    q, v = system.assembly.q, system.assembly.v
    gravity = np.array([0.3, -2.0])
    rows, loops, work = tree.loop_rows, np.empty(tree.size), tree.workspace(tree.loop_rows)
    work.q[:], work.v[:] = q, v
    constrained_dynamics(tree.bodies, rows, system.arrays.elimination, tree.extent, 0.0, gravity, work, loops)
    needed, a, reaction = work.tau, work.a, work.reaction
    heavy = system.replaced({"gravity": [0.3, -2.0, 0.0]})
    np.testing.assert_array_equal(heavy.gravity, gravity)
    given = heavy, np.zeros(1), q[None], v[None], a[None]
    force, moment, drive = free_bodies(*given)
    found = columns(*given)
    assert "guide" in tree.loops  # a prismatic joint is among them: its rows are normal force and moment
    for k, name in enumerate(tree.loops):
        multipliers = reaction[2 * k : 2 * k + 2]
        slides = name == "guide"
        expected = (force[name][0, 1], moment[name][0]) if slides else force[name][0]
        np.testing.assert_allclose(expected, multipliers, rtol=1e-9, atol=1e-11)
        parts = [found[f"{name}.{part}"][0] for part in (("fy", "moment") if slides else ("fx", "fy"))]
        np.testing.assert_allclose(parts, multipliers, rtol=1e-9, atol=1e-11)
    for name in tree.driven:
        torque = needed[tree.coordinates.index(name)]
        assert drive[name][0] == pytest.approx(torque, rel=1e-9)
        assert found[f"{name}.torque"][0] == pytest.approx(torque, rel=1e-9)


@pytest.mark.parametrize("inertia", ["1e-2", "1e-4", "1e-9"])
def test_how_far_from_singular_a_linkage_is_does_not_depend_on_the_slider(system_of, inertia):
    """Its angle, in a guide that is cut, answers to a unit reaction by the reciprocal of its moment of inertia."""
    toml = "duration = 0.2\n[drives.O]\nspeed = 31.4159\n"
    system = system_of(slider_crank().replace("1e-4", inertia), toml)
    arrays, tree = system.arrays, system.tree
    assert tree.loops == ("guide",)
    run, margins = simulate(system, "compiled"), []
    work = packed(make_workspace(len(tree.bodies.records), tree.size, len(arrays.rows)))
    for k in range(0, len(run.time), len(run.time) // 10):
        q = np.array([run[f"q.{name}"][k] for name in tree.coordinates])
        work.q[:] = q
        body_positions(tree.bodies, q, work.pose)
        margins.append(correct(tree.bodies, arrays.rows, arrays.elimination, work, np.zeros(tree.size)))
    assert min(margins) > 0.3


def test_motions_have_the_promised_rates_and_accelerations():
    pieces = [constant_rate(0.3, 2.0), ramped_rate(-0.1, 5.0, 0.4), table([0, 0.5, 1, 1.5, 2], [0, 1, 0, 2, 3])]
    motions = Motions(pieces)
    times = np.linspace(0.0, 2.0, 401)
    value, rate, acceleration = motions(times)
    h = 1e-6
    before, after = motions(times - h), motions(times + h)
    np.testing.assert_allclose(rate, (after[0] - before[0]) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(acceleration, (after[1] - before[1]) / (2 * h), atol=1e-4)
    np.testing.assert_allclose(value[:, 0], 0.3 + 2.0 * times, atol=1e-14)
    assert rate[0, 1] == 0.0
    assert acceleration[0, 1] == 0.0
    assert rate[times >= 0.4, 1] == pytest.approx(5.0)
    assert value[-1, 1] == pytest.approx(-0.1 + 5.0 * (2.0 - 0.2))
    assert value[[0, 100, 200], 2] == pytest.approx([0, 1, 0], abs=1e-12)


def test_closure_error_is_zero_when_closed(seven_bar):
    tree = seven_bar.tree
    assert np.abs(tree.gaps(seven_bar.assembly.q)).max() < 1e-14
