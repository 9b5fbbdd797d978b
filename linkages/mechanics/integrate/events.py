"""Event location: the first sign change of the event functions within a step, and a step that ends there."""

from __future__ import annotations

import math
from typing import Any

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel
from linkages.mechanics.integrate.stepper import Stepper

_TRIES = 60  # attempts at a step that ends on an event


@kernel
def first_event(
    modes: Indices, landing: Array, g0: Array, d0: Array, g1: Array, d1: Array, h: float
) -> tuple[int, float]:
    """Find the event function that changes its sign first within a step of size h: its index, -1 without; when, over h.

    Each function is interpolated by Hermite's cubic, so that a double change within the step is found too. ``modes``
    (ne,) are the signs before the event, ``landing`` the magnitudes that count as zero; values and rates are those at
    the start (0) and at the end (1) of the step.
    """
    which, where = -1, 2.0
    for k in range(len(modes)):
        m = modes[k]
        a, b = m * g0[k], m * g1[k]
        a = max(a, 0.0)  # the step before ended just across zero, and the function has turned back
        da, db = m * d0[k] * h, m * d1[k] * h
        right = 1.0
        if b >= 0.0:
            right = _lowest(a, da, b, db)
            if right <= 0.0 or _cubic(right, a, da, b, db) >= -landing[k]:
                continue
        left = 0.0
        for _ in range(50):
            middle = 0.5 * (left + right)
            if _cubic(middle, a, da, b, db) < 0.0:
                right = middle
            else:
                left = middle
        if right < where:
            which, where = k, right
    return which, where


@inlined_kernel
def _cubic(x: float, a: float, da: float, b: float, db: float) -> float:
    """Evaluate Hermite's cubic on [0, 1]."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    return a + x * (da + x * (c2 + x * c3))


@inlined_kernel
def _lowest(a: float, da: float, b: float, db: float) -> float:
    """Find the inner minimum of Hermite's cubic on [0, 1]; 0 if there is none."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    root = c2 * c2 - 3.0 * c3 * da
    if root < 0.0:
        return 0.0
    root = math.sqrt(root)
    x = (-c2 + root) / (3.0 * c3) if abs(c3) > 1e-14 * abs(c2) else (-0.5 * da / c2 if c2 > 0.0 else 0.0)
    return x if 0.0 < x < 1.0 else 0.0


def lander(attempt: Any, signs: Any) -> Any:
    """Make the compiled function that shortens a step to end on an event; see `linkages.mechanics.integrate.driver`."""

    @kernel
    def land(
        problem: Any, s: Stepper, t: float, h: float, y: Array, modes: Indices, landing: Array,
        g0: Array, d0: Array, g1: Array, d1: Array,
    ) -> tuple[int, float]:  # fmt: skip
        """Find the first event within an accurate step of size h, and repeat the step to end just across the event.

        The shorter steps have no error control, because they are parts of an accurate step. Returns the index of the
        event function, -1 without an event, and the size of the step, h without one, negative if a shorter step failed.
        """
        signs(problem, g1, d1)
        event, fraction = first_event(modes, landing, g0, d0, g1, d1, h)
        if event < 0:
            return event, h
        m, tiny = modes[event], landing[event]
        low, high = 0.0, h
        size = fraction * h
        for _ in range(_TRIES):
            size = min(max(size, low), high)
            error, _ = attempt(problem, s, t, size, y, True)
            if not error <= 1.0:
                return event, -1.0
            signs(problem, g1, d1)
            value, rate = m * g1[event], m * d1[event]
            if -tiny <= value < 0.0 or high - low <= 4e-16 * (t + h):
                return event, size
            if value >= 0.0:
                low = size
            else:
                high = size
            guess = size - (value + 0.5 * tiny) / rate if rate < 0.0 else 0.5 * (low + high)
            size = guess if low < guess < high else 0.5 * (low + high)
        return event, size

    return land
