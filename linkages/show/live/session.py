"""One machine that is changed again and again: the motion for the values of a request.

Where the drives repeat their motion, a lubricated machine is run for a few periods, from where the journals were at the
end of the run before: a small change settles within a few of these runs, and the page requests the next one until the
motion is periodic. Machines that can touch are run from their own start for `_REVOLUTIONS` periods, since their motion
may not repeat at all. Without a common period of the drives, or with additional states, the whole experiment is run.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from copy import copy
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError, RunError, Status
from linkages.elements.analysis import Analysis
from linkages.engines.assessment import ideal, simulate
from linkages.input.files.xml import ANNOTATIONS
from linkages.results.assessment import Assessment
from linkages.results.steady_state import common_period, motion_of
from linkages.results.trajectory import Trajectory
from linkages.results.warnings import warnings_of_run
from linkages.show.live.changes import Changes
from linkages.show.live.pins import Places
from linkages.show.live.view import columns_of, frames_of, joints_of, numbers_for, poses_of, view
from linkages.show.live.watch import TimeLimitError, Watch
from linkages.show.plots.drawing.drawing import Drawing, draw
from linkages.show.plots.drawing.svg import scale, svg
from linkages.show.report.terminal import format_warnings
from linkages.system import System

_PERIODS = 3  # of a run from where the one before ended
_REVOLUTIONS = 8  # periods of a run with contact
_GAP = 0.02  # of an orbit's size: between its begin and its end, for a motion that is steady
_FARTHEST = 0.95  # eccentricity ratio at which a run may start

_SLOWLY, _AHEAD = 0.2, 10.0  # least ratio of the ways of two runs that is extrapolated, most ways ahead
_COARSE = 1e-4  # accuracy of a coarse run [1]
_FASTER = 0.2  # time of a coarse run, over the one of the run in full

_OF_MASSES = ("mass", "inertia", "duration")  # ends of paths that do not change the picture


class Session:
    """Answers requests of one page about one machine, one after the other; a run takes at most `limit` seconds.

    A run that takes longer than `preview` seconds is replaced by a coarse one, until the page requests it in full.
    InputError if the page does not support a model (`linkages.input.model.capabilities`).
    """

    def __init__(self, system: System, limit: float = 20.0, preview: float = 0.5) -> None:
        system.check_analysis(Analysis.LIVE)
        self.system, self.limit, self.preview = system, limit, min(preview, limit)
        self._slow = False  # whether the run before would have taken longer than a preview
        self._ends: list[dict[str, Array]] = []  # where the journals were at the ends of the last runs for these values
        self._shown: tuple[dict[str, Any], dict[str, Any]] = {}, {}  # values of the last request, values of that run
        self._result: _Result | None = None  # of that run
        self._drawings: dict[str, tuple[Drawing, dict[str, Any]]] = {}
        self._ideals: dict[tuple[Any, ...], Trajectory | None] = {}
        self._places: dict[str, Places] = {}
        self._changes = Changes(system)

    def for_page(self) -> Session:
        """Return a session of the same machine for another page; both share drawings and ideal motions."""
        other = copy(self)
        other._ends, other._shown, other._result, other._slow = [], ({}, {}), None, False
        other._changes = Changes(self.system)
        return other

    def _added(self, values: Mapping[str, Any], system: System, period: float | None) -> dict[str, Any]:
        """Return the values of a run that are not requested."""
        if period is None or "duration" in values:
            return {}
        if system.can_touch:
            return {"duration": _REVOLUTIONS * period}
        added: dict[str, Any] = {"duration": _PERIODS * period}
        for name, ratio in _start_after(self._ends).items():
            joint = system.joints.get(name)
            if name in system.play and joint is not None and joint.clearance:
                added[f"joints.{name}.offset"] = (joint.clearance * ratio).tolist()
                added["start"] = "centred"
        return added

    def compute(
        self, values: Mapping[str, Any], outdated: Callable[[], bool] = lambda: False, refine: bool = False
    ) -> dict[str, Any]:
        """Run the mechanism with changed values by dotted path, and return the pictures of the page.

        See `linkages.show.live.view.view`; further `ran` (the values of the run), `settled`, `coarse`, `locked`,
        `picture` (key of the drawing), `poses` of its bodies if it is drawn already, and `took` [s]. With `refine` a
        run that takes longer than a preview is made in full. Errors as of `linkages.simulate`; OutdatedError or
        TimeLimitError if the run was given up.
        """
        begun = clock.perf_counter()
        changed = self.system.replaced(values)
        self._changes.check(values, changed)
        period = _period(changed)
        exact = self._ideal(values, changed, changed.settings.duration if period is None else period)
        if exact is not None and exact.status is Status.LOCKED and changed.determinate:
            perfect = changed.ideal().replaced({"duration": changed.settings.duration if period is None else period})
            exact = ideal(perfect)  # with the quantities of a machine without clearance
            shown = self._view(values, perfect, exact, None, (0.0, float(exact.time[-1])), begun)
            return shown | {"settled": True, "locked": float(exact.time[-1])}
        added = self._added(values, changed, period)
        system, run, coarse = self._run(changed.replaced(added), period, outdated, refine)
        carried = period is not None and "duration" not in values and not changed.can_touch
        carried, motion = carried and run.status is Status.OK, motion_of(system, run)
        settled = not carried or (motion.kind == "periodic" and _closed(system, run, period or 0.0))
        self._ends = (
            [*(self._ends if dict(values) == self._shown[0] else []), _end_of(system, run)][-3:] if carried else []
        )
        part = motion.cycle  # else two periods, or all of the run
        if part is None:
            part = 0.0 if period is None else max(motion.end - 2.0 * period, 0.0), motion.end
        exact = self._ideal(values, changed, part[1] - part[0])
        shown = self._view(values, system, run, exact, part, begun, added, coarse)
        return shown | {"settled": settled, "locked": None}

    def _run(
        self, system: System, period: float | None, outdated: Callable[[], bool], refine: bool
    ) -> tuple[System, Trajectory, bool]:
        """Run a system, or a coarse one where it takes too long; return it, the run, and whether it is coarse."""
        less: dict[str, Any] = {"solver.accuracy": max(system.settings.accuracy, _COARSE)}
        if period is not None and system.can_touch:
            less["duration"] = min(system.settings.duration, 2.0 * period)
        tried = [(self.limit, False)] if refine else [(self.preview, False), (self.limit, True)][self._slow :]
        for limit, coarse in tried:
            begun, one = clock.perf_counter(), system.replaced(less) if coarse else system
            try:
                with Watch(limit, outdated, self._result is None) as watch:
                    run = simulate(one, "compiled", watch, columns_of(one))
            except TimeLimitError:
                if (limit, coarse) == tried[-1]:
                    raise
                continue
            taken = clock.perf_counter() - begun
            self._slow = taken > self.preview * (_FASTER if coarse else 1.0)
            break
        return one, run, coarse

    def _view(
        self,
        values: Mapping[str, Any],
        system: System,
        run: Trajectory,
        exact: Trajectory | None,
        part: tuple[float, float],
        begun: float,
        added: Mapping[str, Any] = MappingProxyType({}),
        coarse: bool = False,
    ) -> dict[str, Any]:
        """Keep a run as the one that is shown, and return its view."""
        ran = {**values, **added}
        self._shown = dict(values), ran
        assessment = Assessment(system, "compiled", run, run if exact is None else exact, None)
        result = self._result = _Result(assessment, exact, frames_of(run, part), _picture(values), coarse, part)
        numbers = {}
        for path in (path for path, value in values.items() if isinstance(value, str)):
            with suppress(InputError):  # of a choice or a list
                numbers[path] = system.value(path)
        shown = view(assessment, exact, part, result.frames) | self._poses()
        told = {"numbers": numbers, "ran": ran, "picture": result.picture, "coarse": coarse}
        return shown | told | {"took": clock.perf_counter() - begun}

    def values_shown(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of the run that was shown for these values; a new run's, if others were shown since."""
        asked, ran = self._shown
        if asked == dict(values):
            return dict(ran)
        system = self.system.replaced(values)
        return dict(values) | self._added(values, system, _period(system))

    def part_shown(self, values: Mapping[str, Any], outdated: Callable[[], bool]) -> tuple[float, float]:
        """Return begin and end [s] of the part of a run in full that the table is about; see `values_shown`."""
        if self._shown[0] != dict(values) or self._result is None or self._result.coarse:
            self.compute(values, outdated, refine=True)
        if self._result is None or self._result.assessment.run.status is not Status.OK:
            raise InputError("page", "run", "does not reach its end with these values")
        assessment, period = self._result.assessment, _period(self._result.assessment.system)
        if period is not None and not assessment.system.can_touch:  # even if it has not settled
            return float(assessment.run.time[-1]) - period, float(assessment.run.time[-1])
        return assessment.reported_span

    def part_drawn(self) -> tuple[float, float]:
        """Return begin and end [s] of the curves of the run that was shown last."""
        if self._result is None:
            raise InputError("page", "run", "has not been shown yet")
        return self._result.part

    def numbers(self) -> dict[str, Any]:
        """Return the numbers of the run that was shown last, see `linkages.show.live.view.numbers_for`."""
        if self._result is None:
            raise InputError("page", "numbers", "has no run yet; change a value, or press reset")
        return numbers_for(self._result.assessment, self._result.exact)

    def warnings(self) -> list[dict[str, Any]]:
        """Return the warnings about the run that was shown last: `text`, and `remedies` with `label` and `values`."""
        if self._result is None:
            return []
        shown = self._result.assessment
        found = warnings_of_run(shown.system, shown.sound, shown.contacts)
        return [{"text": format_warnings([one])[1], "remedies": _remedies(one["changes"])} for one in found]

    def moved(self, values: Mapping[str, Any], joint: str, to: Sequence[float], phase: float) -> dict[str, Any]:
        """Return values with which the pin of a joint is at a place [m] in a pose that is shown, `phase` from 0 to 1.

        InputError if there is no such joint or no run yet, or the pin cannot move.
        """
        if self._result is None or joint not in self.system.joints:
            raise InputError("page", f"joint {joint}"[:60], "is no joint of the picture")
        key = repr(_key(values, ("joints.",), _OF_MASSES))
        if key not in self._places:
            _keep_few(self._places)
            self._places[key] = Places(self.system.replaced(values))
        frames = self._result.frames
        row = round(phase * (len(next(iter(frames.values()))) - 1))
        pose = {name: float(column[row]) for name, column in frames.items()}
        return dict(values) | self._places[key].moved(joint, to, pose)

    def restart(self) -> None:
        """Forget where the journals were: the next run starts as its file says."""
        self._ends = []

    def picture(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Draw the machine with changed values, with its place on the page and the poses of the last run."""
        key = _picture(values)
        if key not in self._drawings:
            _keep_few(self._drawings)
            system = self.system.replaced(values)
            drawing = draw(system)
            place = {
                "low": float(drawing.low[0]),
                "high": float(drawing.high[1]),
                "scale": scale(drawing),
                "joints": joints_of(drawing, system),
                "bodies": drawing.links_of,
            }
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
        """Move the linkage with ideal joints for a time [s]; None where it cannot move, or has too many drives."""
        key = (*_key(values, ("joints.",), ()), f"{duration:.9g}")
        if key not in self._ideals:
            _keep_few(self._ideals)
            self._ideals[key] = None
            with suppress(AssemblyError, InputError, RunError):
                self._ideals[key] = ideal(system.replaced({"duration": duration}))
        return self._ideals[key]


class _Result(NamedTuple):
    """The run that was shown last."""

    assessment: Assessment
    exact: Trajectory | None
    frames: Mapping[str, Array]  # of the moving picture
    picture: str  # key of its drawing
    coarse: bool
    part: tuple[float, float]  # begin and end of its curves [s]


def _period(system: System) -> float | None:
    """Period of the drives [s], if they repeat their motion from the start on and no state must settle."""
    if system.own_states or any(drive.ramp for drive in system.drives.values()):
        return None
    return common_period(system)


def _end_of(system: System, run: Trajectory) -> dict[str, Array]:
    """Where the journals are at the end of a run, in parts of the clearance (2,)."""
    found = {}
    for name in system.tree.journals:
        clearance = system.joints[name].clearance
        if clearance and f"{name}.ex" in run.columns:
            found[name] = _inside(np.array([run[f"{name}.ex"][-1], run[f"{name}.ey"][-1]]) / clearance)
    return found


def _start_after(ends: Sequence[dict[str, Array]]) -> dict[str, Array]:
    """Where the journals start after runs with these ends: where they are going to, if they settle slowly (Aitken)."""
    start = dict(ends[-1]) if ends else {}
    if len(ends) < 3:
        return start
    for name, (first, second, third) in {name: [end[name] for end in ends] for name in start}.items():
        before, last = second - first, third - second
        ratio = float(before @ last) / max(float(before @ before), 1e-300)
        if _SLOWLY < ratio < 1.0:
            start[name] = _inside(third + last * min(ratio / (1.0 - ratio), _AHEAD))
    return start


def _inside(ratio: Array) -> Array:
    """Return a place within the clearance, in parts of it, from where a run may start."""
    return np.asarray(ratio * min(1.0, _FARTHEST / max(float(np.hypot(*ratio)), 1e-300)))


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


def _key(values: Mapping[str, Any], starts: tuple[str, ...], ends: tuple[str, ...]) -> tuple[Any, ...]:
    """Return values as a key, without those whose paths have these starts or ends."""
    kept = {path: value for path, value in values.items() if not path.startswith(starts) and not path.endswith(ends)}
    return tuple(sorted((path, str(value)) for path, value in kept.items()))


def _picture(values: Mapping[str, Any]) -> str:
    """Return the key of the drawing for values: models of joints and the places of everything count."""
    models = {path: value for path, value in values.items() if path.endswith(".model")}
    return repr((_key(models, (), ()), _key(values, ("joints.", "solver."), _OF_MASSES)))


def _keep_few(kept: dict[Any, Any]) -> None:
    """Forget the oldest entries of a cache of twenty."""
    while len(kept) >= 20:
        kept.pop(next(iter(kept)))


def checked(values: Any, known: Mapping[str, Any], system: System | None = None) -> dict[str, float | str]:
    """Check values from outside: paths of controls or of parts, with numbers or short texts; InputError for others."""
    if not isinstance(values, dict):
        raise InputError("page", "values", "must be a table of values by path")
    for path, value in values.items():
        if path not in known and not (system and _of_part(path, system)):
            raise InputError("page", str(path)[:100], "is not a value that can be changed")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number or (isinstance(value, str) and len(value) <= 200)):
            raise InputError("page", path, "must be a number or a text of at most 200 characters")
    return dict(values)


def _of_part(path: str, system: System) -> bool:
    """Whether a path is of a key that a joint or a link can have, but the name of a file."""
    table, name, key = [*path.removeprefix("sdf.").split("."), "", ""][:3]
    parts: dict[str, Mapping[str, Any]] = {"joints": system.joints, "links": system.links}
    if path.startswith("sdf."):
        return name in parts.get(table, {}) and key in ANNOTATIONS[table]
    return name in parts.get(table, {}) and key not in ("", "worn")


def _remedies(changes: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the changes that heed a warning as one remedy with a label; none without changes."""
    label = ", ".join(f"{path.partition('.')[2]} = {value}" for path, value in changes.items())
    return [{"label": label, "values": dict(changes)}] if changes else []
