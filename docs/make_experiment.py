"""Writes docs/experiment.md, the list of keys of an experiment file: ``python docs/make_experiment.py``."""

from pathlib import Path

from linkages.experiment import keys

_HEAD = """# Experiment files

An experiment is a TOML file that names a mechanism and says what is done with it. `sdf/seven_bar.toml` is an example.

- The comment behind a value is kept as its **source** and goes into `summary.json`: `clearance = 3e-4  # m, section 3.3`.
- **Any value can be replaced by its dotted path**: `--set joints.A.clearance=2e-4` on the command line,
  `load("seven_bar.toml", {"joints.A.clearance": 2e-4})` or `experiment.replaced({...})` in Python.
- Values of the SDF file are reached with `sdf.`: `sdf.links.link2.mass` [kg], `sdf.links.link2.inertia` (about the plane's
  normal) [kg m2], `sdf.links.link2.com.x` [m], `sdf.frames.crank1_A.pose.x` [m] (a link's length),
  `sdf.joints.A.bearing.radius` [m].
- An unknown key is an error that names the nearest valid one.

A drive has one of `speed` (with `ramp` for a smooth start), `times` with `angles`, `torque`, or `times` with `torques`.
For prismatic joints read m for rad and N for N m.

This list is written by `python docs/make_experiment.py`; `linkages keys` prints it too.

| key | meaning [unit] |
|---|---|
"""


def markdown() -> str:
    """Return the page."""
    return _HEAD + "".join(
        f"| `{name}` | {meaning.replace('|', chr(92) + '|')} |\n" for name, meaning in keys()
    )


if __name__ == "__main__":
    Path(__file__).with_name("experiment.md").write_text(markdown(), encoding="utf-8")
