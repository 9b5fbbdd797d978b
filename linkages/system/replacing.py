"""Values of the input by dotted path: the numbers, their units, and the input with other values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from linkages.input.files.unit_conversion import SLIDING, si_unit
from linkages.input.model.check import names_first, without_lost_outputs
from linkages.input.model.experiment import Experiment, value_unit
from linkages.input.model.mechanism import Mechanism, faults_of_values, is_inertial, load_mechanism


def with_values(
    mechanism: Mechanism, experiment: Experiment, values: Mapping[str, Any], origin: str
) -> tuple[Mechanism, Experiment]:
    """Return the input with values replaced, see `linkages.System.replaced`."""
    with names_first(lambda: mechanism):
        changed = experiment.replaced(values, origin)
    paths = [path.removeprefix("sdf.") for path in values if path.partition(".")[0] == "sdf"]
    with faults_of_values(changed):
        if "mechanism" in values:
            machine = load_mechanism(changed.mechanism_path, changed.sdf_overrides)
        else:
            machine = mechanism.replaced(changed.sdf_overrides, paths)
    return machine, without_lost_outputs(machine, changed, values)


def same_start(before: Experiment, after: Experiment, values: Mapping[str, Any]) -> bool:
    """Check whether replaced values leave the start of a linkage as it was."""
    if not all(map(keeps_start, values)) or after.start != "centred" or after.deforming:
        return False
    one, other = ({name: each.joints[name].offset for name in each.play} for each in (before, after))
    return one == other


def keeps_start(path: str) -> bool:
    """Check whether a path names a mass or a joint's law, which do not affect the start."""
    if path.startswith("sdf."):
        return is_inertial(path.removeprefix("sdf."))
    return path.startswith("joints.") and ".offset" not in path


def unit_of(mechanism: Mechanism, experiment: Experiment, path: str) -> str:
    """Return the SI unit of the number at a path, see `linkages.System.value_unit`."""
    unit = value_unit(path) or mechanism.units.get(path.removeprefix("sdf."), "")
    if path.startswith("values."):
        return si_unit(str(experiment.texts.get(path)))
    kind, _, rest = path.partition(".")
    name = rest.partition(".")[0]
    tables = getattr(experiment, kind, None)
    table = tables.get(name) if isinstance(tables, Mapping) else None
    joint = mechanism.joint.get(getattr(table, "joint", None) or name) if table is not None else None
    return SLIDING.get(unit, unit) if joint is not None and joint.type == "prismatic" else unit
