"""Figures with a notebook representation, and their axes."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure that a notebook shows at the end of a cell, with any matplotlib backend or none."""

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


def new_figure(
    height: float, rows: int = 1, columns: int = 1, width: float = 6.3, **options: Any
) -> tuple[Figure, Any]:
    """Make a figure of a size [in] and its axes: one, or an array as from `Figure.subplots`."""
    figure = ShownFigure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, **options)
