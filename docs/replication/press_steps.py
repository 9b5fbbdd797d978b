"""Fixed steps of 0.1 ms (Tables 4 and 5) as a cause of the printed spike: the paper's own formulation so integrated."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np

from replication.press_paper import Array

sys.path.append(str(Path(__file__).parents[2] / "tests"))
import paper_formulation

STEP = 1e-4  # s, Tables 4 and 5
END = 0.01  # s, of which the spike is looked for


def _rates(t: float, state: Array) -> Array:
    q, v = state[:18], state[18:]
    with np.errstate(all="ignore"):
        return np.concatenate([v, paper_formulation.accelerations(t, q, v, paper_formulation.Data())])


@cache
def explicit() -> float:
    """Time at which Runge and Kutta's method of fourth order leaves the bearing [s]; the end, if it does not."""
    state = np.concatenate(paper_formulation.start(paper_formulation.Data()))
    for n in range(round(END / STEP)):
        t, h = n * STEP, STEP
        k1 = _rates(t, state)
        k2 = _rates(t + h / 2, state + h / 2 * k1)
        k3 = _rates(t + h / 2, state + h / 2 * k2)
        k4 = _rates(t + h, state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if not _inside(state):
            return t + h
    return END


@cache
def implicit() -> float:
    """Largest acceleration of the slider by Euler's implicit method, infinite where its equations are not solved [m/s2]."""
    state = np.concatenate(paper_formulation.start(paper_formulation.Data()))
    largest = 0.0
    for n in range(1, round(END / STEP) + 1):
        t, new = n * STEP, state.copy()
        base = _rates(t, state)
        shifts = 1e-7 * np.maximum(np.abs(state), 1e-3)
        columns = [(_rates(t, state + shift) - base) / shift.max() for shift in np.diag(shifts)]
        matrix = np.linalg.inv(np.eye(36) - STEP * np.array(columns).T)
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


def _inside(state: Array) -> bool:
    found = paper_formulation.joints(state[:18], state[18:], paper_formulation.Data())
    sizes = [np.hypot(*item[0]) for item in found]
    return bool(np.all(np.isfinite(sizes)) and max(sizes) < paper_formulation.Data().clearance[0])
