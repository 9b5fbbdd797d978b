"""One machine that is changed again and again: the motion for the values of a request.

Where the drives repeat their motion, a lubricated machine is run for a few periods, from where the journals were at the
end of the run before: a small change settles within a few of these runs, and the page requests the next one until the
motion is periodic. Machines that can touch are run from their own start for `_REVOLUTIONS` periods, since their motion
may not repeat at all. Without a common period of the drives, or with additional states, the whole experiment is run.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from contextlib import suppress
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError, RunError, Status
from linkages.engines.assessment import ideal, simulate
from linkages.input.model.capabilities import Analysis
from linkages.results.assessment import Assessment
from linkages.results.steady_state import common_period, motion_of
from linkages.results.trajectory import Trajectory
from linkages.results.warnings import warnings_of_run
from linkages.show.live.view import columns_of, frames_of, numbers_for, poses_of, view
from linkages.show.plots.drawing.drawing import Drawing, draw
from linkages.show.plots.drawing.svg import scale, svg
from linkages.show.report.terminal import format_warnings
from linkages.system import System

_PERIODS = 3  # of a run from where the one before ended
_REVOLUTIONS = 8  # periods of a run with contact
_GAP = 0.02  # of an orbit's size: between its begin and its end, for a motion that is steady
_FARTHEST = 0.95  # eccentricity ratio at which a run may start

#: Ends of paths that change neither the picture nor the motion with ideal joints.
_OF_JOINTS = ("clearance", "viscosity", "film", "temperature", "restitution", "coefficient", "stiffness")
_OF_MASSES = ("mass", "inertia")  # ends of paths that do not change the picture
_WORDS = ("model", "film", "start")  # ends of paths of choices


class OutdatedError(Exception):
    """Raised within a run with an outdated request."""


class TimeLimitError(Exception):
    """Raised within a run that takes longer than its limit."""


class Session:
    """Answers requests of one page about one machine, one after the other; a run takes at most `limit` seconds.

    InputError if the page does not support a model (`linkages.input.model.capabilities`).
    """

    def __init__(self, system: System, limit: float = 20.0) -> None:
        system.check_analysis(Analysis.LIVE)
        self.system, self.limit = system, limit
        self._ratios: dict[str, tuple[float, float]] = {}
        self._shown: tuple[dict[str, Any], dict[str, Any]] = {}, {}  # values of the last request, values of that run
        self._result: _Result | None = None  # of that run
        self._drawings: dict[str, tuple[Drawing, dict[str, Any]]] = {}
        self._ideals: dict[tuple[Any, ...], Trajectory | None] = {}

    def for_page(self) -> Session:
        """Return a session of the same machine for another page; both share drawings and ideal motions."""
        other = copy(self)
        other._ratios, other._shown, other._result = {}, ({}, {}), None
        return other

    def _added(self, values: Mapping[str, Any], system: System, period: float | None) -> dict[str, Any]:
        """Return the values of a run that are not requested."""
        if period is None or "duration" in values:
            return {}
        if system.experiment.can_touch:
            return {"duration": _REVOLUTIONS * period}
        added: dict[str, Any] = {"duration": _PERIODS * period}
        for name, ratio in self._ratios.items():
            joint = system.experiment.joints.get(name)
            if name in system.experiment.play and joint is not None and joint.clearance:
                added[f"joints.{name}.offset"] = [joint.clearance * part for part in ratio]
                added["start"] = "centred"
        return added

    def compute(self, values: Mapping[str, Any], outdated: Callable[[], bool] = lambda: False) -> dict[str, Any]:
        """Run the mechanism with changed values by dotted path, and return the pictures of the page.

        See `linkages.show.live.view.view`; further `ran` (the values of the run), `settled`, `picture` (key of the
        drawing), `poses` of its bodies if it is drawn already, and `took` [s]. Errors as of `linkages.simulate`;
        OutdatedError or TimeLimitError if the run was given up.
        """
        begun = clock.perf_counter()
        integrating: list[float] = []  # start of the integration, without the time of compilation

        def watch(_: float) -> None:
            integrating.append(clock.perf_counter())
            if outdated():
                raise OutdatedError
            if integrating[-1] - integrating[0] > self.limit:
                raise TimeLimitError

        changed = self.system.replaced(values)
        period = _period(changed)
        carried = period is not None and "duration" not in values and not changed.experiment.can_touch
        added = self._added(values, changed, period)
        system = changed.replaced(added)
        run = simulate(system, "compiled", watch, columns_of(system))
        carried, motion = carried and run.status is Status.OK, motion_of(system, run)
        settled = not carried or (motion.kind == "periodic" and _closed(system, run, period or 0.0))
        self._ratios = _end_of(system, run) if carried else {}
        ran = dict(values) | added
        self._shown = dict(values), ran
        part = motion.cycle  # else two periods, or all of the run
        if part is None:
            part = 0.0 if period is None else max(motion.end - 2.0 * period, 0.0), motion.end
        exact = self._ideal(values, system, part[1] - part[0])
        assessment = Assessment(system, "compiled", run, run if exact is None else exact, None)
        result = _Result(assessment, exact, frames_of(run, part), repr(_key(values, _OF_JOINTS + _OF_MASSES)))
        self._result = result
        texts = [path for path, value in values.items() if isinstance(value, str)]
        numbers = {path: system.value(path) for path in texts if path.rpartition(".")[2] not in _WORDS}
        told = {"numbers": numbers, "ran": ran, "settled": settled, "picture": result.picture}
        shown = view(assessment, exact, part, result.frames) | self._poses() | told
        return shown | {"took": clock.perf_counter() - begun}

    def values_shown(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of the run that was shown for these values; a new run's, if others were shown since."""
        asked, ran = self._shown
        if asked == dict(values):
            return dict(ran)
        system = self.system.replaced(values)
        return dict(values) | self._added(values, system, _period(system))

    def numbers(self) -> dict[str, Any]:
        """Return the numbers of the run that was shown last, see `linkages.show.live.view.numbers_for`."""
        if self._result is None:
            raise InputError("page", "numbers", "has no run yet; change a value, or press reset")
        return numbers_for(self._result.assessment, self._result.exact)

    def warnings(self) -> list[str]:
        """Return the warnings about the run that was shown last."""
        if self._result is None:
            return []
        shown = self._result.assessment
        found = warnings_of_run(shown.system, shown.sound, shown.contacts)
        return [line for line in format_warnings(found) if line]

    def restart(self) -> None:
        """Forget where the journals were: the next run starts as its file says."""
        self._ratios = {}

    def picture(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Draw the machine with changed values, with its place on the page and the poses of the last run."""
        key = repr(_key(values, _OF_JOINTS + _OF_MASSES))
        if key not in self._drawings:
            _keep_few(self._drawings)
            drawing = draw(self.system.replaced(values))
            place = {"low": float(drawing.low[0]), "high": float(drawing.high[1]), "scale": scale(drawing)}
            self._drawings[key] = drawing, {"svg": str(svg(drawing, said=False)), **place}
        shown = self._result is not None and self._result.picture == key
        return self._drawings[key][1] | {"picture": key} | (self._poses() if shown else {})

    def _poses(self) -> dict[str, Any]:
        """Return the poses of the drawing's bodies in the run that was shown last, if it is drawn."""
        result = self._result
        if result is None or result.picture not in self._drawings:
            return {}
        return {"poses": poses_of(self._drawings[result.picture][0], result.assessment.system, result.frames)}

    def _ideal(self, values: Mapping[str, Any], system: System, duration: float) -> Trajectory | None:
        """Move the linkage with ideal joints for a time [s]; None where it cannot move."""
        key = (*_key(values, _OF_JOINTS), duration)
        if key not in self._ideals:
            _keep_few(self._ideals)
            self._ideals[key] = None
            with suppress(AssemblyError, RunError):
                self._ideals[key] = ideal(system.replaced({"duration": duration}))
        return self._ideals[key]


class _Result(NamedTuple):
    """The run that was shown last."""

    assessment: Assessment
    exact: Trajectory | None
    frames: Mapping[str, Array]  # of the moving picture
    picture: str  # key of its drawing


def _period(system: System) -> float | None:
    """Period of the drives [s], if they repeat their motion from the start on and no state must settle."""
    if system.experiment.own_states or any(drive.ramp for drive in system.experiment.drives.values()):
        return None
    return common_period(system)


def _end_of(system: System, run: Trajectory) -> dict[str, tuple[float, float]]:
    """Where the journals are at the end of a run, in parts of the clearance."""
    found = {}
    for name in system.tree.journals:
        clearance = system.experiment.joints[name].clearance
        if clearance and f"{name}.ex" in run.columns:
            ratio = np.array([run[f"{name}.ex"][-1], run[f"{name}.ey"][-1]]) / clearance
            ratio *= min(1.0, _FARTHEST / max(float(np.hypot(*ratio)), 1e-300))
            found[name] = (float(ratio[0]), float(ratio[1]))
    return found


def _closed(system: System, run: Trajectory, period: float) -> bool:
    """Whether the orbits of the last period end where they begin, to a part of their size."""
    last = run.time >= run.time[-1] - period
    for name in system.tree.journals:
        path = np.column_stack([run[f"{name}.ex"], run[f"{name}.ey"]])
        before = [np.interp(run.time[-1] - period, run.time, column) for column in path.T]
        size = float(np.ptp(path[last], axis=0).max())
        if np.hypot(*(path[-1] - before)) > _GAP * size:
            return False
    return True


def _key(values: Mapping[str, Any], without: tuple[str, ...]) -> tuple[Any, ...]:
    """Values that change the picture or the ideal motion, as a key."""
    kept = {path: value for path, value in values.items() if path.rpartition(".")[2] not in without}
    return tuple(sorted((path, str(value)) for path, value in kept.items()))


def _keep_few(kept: dict[Any, Any]) -> None:
    """Forget the oldest entries of a cache of twenty."""
    while len(kept) >= 20:
        kept.pop(next(iter(kept)))


def checked(values: Any, known: Mapping[str, Any]) -> dict[str, float | str]:
    """Check values from outside: paths of controls, with numbers or short texts; InputError for others."""
    if not isinstance(values, dict):
        raise InputError("page", "values", "must be a table of values by path")
    for path, value in values.items():
        if path not in known:
            raise InputError("page", str(path)[:100], "is not a value that can be changed")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number or (isinstance(value, str) and len(value) <= 200)):
            raise InputError("page", path, "must be a number or a text of at most 200 characters")
    return dict(values)
