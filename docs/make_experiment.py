"""Writes docs/experiment.md, the list of keys of an experiment file: ``python docs/make_experiment.py``."""

from collections.abc import Iterable
from pathlib import Path

from linkages.model.experiment import described

_HEAD = """# Experiment files

An experiment is a TOML file that names a mechanism and says what is done with it. `sdf/seven_bar.toml` is an example.

- Numbers are in SI units, or texts with their [unit](describe.md#units): `clearance = "0.1 mm"`, `speed = "300 r/min"`.
- The comment behind a value is kept as its **source** and goes into `summary.json`: `clearance = 3e-4  # m, section 3.3`.
- **Any value can be replaced by its dotted path**: `--set joints.A.clearance=2e-4` on the command line,
  `linkages.load("seven_bar.toml", {"joints.A.clearance": 2e-4})` or `system.replaced({...})` in Python;
  `system.value("joints.A.clearance")` reads it.
- Values of the SDF file are reached with `sdf.`: `sdf.links.link2.mass` [kg], `sdf.links.link2.inertia` (about the plane's
  normal) [kg m2], `sdf.links.link2.com.x` [m], `sdf.frames.crank1_A.pose.x` [m] (a link's length),
  `sdf.joints.A.bearing.radius` [m], `sdf.links.rod.beam.height` [m], `sdf.links.rod.beam.youngs_modulus` [Pa]. The mass of a
  link with a beam follows from the beam.
- An unknown key is an error that names the nearest valid one.

A drive has one of `speed` (with `ramp` for a smooth start), `times` with `angles`, `formula`, `torque`, or `times` with `torques`;
one of a joint that slides `force`, or `times` with `forces`. For prismatic joints read m for rad. A formula of the motion must be
smooth: where its rate jumps a drive would need a force without bounds, and no engine sees it.

**Applied loads** have names of their own, which no link, frame or joint has; what they give is listed among the
[outputs](outputs.md#outputs), their signs are in [theory.md](theory.md). They act in every run of the experiment, the ideal
linkage's too.

```toml
# a force at the origin of a link or frame
[forces.P]
point = "slider"
force = [-200.0, 0.0]          # N, plane axes; axes = "body": the point's frame's

# or over time, with monotone cubics between the values
[forces.cutting]
point  = "slider"
times  = [0.0, 0.4, 0.5, 1.0]  # s, from 0 or before to the duration or after
forces = [[0.0, 0.0], [0.0, 0.0], [-900.0, 0.0], [0.0, 0.0]]  # N

# or by formulas of the time t and of positions and speeds
[forces.drag]
point   = "slider"
formula = ["-40*slider.vx*abs(slider.vx)", "5*sin(2*pi*t)"]  # N

# or over one of these, with monotone cubics between the values; beyond the ends the values there hold
[forces.press]
point  = "slider"
over   = "slider.x"
at     = ["0.20 m", "0.24 m", "0.25 m"]
forces = [[0.0, 0.0], [0.0, 0.0], [-900.0, 0.0]]  # N

# counter-clockwise, on a link; constant, over time, a position or a speed, or a formula
[torques.load]
link   = "follower"
torque = -0.5                  # N m

# in a revolute joint: along its coordinate on the child, its opposite on the parent; here a motor's characteristic
[torques.motor]
joint   = "O"
formula = "0.6*(1 - O.rate/157)"  # N m

# between two links' or frames' origins, or from one to a fixed point
[springs.S]
point       = "slider"
anchor      = [0.3, 0.0]       # m, plane axes; or: to = "FRAME"
stiffness   = 4530.0           # N/m
free_length = 0.07785          # m
damping     = 2.0              # N s/m, along the line

# in a revolute joint, or: links = ["first", "second"]
[torsion_springs.T]
joint      = "O"
stiffness  = 1.5               # N m/rad
free_angle = 0.2               # rad, the joint's angle, zero in the drawn pose
```

**Friction in ideal joints** is given by its torque, or by its force where the joint slides; it is not computed from what the joint
carries. `constant` is mu R F for a pin of radius R that carries about F. Where F varies much, or lifts off, a [dry joint](laws.md)
with play has the friction of its own contact forces.

```toml
# constant*tanh(v/speed) + viscous*v against the rate v
[frictions.pin]
joint    = "O"
constant = 0.02                # N m
viscous  = 1e-3                # N m s/rad
speed    = 0.01                # rad/s
```

A joint that should stick creeps, at less than `speed`. What is quick in it, inertia times `speed` over `constant`, may make the
equations stiff: then `solver.integrator = "radau3"`.

**Gears** join the coordinates of two joints; which are zero in the drawn pose. A geared joint needs no drive of its own.

```toml
# coordinate of Q = ratio * coordinate of O + offset
[gears.mesh]
joints = ["O", "Q"]
ratio  = -0.5                  # meshing wheels turn against each other; a belt or chain: above zero
offset = 0.0                   # rad; of a joint that slides (a rack, a screw) m, the ratio m/rad
```

`mesh.torque` is the torque on the second joint; the first one gets -ratio times it. Joints may be on moving links: on a planet carrier
ratios are those seen from the carrier. A gear joins coordinates and has no radii: forces in the wheels' joints are without those of the
teeth or the belt, as a [warning](outputs.md#warnings) says; add, in both, `mesh.torque` over the second wheel's pitch radius and the
cosine of the teeth's pressure angle. All other joints carry what they would with teeth.

**Stops and lines** are contacts beside those in joints with play; they have names of their own too.

```toml
# where the way of a joint's coordinate ends; of a joint that turns an angle, and torques
[stops.end]
joint = "O"
side  = "upper"                # or "lower"
limit = "30 deg"
[stops.end.contact]
law         = "flores"
restitution = 0.6
stiffness   = 2e4              # N m/rad^n; of a sliding joint N/m^n
exponent    = 1.5              # n

# a point of a link at a straight line, on the ground or on another link (line = "FRAME": its x axis)
[contacts.foot]
point  = "shank_tip"
anchor = [0.0, -0.35]          # m, plane axes; the free side is to the left of its direction
angle  = 0.0                   # rad, from x_P
[contacts.foot.contact]
law         = "hunt-crossley"
restitution = 0.5
stiffness   = 1e6              # N/m^n
[contacts.foot.friction]
law         = "coulomb"
coefficient = 0.6
```

They take the contact and friction laws of [dry joints](laws.md), by a stiffness, not by a material. A stop at 0.3 is met at
0.3; what lies beyond is the law's penetration. With them the largest step is as small as with dry joints, in runs on Drake: set
`solver.max_step` to a tenth of how long a contact lasts. The exact motion of a linkage whose drives determine it knows nothing of them; runs do.

Loads can depend on `x`, `y`, `angle`, `vx`, `vy` and `omega` of a link or frame (plane axes; as the outputs of these names), and on
`coordinate` and `rate` of a joint (from its parent to its child; of a sliding one along the way). Formulas have
`+ - * / **`, parentheses, `pi`, and `abs sqrt exp log sin cos tan asin acos atan tanh atan2 hypot min max`; their numbers are SI units.
Both engines compute formula and table in every evaluation, with their exact derivatives: nothing is tabulated in between.

A journal starts in the middle of its bearing, at its `offset`, or with `start = "equilibrium"` where its load holds it at
rest. Tables give the last period of a run that has become periodic, or what `report`, `report_from` ask for; further parts
have names. [How a steady motion is known](outputs.md#the-steady-cycle).

```toml
start       = "equilibrium"
report_from = 0.5              # s

[windows.press]
start = 0.62                   # s
end   = 0.70                   # s
```

**Links that bend** need a beam in the SDF file ([machines](../sdf/README.md)); [flexible.md](flexible.md) says how they are modelled.

```toml
[links.rod]
model   = "flexible"           # or "rigid", the default
bending = 4                    # modes; by default as many as its joints and loads need, and two
axial   = 1                    # 0: the link does not stretch
damping = 0.01                 # ratio of its first bending mode
```

A step may miss a force that changes within less than `solver.max_step`: lower that for such a table.

This list is written by `python docs/make_experiment.py`; `linkages keys` prints it too.

| key | meaning [unit] |
|---|---|
"""


def rows(pairs: Iterable[tuple[str, str]]) -> str:
    """Write rows of keys and meanings."""
    return "".join(f"| `{name}` | {meaning.replace('|', chr(92) + '|')} |\n" for name, meaning in pairs)


def markdown() -> str:
    """Return the page."""
    return _HEAD + rows(described())


if __name__ == "__main__":
    Path(__file__).with_name("experiment.md").write_text(markdown(), encoding="utf-8")
