"""Which model does not support which analysis: one table, one check; all others support each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple

from linkages.base.errors import InputError
from linkages.elements.analysis import Analysis as Analysis
from linkages.elements.machine import KINDS
from linkages.input.model.experiment import Experiment


class Unsupported(NamedTuple):
    """A model of a part that some analyses do not support."""

    key: str  # path in the experiment, with the part's name as {}
    parts: Callable[[Experiment], Iterable[str]]  # names of the parts that have this model
    problems: Mapping[Analysis, str]  # what is wrong, and the remedy


def _having(table: str, applies: Callable[[Any], bool], experiment: Experiment) -> list[str]:
    """List the elements with keys that some analyses cannot treat."""
    return [name for name, keys in experiment.elements[table].items() if applies(keys)]


_CONTENT = "{} cannot follow the film content; remove the table, the film is then given by its map"


def _fractional(experiment: Experiment) -> list[str]:
    """List the gears of a turning drive whose wheels have another pose after a revolution."""
    turns = any(drive.prescribed and drive.speed for drive in experiment.drives.values())
    return [name for name, gear in experiment.gears.items() if turns and gear.ratio % 1.0]


#: The table. A film with history has runs on both engines, batches and sweeps, with errors.
UNSUPPORTED = (
    Unsupported(
        "joints.{}.history",
        lambda experiment: [name for name in experiment.play if experiment.joints[name].has_history],
        {analysis: _CONTENT.format(analysis) for analysis in set(Analysis) - {Analysis.DRAKE}}
        | {Analysis.EQUILIBRIUM: 'has no equilibrium that start = "equilibrium" could find; use "centred"'},
    ),
    *(
        Unsupported(f"{kind.table}.{{}}.{one.key}", partial(_having, kind.table, one.applies), one.problems)
        for kind in KINDS
        for one in kind.unsupported
    ),
    Unsupported(
        "gears.{}.ratio",
        _fractional,
        {Analysis.WEAR: "is no whole number: cycles of the drive do not begin in the same pose; drive the other joint"},
    ),
    Unsupported(
        "drives.{}.backlash.inertia",
        lambda experiment: [name for name, slack in experiment.gearboxes.items() if not slack.inertia],
        dict.fromkeys((Analysis.DRAKE, Analysis.DIAGRAM), "is 0, but Drake needs an inertia of the gearbox' wheel"),
    ),
    Unsupported(
        "links.{}.stiffening",
        lambda experiment: [name for name in experiment.flexible if not experiment.links[name].stiffening],
        {Analysis.DRAKE: "is false, but Drake's rigid segments always stiffen; remove it, or use the compiled engine"},
    ),
)


def check_analysis(experiment: Experiment, analysis: Analysis) -> None:
    """Check that the models of all parts support an analysis; InputError with the part's key, reason and remedy."""
    for model in UNSUPPORTED:
        for name in model.parts(experiment) if analysis in model.problems else ():
            raise InputError(experiment.source, model.key.format(name), model.problems[analysis])
