"""How far derivatives predict: the largest change of a value at which runs still follow the straight line.

A derivative of a peak can be exact and hold for a millionth of the value only: where the motion is sensitive to its
start, or another maximum becomes the peak. So it is compared with runs at the changes `STEPS` of the value, in both
directions. It predicts a change if the runs there, and at the next two smaller steps, depart from the straight line by
at most a tenth of the predicted change. Statements about a change of 1 % (`STATED`) need a derivative that predicts it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.base.errors import Status, listed
from linkages.engines.compiled.batch.batch import Batch
from linkages.engines.compiled.derivatives.neighbours import magnitude_of
from linkages.explore.numerics import PREDICTION_DEPARTS, PREDICTION_FELT, PREDICTION_TOGETHER
from linkages.results.shape import RunWarning
from linkages.results.validity import warning
from linkages.system import System

Flags = NDArray[np.bool_]

#: Change of a value that tables and sentences are about, in parts of the value.
STATED = 0.01
#: Examined changes of a value, in parts of it.
STEPS = np.array([1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6])
#: Why a derivative predicts less.
WHY = "the motion is sensitive to its start, or another maximum becomes the peak"
_TIGHTER, _LEAST = 1e-3, 1e-13  # accuracy of runs at small steps over the usual one, and its least value
_SIGNS = np.array([1.0, -1.0])


def reaches(values: Mapping[str, float], rates: Array, scales: Array, numbers: Callable[[Array, bool], Array]) -> Array:
    """Find the changes up to which derivatives predict.

    Parameters
    ----------
    values : mapping of str to float
        The np values by path.
    rates : (np, nk) array
        Derivatives of nk numbers by each value; NaN where there is none.
    scales : (nk,) array
        Magnitudes of the numbers, such as the peak of an output for its mean.
    numbers : callable
        Makes the numbers (m, nk) of runs with values (m, np): NaN where a run fails, infinite where a value is not
        allowed. Its second argument tells whether the runs need a tighter accuracy, see `finer`.

    Returns
    -------
    (np, nk) array
        In parts of the value (of its unit's magnitude, if it is zero): `STATED` or less, 0 where a derivative predicts
        none of `STEPS`; NaN without a derivative.
    """
    nominal, known = np.array([*values.values()]), ~np.isnan(rates)
    sizes = np.array([magnitude_of(path, value) for path, value in values.items()])
    follows = np.zeros((len(STEPS), *rates.shape), dtype=bool)
    largest, others = slice(PREDICTION_TOGETHER), slice(PREDICTION_TOGETHER, len(STEPS))
    # without the errors of the runs, and with smaller steps, only for the values that need them
    for tight, part in ((False, largest), (True, largest), (True, others)):
        left = np.flatnonzero((known & ~follows[:PREDICTION_TOGETHER].all(axis=0)).any(axis=1))
        if not len(left):
            break
        moves = STEPS[part, None, None, None] * (sizes * np.eye(len(sizes)))[left] * _SIGNS[:, None, None]
        found = numbers(np.concatenate([nominal[None], nominal + moves.reshape(-1, len(sizes))]), tight)
        with np.errstate(invalid="ignore"):  # failed runs
            changes = (found[1:] - found[0]).reshape(*moves.shape[:-1], len(scales))
            follows[part, left] = _follow(changes, moves.sum(axis=-1), sizes[left], rates[left], scales)
    return np.where(known, _longest(follows), np.nan)


def _follow(changes: Array, moves: Array, sizes: Array, rates: Array, scales: Array) -> Flags:
    """Whether numbers follow the straight line (steps, values, nk), by their changes (steps, signs, values, nk)."""
    line = moves[..., None] * rates
    least = PREDICTION_FELT * np.abs(moves / sizes)[..., None] * scales
    near = np.abs(changes - line) <= PREDICTION_DEPARTS * np.maximum(np.abs(line), least)
    allowed = ~np.isinf(changes)
    return np.asarray((near | ~allowed).all(axis=1) & allowed.any(axis=1))


def _longest(follows: Flags) -> Array:
    """Return the largest of `STEPS` at which, and at the next two, numbers follow the line; 0 without one."""
    together = np.stack(
        [follows[k : len(STEPS) - PREDICTION_TOGETHER + 1 + k] for k in range(PREDICTION_TOGETHER)]
    ).all(axis=0)
    return np.where(together.any(axis=0), STEPS[together.argmax(axis=0)], 0.0)


def finer(system: System) -> System:
    """Return the system at the accuracy that shows the changes of numbers by small steps."""
    accuracy = system.settings.accuracy
    return system.replaced({"solver.accuracy": max(_TIGHTER * accuracy, min(accuracy, _LEAST))})


def numbers_of(batch: Batch, keys: Sequence[str]) -> Array:
    """Return numbers of the first window of runs by keys (``B.force.peak``, ``O.work``), as `reaches` needs them."""
    columns = []
    for name, _, kind in (key.rpartition(".") for key in keys):
        output, statistic = (f"{name}.power", "mean") if kind == "work" else (name, kind)
        column = getattr(batch, statistic)[:, 0, batch.outputs.index(output)]
        columns.append(column * (np.ptp(batch.windows[0]) if kind == "work" else 1.0))
    found = np.stack(columns, axis=1)
    found[[status is Status.BAD_INPUT for status in batch.status]] = np.inf
    return found


def warnings_of(reach: Mapping[str, Mapping[str, float]]) -> Iterator[RunWarning]:
    """Warn of peaks whose derivatives do not predict the stated change; `reach` by path and key."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for path, line in reach.items():
        keys = tuple(key for key, one in line.items() if key.endswith(".peak") and one < STATED)
        groups.setdefault(keys, []).append(path)
    for keys, paths in groups.items():
        if keys:
            what = (
                f"no statement is possible about a change of {listed(paths)} by {100.0 * STATED:g} %: runs there depart"
            )
            what += f" by more than a tenth from what the derivatives of {listed(keys)} predict, since {WHY}"
            yield warning(
                "reach", None, what, "use derivatives of means over many periods, or runs of scattered values"
            )


def extent(reach: float) -> str:
    """Write how far a derivative predicts: "0.02 %", "at least 1 %", "nothing"."""
    if reach == 0.0:
        return "nothing"
    return f"{'at least ' if reach == STATED else ''}{100.0 * reach:g} %"
