"""Which model does not support which analysis: one table, one check; all others support each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from linkages.base.errors import InputError
from linkages.elements.analysis import Analysis
from linkages.elements.machine import all_elements_of
from linkages.input.model.experiment import Experiment


class Unsupported(NamedTuple):
    """A model of a part that some analyses do not support."""

    key: str  # path in the experiment, with the part's name as {}
    parts: Callable[[Experiment], Iterable[str]]  # names of the parts that have this model
    problems: Mapping[Analysis, str]  # what is wrong, and the remedy


_CONTENT = "{} cannot follow the film content; remove the table, the film is then given by its map"


#: The table; elements have their own. A film with history has runs on both engines, batches and sweeps, with errors.
UNSUPPORTED = (
    Unsupported(
        "joints.{}.history",
        lambda experiment: [name for name in experiment.play if experiment.joints[name].has_history],
        {analysis: _CONTENT.format(analysis) for analysis in set(Analysis) - {Analysis.DRAKE}}
        | {Analysis.EQUILIBRIUM: 'has no equilibrium that start = "equilibrium" could find; use "centred"'},
    ),
)


def _of_elements(experiment: Experiment, analysis: Analysis) -> Iterator[tuple[str, str]]:
    """Yield path and problem of the elements' models that an analysis does not support."""
    turns = any(drive.prescribed and drive.speed for drive in experiment.drives.values())
    for kind, name, keys in all_elements_of(experiment.elements):
        for model in kind.unsupported:
            if analysis in model.problems and model.applies(keys) and (turns or not model.turning):
                yield f"{kind.path(name)}.{model.key}", model.problems[analysis]


def check_analysis(experiment: Experiment, analysis: Analysis) -> None:
    """Check that the models of all parts support an analysis; InputError with the part's key, reason and remedy."""
    for model in UNSUPPORTED:
        for name in model.parts(experiment) if analysis in model.problems else ():
            raise InputError(experiment.source, model.key.format(name), model.problems[analysis])
    for path, problem in _of_elements(experiment, analysis):
        raise InputError(experiment.source, path, problem)
