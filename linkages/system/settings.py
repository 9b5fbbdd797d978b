"""Settings of a run: how long, how accurate, by which method, and which of its results are asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from linkages.input.functions.recorded_tables import DataTable
from linkages.input.model.experiment import Experiment


@dataclass(frozen=True)
class Settings:
    """Settings of a run, which change nothing of the machine.

    Attributes
    ----------
    duration : float
        Simulated time [s].
    start : str
        "centred" or "equilibrium": the places of journals at t = 0.
    integrator : str or None
        Method of integration; None: the engine's choice.
    accuracy : float
        Relative accuracy.
    max_step : float or None
        Largest step [s]; None: the engine's choice.
    max_steps : int or None
        Largest number of steps; None: the engine's choice.
    resolve_vibrations : bool
        Whether implicit methods follow small vibrations of flexible links.
    stabilisation : float
        Decay rate of errors of drives and loops on Drake [1/s].
    outputs : tuple of str
        Requested outputs.
    report : str
        "steady" or "whole": the part of the run that tables give first.
    report_from : float or None
        Start of the part that tables give instead [s].
    windows : mapping of str to (float, float)
        Start and end of further parts with separate results [s].
    data : DataTable or None
        Measured curves for comparison with the run.
    """

    duration: float
    start: str
    integrator: str | None
    accuracy: float
    max_step: float | None
    max_steps: int | None
    resolve_vibrations: bool
    stabilisation: float
    outputs: tuple[str, ...]
    report: str
    report_from: float | None
    windows: Mapping[str, tuple[float, float]]
    data: DataTable | None


def settings_of(experiment: Experiment) -> Settings:
    """Take the settings of a run from an experiment."""
    solver = experiment.solver
    return Settings(
        duration=experiment.duration,
        start=experiment.start,
        integrator=solver.integrator,
        accuracy=solver.accuracy,
        max_step=solver.max_step,
        max_steps=solver.max_steps,
        resolve_vibrations=solver.resolve_vibrations,
        stabilisation=solver.stabilisation,
        outputs=tuple(experiment.outputs),
        report=experiment.report,
        report_from=experiment.report_from,
        windows={name: (window.start, window.end) for name, window in experiment.windows.items()},
        data=experiment.data,
    )
