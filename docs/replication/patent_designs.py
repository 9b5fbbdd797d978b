"""Runs of the linkages that the patent claims: nominal and recorded designs of its studies, side by side."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from linkages import System, Trajectory, extremes, ideal, impacts, simulate
from linkages.results.impacts import Impact
from linkages.results.steady_state import common_period
from optim import Evaluator, Study, find_study, load_study
from replication.claims import change
from replication.recorded import Array, load_record

#: Start angles that no search has seen [rad].
UNSEEN = 0.2 + 2.0 * np.pi * np.arange(10) / 10.0
RESOLUTION = 1e-5  # s: a contact takes five times as long
SETTLED = 0.05  # s: half a revolution, after the ramp of the drive


@dataclass(frozen=True)
class Pair:
    """A shipped study's nominal design and its recorded one, run by the compiled engine."""

    name: str
    #: Start angle of the drives, as part of their common period.
    part: float = 0.0

    @property
    def study(self) -> Study:
        """The study that the record answers."""
        return study(self.name)

    @cached_property
    def designs(self) -> Array:
        """Nominal and recorded values of the variables, (2, n)."""
        return np.array([self.study.nominal, load_record(self.name).design(self.study)])

    @cached_property
    def systems(self) -> list[System]:
        """The linkage with either."""
        systems = [self.study.system(design) for design in self.designs]
        return [one.replaced(start_angles(one, self.part)) for one in systems] if self.part else systems

    @cached_property
    def runs(self) -> list[Trajectory]:
        """Runs with play."""
        return [simulate(system, "compiled") for system in self.systems]

    @cached_property
    def ideals(self) -> list[Trajectory]:
        """The ideal motions."""
        return [ideal(system, "compiled") for system in self.systems]

    @property
    def gain(self) -> float:
        """Change of the study's objective [%]."""
        return objective_change(self.study, self.designs)

    @property
    def joints(self) -> tuple[str, ...]:
        """Clearance joints."""
        return tuple(self.systems[0].experiment.joints)

    @property
    def lengths(self) -> str:
        """Recorded values of the variables, which are lengths [mm]."""
        return ", ".join(f"{1e3 * value:.0f}" for value in self.designs[1])

    @cached_property
    def impacts(self) -> list[list[Impact]]:
        """Contacts in either run."""
        return [impacts(run, self.joints) for run in self.runs]

    def peaks(self, output: str, perfect: bool = False) -> list[float]:
        """Largest magnitudes of an output in either run, or of the ideal linkages."""
        return [extremes(run, [output])[output].peak for run in (self.ideals if perfect else self.runs)]

    def change(self, output: str) -> float:
        """Change of an output's largest magnitude [%]."""
        return change(*self.peaks(output))

    def times_above_half(self, output: str) -> list[int]:
        """How often the departure from the ideal linkage rises above half of the nominal run's largest."""
        departures = []
        for run, perfect in zip(self.runs, self.ideals, strict=True):
            times = RESOLUTION * (np.arange(round(float(run.time[-1]) / RESOLUTION)) + 0.5)
            real, exact = (motion.evaluate(times)[output] for motion in (run, perfect))
            departures.append(np.abs(real - exact))
        level = 0.5 * departures[0].max()
        return [int(np.sum(np.diff((departure > level).astype(int)) > 0)) for departure in departures]


@cache
def study(name: str) -> Study:
    """Load a shipped study."""
    return load_study(find_study(name))


def period(system: System) -> float:
    """Give the common period of the drives [s]."""
    found = common_period(system)
    assert found is not None  # all drives of the patent's studies turn at speeds of simple ratios
    return found


def start_angles(system: System, part: float) -> dict[str, float]:
    """Give the overrides that start the drives at a part of their common period [rad]."""
    turn = part * period(system)
    return {f"drives.{key}.angle": drive.speed * turn for key, drive in system.experiment.drives.items()}


@cache
def pair(name: str) -> Pair:
    """Give the nominal and the recorded design of a shipped study."""
    return Pair(name)


def motions(name: str) -> list[tuple[dict[str, Array], dict[str, Array]]]:
    """Columns with clearance, and ideal, at the same times; nominal and recorded lengths."""
    found = pair(name)
    return [(run.columns, perfect.evaluate(run.time)) for run, perfect in zip(found.runs, found.ideals, strict=True)]


def spans(pair: Pair, output: str) -> list[tuple[float, float]]:
    """Least and largest value of an ideal linkage's output after the ramp of the drive, nominal and recorded."""
    times = np.linspace(SETTLED, pair.systems[0].experiment.duration, 4001)
    found = [motion.evaluate(times)[output] for motion in pair.ideals]
    return [(float(values.min()), float(values.max())) for values in found]


def started_at(given: Study, angle: float) -> Study:
    """Return the study with another start angle of the crank [rad]."""
    return given.replaced(lambda system: {"drives.O.angle": angle})


def objectives(given: Study, designs: Array) -> Array:
    """Objectives of designs in a variant of a study, (m,)."""
    return Evaluator(given)(designs).objectives[:, 0]


def objective_change(given: Study, designs: Array) -> float:
    """Change of the objective from the first design to the second [%]."""
    return change(*objectives(given, designs))
