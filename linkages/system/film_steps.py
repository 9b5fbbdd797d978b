"""Longest steps of films with history, which are given or follow from the drives."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import FILM_ACCURACY, FilmHistory, JointModel

_FILM_STEPS = 200  # of a turn of the fastest drive
_LEAST_FORCE = 0.03  # force of a film whose errors count, over the forces that the drives need for all masses


def film_steps(experiment: Experiment, rate: float) -> dict[str, float]:
    """Return the longest film step of each clearance joint whose film has a history [s].

    `rate` is the largest one of a prescribed motion [rad/s]; InputError if no step is given and it is zero.
    """
    joints = {name: experiment.joints[name] for name in experiment.play}
    histories = {name: joint.history for name, joint in joints.items() if joint.has_history}
    return {name: _step(experiment, name, one, rate) for name, one in histories.items() if one is not None}


def _step(experiment: Experiment, name: str, history: FilmHistory, rate: float) -> float:
    if history.step is not None:
        return history.step
    if rate == 0.0:
        problem = "is missing: without a prescribed speed it has no default; give 1/200 turn [s], and an accuracy"
        raise InputError(experiment.source, f"joints.{name}.history.step", problem)
    return 2.0 * np.pi / (_FILM_STEPS * rate)


def with_film_step(experiment: Experiment, steps: Mapping[str, float], name: str) -> JointModel:
    """Return the model of a joint; a film with history has its longest step, and its accuracy if any."""
    model = experiment.joints[name]
    if name not in steps or model.history is None:
        return model
    accuracy = FILM_ACCURACY if model.history.step is None else None
    chosen = {"step": steps[name], "accuracy": model.history.accuracy or accuracy}
    return model.model_copy(update={"history": model.history.model_copy(update=chosen)})


def least_force(extent: float, rate: float, gravity: Array, mass: float) -> float:
    """Return the force of a film below which its errors do not count [N]; length [m] and rate [rad/s] of the motion."""
    return _LEAST_FORCE * (extent * rate**2 + float(np.linalg.norm(gravity))) * mass
