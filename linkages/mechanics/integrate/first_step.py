"""The size of a run's first step."""

from __future__ import annotations

import math
from typing import Any

from linkages.base.kernel import Array, kernel
from linkages.mechanics.integrate.stepper import Stepper, copy

# Limits of the first step, over the sixth root of the accuracy: change of an entry of the state relative to its scale;
# length relative to the shortest time constant; length where all rates are zero.
_CHANGE, _TIME_CONSTANT, _AT_REST = 0.01, 0.5, 1e-6
_DISTANCE = 1e-7  # of the state, relative to its scale, for the differences that give the time constant


def starter(rhs: Any) -> Any:
    """Make the compiled function that chooses the first step."""

    @kernel
    def first_step(problem: Any, s: Stepper, t: float, y: Array, accuracy: float) -> float:
        """Choose the size of the first step from (t, y), with f0 and the scale known.

        The size depends on the state and on the accuracy, and not on the end of the run. It resolves a stiff start,
        such as a film that stops a journal within nanoseconds: three differences of the rates, each in the direction of
        the previous one, give the shortest time constant.
        """
        speed = _largest(s.f0, s.scale)
        if not 0.0 < speed < math.inf:
            return _AT_REST
        direction, trial = s.error, s.trial[0]
        copy(s.f0, direction)
        size, square, distance = speed, 1.0, _DISTANCE / accuracy
        for k in range(3):
            for i in range(len(y)):
                trial[i] = y[i] + distance * direction[i] / size
            rhs(problem, t, trial, s.f1)
            for i in range(len(y)):
                direction[i] = s.f1[i] - s.f0[i]
            size = _largest(direction, s.scale)
            if not 0.0 < size < math.inf:
                square = 0.0
                break
            if k > 0:
                square *= size / distance
        rhs(problem, t, y, s.f0)
        step = _CHANGE / (accuracy * speed)
        if square > 0.0:
            step = min(step, _TIME_CONSTANT / math.sqrt(square))
        return step * accuracy ** (1.0 / 6.0)

    return first_step


@kernel
def _largest(entries: Array, scale: Array) -> float:
    """Find the largest magnitude of the entries relative to their scales."""
    found = 0.0
    for i in range(len(entries)):
        found = max(found, abs(entries[i]) / scale[i])
    return found
