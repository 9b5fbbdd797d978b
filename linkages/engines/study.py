"""One experiment from start to end: the run, the ideal linkage beside it, and how far the run can be trusted."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from linkages import engines
from linkages.errors import Status
from linkages.model.experiment import Experiment, check
from linkages.model.mechanism import Mechanism
from linkages.results.extremes import extremes, integral
from linkages.results.impacts import Impact, impacts
from linkages.results.trajectory import Trajectory, sample
from linkages.system.assembly import Assembly, AssemblyError, IdealMotion, assemble
from linkages.system.loads import load_names

Progress = Callable[[float], None]

_TIGHTER = 0.1  # ratio of tolerances between a run and the run that estimates its error


def simulate(
    mechanism: Mechanism, experiment: Experiment, engine: str = "drake", progress: Progress | None = None
) -> Trajectory:
    """Run an experiment.

    Parameters
    ----------
    mechanism, experiment
        From `linkages.load`.
    engine : str
        One of `linkages.engines.ENGINES`.
    progress : callable, optional
        Called with the simulated time [s] after every step.

    Returns
    -------
    Trajectory
        Up to the end, or to where the run failed (`Trajectory.status`).

    Raises
    ------
    InputError
        If mechanism and experiment do not fit each other.
    AssemblyError
        If the linkage cannot be assembled at t = 0.
    """
    run = engines.engine(engine)
    check(mechanism, experiment)
    trajectory: Trajectory = run(mechanism, experiment, progress)
    return trajectory


@dataclass(frozen=True)
class Study:
    """A run with what is needed to judge it.

    Attributes
    ----------
    run : Trajectory
    ideal : Trajectory
        The same linkage with every joint ideal: exact kinematics and inverse dynamics where the drives determine
        the motion, a run of its own otherwise.
    tighter : Trajectory or None
        The run repeated at a ten times tighter tolerance.
    """

    mechanism: Mechanism
    experiment: Experiment
    assembly: Assembly
    run: Trajectory
    ideal: Trajectory
    tighter: Trajectory | None

    @cached_property
    def contacts(self) -> list[Impact]:
        """Every contact of the run."""
        return impacts(self.run, touching(self.experiment, self.run))


def study(
    mechanism: Mechanism,
    experiment: Experiment,
    engine: str = "drake",
    error_estimate: bool = True,
    progress: Callable[[str], Progress] | None = None,
) -> Study:
    """Run an experiment, its ideal counterpart and, if asked, the run at a tighter tolerance.

    Parameters
    ----------
    error_estimate : bool
        Whether to repeat the run at a ten times tighter tolerance.
    progress : callable, optional
        Called with the name of each stage; returns the stage's progress function.

    Raises
    ------
    InputError, AssemblyError
        As `simulate`.
    """
    check(mechanism, experiment)
    assembly = assemble(mechanism, experiment)
    stage = progress or (lambda name: lambda time: None)
    run = simulate(mechanism, experiment, engine, stage("run"))
    tighter = None
    if error_estimate and run.status is Status.OK:
        accuracy = experiment.solver.accuracy * _TIGHTER
        finer = experiment.replaced({"solver.accuracy": accuracy})
        tighter = simulate(mechanism, finer, engine, stage("error estimate"))
    return Study(
        mechanism, experiment, assembly, run, ideal(mechanism, experiment, engine, assembly), tighter
    )


def ideal(
    mechanism: Mechanism, experiment: Experiment, engine: str = "drake", assembly: Assembly | None = None
) -> Trajectory:
    """Motion of the linkage with every joint ideal; see `Study.ideal`."""
    without_offsets = experiment.ideal()
    if assembly is None or not assembly.determinate:
        assembly = assemble(mechanism, without_offsets)
    if not assembly.determinate:
        return simulate(mechanism, without_offsets, engine)
    motion = IdealMotion(assembly, experiment)
    if len(motion.times) < 2:
        raise AssemblyError(motion.status, "the ideal linkage cannot leave its start position")
    return sample(motion.times, motion.evaluate, motion.status, {"engine": "kinematics"})


def summarize(study: Study, engine: str) -> dict[str, Any]:
    """Make the contents of ``summary.json``: SI units; see docs/outputs.md."""
    numbers = _numbers(study.experiment, study.mechanism, study.run, study.contacts)
    ideal_numbers = _numbers(study.experiment, study.mechanism, study.ideal)
    error = {}
    if study.tighter is not None and study.tighter.status is Status.OK:
        finer = _numbers(study.experiment, study.mechanism, study.tighter)
        error = {
            key: abs(value - dict(_peaks(finer))[key])
            for key, value in _peaks(numbers)
            if key in dict(_peaks(finer))
        }
    return {
        "engine": engine,
        "duration": float(study.run.time[-1]),
        "status": study.run.status.value,
        "mechanism": {
            "name": study.mechanism.name,
            "mobility": study.assembly.mobility,
            "driven": [*study.assembly.tree.driven, *study.assembly.tree.powered],
            "cut": {"play": list(study.assembly.tree.play), "ideal": list(study.assembly.tree.loops)},
            "quality": None if np.isnan(study.assembly.quality) else study.assembly.quality,
            "loop_error": study.run.provenance.get("loop_error", 0.0),
        },
        **numbers,
        "ideal": {"status": study.ideal.status.value, **ideal_numbers},
        "error": error,
        "provenance": {
            "versions": versions(),
            "experiment": study.experiment.model_dump(exclude_unset=True, exclude_none=True)
            | {"file": study.experiment.source.name},
            "sources": study.experiment.sources,
            "run": {key: value for key, value in study.run.provenance.items() if key != "wall_time"},
            "wall_time": study.run.provenance["wall_time"],
        },
    }


def touching(experiment: Experiment, trajectory: Trajectory) -> list[str]:
    """Contacts of a run that can touch: joints, and the corners of guides."""
    names = [name for name in experiment.play for name in (name, *(f"{name}.corner{i}" for i in range(1, 5)))]
    return [name for name in names if f"{name}.penetration" in trajectory.columns]


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that determine the numbers."""
    packages = ("linkages", "drake", "numba", "numpy", "scipy")
    result = {"python": platform.python_version()}
    for package in packages:
        try:
            result[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            result[package] = "not installed"
    return result


def _numbers(
    experiment: Experiment, mechanism: Mechanism, trajectory: Trajectory, touches: Sequence[Impact] = ()
) -> dict[str, Any]:
    """Collect outputs, joints, drives and applied loads of one trajectory with these contacts."""
    joints = [joint.name for joint in mechanism.joints]
    play = [name for name in experiment.play if f"{name}.eccentricity_ratio" in trajectory.columns]
    wanted = [
        *experiment.outputs,
        *(f"{name}.force" for name in joints),
        *(f"{name}.eccentricity_ratio" for name in play),
        *(f"{name}.torque" for name in experiment.drives),
        *(f"{name}.{_effort(table)}" for table, name in load_names(experiment)),
    ]
    found = extremes(trajectory, wanted)
    result: dict[str, Any] = {"outputs": {}, "joints": {}, "drives": {}}
    for name in experiment.outputs:
        value = found[name]
        result["outputs"][name] = {"min": value.min, "max": value.max, "peak": value.peak}
    for name in joints:
        force = found[f"{name}.force"]
        entry: dict[str, Any] = {"model": "ideal", "force": {"peak": force.peak, "time": force.time}}
        if name in play:
            entry["model"] = experiment.joints[name].model
            entry["eccentricity_ratio"] = {"peak": found[f"{name}.eccentricity_ratio"].peak}
            contacts = [row for row in touches if row.joint.partition(".")[0] == name]
            entry["contact_fraction"] = _covered(contacts) / float(np.ptp(trajectory.time))
            entry["impacts"] = len(contacts)
        result["joints"][name] = entry
    for name in experiment.drives:
        power = trajectory[f"{name}.torque"] * trajectory[f"{name}.rate"]
        torque = found[f"{name}.torque"]
        result["drives"][name] = {"torque": {"peak": torque.peak}, "work": integral(trajectory, power)}
    for table, name in load_names(experiment):
        effort = _effort(table)
        peak, work = found[f"{name}.{effort}"].peak, integral(trajectory, trajectory[f"{name}.power"])
        result.setdefault("loads", {})[name] = {effort: {"peak": peak}, "work": work}
    return result


def _effort(table: str) -> str:
    """Quantity by which a kind of applied load is judged."""
    return "torque" if table in ("torques", "torsion_springs") else "force"


def _covered(rows: list[Impact]) -> float:
    """Time in which at least one of the contacts lasts [s]."""
    total, until = 0.0, -np.inf
    for row in sorted(rows, key=lambda row: row.start):
        end = row.start + row.duration
        total += max(0.0, end - max(row.start, until))
        until = max(until, end)
    return total


def _peaks(numbers: dict[str, Any]) -> list[tuple[str, float]]:
    """Every peak of a summary with its key: ``slider7.ax.peak``, ``A.force.peak``."""
    result = [(f"{name}.peak", value["peak"]) for name, value in numbers["outputs"].items()]
    for name, entry in numbers["joints"].items():
        for key in ("force", "eccentricity_ratio"):
            if key in entry:
                result.append((f"{name}.{key}.peak", entry[key]["peak"]))
    result += [(f"{name}.torque.peak", value["torque"]["peak"]) for name, value in numbers["drives"].items()]
    for name, entry in numbers.get("loads", {}).items():
        result += [(f"{name}.{key}.peak", entry[key]["peak"]) for key in ("force", "torque") if key in entry]
    return result
