"""Which model does not support which analysis: one table, one check; all others support each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum
from functools import partial
from typing import NamedTuple

from linkages.base.errors import InputError
from linkages.input.model.experiment import Experiment


class Analysis(StrEnum):
    """What is done with a system; the values are for messages."""

    DRAKE = "Drake"
    DIAGRAM = "a Drake diagram"
    DERIVATIVES = "derivatives"
    PERIODIC = "the return map"
    EXPONENT = "the Lyapunov exponent"
    WEAR = "wear over a service life"
    LINEAR = "the linear model"
    LIVE = "the live page"
    EQUILIBRIUM = 'start = "equilibrium"'


class Unsupported(NamedTuple):
    """A model of a part that some analyses do not support."""

    key: str  # path in the experiment, with the part's name as {}
    parts: Callable[[Experiment], Iterable[str]]  # names of the parts that have this model
    problems: Mapping[Analysis, str]  # what is wrong, and the remedy


def _sampled(table: str, experiment: Experiment) -> list[str]:
    """List the states or controllers with a sampling time."""
    return [name for name, one in getattr(experiment, table).items() if one.sample_time is not None]


_SAMPLED = "makes sampling instants, which {} cannot follow; make it continuous"
_SMOOTH = Analysis.DIAGRAM, Analysis.PERIODIC, Analysis.EXPONENT, Analysis.LINEAR
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
        Unsupported(
            f"{table}.{{}}.sample_time",
            partial(_sampled, table),
            {analysis: _SAMPLED.format(analysis) for analysis in _SMOOTH},
        )
        for table in ("states", "controllers")
    ),
    Unsupported(
        "gears.{}.ratio",
        _fractional,
        {Analysis.WEAR: "is no whole number: cycles of the drive do not begin in the same pose; drive the other joint"},
    ),
    Unsupported(
        "controllers.{}.function",
        lambda experiment: [name for name, one in experiment.controllers.items() if one.function is not None],
        {Analysis.DERIVATIVES: "is in Python, which has no derivatives; give the controller by formulas of states"},
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
