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
  `sdf.joints.A.bearing.radius` [m].
- An unknown key is an error that names the nearest valid one.

A drive has one of `speed` (with `ramp` for a smooth start), `times` with `angles`, `torque`, or `times` with `torques`; one of a
joint that slides `force`, or `times` with `forces`. For prismatic joints read m for rad.

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

# counter-clockwise, on a link; constant or over time
[torques.load]
link   = "follower"
torque = -0.5                  # N m

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
