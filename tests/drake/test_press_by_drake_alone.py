"""The ideal press by Drake's own means alone: joints and ball constraints of a discrete plant, built from Tables 2 and 3.

Neither the package's mechanism nor its recursion takes part. Joints A and B, which close the loops, are ball constraints (SAP).
A flywheel on each crank, whose inertia changes neither the other links' motion nor their forces, keeps the prescribed speed.
"""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, RotationalInertia, SpatialInertia
from pydrake.systems.analysis import Simulator

import linkages

LENGTH = {1: 0.080, 2: 0.180, 3: 0.318, 4: 0.080, 6: 0.300, 7: 0.0}  # m, Table 2
HEIGHT = 0.301  # m, L5
MASS = {1: 0.107, 2: 0.219, 3: 0.374, 4: 0.107, 6: 0.354, 7: 0.139}  # kg, Table 3
INERTIA = {1: 1.179e-4, 2: 7.736e-4, 3: 3.595e-3, 4: 1.179e-4, 6: 3.056e-3, 7: 6.083e-5}  # kg m2, Table 3
START = np.array([0.0, np.deg2rad(310.79)])  # rad, eq. (17)
FLYWHEEL = 1e4  # kg m2: 0.1 N m in 1 s change its speed by 1e-5 rad/s
SETTLED = 0.02  # s: the discrete plant starts without constraint impulses


def coordinates(cranks):
    """Angles of joints O1, O4, D, C2, C3 and the slider's place, by intersection of circles."""
    a, b = LENGTH[1] * np.exp(1j * cranks[0]), 1j * HEIGHT + LENGTH[4] * np.exp(1j * cranks[1])
    distance = abs(b - a)
    along = (LENGTH[2] ** 2 - LENGTH[3] ** 2 + distance**2) / (2.0 * distance)
    c = a + (b - a) / distance * (along - 1j * np.sqrt(LENGTH[2] ** 2 - along**2))
    slider = c.real + np.sqrt(LENGTH[6] ** 2 - c.imag**2)
    rod = np.angle(slider - c)
    return {
        "O1": cranks[0], "O4": cranks[1], "D": rod, "C2": np.angle(c - a) - rod, "C3": np.angle(c - b) - rod, "guide": slider,
    }  # fmt: skip


def press(step, gravity):
    """Build the plant; returns it with its bodies and joints."""
    plant = MultibodyPlant(step)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector([0.0, gravity, 0.0])
    bodies = {}
    for k, mass in MASS.items():
        moment = INERTIA[k] + (FLYWHEEL if k in (1, 4) else 0.0)
        inertia = SpatialInertia.MakeFromCentralInertia(
            mass, [0.5 * LENGTH[k], 0.0, 0.0], RotationalInertia(moment, moment, moment)
        )
        bodies[k] = plant.AddRigidBody(f"link{k}", inertia)

    def frame(body, x, y=0.0):
        return plant.AddFrame(FixedOffsetFrame(f"{body.name()}_pin", body.body_frame(), RigidTransform([x, y, 0.0])))

    world = plant.world_body()
    ends = {
        "O1": (world.body_frame(), bodies[1].body_frame()),
        "O4": (frame(world, 0.0, HEIGHT), bodies[4].body_frame()),
        "D": (bodies[7].body_frame(), frame(bodies[6], LENGTH[6])),
        "C2": (bodies[6].body_frame(), frame(bodies[2], LENGTH[2])),
        "C3": (bodies[6].body_frame(), frame(bodies[3], LENGTH[3])),
    }
    joints = {name: plant.AddJoint(RevoluteJoint(name, *pair, [0, 0, 1])) for name, pair in ends.items()}
    joints["guide"] = plant.AddJoint(
        PrismaticJoint("guide", world.body_frame(), bodies[7].body_frame(), [1.0, 0.0, 0.0])
    )
    for crank, rod in ((1, 2), (4, 3)):
        plant.AddBallConstraint(bodies[crank], [LENGTH[crank], 0.0, 0.0], bodies[rod], np.zeros(3))
    plant.Finalize()
    return plant, joints


def run(step, speeds, gravity):
    """Acceleration of the slider and sizes of the joints' reactions after each step, by name, and the times."""
    plant, joints = press(step, gravity)
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    h = 1e-6
    before, here, after = (coordinates(START + x * h * speeds) for x in (-1.0, 0.0, 1.0))
    for name, joint in joints.items():
        rate = (after[name] - before[name]) / (2.0 * h)
        if name == "guide":
            joint.set_translation(context, here[name])
            joint.set_translation_rate(context, rate)
        else:
            joint.set_angle(context, here[name])
            joint.set_angular_rate(context, rate)
    place = joints["guide"].velocity_start()
    accelerations, reactions = plant.get_generalized_acceleration_output_port(), plant.get_reaction_forces_output_port()
    times = step * np.arange(1, round(1.0 / step) + 1)
    found = []
    for time in times:
        simulator.AdvanceTo(time)
        forces = reactions.Eval(context)
        found.append(
            [np.hypot(*forces[int(joint.index())].translational()[:2]) for joint in joints.values()]
            + [accelerations.Eval(context)[place]]
        )
    values = dict(zip((*(f"{name}.force" for name in joints), "slider7.ax"), np.array(found).T, strict=True))
    late = times > SETTLED
    return times[late], {name: column[late] for name, column in values.items()}


@pytest.mark.parametrize(
    ("speeds", "gravity"), [((2.0, 2.0), 0.0), ((2.0, 2.0), -9.81), ((1.0, -2.0), -9.81)], ids=["flat", "upright", "against"]
)  # fmt: skip
def test_the_ideal_press_is_that_of_drake_alone(speeds, gravity):
    """Slider and reactions in all ideal joints, at each step; the rest is the discrete plant's step, and falls with it."""
    rates = np.pi * np.array(speeds)
    system = linkages.load(
        linkages.find_file("seven_bar.toml"),
        {"drives.O1.speed": rates[0], "drives.O4.speed": rates[1], "gravity": [0.0, gravity, 0.0]},
    )
    ideal = linkages.ideal(system, "compiled")
    worst = []
    for step in (2e-3, 5e-4):
        times, found = run(step, rates, gravity)
        exact = ideal.evaluate(times)
        worst.append(
            {name: np.abs(found[name] - exact[name]).max() / np.abs(exact[name]).max() for name in found}
        )  # fmt: skip
    coarse, fine = worst
    assert set(fine) == {"O1.force", "O4.force", "D.force", "C2.force", "C3.force", "guide.force", "slider7.ax"}
    assert max(fine.values()) < 0.01
    assert all(fine[name] < 0.5 * coarse[name] for name in fine)
