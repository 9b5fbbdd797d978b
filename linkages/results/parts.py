"""Parts of an assessment: the whole run or a window, with the numbers of its motions, their differences and errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from linkages.base.errors import Status
from linkages.results import numerics
from linkages.results.assessment import Assessment
from linkages.results.characteristics import numbers
from linkages.results.extremes import peaks
from linkages.results.peak_errors import errors
from linkages.results.shape import Difference, Numbers
from linkages.results.trajectory import Trajectory


@dataclass(frozen=True)
class Part:
    """The motions of an assessment between two times [s]; `whole` is the whole run if this is a window of it."""

    assessment: Assessment
    start: float
    end: float
    whole: Part | None = None

    @cached_property
    def run(self) -> Trajectory:
        """Return the run."""
        return _within(self.assessment.run, self.start, self.end)

    @cached_property
    def numbers(self) -> Numbers:
        """Collect the numbers of the run, with the heat balances of the whole one and the differences."""
        assessment = self.assessment
        found = numbers(assessment.system, self.run, assessment.meaningless, assessment.contacts)
        heats = {} if self.whole is not None else assessment.heat
        joints = {name: found.joints[name].model_copy(update={"heat": one.numbers}) for name, one in heats.items()}
        return found.model_copy(update={"joints": found.joints | joints, "difference": self.difference})

    @cached_property
    def ideal(self) -> Numbers | None:
        """Collect the numbers of the ideal motion: of the whole one, if it ends before the window; None without one."""
        ideal, unknown = self.assessment.ideal, self.assessment.ideal_meaningless
        if ideal is None:
            return None
        if self.whole is None:
            return numbers(self.assessment.system, ideal, unknown)
        if ideal.time[-1] < self.end:
            return self.whole.ideal
        return numbers(self.assessment.system, ideal.within(self.start, self.end), unknown)

    @cached_property
    def difference(self) -> dict[str, Difference]:
        """Find the largest difference of outputs and forces of clearance joints from the ideal motion, after the start.

        Its share is the part of the ideal output's range or of the ideal force's peak, None if that is rounding.
        Differences that are rounding are left out.
        """
        assessment, system = self.assessment, self.assessment.system
        if self.ideal is None or not (system.play or system.tree.deformable):
            return {}
        apart, unknown = assessment.difference, assessment.meaningless | assessment.ideal_meaningless
        names = [*system.settings.outputs, *(f"{name}.force" for name in system.play)]
        begin = max(self.start, assessment.taken_up)
        if begin >= (last := min(self.end, float(apart.time[-1]))):
            return {}
        found = peaks(apart.within(begin, last), [name for name in names if name in apart and name not in unknown])
        return {
            name: Difference(peak=peak.value, time=peak.time, share=_share(peak.value, _extent(self.ideal, name)))
            for name, peak in found.items()
            if peak.value > assessment.noise[name]
        }

    def errors(self, of: Mapping[str, float | None]) -> dict[str, float | None]:
        """Estimate the error of each of the run's peaks, by key; empty without the tighter run.

        If the tighter run ends before a part that repeats an earlier one, the errors are those of the earlier one.
        """
        assessment = self.assessment
        if assessment.tighter is None:
            return {}
        error = self._changes(assessment.tighter, of)
        if assessment.remeshed is None:
            return error
        of_cells = self._changes(assessment.remeshed, of)
        both = {key: (error[key], of_cells.get(key)) for key in error}
        return {key: None if one is None or other is None else one + other for key, (one, other) in both.items()}

    def _changes(self, tighter: Trajectory, of: Mapping[str, float | None]) -> dict[str, float | None]:
        """Estimate the errors of the run's peaks that a finer run shows."""
        assessment = self.assessment
        if tighter.status is not Status.OK:
            return dict.fromkeys(of)
        early = self._early
        if early is not self:
            of = numbers(assessment.system, early.run, assessment.meaningless).peaks
        finer = _within(tighter, early.start, early.end)
        found = numbers(assessment.system, finer, assessment.meaningless).peaks
        jagged = bool(assessment.system.film_steps)
        return errors(early.run, finer, of, found, assessment.apart, assessment.noise, jagged)

    @property
    def _early(self) -> Part:
        """Return the earlier part that this one repeats, or this one."""
        if self.assessment.repeating is None:
            return self
        early = self.assessment.repeating.earlier(self.start, self.end)
        return self if early == (self.start, self.end) else Part(self.assessment, *early)


def _within(run: Trajectory, start: float, end: float) -> Trajectory:
    """Return the part of a run between two times [s]; the run itself if it has no other part."""
    return run if (start, end) == (run.time[0], run.time[-1]) else run.within(start, end)


def _extent(ideal: Numbers, name: str) -> float:
    """Return the range of an output, or the peak of a joint's force, of the ideal motion."""
    if name in ideal.outputs:
        one = ideal.outputs[name]
        return (one.max or 0.0) - (one.min or 0.0)
    return ideal.joints[name.removesuffix(".force")].force.peak or 0.0


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > numerics.ROUNDED * part else None
