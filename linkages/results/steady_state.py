"""Steady state of a run: classification of its motion by the return map of states at the drives' common period.

The state at a time consists of the eccentricities of the journals over their clearances, and of the coordinates without
prescribed motion (angles in rad, lengths over the linkage's length). Two times a period apart show the same motion if
no entry of their states differs by more than `SAME`.

| kind           | rule                                                                                               |
|----------------|----------------------------------------------------------------------------------------------------|
| periodic       | the final state equals the state n periods before, with the smallest n = 1 to `MOST`, over more    |
|                | than half of the comparable time, at least n/2 and at most 3n periods. If differences shrink by a  |
|                | factor per n periods (by least squares, so that scatter is no trend), their expected remaining     |
|                | change (a geometric series) is within `SAME` too; for n > 1 the run must be sufficiently long      |
| chaotic        | at least `ENOUGH` periods, and close states diverge: the distance of a state from its nearest      |
|                | neighbour among the others grows per period by `GROWTH` in its natural logarithm                   |
| quasi-periodic | at least `ENOUGH` periods, and neighbours neither diverge nor approach                             |
| not settled    | neighbours approach, or the changes per period halve over the run; or the run has too few periods  |
|                | for a decision                                                                                     |
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from linkages.base.arguments import validated
from linkages.base.arrays import Array
from linkages.base.errors import Status
from linkages.input.functions.definitions import TIME, inputs_of
from linkages.results import numerics
from linkages.results.akima import interpolated
from linkages.results.divergence import configuration
from linkages.results.shape import FinalMotion
from linkages.results.trajectory import Trajectory
from linkages.system import System

SAME = 0.01  # tolerance of equal states [clearances, or rad]
MOST = 4  # most drive periods in one period of the motion
ENOUGH = 16  # fewest periods for the classification of a motion that does not repeat
GROWTH = 0.2  # growth per period of the logarithm of neighbours' distance
_SHORT = "the run is shorter than a period"
_SETTLES = "the changes from period to period still decrease"
#: Units of states in messages: journals alone, and all coordinates.
_CLEARANCES = "of the clearance"
_MIXED = "(eccentricities in clearances, positions over the linkage's size, angles in rad)"


@dataclass(frozen=True)
class Motion:
    """Classification of the motion at the end of a run.

    Attributes
    ----------
    kind : str or None
        "periodic", "quasi-periodic", "chaotic", "not settled"; None if the drives have no common period.
    why : str
        Reason in words.
    period : float or None
        The drives' common period [s].
    periods : int
        Number of drive periods in one period of the motion; 0 if it is not periodic.
    since : float or None
        Start of the periodic motion [s].
    end : float
        End of the run [s].
    """

    kind: str | None
    why: str
    period: float | None = None
    periods: int = 0
    since: float | None = None
    end: float = 0.0

    @property
    def summary(self) -> FinalMotion:
        """Return the entry ``motion`` of a summary."""
        return FinalMotion(kind=self.kind, why=self.why, period=self.period, periods=self.periods, since=self.since)

    @property
    def cycle(self) -> tuple[float, float] | None:
        """Return the last period of a periodic motion [s]; None for other motions."""
        if self.period is None or not self.periods:
            return None
        return max(self.end - self.periods * self.period, 0.0), self.end


def common_period(system: System) -> float | None:
    """Find the shortest time in which all drives repeat their motion [s]; None without one.

    A drive of constant speed repeats it after a revolution, a table or formula after the time found by `repeats`. A
    constant torque or force, whatever its speed at the start, has any period. A load over time, a prismatic drive at
    constant speed, a linkage without a prescribed drive that moves, and drive frequencies without a ratio of small
    integers have no common period.
    """
    own = [name for one in system.quantities.values() for name in inputs_of(one.definition, system.quantities)]
    if TIME in own or TIME in system.functions_read:
        return None
    frequencies = []
    for name, drive in system.drives.items():
        if not drive.varies and not (drive.prescribed and drive.speed):
            continue
        period = drive_period(system, name, system.settings.duration) if drive.prescribed else None
        if period is None:
            return None
        frequencies.append(1.0 / period)
    if not frequencies:
        return None
    whole = 1
    for frequency in frequencies[1:]:
        ratio = Fraction(frequency / frequencies[0]).limit_denominator(numerics.STEADY_STATE_TURNS)
        if not ratio or abs(float(ratio) - frequency / frequencies[0]) > numerics.ROUNDED * frequency / frequencies[0]:
            return None
        whole = int(np.lcm(whole, ratio.denominator))
    return whole / frequencies[0] if whole <= numerics.STEADY_STATE_TURNS else None


def drive_period(system: System, name: str, end: float) -> float | None:
    """Find the period of a prescribed drive [s]; None if it does not repeat, or does not move.

    The motion of a table, a formula or a prismatic joint is examined up to `end` [s].
    """
    drive = system.drives[name]
    if (period := next((fit.period for fit in drive.fitted), None)) is not None:
        return period
    if drive.varies or system.joints[name].type != "revolute":
        k = system.tree.driven.index(name)
        return repeats(lambda times: np.stack(system.motions(times), axis=-1)[:, k], end)
    return 2.0 * np.pi / abs(drive.speed) if drive.speed else None


def repeats(history: Callable[[Array], Array], end: float) -> float | None:
    """Find the period of a motion [s], at most half of its duration; None if it does not repeat.

    `history` gives coordinate, rate and acceleration (nt, 3) at times (nt,), from 0 to `end` [s].
    """
    times = np.linspace(0.0, end, numerics.STEADY_STATE_LOOKS)
    values = history(times)[:, :2]
    scale = np.ptp(values, axis=0)
    if not scale.all():
        return None
    half = numerics.STEADY_STATE_LOOKS // 2
    quickest = times[half + int(np.abs(values[half:, 1]).argmax())]  # the motion may be at rest at its end
    before = times[: half + 2]  # candidate periods, and one more
    here, *_ = found = history(quickest - before)
    far = np.linalg.norm((found - here)[:, :2] / scale, axis=1)
    for guess in before[1:-1][(far[1:-1] <= far[:-2]) & (far[1:-1] < far[2:])]:
        period = guess
        for _ in range(numerics.STEADY_STATE_ROUNDS):  # Gauss-Newton iterations
            now = history(np.array([quickest - period]))[0]
            left, slope = (now - here)[:2] / scale, -now[1:] / scale
            period = float(np.clip(period - left @ slope / (slope @ slope or 1.0), guess - times[1], guess + times[1]))
        last = np.linspace(end - period, end, numerics.STEADY_STATE_LOOKS)
        if period <= 0.5 * end * (1.0 + numerics.ROUNDED) and np.all(
            np.abs(history(last - period) - history(last))[:, :2] <= numerics.STEADY_STATE_REPEATED * scale
        ):
            return period
    return None


@validated
def motion_of(system: System, run: Trajectory) -> Motion:
    """Classify the motion at the end of a run.

    Parameters
    ----------
    system : System
        System of the run.
    run : Trajectory
        Run of the engine, or a loaded one.

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
    start, each = max(float(run.time[0]), system.ramp), period / numerics.STEADY_STATE_PHASES
    count = int(max(end - start, 0.0) / each * (1.0 + 1e-12))  # zero if the ramp is longer than the run
    times = end - each * np.arange(count + 1)
    states = interpolated(run.time, configuration(system, run.columns), np.maximum(times, run.time[0]))
    kind, periods, reached, why = classify(states, scale=_CLEARANCES if system.determinate else _MIXED)
    since = None if reached is None else float(max(times[reached], start))
    return Motion(kind, why, period, periods, since, end)


