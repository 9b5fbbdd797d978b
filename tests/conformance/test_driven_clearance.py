"""Clearance in driven joints, against independent models; see `driven_clearance`."""

from __future__ import annotations

import guide_model
import joint_laws
import numpy as np
import pytest
from driven_clearance import BLOCK, SDF, DrivenBlock, DrivenCrank, carried_crank, cylinder
from machines import written
from measures import worst

import linkages
from linkages import impacts
from linkages.results.extremes import integral
from linkages.results.link_loads import link_loads

MACHINES = pytest.mark.parametrize("machine", SDF)
#: An angle that starts from rest at a constant rate and swings about it, and a torque with a speed at the start.
ANGLE = "[drives.O]\nformula = '30*t + 0.2*sin(50*t)'\n"
TORQUE = "[drives.O]\ntorque = 0.2\nspeed = 40.0\n"
HEAD = "duration = {}\ngravity = [0.0, -9.81, 0.0]\n"
FILM = "[joints.O]\nmodel = 'lubricated'\nfilm = 'pinkus-sternlicht'\nclearance = 1e-4\nviscosity = 0.01\nshear_film = 'full'\n"
DRY = """[joints.O]
model = "dry"
clearance = 1e-4
[joints.O.contact]
law = "lankarani-nikravesh"
restitution = 0.9
youngs_modulus = 200e9
poissons_ratio = 0.3
[joints.O.friction]
law = "cubic"
static = 0.15
coefficient = 0.1
v_0 = 1e-3
v_1 = 1e-2
"""
DRIVES = {
    "angle": (ANGLE, {"motion": lambda t: (
        30 * t + 0.2 * np.sin(50 * t), 30 + 10 * np.cos(50 * t), -500 * np.sin(50 * t)
    )}),
    "torque": (TORQUE, {"torque": 0.2, "speed": 40.0}),
}  # fmt: skip


SLOT = f"""[joints.P]
model = "dry"
clearance = {guide_model.CLEARANCE}
[joints.P.contact]
law = "flores"
restitution = {guide_model.RESTITUTION}
stiffness = {guide_model.STIFFNESS}
[joints.P.friction]
law = "coulomb"
coefficient = {guide_model.FRICTION}
v_1 = {guide_model.V_1}
"""
SOFT_SLOT = SLOT.replace(f"stiffness = {guide_model.STIFFNESS}", "stiffness = 1e9")
PLACE = "[drives.P]\nformula = '0.02*sin(100*t)'\n"
FORCE = "[drives.P]\nforce = 5.0\nspeed = 0.3\n"
SLIDES = {
    "place": (PLACE, {"motion": lambda t: (
        0.02 * np.sin(100 * t), 2 * np.cos(100 * t), -200 * np.sin(100 * t)
    )}),
    "force": (FORCE, {"force": 5.0, "speed": 0.3}),
}  # fmt: skip
#: Driven joints between links that move, either way round: machine, drives, joint.
BETWEEN = {
    "pin": (carried_crank("carriage", "crank", "0 0 1", "xy"), (ANGLE, TORQUE), FILM),
    "pin, backwards": (carried_crank("crank", "carriage", "0 0 1", "oblique"), (ANGLE, TORQUE), FILM),
    "pin, axis against the normal": (carried_crank("carriage", "crank", "0 0 -1", "xz"), (ANGLE, TORQUE), FILM),
    "pin, both": (carried_crank("crank", "carriage", "0 0 -1", "xy"), (ANGLE, TORQUE), FILM),
    "slider": (cylinder("cylinder", "rod"), (PLACE, FORCE), SOFT_SLOT),
    "slider, backwards": (cylinder("rod", "cylinder"), (PLACE, FORCE), SOFT_SLOT),
}
EACH_DRIVE = pytest.mark.parametrize("drive", [0, 1], ids=["motion", "effort"])


def build(folder, sdf, drive, joint, duration, accuracy=1e-10):
    text = HEAD.format(duration) + drive + joint + f"[solver]\naccuracy = {accuracy}\n"
    return linkages.load(written(folder, sdf, text))


def load(folder, machine, drive, joint, duration, accuracy=1e-10):
    """A machine with a bearing in its driven pin."""
    return build(folder, SDF[machine], DRIVES[drive][0], joint, duration, accuracy)


