"""Smooth functions of recorded signals: Fourier series and smoothing splines whose accelerations can be used.

A motion repeats with every turn, or after a given period: its Fourier series has the order with the least BIC. Any
other signal becomes a quintic spline with the smoothness at which its residual equals the stated deviation of a sample
(Reinsch). Both are independent of the unit of time.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.recorded import Recording
from linkages.input.functions.definitions import TIME, formula, program
from linkages.mechanics.planar.motion import Pieces, Program, monotone_table

_TURN = 2.0 * math.pi
_MOST = 100  # largest order of a Fourier series
_SAMPLES = 4  # least samples per period of the highest harmonic
_LOOKS = 20_000  # most samples that select the order, at random to avoid aliasing
_LONGEST = 50_000  # most samples of a spline
_FINE = 0.3  # deviations by which samples of an angle differ at least
_ROUNDS = 12  # Gauss-Newton iterations for the speed
_ROUNDING = 1e-12  # relative to a signal's range: smaller residuals are rounding errors
_REPEATS = 2.0  # residual over deviation up to which a signal counts as repeating
_GAP = 2.5  # steps over the typical step that are a gap
_DIGITS = 9  # decimals of times in steps: times in ms and in s are the same


@dataclass(frozen=True)
class Smoothing:
    """How a signal is smoothed.

    Attributes
    ----------
    deviation : float
        Standard deviation of a sample, in the signal's unit; 0: the samples are exact.
    periodic : bool or None
        Whether the signal repeats; None: if it covers whole turns and the turns agree.
    period : float or None
        Time after which it repeats [s]; None: a turn.
    unwrap : bool
        Whether an angle jumps by a turn.
    factor : float
        Divisor of the series' order, or of the number of the spline's segments.
    """

    deviation: float
    periodic: bool | None = None
    period: float | None = None
    unwrap: bool = False
    factor: float = 1.0


@dataclass(frozen=True, eq=False)
class SmoothSignal:
    """A smooth function of a recorded signal.

    Attributes
    ----------
    function : Pieces or Program
    text : str
        Kind and order.
    rows : int
        Number of its samples.
    residual, deviation : float
        Root mean square of the residual, and the stated deviation, in the signal's unit.
    period : float or None
        Time after which it repeats [s].
    covered : tuple of float
        First and last time of the function [s].
    """

    function: Pieces | Program
    text: str
    rows: int
    residual: float
    deviation: float
    period: float | None
    covered: tuple[float, float]


@lru_cache(maxsize=64)
def fitted(
    recording: Recording,
    places: tuple[str, str, str | None],
    column: tuple[str, str, str | None],
    kind: str,
    smoothing: Smoothing,
    shift: float = 0.0,
    start: float = 0.0,
    line: tuple[float, float] = (1.0, 0.0),
) -> SmoothSignal:
    """Fit a column over another one, each given by name, SI unit and stated unit.

    `kind` is "angle" (of a drive: it may turn), "speed" (integrated, from the angle `start` at t = 0) or "value".
    `shift` is added to the places; the signal is the gain times the column plus the offset of the `line`. A ValueError
    has one sentence with the error and the remedy.
    """
    name = recording.path.name
    x, y = recording.column(*places) + shift, recording.column(*column)
    whole = np.isfinite(x) & np.isfinite(y)
    rows, x, y = np.flatnonzero(whole) + 1, x[whole], y[whole]
    if len(x) < 8:
        raise ValueError(f'column "{column[0]}" of {name} has {len(x)} numbers; 8 or more are needed')
    if (back := np.flatnonzero(np.diff(x) <= 0.0)).size:
        raise ValueError(f'column "{places[0]}" of {name} must increase, and does not after row {rows[back[0]]}')
    if kind == "angle":
        y = _unwrapped(x, y) if smoothing.unwrap else y
        jump = np.flatnonzero(np.abs(np.diff(y)) > 0.5 * _TURN)
        if jump.size and column[1] == "rad" and not smoothing.unwrap:
            raise ValueError(f'column "{column[0]}" of {name} jumps after row {rows[jump[0]]}; set unwrap = true')
    y = line[0] * y + line[1]
    return _series(x, y, kind, smoothing, start) or _spline(x, y, kind, smoothing, start)


def _unwrapped(t: Array, y: Array) -> Array:
    """Remove jumps by whole turns; across a gap the speed on both sides gives the number of turns."""
    steps, rises = np.diff(t), np.diff(y)
    rises -= _TURN * np.round(rises / _TURN)
    gaps = np.flatnonzero(steps > _GAP * np.median(steps))
    speeds = rises / steps
    usual = np.setdiff1d(np.arange(len(steps)), gaps)
    for k in gaps:
        near = usual[np.argsort(np.abs(usual - k))[:20]]
        expected = float(speeds[near].mean() * steps[k])
        rises[k] += _TURN * np.round((expected - rises[k]) / _TURN)
    result: Array = y[0] + np.concatenate([[0.0], np.cumsum(rises)])
    return result


def _series(t: Array, y: Array, kind: str, smoothing: Smoothing, start: float) -> SmoothSignal | None:
    """Fit a Fourier series to a signal that repeats; None if it does not."""
    if smoothing.periodic is False:
        return None
    t0, t, speed = float(t[0]), t - t[0], kind == "speed"
    found = _frequency(t, y, kind, smoothing)
    if found is None:
        return None
    omega, turns = found  # angular frequency, and turns per period
    periods = max(abs(omega) * t[-1] / _TURN, 1.0)
    most = max(1, min(_MOST, int(len(t) / periods / _SAMPLES)))
    some = np.arange(len(t))
    if len(t) > _LOOKS:
        some = np.sort(np.random.default_rng(0).choice(len(t), _LOOKS, replace=False))
    for _ in range(2):  # the order depends little on the frequency
        order = _order(t[some], y[some], omega, turns, speed, most, smoothing.deviation)
        if smoothing.factor != 1.0:
            order = min(most, max(1, round(max(order, 1) / smoothing.factor)))
        if smoothing.period is None:
            omega = _refined(omega, t, y, order, speed)
    columns = _basis(omega * t, order, omega, speed)
    left = y - turns * omega * (1.0 if speed else t)
    c = np.linalg.lstsq(columns, left, rcond=None)[0]
    residual = float(np.sqrt(np.mean((left - columns @ c) ** 2)))
    if smoothing.periodic is None and smoothing.period is None and residual > _REPEATS * smoothing.deviation:
        return None
    pairs = (c if speed else c[1:]).reshape(-1, 2).tolist()
    waves = [
        (math.hypot(a, b), k * omega, math.atan2(-b, a) - k * omega * t0) for k, (a, b) in enumerate(pairs, start=1)
    ]
    constant = float(c[0]) - turns * omega * t0 if not speed else 0.0
    if speed:
        constant = start - sum(amplitude * math.cos(phase) for amplitude, _, phase in waves)
    terms = [f"{constant!r} + {turns * omega!r}*t"]
    terms += [f"{amplitude!r}*cos({frequency!r}*t + {phase!r})" for amplitude, frequency, phase in waves]
    made = program(formula(" + ".join(terms), of_state=False), {TIME: 0})
    period = _TURN / abs(omega)
    text = f"Fourier series of order {order}, period {period:.6g} s"
    return SmoothSignal(made, text, len(t), residual, smoothing.deviation, period, (-math.inf, math.inf))


def _frequency(t: Array, y: Array, kind: str, smoothing: Smoothing) -> tuple[float, int] | None:
    """Return the angular frequency [rad/s] and the turns per period; None if the signal need not repeat.

    Without a period it is that of a turn, estimated from the time of all whole turns.
    """
    travel = y - y[0]
    if kind == "speed":
        travel = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (y[1:] + y[:-1]))])
    advance = float(travel[-1])
    if smoothing.period is not None:
        turns = round(advance / t[-1] * smoothing.period / _TURN) if kind != "value" else 0
        return _TURN / smoothing.period, turns
    last = 1.5 * abs(advance) / len(t)  # the last sample need not repeat the first
    turns = math.floor((abs(advance) + last) / _TURN) if kind != "value" else 0
    if turns < 1:
        if smoothing.periodic:
            raise ValueError("periodic needs period [s]: the recording is shorter than a turn")
        return None
    covered = abs(abs(advance) - turns * _TURN) <= last + 4.0 * smoothing.deviation
    if not smoothing.periodic and not (covered and smoothing.deviation > 0.0):
        return None
    passed = turns * _TURN
    time = float(t[-1]) * passed / abs(advance)
    if passed < abs(advance):
        time = float(np.interp(passed, np.maximum.accumulate(np.abs(travel)), t))
    return math.copysign(passed / time, advance), 1


def _basis(theta: Array, order: int, omega: float, speed: bool) -> Array:
    """Harmonics of a position, 1, cos, sin, cos 2 ..., or without the constant their rates; (n, 1 + 2 order)."""
    k = np.arange(1, order + 1)
    angles = np.outer(theta, k)
    cosines, sines = np.cos(angles), np.sin(angles)
    pair = (-omega * k * sines, omega * k * cosines) if speed else (cosines, sines)
    columns = np.stack(pair, axis=2).reshape(len(theta), -1)
    return columns if speed else np.hstack([np.ones((len(theta), 1)), columns])


def _order(t: Array, y: Array, omega: float, turns: int, speed: bool, most: int, deviation: float) -> int:
    """Select the order with the least BIC; equal samples count once: their errors are not independent."""
    target = y - turns * omega * (1.0 if speed else t)
    columns = _basis(omega * t, most, omega, speed)
    triangle = np.asarray(np.linalg.qr(np.column_stack([columns, target]), mode="r"))
    parts = triangle[:, -1] ** 2
    first = 0 if speed else 1
    left = np.array([parts[first + 2 * k :].sum() for k in range(most + 1)])
    samples, step = y, _ROUNDING * float(np.ptp(y))
    if turns and not speed:  # a sensor's errors repeat with its angle
        samples, step = np.mod(y, _TURN), _FINE * deviation
    count = len(np.unique(np.round(samples / step) if step > 0.0 else samples))
    floor = len(t) * (_ROUNDING * (float(np.ptp(y)) or 1.0)) ** 2
    criterion = count * np.log(left + floor) + 2.0 * np.arange(most + 1) * math.log(count)
    return int(np.argmin(criterion))


def _refined(omega: float, t: Array, y: Array, order: int, speed: bool) -> float:
    """Refine the mean speed of a motion that repeats with every turn, by Gauss and Newton's method."""
    k = np.repeat(np.arange(1, order + 1), 2)
    for _ in range(_ROUNDS):
        theta = omega * t
        columns = _basis(theta, order, omega, speed)
        left = y - omega * (1.0 if speed else t)
        c = np.linalg.lstsq(columns, left, rcond=None)[0]
        harmonics = c if speed else c[1:]
        first = _basis(theta, order, 1.0, True) @ harmonics
        second = -(_basis(theta, order, 1.0, False)[:, 1:] * k**2) @ harmonics
        slope = 1.0 + first + theta * second if speed else t * (1.0 + first)
        change = float(np.linalg.lstsq(np.column_stack([columns, slope]), left - columns @ c, rcond=None)[0][-1])
        omega += change
        if abs(change) <= 1e-13 * abs(omega):
            break
    return omega


