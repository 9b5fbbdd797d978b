"""Clearance in driven joints, against independent models; see `driven_clearance`."""

from __future__ import annotations

import joint_laws
import numpy as np
import pytest
from driven_clearance import SDF, DrivenCrank
from machines import written

import linkages
from linkages import impacts

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


def load(folder, machine, drive, joint, duration, accuracy=1e-10):
    """A machine with a bearing in its driven pin."""
    text = HEAD.format(duration) + DRIVES[drive][0] + joint + f"[solver]\naccuracy = {accuracy}\n"
    return linkages.load(written(folder, SDF[machine], text))


@MACHINES
@pytest.mark.parametrize("drive", DRIVES)
def test_film_in_the_driven_pin(machine, drive, tmp_path):
    """A film with Petroff's shear torque: eccentricity, force, torque of the drive."""
    run = linkages.simulate(load(tmp_path, machine, drive, FILM, 0.03), "compiled")
    times = np.linspace(0.0, 0.03, 16)
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