@MACHINES
@pytest.mark.parametrize("drive", DRIVES)
def test_film_in_the_driven_pin(machine, drive, tmp_path):
    """A film with Petroff's shear torque: eccentricity, force, torque of the drive."""
    run = linkages.simulate(load(tmp_path, machine, drive, FILM, 0.02), "compiled")
    times = np.linspace(0.0, 0.02, 11)
    expected = DrivenCrank(machine, joint_laws.sheared, 1e-4, 0.01, **DRIVES[drive][1]).run(times).T
    found = run.evaluate(times)
    for name, column in zip(("O.ex", "O.ey"), expected[:2], strict=True):
        np.testing.assert_allclose(found[name], column, rtol=0.0, atol=1e-6 * 1e-4)
    for name, column in zip(("O.fx", "O.fy", "O.torque"), expected[2:], strict=True):
        np.testing.assert_allclose(found[name], column, rtol=0.0, atol=1e-6 * np.abs(column).max())


@MACHINES
@pytest.mark.parametrize("drive", DRIVES)
def test_impacts_in_the_driven_pin(machine, drive, tmp_path):
    """Lankarani and Nikravesh's contact with a cubic friction: the first six impacts; the model's peaks are sampled."""
    duration = {
        "angle": {"slider_crank": 0.0152, "four_bar": 0.0066},
        "torque": {"slider_crank": 0.0066, "four_bar": 0.005},
    }
    system = load(tmp_path, machine, drive, DRY, duration[drive][machine], 1e-12)
    found = [
        [one.start, one.approach_speed, one.peak_force] for one in impacts(linkages.simulate(system, "compiled"), ["O"])
    ]
    model = DrivenCrank(machine, joint_laws.dry(joint_laws.cubic), 1e-4, **DRIVES[drive][1])
    expected = model.contacts(duration[drive][machine])[:, [1, 2, 4]]
    assert len(expected) >= 6
    for one, other in zip(found[:6], expected[:6], strict=True):
        assert one[0] == pytest.approx(other[0], abs=1e-11)
        np.testing.assert_allclose(one[1:], other[1:], rtol=1e-5)


@pytest.mark.parametrize(("drive", "count", "duration"), [("place", 4, 8.4e-3), ("force", 5, 9.6e-3)])
def test_impacts_of_a_driven_block_in_its_slot(drive, count, duration, tmp_path):
    """Corner, start and peak force of the first impacts; the model's peaks are sampled."""
    system = build(tmp_path, BLOCK, SLIDES[drive][0], SLOT, duration, 1e-12)
    labels = [f"P.corner{k}" for k in range(1, 5)]
    found = impacts(linkages.simulate(system, "compiled"), labels)[:count]
    expected = DrivenBlock(**SLIDES[drive][1]).contacts(duration)[:count]
    for one, other in zip(found, expected, strict=True):
        assert one.joint == labels[int(other[0])]
        assert one.start == pytest.approx(other[1], abs=1e-11)
        assert one.peak_force == pytest.approx(other[4], rel=1e-4)


@pytest.mark.parametrize("case", BETWEEN)
@EACH_DRIVE
def test_energy_and_loads_are_balanced(case, drive, tmp_path):
    """The drive is a pair of efforts on both links, and the only source of work."""
    sdf, drives, joint = BETWEEN[case]
    system = build(tmp_path, sdf, drives[drive], joint, 0.05)
    run, name = linkages.simulate(system, "compiled"), system.experiment.play[0]
    energy = run["kinetic_energy"] + run["potential_energy"]
    work, lost = (integral(run, run[f"{name}.{power}"]) for power in ("power", "contact_power"))
    np.testing.assert_array_equal(run[f"{name}.power"], run[f"{name}.torque"] * run[f"{name}.rate"])
    through = integral(run, np.abs(run[f"{name}.power"]))
    assert lost < 0.0
    assert abs(energy[-1] - energy[0] - work - lost) < 1e-6 * through
    for time in run.time[-1] * np.array([0.0, 0.3, 1.0]):
        state = tuple(part[0] for part in run.evaluate.function.states_at(np.array([time])))
        for link in link_loads(system, time, state).values():
            assert link.imbalance < 1e-12, link.link


@pytest.mark.parametrize("case", BETWEEN)
@EACH_DRIVE
@pytest.mark.slow
def test_the_engines_agree(case, drive, tmp_path):
    sdf, drives, joint = BETWEEN[case]
    system = build(tmp_path, sdf, drives[drive], joint, 0.01)
    ours, theirs = (linkages.simulate(system, engine) for engine in ("compiled", "drake"))
    times = np.linspace(0.0, 0.01, 11)
    column, difference = worst(theirs.evaluate(times), ours.evaluate(times))
    assert difference < 1e-6, column
