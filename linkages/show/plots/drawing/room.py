"""Free space for names in a drawing."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from linkages.base.arrays import Array
from linkages.show.plots.drawing.shapes import STYLES

# lengths in units of the drawing
_STEP = 0.5  # distance of the sample points of a line
_BAR = 0.65  # half a bar's width
# relative to the size of a text
_LETTER, _HEIGHT = 0.31, 0.6  # half the width of a letter, half the height of a line
# cost of a position of a name
_BEYOND, _ON_TEXT, _ON_LINE, _MOST = 4.0, 3.0, 0.1, 12  # per point of a line; most counted points


class Room:
    """Occupied lines and boxes at the start of a drawing with corners (2,) [m], which names must avoid."""

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high, self.unit = low, high, float(high[0] - low[0]) / 100.0
        self._points: list[Array] = []
        self._boxes: list[tuple[Array, Array]] = []

    def take_line(self, points: Sequence[Array] | Array) -> None:
        """Mark a line through points (n, 2) [m] as occupied."""
        ends = np.asarray(points, dtype=np.float64)
        for start, end in itertools.pairwise(ends):
            count = 2 + int(np.linalg.norm(end - start) / (_STEP * self.unit))
            self._points.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))

    def take_box(self, one: Array, other: Array) -> None:
        """Mark a box between two corners (2,) [m] as occupied."""
        self._boxes.append((np.minimum(one, other), np.maximum(one, other)))

    def take_name(self, role: str, middle: Array, text: str) -> None:
        """Mark the box of a name around its middle (2,) [m] as occupied."""
        half = self.half(role, text)
        self.take_box(middle - half, middle + half)

    def half(self, role: str, text: str) -> Array:
        """Compute half the width and height of a text (2,) [m]."""
        size = STYLES[role].size * self.unit
        return np.array([_LETTER * size * len(text), _HEIGHT * size])

    def cost(self, role: str, middle: Array, text: str) -> float:
        """Compute the cost of a text around its middle (2,) [m]: 0 in free space within the picture."""
        half = self.half(role, text)
        low, high = middle - half, middle + half
        total = _BEYOND if np.any(low < self.low) or np.any(high > self.high) else 0.0
        total += _ON_TEXT * sum(bool(np.all(low < above) and np.all(below < high)) for below, above in self._boxes)
        if self._points:
            points, around = np.concatenate(self._points), _BAR * self.unit
            inside = np.all((points > low - around) & (points < high + around), axis=1).sum()
            total += _ON_LINE * min(int(inside), _MOST)
        return total