def _spline(t: Array, y: Array, kind: str, smoothing: Smoothing, start: float) -> SmoothSignal:
    """Fit a quintic smoothing spline; exact samples of a value: monotone cubics, of a motion: a quintic spline."""
    from scipy.interpolate import PPoly, make_interp_spline, make_lsq_spline, make_splrep

    t0, step = t[0], float(t[-1] - t[0]) / (len(t) - 1)
    u = np.round((t - t0) / step, _DIGITS)
    text = "quintic smoothing spline"
    if smoothing.deviation > 0.0:
        if len(t) > _LONGEST:
            raise ValueError(f"has {len(t)} samples; a spline takes up to {_LONGEST}: shorten or average the recording")
        weights = np.full(len(t), 1.0 / smoothing.deviation)
        with warnings.catch_warnings():  # the residual is reported
            warnings.simplefilter("ignore", RuntimeWarning)
            spline = make_splrep(u, y, w=weights, k=5, s=len(t))
        if smoothing.factor != 1.0:
            knots = spline.t[5:-5]  # the same distribution of more or fewer
            count = min(max(1, round((len(knots) - 1) / smoothing.factor)), len(t) // 8)
            inner = np.interp(np.linspace(0.0, len(knots) - 1, count + 1), np.arange(len(knots)), knots)
            spline = make_lsq_spline(u, y, np.r_[[u[0]] * 5, inner, [u[-1]] * 5], k=5)
    elif kind == "value":
        covered = float(t[0]), float(t[-1])
        return SmoothSignal(
            monotone_table(t.tolist(), y.tolist()),
            "monotone cubics through all samples",
            len(t),
            0.0,
            0.0,
            None,
            covered,
        )
    else:
        spline, text = make_interp_spline(u, y, k=5), "quintic spline through all samples"
    residual = float(np.sqrt(np.mean((spline(u) - y) ** 2)))
    if kind == "speed":
        spline = spline.antiderivative()
    pieces = PPoly.from_spline(spline)
    lasting = np.flatnonzero(np.diff(pieces.x) > 0.0)
    breaks = np.append(pieces.x[lasting], pieces.x[lasting[-1] + 1])
    powers = np.arange(len(pieces.c) - 1, -1, -1)[:, None]
    c = pieces.c[:, lasting] / step**powers
    if kind == "speed":
        c *= step
        c[-1] += start - step * float(spline(np.clip(-t0 / step, 0.0, u[-1])))
    text += f" of {len(breaks) - 1} segments" if smoothing.deviation > 0.0 else ""
    made = Pieces(c, t0 + step * breaks)
    return SmoothSignal(made, text, len(t), residual, smoothing.deviation, None, (float(t[0]), float(t[-1])))
