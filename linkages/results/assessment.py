"""An assessment: a run with its ideal linkage and its error estimate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from linkages.base.brief import Brief
from linkages.elements.machine import all_elements_of
from linkages.elements.outputs import Quantities, Source
from linkages.results import numerics
from linkages.results.characteristics import peak_columns
from linkages.results.derivatives import NONE
from linkages.results.divergence import apart
from linkages.results.films import JointHeat
from linkages.results.impacts import Impact, impacts
from linkages.results.measured import Measured, measured
from linkages.results.peak_errors import noise
from linkages.results.soundness import Soundness
from linkages.results.start_up import start_up
from linkages.results.steady_state import Motion, motion_of
from linkages.results.trajectory import Trajectory, values_at
from linkages.system import System


class Repeating(NamedTuple):
    """The part of a long run that repeats itself: its start, its cycle, and the end of its first cycles [s]."""

    since: float
    cycle: float
    settled: float

    def earlier(self, start: float, end: float) -> tuple[float, float]:
        """Return the part of the run that a part [s] repeats, up to `settled`."""
        ahead = self.cycle * np.ceil(max(end - self.settled, 0.0) / self.cycle)
        return min(start, max(start - ahead, self.since)), min(end - ahead, self.settled)


#: Factors of the smoothing of signals from data files in further runs, by name.
SMOOTHINGS = {"half": 0.5, "double": 2.0}


@dataclass(frozen=True, repr=False)
class Assessment(Brief):
    """A run with its ideal linkage and a run at a tighter tolerance; made by `linkages.assess`.

    Attributes
    ----------
    system : System
    engine : str
        Engine of the run.
    run : Trajectory
    ideal : Trajectory or None
        Motion of the linkage with every joint ideal and every link rigid; see `linkages.ideal`.
    tighter : Trajectory or None
        The run repeated at a ten times tighter tolerance; the first part of a long run, see `repeating`.
    heat : dict of str to JointHeat
        Heat balances of the joints that have one, by name.
    resmoothed : dict of str to Trajectory
        Runs with half and double smoothing of signals from data files, by the names in `SMOOTHINGS`.
    remeshed : Trajectory or None
        The run repeated with twice as many cells in each direction of its films with history, if it has any.
    no_ideal : str
        Why there is no ideal motion, such as two drives that only a gear's backlash lets move; empty if there is one.
    """

    system: System
    engine: str
    run: Trajectory
    ideal: Trajectory | None
    tighter: Trajectory | None
    heat: dict[str, JointHeat] = field(default_factory=dict)
    resmoothed: dict[str, Trajectory] = field(default_factory=dict)
    remeshed: Trajectory | None = None
    no_ideal: str = ""

    def _facts(self) -> tuple[str, dict[str, str]]:
        title = self.system.description.heading
        parts = {"run": self.run, "ideal": self.ideal, "tighter": self.tighter}
        rows = {name: part._facts()[0] if part is not None else "not computed" for name, part in parts.items()}
        return f"{title}; {self.engine} engine, {self.run.status.value}", rows

    @cached_property
    def contacts(self) -> list[Impact]:
        """Return all contacts of the run."""
        return impacts(self.run, touching(self.system))

    @cached_property
    def measured(self) -> dict[str, Measured]:
        """Compare the measured curves of the experiment with the run, by output."""
        return measured(self.system, self.run)

    @cached_property
    def motion(self) -> Motion:
        """Classify the motion at the end of the run."""
        return motion_of(self.system, self.run)

    @cached_property
    def repeating(self) -> Repeating | None:
        """Return how a long run repeats itself; None for shorter runs, and where errors may grow from cycle to cycle.

        A run is long if its periodic motion has more than a hundred cycles. The first twenty stand for all of them. The
        phase of free motions and of vibrating links drifts by errors of the run: their cycles are not alike.
        """
        motion, system = self.motion, self.system
        if motion.cycle is None or motion.since is None or not system.determinate or system.tree.deformable:
            return None
        start, end = motion.cycle
        lasts = numerics.ASSESSMENT_CYCLES * (end - start)
        found = Repeating(motion.since, end - start, motion.since + lasts)
        return found if end - motion.since > numerics.ASSESSMENT_LONG * lasts else None

    def latest(self) -> Assessment:
        """Return the assessment without the tighter run, of a long run its last twenty cycles alone: for figures."""
        if self.repeating is None:
            return replace(self, tighter=None)
        end = float(self.run.time[-1])
        span = end - numerics.ASSESSMENT_CYCLES * self.repeating.cycle, end
        ideal = self.ideal
        if ideal is not None and ideal.time[-1] >= end:
            ideal = ideal.within(*span)
        return replace(self, run=self.run.within(*span), ideal=ideal, tighter=None)

    @cached_property
    def start_up(self) -> float | None:
        """Return the time at which the start-up of the run ends [s]; None if no journal starts with free flight."""
        return start_up(self.system, self.run, self.ideal, self.contacts)

    @cached_property
    def difference(self) -> Trajectory:
        """Return the run minus the ideal motion at the run's steps, in the columns and the time that both have."""
        run, times, exact = self.run, self.run.time, {}
        if self.ideal is not None:
            times = times[times <= self.ideal.time[-1]]
            exact = values_at(self.ideal, times)
        columns = {name: run[name][: len(times)] - exact[name] for name in run if name in exact} | {"time": times}
        return replace(run, time=times, columns=columns, evaluate=None, sensitivity=NONE)

    @cached_property
    def windows(self) -> dict[str, tuple[float, float]]:
        """Return the time ranges with separate results, by name [s]; docs/summary_json.md lists them."""
        settings, end = self.system.settings, float(self.run.time[-1])
        asked = {**settings.windows}
        if settings.report_from is not None:
            asked["report"] = settings.report_from, settings.duration
        if self.motion.cycle is not None:
            asked["steady"] = self.motion.cycle
        elif self.start_up is not None:
            asked["later"] = self.start_up, end
        return {name: (start, min(stop, end)) for name, (start, stop) in asked.items() if start < end}

    @property
    def counted_from(self) -> float:
        """Return the time from which the reported differences from ideal joints count [s]."""
        start, _ = self.windows.get(self.reported, (0.0, 0.0))
        return max(start, self.taken_up) if start < self.difference.time[-1] else self.taken_up

    @property
    def taken_up(self) -> float:
        """Return the time at which centred journals have taken up their load [s]."""
        times = self.difference.time
        return float(times[0] + numerics.ASSESSMENT_TAKEN_UP * np.ptp(times))

    @property
    def reported(self) -> str:
        """Return the name of the window that tables show first, or "whole"."""
        settings = self.system.settings
        if settings.report == "whole" and settings.report_from is None:
            return "whole"
        wanted = ("report",) if settings.report_from is not None else ("steady", "later")
        return next((name for name in wanted if name in self.windows), "whole")

    @property
    def reported_span(self) -> tuple[float, float]:
        """Return begin and end of the part that tables, derivatives and cases of loads are about [s]."""
        return self.windows.get(self.reported, (float(self.run.time[0]), float(self.run.time[-1])))

    @cached_property
    def sound(self) -> Soundness:
        """Return where numbers of the run have no meaning."""
        return Soundness.of_run(self.system, self._early(self.run))

    @cached_property
    def ideal_sound(self) -> Soundness | None:
        """Return where numbers of the ideal motion have no meaning."""
        return None if self.ideal is None else Soundness.of_ideal(self.system, self._early(self.ideal))

    def _early(self, motion: Trajectory) -> Trajectory:
        """Return the first part of a long motion that repeats itself, whose samples are close to each other."""
        if self.repeating is None or motion.time[-1] <= self.repeating.settled:
            return motion
        return motion.within(float(motion.time[0]), self.repeating.settled)

    @cached_property
    def meaningless(self) -> frozenset[str]:
        """Return the columns of the run with meaningless peaks."""
        return self.sound.meaningless(_judged(self.system))

    @cached_property
    def ideal_meaningless(self) -> frozenset[str]:
        """Return the columns of the ideal motion with meaningless peaks."""
        sound = self.ideal_sound
        return frozenset() if sound is None else sound.meaningless(_judged(self.system))

    @cached_property
    def noise(self) -> dict[str, float]:
        """Return the rounding level of the run's columns."""
        return noise(self.system, [name for name in self.run.columns if name != "time"])

    @cached_property
    def apart(self) -> tuple[float, float] | None:
        """Return the times of divergence and final convergence of the run and the tighter one [s], or None."""
        run, tighter = self.run, self.tighter
        if tighter is None or not run.evaluate:
            return None
        return apart(run, tighter, self.system, 1 + len(tighter.time) // numerics.COMPARED)


def touching(system: System) -> list[str]:
    """Return the contacts that can touch: joints, corners of guides, flanks, prismatic stops, points at lines."""
    parts, slides = all_elements_of(system.parts), system.slides
    turning = {name for kind, name, keys in parts if _gives_torque(kind.outputs_of(keys, slides))}
    able = zip(system.contacts, system.touching, strict=True)
    return [label for (_, label), one in able if one and label not in turning]


def _gives_torque(outputs: Sequence[Quantities]) -> bool:
    """Tell whether an element is a contact with a torque, as a revolute stop is."""
    return any(one.source is Source.CONTACT and one.effort == "torque" for one in outputs[:1])


def _judged(system: System) -> list[str]:
    """Return the columns that a singular position can make meaningless: outputs, and peaks except of loads."""
    bounded = {name for _, name in system.acting if name not in system.tree.coupled}
    peaks = [column for column in peak_columns(system) if not column.endswith(".tilting_moment")]
    return [*system.settings.outputs, *(column for column in peaks if column.rpartition(".")[0] not in bounded)]
