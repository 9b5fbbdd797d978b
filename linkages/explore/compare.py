"""Both engines on the same experiment: how far apart they are, and how long that is a fair question.

Where joints touch, solutions part: a difference grows by the same factor in every impact, and two runs of *one* engine
at different tolerances agree up to a horizon and no further. Differences are taken up to the horizon of the engine that
parts from itself first; beyond it they would say nothing about either.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from linkages.brief import Brief
from linkages.engines.study import simulate
from linkages.model.experiment import Experiment
from linkages.results.divergence import PARTED, dense, horizon
from linkages.results.impacts import Impact, impacts
from linkages.results.summary import meaningless_of, touching, warnings_of
from linkages.results.trajectory import Progress, Trajectory
from linkages.system import System

__all__ = ["PARTED", "Comparison", "Difference", "compare", "differences", "horizon", "looser", "names", "revolutions"]


_IMPACTS = 2  # contacts of each joint that are compared one by one


@dataclass(frozen=True)
class Difference:
    """Difference in one quantity: the largest over time, when [s], and the quantity's peak in either run."""

    max_difference: float
    time: float
    peak: float

    @property
    def relative(self) -> float:
        """Largest difference in parts of the peak."""
        return self.max_difference / self.peak if self.peak > 0.0 else 0.0


@dataclass(frozen=True, repr=False)
class Comparison(Brief):
    """Two engines on one experiment: runs and horizons by engine, differences by name of the column.

    An engine's horizon is the time up to which its runs at two tolerances stay together [s]; the run's end if
    nothing touches. Differences and contacts are those up to `until`; contacts are the first of each joint,
    in pairs of both engines. Columns that are meaningless, as forces in a singular position, have no difference.
    Warnings, by engine, are those of its run as in ``summary.json``.
    """

    runs: dict[str, Trajectory]
    horizons: dict[str, float]
    differences: dict[str, Difference]
    meaningless: frozenset[str]
    contacts: list[tuple[Impact, Impact]]
    warnings: dict[str, list[dict[str, Any]]]

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{' and '.join(self.runs)}, compared up to {self.until:g} s"
        rows = {f"run of {name}": run._facts()[0] for name, run in self.runs.items()}
        for name, one in self.differences.items():
            rows[name] = f"{one.relative:.1e} of the peak at {one.time:g} s"
        return line, rows

    @property
    def until(self) -> float:
        """Time up to which the engines are compared [s]."""
        return min(self.horizons.values())

    @property
    def parted(self) -> bool:
        """Whether the horizon lies before the end of the runs."""
        return bool(self.until < min(run.time[-1] for run in self.runs.values()))


def compare(system: System, progress: Callable[[str], Progress] | None = None) -> Comparison:
    """Run an experiment on both engines and compare them.

    Each engine runs a second time, at a ten times looser tolerance, if joints can touch: that gives the horizon.

    Parameters
    ----------
    system : System
    progress : callable, optional
        Called with the name of each stage; returns the stage's progress function.

    Returns
    -------
    Comparison
        Both runs, their horizons, the differences up to the earlier one, the first contacts side by side.

    Raises
    ------
    InputError, AssemblyError
        As `linkages.engines.study.simulate`.

    Examples
    --------
    >>> import linkages
    >>> values = {"duration": 0.01, "solver.accuracy": 1e-9}
    >>> comparison = linkages.compare(linkages.load(linkages.find_file("seven_bar.toml"), values))
    >>> comparison.parted
    False
    >>> comparison.differences["A.force"].relative < 1e-4
    True
    """
    stage = progress or (lambda name: lambda time: None)
    runs, horizons = {}, {}
    for engine in ("compiled", "drake"):
        runs[engine] = simulate(system, engine, stage(engine))
        horizons[engine] = float(runs[engine].time[-1])
        if system.touching.any():
            other = simulate(looser(system), engine, stage(f"{engine}, looser"))
            horizons[engine] = horizon(runs[engine], other, system)
    until, every = min(horizons.values()), names(system)
    none = frozenset().union(*(meaningless_of(system, run, every) for run in runs.values()))
    given = [name for name in every if name not in none]
    found = differences(runs["compiled"], runs["drake"], given, until)
    met = {engine: impacts(run, touching(system)) for engine, run in runs.items()}
    warnings = {engine: warnings_of(system, run, met[engine]) for engine, run in runs.items()}
    return Comparison(runs, horizons, found, none, _contacts(met["compiled"], met["drake"], until), warnings)


def looser(system: System) -> System:
    """Return the same system with a ten times looser accuracy."""
    return system.replaced({"solver.accuracy": min(10.0 * system.experiment.solver.accuracy, 0.1)})


def names(system: System) -> list[str]:
    """Name what is compared: outputs, force and eccentricity of joints with play, drive torques."""
    joints, drives = system.experiment.play, system.experiment.drives
    of_joints = [f"{joint}.{what}" for joint in joints for what in ("force", "eccentricity_ratio")]
    return [*system.experiment.outputs, *of_joints, *(f"{drive}.torque" for drive in drives)]


def differences(run: Trajectory, other: Trajectory, columns: list[str], until: float) -> dict[str, Difference]:
    """Largest differences of columns up to a time [s], at the steps of `other`; `run` has dense output."""
    inside = other.time <= until
    times = other.time[inside]
    exact = dense(run)(times)
    result = {}
    for name in columns:
        pair = exact[name], other[name][inside]
        apart = np.abs(pair[0] - pair[1])
        worst = int(np.argmax(apart))
        result[name] = Difference(float(apart[worst]), float(times[worst]), float(np.abs(pair).max()))
    return result


def revolutions(experiment: Experiment, time: float) -> float | None:
    """Revolutions of the first drive of constant speed in a time; None if there is none."""
    for drive in experiment.drives.values():
        if drive.prescribed and drive.speed:
            return abs(drive.speed) * time / (2.0 * np.pi)
    return None


def _contacts(ours: Sequence[Impact], others: Sequence[Impact], until: float) -> list[tuple[Impact, Impact]]:
    """Pair the first contacts of each joint."""
    result = []
    for joint in dict.fromkeys(impact.joint for impact in ours):
        pairs = zip(*([impact for impact in found if impact.joint == joint] for found in (ours, others)), strict=False)
        ended = [pair for pair in pairs if all(row.start + row.duration < until for row in pair)]
        result += ended[:_IMPACTS]
    return sorted(result, key=lambda pair: pair[0].start)
