"""Names and units on axes, and where legends go."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHOWN = {"m": ("mm", 1e3), "1": ("", 1.0)}


def shown(unit: str) -> tuple[str, float]:
    """Return the unit in which values of an SI unit are drawn, and the factor from one to the other."""
    return _SHOWN.get(unit, (typeset(unit), 1.0))


def typeset(unit: str) -> str:
    """Write a unit with its exponent raised: m/s2 as m/s²."""
    return unit.replace("s2", "s²")


def axis_label(name: str, unit: str) -> str:
    """Join a name and its unit; what has no unit gets no brackets."""
    return f"{name} [{unit}]" if unit else name


def add_legend(axis: Axes) -> None:
    """Write the legend above the axes, right-aligned."""
    axis.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
