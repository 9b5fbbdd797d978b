"""Whether a run has come to a steady motion, by the return map of its states at the drives' common period.

The state at a time is where the journals lie in their clearances (in parts of these), and the coordinates that the
drives leave free (angles in rad, lengths in parts of the linkage's). Two times a period apart show the same motion if
no entry of their states differs by more than `SAME`.

| kind           | rule                                                                                               |
|----------------|----------------------------------------------------------------------------------------------------|
| periodic       | at the end the state is that of n periods before, n = 1 to `MOST`, the least: over half of what    |
|                | can be compared, at least n/2 and at most 3n periods. Where differences shrink by a factor from    |
|                | one n periods to the next (by least squares, so that scatter is no trend), what is still to come   |
|                | of them (a geometric series) is within `SAME` too; for n > 1 the run must be long enough to tell   |
| chaotic        | `ENOUGH` periods or more, and states that are close part: the distance of a state from its nearest |
|                | neighbour among the others grows from one period to the next, by `GROWTH` in its natural logarithm |
| quasi-periodic | as many periods, and neighbours neither part nor approach                                          |
| not settled    | neighbours approach, or the steps from period to period shrink by half over the run; or too few    |
|                | periods to tell                                                                                    |
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

import numpy as np

from linkages.arrays import Array
from linkages.errors import Status
from linkages.results.akima import interpolated
from linkages.results.configuration import configuration
from linkages.results.trajectory import Trajectory
from linkages.system import System

SAME = 0.01  # of a clearance, or [rad]
MOST = 4  # periods of the drives in one of the motion
ENOUGH = 16  # periods from which on a motion that does not repeat is judged
GROWTH = 0.2  # of the logarithm of neighbours' distance in a period
_PHASES = 48  # of a period, at which states are compared; a multiple of 4
_SHRINKS = 0.5  # of distances over the run, or of the later to the earlier steps: a motion that still settles
_SHORT = "the run is shorter than a period"
_SETTLES = "it still changes from period to period, less and less"
_TURNS = 12  # most turns of one drive in a common period
_COMMENSURATE = 1e-9  # relative error of two frequencies' ratio as a fraction
_LOOKS = 2001  # times at which a drive's table or formula is looked at
#: What states are measured in, for sentences: of journals alone, and of all coordinates.
_CLEARANCES = "of the clearance"
_MIXED = "(eccentricities in clearances, positions in sizes of the machine, angles in rad)"
_ROUNDS = 8  # by which a period is refined
_REPEATED = 1e-6  # of its range: by how much a motion that repeats itself may differ a period later


@dataclass(frozen=True)
class Motion:
    """What kind of motion a run ends in.

    Attributes
    ----------
    kind : str or None
        "periodic", "quasi-periodic", "chaotic", "not settled"; None if the drives have no common period.
    why : str
        In words.
    period : float or None
        The drives' common period [s].
    periods : int
        Of them, in one period of the motion; 0 if it is not periodic.
    since : float or None
        When the periodic motion was reached [s].
    end : float
        When the run ends [s].
    """

    kind: str | None
    why: str
    period: float | None = None
    periods: int = 0
    since: float | None = None
    end: float = 0.0

    @property
    def cycle(self) -> tuple[float, float] | None:
        """The last period of a periodic motion [s]; None of another one."""
        if self.period is None or not self.periods:
            return None
        return max(self.end - self.periods * self.period, 0.0), self.end


def common_period(system: System) -> float | None:
    """Shortest time in which all drives repeat their motion [s]; None where there is none.

    A drive of constant speed repeats it in a full turn, one by a table or formula after the time that `repeats` finds.
    There is none with a load over time, a drive by torque, one that slides on and on, or without any that moves; or
    with drives whose frequencies are not in the ratio of small whole numbers.
    """
    experiment = system.experiment
    changing = [load for table, name in experiment.loads if (load := getattr(experiment, table)[name])]
    if any(getattr(load, "over_time", False) for load in changing):
        return None
    frequencies = []
    for name, drive in experiment.drives.items():
        if not drive.speed and not drive.varies:
            continue
        period = drive_period(system, name, experiment.duration) if drive.prescribed else None
        if period is None:
            return None
        frequencies.append(1.0 / period)
    if not frequencies:
        return None
    whole = 1
    for frequency in frequencies[1:]:
        ratio = Fraction(frequency / frequencies[0]).limit_denominator(_TURNS)
        if not ratio or abs(float(ratio) - frequency / frequencies[0]) > _COMMENSURATE * frequency / frequencies[0]:
            return None
        whole = int(np.lcm(whole, ratio.denominator))
    return whole / frequencies[0] if whole <= _TURNS else None


def drive_period(system: System, name: str, end: float) -> float | None:
    """Time in which a prescribed drive repeats its motion [s]; None if it does not, or stands still.

    Parameters
    ----------
    system : System
    name : str
        The driven joint.
    end : float
        The motion of a table, of a formula or of a sliding joint is looked at from 0 to here [s].
    """
    drive = system.experiment.drives[name]
    if drive.varies or system.mechanism.joint[name].type != "revolute":
        return repeats(partial(_history, system, name), end)
    return 2.0 * np.pi / abs(drive.speed) if drive.speed else None


def _history(system: System, name: str, times: Array) -> Array:
    """Coordinate of a prescribed drive, its rate and acceleration at some times, (nt, 3)."""
    return np.stack(system.motions(times), axis=-1)[:, system.tree.driven.index(name)]


def repeats(history: Callable[[Array], Array], end: float) -> float | None:
    """Shortest time after which a motion repeats itself up to its end [s], where that is half of all at most; or None.

    Parameters
    ----------
    history : callable
        Coordinate, rate and acceleration (nt, 3) at some times (nt,) [s].
    end : float
        The motion goes from 0 to here [s].

    Examples
    --------
    >>> import numpy as np
    >>> from linkages.results.steady_state import repeats
    >>> round(repeats(lambda t: np.column_stack([np.sin(4 * t), 4 * np.cos(4 * t), -16 * np.sin(4 * t)]), 5.0), 9)
    1.570796327
    """
    times = np.linspace(0.0, end, _LOOKS)
    values = history(times)[:, :2]
    scale = np.ptp(values, axis=0)
    if not scale.all():
        return None
    half = _LOOKS // 2
    quickest = times[half + int(np.abs(values[half:, 1]).argmax())]  # it may rest at its end
    before = times[: half + 2]  # periods that are tried, and one beyond
    here, *_ = found = history(quickest - before)
    far = np.linalg.norm((found - here)[:, :2] / scale, axis=1)
    for guess in before[1:-1][(far[1:-1] <= far[:-2]) & (far[1:-1] < far[2:])]:
        period = guess
        for _ in range(_ROUNDS):  # Gauss and Newton: to all digits where nothing is left in the end
            now = history(np.array([quickest - period]))[0]
            left, slope = (now - here)[:2] / scale, -now[1:] / scale
            period = float(np.clip(period - left @ slope / (slope @ slope or 1.0), guess - times[1], guess + times[1]))
        last = np.linspace(end - period, end, _LOOKS)
        if period <= 0.5 * end * (1.0 + _COMMENSURATE) and np.all(
            np.abs(history(last - period) - history(last))[:, :2] <= _REPEATED * scale
        ):
            return period
    return None


def motion_of(system: System, run: Trajectory) -> Motion:
    """Tell what kind of motion a run ends in.

    Parameters
    ----------
    system : System
        That made the run.
    run : Trajectory
        A loaded one will do.

    Returns
    -------
    Motion

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"))
    >>> motion = linkages.motion_of(system, linkages.simulate(system, "compiled"))
    >>> motion.kind, motion.periods, round(motion.period, 6)  # s
    ('periodic', 1, 0.012)
    """
    end, period = float(run.time[-1]), common_period(system)
    if period is None:
        return Motion(None, "the drives have no common period", end=end)
    if run.status is not Status.OK:
        return Motion("not settled", "the run ended early", period, end=end)
    start = max(float(run.time[0]), *(drive.ramp for drive in system.experiment.drives.values()))
    count = int(max(end - start, 0.0) / period * _PHASES * (1.0 + 1e-12))  # none where the ramp outlasts the run
    times = end - period / _PHASES * np.arange(count + 1)
    states = interpolated(run.time, configuration(system, run.columns), np.maximum(times, run.time[0]))
    kind, periods, reached, why = classify(states, scale=_CLEARANCES if system.determinate else _MIXED)
    since = None if reached is None else float(max(times[reached], start))
    return Motion(kind, why, period, periods, since, end)


def classify(states: Array, phases: int = _PHASES, scale: str = "") -> tuple[str, int, int | None, str]:
    """Apply the rule to states (nt, m) that go back from the end, `phases` in each period.

    Parameters
    ----------
    states : (nt, m) array
        Without units.
    phases : int
    scale : str
        What the states are measured in, for `why`.

    Returns
    -------
    kind : str
    periods : int
        Of the motion, in periods; 0 if it is not periodic.
    reached : int or None
        Line from which on it is periodic.
    why : str
    """
    last = len(states) - 1
    if not states.shape[1]:  # the drives determine all there is
        found = last >= phases
        return ("periodic", 1, last, "") if found else ("not settled", 0, None, _SHORT)
    for n in range(1, MOST + 1):
        shift = n * phases
        window = min(max(shift // 2, (last - shift) // 2), 3 * shift)
        if last < shift + window:
            break
        changes = states[:-shift] - states[shift:]
        apart = np.abs(changes).max(axis=1)
        recent, told = float(apart[: window + 1].max()), last >= 2 * shift + window
        if n > 1 and not told:
            break  # of a whirl that dies away two periods may look alike
        rest = _rest(changes[: window + 1], changes[shift : shift + window + 1]) if told else 0.0
        if max(recent, rest) <= SAME:
            apart_at = np.flatnonzero(apart > SAME)
            first = int(apart_at[0]) - 1 if len(apart_at) else len(apart) - 1
            return "periodic", n, first + shift, ""
        if n == 1 and recent <= SAME:
            return "not settled", 0, None, _SETTLES
    count = (last + 1) // phases
    if last < phases:
        return "not settled", 0, None, _SHORT
    if count < ENOUGH:
        lasts = f"{last / phases:.3g}"
        why = f"it does not repeat within {lasts} period{'' if lasts == '1' else 's'}"
        if last > phases:
            apart = np.abs(states[: min(phases, last - phases) + 1] - states[phases : 2 * phases + 1]).max()
            why += f"; the states of the last two periods differ by {apart:.2g}{scale and f' {scale}'}"
        return "not settled", 0, None, why
    growth, steps = _neighbours(states, phases, count)
    if growth > GROWTH:
        return "chaotic", 0, None, f"states that are close part by a factor of {np.exp(growth):.2g} in a period"
    if growth * count < np.log(_SHRINKS) or steps < _SHRINKS:
        return "not settled", 0, None, _SETTLES
    return "quasi-periodic", 0, None, "it does not repeat, and states that are close stay close"


def _rest(recent: Array, before: Array) -> float:
    """Return what is still to come of changes (nt, m) that follow those before as terms of geometric series do."""
    factor = (recent * before).sum(axis=0) / np.maximum((before * before).sum(axis=0), 1e-300)
    shrinks = (factor > 0.0) & (factor < 1.0)
    return float(np.max(np.abs(recent).max(axis=0)[shrinks] * (factor / (1.0 - factor))[shrinks], initial=0.0))


def _neighbours(states: Array, phases: int, count: int) -> tuple[float, float]:
    """Growth of the logarithm of neighbours' distance in a period; ratio of later to earlier steps between periods."""
    part = phases // 4  # positions over a time, in place of rates
    blocks = np.array([states[k * phases : k * phases + part].ravel() for k in range(count)])
    apart = np.abs(blocks[:, None] - blocks).max(axis=2)
    steps = np.diagonal(apart, 1)
    half = len(steps) // 2
    shrunk = float(steps[:half].mean() / max(steps[half:].mean(), 1e-300))
    np.fill_diagonal(apart, np.inf)
    grown = []
    for k in range(1, count):
        near = 1 + int(np.argmin(apart[k, 1:]))
        grown.append(np.log(max(apart[k - 1, near - 1], 1e-300) / max(apart[k, near], 1e-300)))
    return float(np.median(grown)), shrunk
