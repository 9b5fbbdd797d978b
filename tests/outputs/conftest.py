"""Systems for tests of outputs: every shipped mechanism, and one with all other elements."""

from functools import cache

import pytest
from machines import four_bar, written
from shipped import NAMES, shipped

import linkages

#: Seconds until the first contact is over, or of smooth motion: both engines have one solution there.
DURATION = {
    "seven_bar": 0.1,
    "seven_bar_rig": 0.1,
    "seven_bar_paper": 0.1,
    "slider_crank_lubricated": 0.002,
    "slider_crank_main_bearing": 0.002,
    "slider_crank_motor": 0.02,
    "slider_crank_flywheel": 0.02,
    "gear_rattle": 0.014,
    "four_bar_dry": 0.004,
    "five_bar_dry": 0.0014,
    "six_bar_dry": 0.005,
    "seven_bar_dry": 0.0125,
    "slider_crank_dry": 0.0006,
    "slider_crank_wear": 0.0006,
    "slider_crank_guide": 0.00115,
    "seven_bar_mixed": 0.04,
}

#: A crank-rocker with what no shipped machine has: every kind of load, a torque drive, bristles, an ideal loop.
LOADED = """duration = 0.004
gravity = [0.0, -9.81, 0.0]
[drives.O]
torque = 0.4
speed = 5.0
[joints.A]
model = "dry"
clearance = 1e-5
contact = {law = "flores", restitution = 0.5, youngs_modulus = 2e9}
friction = {law = "lugre", coefficient = 0.1, bristle_stiffness = 1e4}
[forces.P]
point = "follower_tip"
force = [2.0, -5.0]
axes = "body"
[torques.M]
link = "coupler"
times = [0.0, 0.3]
torques = [0.5, -0.2]
[springs.S]
point = "coupler_tip"
anchor = [-0.1, 0.1]
stiffness = 200.0
free_length = 0.2
damping = 3.0
[torsion_springs.T]
joint = "Q"
stiffness = 2.0
free_angle = 0.5
damping = 0.01
"""


@pytest.fixture(scope="session")
def system_named(tmp_path_factory):
    """Make the system of a case, tight enough for its columns to have ten digits."""
    path = written(tmp_path_factory.mktemp("loaded"), four_bar(), LOADED)

    @cache
    def made(name):
        changes = {"solver.accuracy": 1e-10}
        if name == "loaded":
            return linkages.load(path, changes)
        return shipped(name, duration=DURATION[name], **changes)

    return made


@pytest.fixture(params=[*NAMES, "loaded"])
def system(request, system_named):
    return system_named(request.param)
