"""Comparison of both engines on one experiment: differences up to the horizon.

With contacts solutions diverge: a difference grows by a constant factor in every impact, and two runs of *one* engine
at different tolerances agree only up to a horizon. Differences are computed up to the earlier horizon of the two
engines; beyond it they would be meaningless.

Drake has no flexible links: its machine has rigid segments. So the compiled engine runs this machine too, and the
differences are those of the engines. What the segments change is computed apart, in the compiled engine.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from linkages.base.arguments import validated
from linkages.base.brief import Brief
from linkages.base.errors import Status, TimeOverError
from linkages.elements.analysis import Analysis
from linkages.engines import ENGINES, check_engine
from linkages.engines.assessment import simulate
from linkages.explore.numerics import COMPARE_FEWEST, COMPARE_IMPACTS
from linkages.results.assessment import touching
from linkages.results.divergence import dense, horizon
from linkages.results.impacts import Impact, impacts
from linkages.results.shape import RunWarning
from linkages.results.soundness import Soundness
from linkages.results.trajectory import TimeReport, Trajectory
from linkages.results.warnings import warnings_of_run
from linkages.system import System
from linkages.system.rigid_segments import segmented

_RUN, _LOOSER, _HORIZON = 0.5, 0.85, 0.95  # parts of the limit of time after which these stages end


@dataclass(frozen=True)
class Difference:
    """Largest difference of one quantity.

    Attributes
    ----------
    max_difference : float
        In the quantity's unit.
    time : float
        Time of the difference [s].
    peak : float
        Peak of the quantity in either run.
    """

    max_difference: float
    time: float
    peak: float

    @property
    def relative(self) -> float:
        """Return the largest difference over the peak."""
        return self.max_difference / self.peak if self.peak > 0.0 else 0.0


@dataclass(frozen=True, repr=False)
class Comparison(Brief):
    """Two engines on one experiment; made by `compare`.

    Attributes
    ----------
    runs : dict of str to Trajectory
        By engine.
        With flexible links those of the machine with rigid segments, in both engines.
    horizons : dict of str to float
        Time up to which an engine's runs at two tolerances agree, or the run's end without contacts, by engine [s].
    differences : dict of str to Difference
        By column name, up to `until`.
    segments : dict of str to Difference
        Differences of the machines with rigid segments and with flexible links, both in the compiled engine, up to
        `until`; empty without flexible links.
    late : bool
        Whether the limit of time ended a run, or the search for its horizon.
    meaningless : frozenset of str
        Columns without a difference, such as forces in a singular position.
    contacts : list of (Impact, Impact)
        First contacts of each joint up to `until`, in pairs of both engines.
    warnings : dict of str to list of RunWarning
        As in ``summary.json``, by engine.
    """

    runs: dict[str, Trajectory]
    horizons: dict[str, float]
    differences: dict[str, Difference]
    meaningless: frozenset[str]
    contacts: list[tuple[Impact, Impact]]
    warnings: dict[str, list[RunWarning]]
    segments: dict[str, Difference] = field(default_factory=dict)
    late: bool = False

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{' and '.join(self.runs)}, compared up to {self.until:g} s"
        rows = {f"run of {name}": run._facts()[0] for name, run in self.runs.items()}
        for name, one in self.differences.items():
            rows[name] = f"{one.relative:.1e} of the peak at {one.time:g} s"
        return line, rows

    @property
    def until(self) -> float:
        """Return the time up to which the engines are compared [s]."""
        return min(self.horizons.values())

    @property
    def parted(self) -> bool:
        """Check whether the horizon is before the end of the runs, and no limit of time."""
        return bool(not self.late and self.until < min(run.time[-1] for run in self.runs.values()))


@validated
def compare(
    system: System, progress: Callable[[str], TimeReport] | None = None, limit: float | None = None
) -> Comparison:
    """Run an experiment on both engines and compare them.

    With contacts each engine also runs at a ten times looser tolerance, which gives the horizon.

    Parameters
    ----------
    system : System
    progress : callable, optional
        Called with the name of each stage; returns the stage's progress function.
    limit : float, optional
        Longest time of the runs [s]: what they have reached by then is compared. Default: none.

    Returns
    -------
    Comparison
        Both runs, their horizons, the differences up to the earlier one, pairs of the first contacts.

    Raises
    ------
    InputError, AssemblyError
        See `linkages.engines.assessment.simulate`.

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
    for engine in ENGINES:
        check_engine(engine)
    system.check_analysis(Analysis.DRAKE)
    told = progress or (lambda name: lambda time: None)
    stages = _Stages(told, clock.monotonic(), np.inf if limit is None else limit)
    model = segmented(system)
    runs, horizons = {}, {}
    for engine in ("compiled", "drake"):
        runs[engine] = stages.run(engine, model, engine, _RUN)
        horizons[engine] = float(runs[engine].time[-1])
        if system.can_touch:
            other = stages.run(f"{engine}, looser", looser(model), engine, _LOOSER, horizons[engine])
            horizons[engine] = stages.horizon(f"{engine}, horizon", runs[engine], other, system)
    until, every = min(horizons.values()), names(system)
    whole = stages.run("without segments", system, "compiled", 1.0, until) if model is not system else None
    told("differences")
    sound = {engine: Soundness.of_run(system, run) for engine, run in runs.items()}
    none = frozenset().union(*(one.meaningless(every) for one in sound.values())).intersection(every)
    given = [name for name in every if name not in none]
    found = differences(runs["compiled"], runs["drake"], given, until)
    of_segments = differences(runs["compiled"], whole, given, min(until, whole.time[-1])) if whole else {}
    met = {engine: impacts(run, touching(system)) for engine, run in runs.items()}
    warnings = {engine: warnings_of_run(system, sound[engine], met[engine]) for engine in runs}
    pairs = _contacts(met["compiled"], met["drake"], until)
    return Comparison(runs, horizons, found, none, pairs, warnings, of_segments, stages.late)


