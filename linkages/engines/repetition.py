"""The repetition of a run that estimates its error: its finer settings resolve motions that the run omits."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.machine import all_elements_of
from linkages.engines.numerics import REPETITION_CELLS, REPETITION_FEWEST, REPETITION_FILM, REPETITION_SHORTER
from linkages.input.model.experiment_tables import FILM_ACCURACY, FILM_CELLS, FilmHistory
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.rigid_segments import has_segments

# Its accuracies with which an implicit method resolves vibrations of flexible links: a looser one omits those that the
# run omits, and from the finest one on the positions are so accurate that no vibration is small against it.
_LOOSEST, _FINEST = 1e-6, 1e-10


def tightened(system: System, run: Trajectory, ratio: float) -> System:
    """Return the system for the repetition of a run that estimates its error, with the tolerance times a ratio.

    Its longest step is half the run's typical one, because Newton's method or the longest step may limit both runs at
    any tolerance. It takes at least `REPETITION_FEWEST` steps, resolves the vibrations of flexible links, or has twice
    as many rigid segments. Films with history choose their film step, also where the experiment gives a constant one:
    a constant one that is longer than an impact has nearly the same error as half of it.
    """
    accuracy, times = system.settings.accuracy * ratio, run.time
    step = float(min(REPETITION_SHORTER * _typical_step(times), times[-1] / REPETITION_FEWEST))
    finer = {"solver.accuracy": accuracy, "solver.max_step": step} | _finer_films(system)
    if len(system.tree.shape_frequencies):
        if has_segments(system, run.columns):
            finer |= _finer_substitutes(system)
        elif accuracy >= _FINEST:
            finer |= {"solver.accuracy": min(accuracy, _LOOSEST), "solver.resolve_vibrations": True}
    return system.replaced(finer)


def _finer_films(system: System) -> dict[str, float]:
    """Return the settings of films with history that are finer than those of a system."""
    finer = dict[str, float]()
    for name, history in _histories(system).items():
        accuracy = FILM_ACCURACY if history.accuracy is None else history.accuracy
        finer[f"joints.{name}.history.step"] = REPETITION_SHORTER * system.film_steps[name]
        finer[f"joints.{name}.history.accuracy"] = REPETITION_FILM * accuracy
    return finer


def finer_cells(system: System) -> dict[str, list[int]]:
    """Return twice as many cells in each direction of each film with history, by path."""
    return {
        f"joints.{name}.history.cells": [
            min(REPETITION_CELLS * count, most) for count, (_, most) in zip(history.cells, FILM_CELLS, strict=True)
        ]
        for name, history in _histories(system).items()
    }


def _histories(system: System) -> dict[str, FilmHistory]:
    """Return the histories of films, by joint."""
    found = {name: system.joints[name].history for name in system.film_steps}
    return {name: history for name, history in found.items() if history is not None}


def _finer_substitutes(system: System) -> dict[str, float]:
    """Return the values that refine what the Drake engine runs instead of elements."""
    found = dict[str, float]()
    for kind, name, keys in all_elements_of(system.parts):
        if kind.substitute is not None and kind.deforms(keys):
            found |= {f"{kind.path(name)}.{key}": value for key, value in kind.substitute.refined(keys).items()}
    return found


def _typical_step(times: Array) -> float:
    """Median of the steps [s], weighted by their length: longer ones cover half of the time."""
    steps = np.sort(np.diff(times))
    covered = np.cumsum(steps)
    return float(steps[np.searchsorted(covered, 0.5 * covered[-1])])
