"""Fixed steps of 0.1 ms (Tables 4 and 5) as a cause of the printed spike: the paper's own formulation so integrated."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np

from replication.press_paper import Array, conditions

sys.path.append(str(Path(__file__).parents[2] / "tests"))
import paper_formulation

STEP = 1e-4  # s, Tables 4 and 5
#: The classical method is stable up to this step over the time constant of a decay: 1 - z + z^2/2 - z^3/6 + z^4/24 = 1.
STABLE = 2.785293563405282
END = 0.01  # s, of which the spike is looked for


@cache
def _data() -> paper_formulation.Data:
    """Give the data of the press under the conditions of `PAPER`, without eqs. (12)-(13)."""
    found = conditions()
    return paper_formulation.Data(
        omega=(found["drives.O1.speed"], found["drives.O4.speed"]), gravity=tuple(found["gravity"][:2])
    )


class _Left(Exception):  # noqa: N818 (an event)
    """A journal is beyond its bearing, where the film has no force."""


def _rates(t: float, state: Array) -> Array:
    q, v = state[:18], state[18:]
    if not all(np.hypot(*e) < c for (e, *_), c in zip(paper_formulation.gaps(q, v), _data().clearance, strict=True)):
        raise _Left
    return np.concatenate([v, paper_formulation.accelerations(t, q, v, _data())])


@cache
def explicit() -> float:
    """Time of the step in which Runge and Kutta's method of fourth order leaves the bearing [s]; the end, if it does not."""
    state = np.concatenate(paper_formulation.start(_data()))
    for n in range(round(END / STEP)):
        t, h = n * STEP, STEP
        try:
            k1 = _rates(t, state)
            k2 = _rates(t + h / 2, state + h / 2 * k1)
            k3 = _rates(t + h / 2, state + h / 2 * k2)
            k4 = _rates(t + h, state + h * k3)
        except _Left:
            return t + h
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return END


@cache
def implicit() -> float:
    """Largest acceleration of the slider by Euler's implicit method, infinite where its equations are not solved [m/s2]."""
    state = np.concatenate(paper_formulation.start(_data()))
    largest = 0.0
    for n in range(1, round(END / STEP) + 1):
        t, new = n * STEP, state.copy()
        matrix = np.linalg.inv(np.eye(36) - STEP * _jacobian(t, state))
        for _ in range(30):
            change = matrix @ (new - state - STEP * _rates(t, new))
            new = new - change
            if np.abs(change).max() < 1e-10:
                break
        else:
            return np.inf
        state = new
        largest = max(largest, abs(float(_rates(t, state)[33])))
    return largest


@cache
def fastest() -> float:
    """Least time constant at the start [s]."""
    rates = np.linalg.eigvals(_jacobian(0.0, np.concatenate(paper_formulation.start(_data()))))
    return float(1.0 / np.abs(rates).max())


def _jacobian(t: float, state: Array) -> Array:
    base = _rates(t, state)
    shifts = 1e-7 * np.maximum(np.abs(state), 1e-3)
    return np.array([(_rates(t, state + shift) - base) / shift.max() for shift in np.diag(shifts)]).T