class _Stages:
    """The runs of a comparison, each of which ends at its part of a limit of time [s] from the start on."""

    def __init__(self, tell: Callable[[str], TimeReport], start: float, limit: float) -> None:
        self._tell, self._start, self._limit = tell, start, limit
        self.late = False

    def run(self, name: str, system: System, engine: str, part: float, until: float = np.inf) -> Trajectory:
        """Run a system up to a part of the limit, or a time of the run [s]; KeyboardInterrupt after a signal."""
        stage = self._stage(name, part, until)
        run = simulate(system, engine, stage)
        if run.status is Status.INTERRUPTED:  # a comparison with a part of a run would look like a whole one
            raise KeyboardInterrupt
        self.late |= stage.late
        return run

    def horizon(self, name: str, run: Trajectory, other: Trajectory, system: System) -> float:
        """Return the horizon of two runs, or the time up to which the limit let them be compared [s]."""
        stage = self._stage(name, _HORIZON)
        try:
            return horizon(run, other, system, stage)
        except TimeOverError:
            self.late = True
            return stage.reached

    def _stage(self, name: str, part: float, until: float = np.inf) -> _Stage:
        return _Stage(self._tell(name), self._start + part * self._limit, until)


class _Stage:
    """Progress of a stage, which ends it at a time of the clock, or at one of the run [s]."""

    def __init__(self, tell: TimeReport, end: float, until: float) -> None:
        self._tell, self._end, self._until = tell, end, until
        self.reached, self.late, self._calls = 0.0, False, 0

    def __call__(self, time: float) -> None:
        self.reached, self._calls = time, self._calls + 1
        self._tell(time)
        self.late = clock.monotonic() > self._end and self._calls > COMPARE_FEWEST
        if self.late or time > self._until:
            raise TimeOverError


def looser(system: System) -> System:
    """Return the same system with a ten times looser accuracy."""
    return system.replaced({"solver.accuracy": min(10.0 * system.settings.accuracy, 0.1)})


def names(system: System) -> list[str]:
    """Return the compared columns: outputs, force and eccentricity of clearance joints, drive torques."""
    joints, drives = system.play, system.drives
    of_joints = [f"{joint}.{what}" for joint in joints for what in ("force", "eccentricity_ratio")]
    return [*dict.fromkeys([*system.settings.outputs, *of_joints, *(f"{drive}.torque" for drive in drives)])]


def differences(run: Trajectory, other: Trajectory, columns: list[str], until: float) -> dict[str, Difference]:
    """Compute the largest differences of columns up to a time [s] at `other`'s steps; `run` has dense output."""
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


def revolutions(system: System, time: float) -> float | None:
    """Return the revolutions of the first drive with constant speed in a time; None without one."""
    for drive in system.drives.values():
        if drive.prescribed and drive.speed:
            return abs(drive.speed) * time / (2.0 * np.pi)
    return None


def _contacts(ours: Sequence[Impact], others: Sequence[Impact], until: float) -> list[tuple[Impact, Impact]]:
    """Pair the first contacts of each joint."""
    result = []
    for joint in dict.fromkeys(impact.joint for impact in ours):
        pairs = zip(*([impact for impact in found if impact.joint == joint] for found in (ours, others)), strict=False)
        ended = [pair for pair in pairs if all(row.start + row.duration < until for row in pair)]
        result += ended[:COMPARE_IMPACTS]
    return sorted(result, key=lambda pair: pair[0].start)
