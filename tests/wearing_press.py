"""A shaft that turns in a block; the block is pressed onto it and can only slide: a load of constant direction."""

from __future__ import annotations

import math

from machines import BEARING, joint, model, solid
from scipy.optimize import brentq

CLEARANCE, RADIUS, LENGTH, SPEED = 1e-4, 0.01, 0.02, 200.0 * math.pi

SDF = model(
    "press",
    solid("shaft", 1.0, 1e-3) + solid("block", 0.2, 1e-3)
    + joint("O", "world", "shaft") + joint("guide", "world", "block", "prismatic", "0 1 0")
    + joint("B", "block", "shaft", inner=BEARING),
)  # fmt: skip
EXPERIMENT = f"""
mechanism = "press.sdf"
duration = 0.02
[drives.O]
speed = {SPEED!r}
[joints.B]
model = "dry"
clearance = {CLEARANCE}
[joints.B.contact]
law = "lankarani-nikravesh"
restitution = 0.5
youngs_modulus = 207e9
[joints.B.wear]
coefficient = 5e-13
"""
FORCE = '[forces.F]\npoint = "block"\nforce = [0.0, -100.0]\n'
#: The spring is stretched by 40 um when the block rests on the shaft: wear unloads it.
SPRING = """[springs.S]
point = "block"
anchor = [0.0, -0.1]
stiffness = 2.5e6
free_length = 0.09986
damping = 300.0
"""


def write_press(folder, load=FORCE, driven=False):
    """Write the machine and its experiment into a folder; returns the experiment's path."""
    (folder / "press.sdf").write_text(DRIVEN if driven else SDF)
    path = folder / "press.toml"
    path.write_text((EXPERIMENT.replace("joints.B", "joints.O") if driven else EXPERIMENT) + load)
    return path


#: The press whose driven shaft has the clearance, in a bearing of the ground; the block turns on it without clearance.
DRIVEN = model(
    "press",
    solid("shaft", 1.0, 1e-3) + solid("block", 0.2, 1e-3)
    + joint("O", "world", "shaft", inner=BEARING) + joint("B", "block", "shaft")
    + joint("guide", "world", "block", "prismatic", "0 1 0"),
)  # fmt: skip


def half_angle(depth):
    """Half-angle of the crescent of a depth [rad]."""
    e, journal = CLEARANCE + depth, RADIUS - CLEARANCE
    return math.acos((e * e + RADIUS**2 - journal**2) / (2.0 * e * RADIUS))


def area(depth):
    """Area of the crescent, the part of the journal's circle outside the bearing's, by its depth [m2]."""
    e, journal, alpha = CLEARANCE + depth, RADIUS - CLEARANCE, half_angle(depth)
    about_journal = math.pi - math.acos((e * e + journal**2 - RADIUS**2) / (2.0 * e * journal))
    return journal**2 * about_journal - RADIUS**2 * alpha + e * RADIUS * math.sin(alpha)


def crescent(size):
    """Depth [m] and half-angle [rad] of the crescent of an area [m2]."""
    depth = brentq(lambda d: area(d) - size, 1e-9 * CLEARANCE, 29.0 * CLEARANCE, xtol=1e-18)
    return depth, half_angle(depth)
