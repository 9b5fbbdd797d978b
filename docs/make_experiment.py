"""Write docs/experiment.md, the list of keys of an experiment file: ``python docs/make_experiment.py``."""

import re
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

from linkages.input.files.table_keys import described_keys
from linkages.input.model.experiment import Experiment

_HEAD = """# Keys of experiment files

Reference for all users: every key of an experiment file with its unit, range and default. `python docs/make_experiment.py` writes the list;
`linkages keys [PATH]` prints it.

An experiment is a TOML file that names a [mechanism](glossary.md#mechanism) and describes one run of it, for example `sdf/seven_bar.toml`.

- **Units.** Numbers are in SI units, or texts with a [unit](units.md): `clearance = "0.1 mm"`.
- **Sources.** The comment behind a value is its source; `summary.json` contains it: `clearance = 3e-4  # m, section 3.3`.
- **Paths.** Any value can be replaced by its [dotted path](glossary.md#dotted-path): `--set joints.A.clearance=2e-4` on the command line,
  `linkages.load(file, {"joints.A.clearance": 2e-4})` or `system.replaced({...})` in Python. `system.value(path)` returns it.
- **Values of the SDF file** have paths with `sdf.`: `sdf.links.link2.mass` [kg], `sdf.links.link2.inertia` (about the plane's normal) [kg m2],
  `sdf.links.link2.com.x` [m], `sdf.frames.crank1_A.pose.x` [m] (a length of a link whose joint A is at this frame), `sdf.joints.A.bearing.radius` [m],
  `sdf.links.rod.beam.height` [m], `sdf.links.rod.beam.youngs_modulus` [Pa]. The beam of a link determines its mass. A joint without a bearing gets
  one by both `bearing.radius` and `bearing.length`, a guide its slot by `slot.length` and `slot.height`, a link
  between two pins its beam by `beam.width`, `beam.height`, `beam.youngs_modulus` and `beam.density`.
- **A number that changes nothing in a run** is refused by `--set`, `--vary`, `--wrt`, studies, identification and the live page: the place of a frame that only the drawing
  uses, a parameter of another law, a value across the plane. The message names the path that acts. Numbers of wear, heat and warnings, solver settings and
  windows are not refused by `--set`, nor is the present value.
- **Decimal sign.** It is a point: `0,2 mm` is refused.

## Drives

A drive has one of `speed` (optionally with `ramp`, a smooth start), `times` with `angles`, `formula`, `torque`, or `times` with `torques`. A prismatic joint
has `force`, or `times` with `forces`, and m instead of rad. A formula of the motion reads the time `t` and [values](loads.md#a-number-with-a-name). It must be smooth: at a jump of its rate the drive force would be
infinite, and no engine reports it. Drives, forces and torques also take their signal [from a data file](recorded.md).

### Clearance in a driven joint

A driven joint may have clearance, with every model of other joints: give it both tables, `drives.O` and `joints.O`.

- **Revolute joint.** The drive turns the child relative to the parent, or applies a torque. It acts on both as a pure couple, `O.torque`. The journal's
  centre moves freely in the bearing: `O.force` and `O.ex` describe film and contact.
- **Prismatic joint.** The drive moves the middle of the block along the slot, or applies a force through this middle along the slot. The block moves
  across the slot and tilts.
- `O.power` is the drive's power, `O.contact_power` the power of film and contact.

## All keys

Examples: [loads](loads.md), [gears and backlash](gears.md), [stops, lines and friction](constraints.md), [flexible links](flexible.md), [grooves](bearing_grooves.md), [heat](bearing_heat.md), [tilt](bearing_tilt.md),
[part of a run that tables report](steady_cycle.md), [wear](wear.md).

"""


_FEW = 3  # keys that are written again where another table has them too


def lines(pairs: Iterable[tuple[str, str]]) -> str:
    """Write lines of keys and meanings; a table with the keys of an earlier one, or several of them, refers to it."""
    found, first, hidden, text = list(pairs), {}, "?", ""
    shown: list[tuple[str, str, str]] = []  # key, meaning, and the same key of an earlier table
    for path, meaning in found:
        if path.startswith(hidden):
            continue
        inner = tuple((other.removeprefix(path), said) for other, said in found if other.startswith(f"{path}."))
        if inner and first.setdefault(inner, path) != path:
            hidden, meaning = f"{path}.", f"{meaning}; keys of `{first[inner]}`"
        if not re.fullmatch(r"\S+( \S+)? by name", meaning):  # "driven joints by name"
            earlier = first.setdefault((path.rpartition(".")[2], meaning), path)
            shown.append((path, meaning, earlier if earlier != path else ""))
    for _, group in groupby(shown, lambda key: (key[0].rpartition(".")[0], key[2].rpartition(".")[0])):
        keys = list(group)
        if len(keys) > _FEW and keys[0][2]:
            text += f"- `{_all(path for path, _, _ in keys)}`: as `{_all(earlier for _, _, earlier in keys)}`\n"
        else:
            text += "".join(f"- `{path}`: {meaning}\n" for path, meaning, _ in keys)
    return text


def _all(paths: Iterable[str]) -> str:
    """Write neighbouring keys of a table as its first and last one."""
    names = list(paths)
    return f"{names[0]}` to `.{names[-1].rpartition('.')[2]}"


def markdown() -> str:
    """Return the page."""
    return _HEAD + lines(described_keys(Experiment))


if __name__ == "__main__":
    Path(__file__).with_name("experiment.md").write_text(markdown(), encoding="utf-8")