def classify(states: Array, scale: str = "") -> tuple[str, int, int | None, str]:
    """Classify a series of dimensionless states (nt, m), ordered backwards from the end.

    There are `numerics.STEADY_STATE_PHASES` of them per period. Returns the kind, the period in drive periods (0 if not
    periodic), the first line of the periodic motion, and the reason, in which `scale` is the unit of the states.
    """
    last = len(states) - 1
    if not states.shape[1]:  # the drives determine the motion
        found = last >= numerics.STEADY_STATE_PHASES
        return ("periodic", 1, last, "") if found else ("not settled", 0, None, _SHORT)
    for n in range(1, MOST + 1):
        shift = n * numerics.STEADY_STATE_PHASES
        window = min(max(shift // 2, (last - shift) // 2), 3 * shift)
        if last < shift + window:
            break
        changes = states[:-shift] - states[shift:]
        apart = np.abs(changes).max(axis=1)
        recent, told = float(apart[: window + 1].max()), last >= 2 * shift + window
        if n > 1 and not told:
            break  # two periods of a decaying whirl may look alike
        rest = _rest(changes[: window + 1], changes[shift : shift + window + 1]) if told else 0.0
        if max(recent, rest) <= SAME:
            apart_at = np.flatnonzero(apart > SAME)
            first = int(apart_at[0]) - 1 if len(apart_at) else len(apart) - 1
            return "periodic", n, first + shift, ""
        if n == 1 and recent <= SAME:
            return "not settled", 0, None, _SETTLES
    count = (last + 1) // numerics.STEADY_STATE_PHASES
    if last < numerics.STEADY_STATE_PHASES:
        return "not settled", 0, None, _SHORT
    if count < ENOUGH:
        lasts = f"{last / numerics.STEADY_STATE_PHASES:.3g}"
        why = f"it does not repeat within {lasts} period{'' if lasts == '1' else 's'}"
        if last > numerics.STEADY_STATE_PHASES:
            apart = np.abs(
                states[: min(numerics.STEADY_STATE_PHASES, last - numerics.STEADY_STATE_PHASES) + 1]
                - states[numerics.STEADY_STATE_PHASES : 2 * numerics.STEADY_STATE_PHASES + 1]
            ).max()
            why += f"; the states of the last two periods differ by {apart:.2g}{scale and f' {scale}'}"
        return "not settled", 0, None, why
    growth, steps = _neighbours(states, count)
    if growth > GROWTH:
        return "chaotic", 0, None, f"close states diverge by a factor of {np.exp(growth):.2g} in a period"
    if growth * count < np.log(numerics.STEADY_STATE_SHRINKS) or steps < numerics.STEADY_STATE_SHRINKS:
        return "not settled", 0, None, _SETTLES
    return "quasi-periodic", 0, None, "it does not repeat, and close states stay close"


def _rest(recent: Array, before: Array) -> float:
    """Extrapolate the remaining sum of changes (nt, m) as geometric series."""
    factor = (recent * before).sum(axis=0) / np.maximum((before * before).sum(axis=0), 1e-300)
    shrinks = (factor > 0.0) & (factor < 1.0)
    return float(np.max(np.abs(recent).max(axis=0)[shrinks] * (factor / (1.0 - factor))[shrinks], initial=0.0))


def _neighbours(states: Array, count: int) -> tuple[float, float]:
    """Compute the growth of the logarithmic distance of neighbours per period; ratio of later to earlier changes."""
    part = numerics.STEADY_STATE_PHASES // 4  # positions over a time, instead of rates
    blocks = np.array(
        [
            states[k * numerics.STEADY_STATE_PHASES : k * numerics.STEADY_STATE_PHASES + part].ravel()
            for k in range(count)
        ]
    )
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
