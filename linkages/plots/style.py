"""How all figures look: style, palette, line styles, labels of axes, legends. Loads without matplotlib."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Okabe and Ito's palette: distinct to colour-blind readers, and in grey.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
#: Line styles in the order of the colours.
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 150,
    "legend.frameon": False,
}
#: Prefixes of units and their factors, the largest first.
_PREFIXED = {"m": (("", 1.0), ("m", 1e3), ("µ", 1e6)), "N": (("k", 1e-3), ("", 1.0)), "Pa": (("G", 1e-9), ("M", 1e-6))}
_SHOWN = {"m": ("mm", 1e3), "1": ("", 1.0)}


def figure_style() -> AbstractContextManager[None]:
    """Return a context in which figures are drawn alike; settings outside are left alone."""
    import matplotlib as mpl

    return mpl.rc_context(_STYLE)


def shown(unit: str) -> tuple[str, float]:
    """Return the unit in which values of an SI unit are drawn, and the factor from one to the other."""
    return _SHOWN.get(unit, (typeset(unit), 1.0))


def engineering(unit: str, largest: float) -> tuple[str, float]:
    """Return the unit in which values up to a magnitude are read best, and the factor from the SI unit to it."""
    for prefix, factor in _PREFIXED.get(unit, ()):
        if largest * factor >= 1.0:
            return f"{prefix}{unit}", factor
    return ("", 1.0) if unit == "1" else (typeset(unit), 1.0)


def typeset(unit: str) -> str:
    """Write a unit with its exponent raised: m/s2 as m/s²."""
    return unit.replace("s2", "s²")


def axis_label(name: str, unit: str) -> str:
    """Join a name and its unit; what has no unit gets no brackets."""
    return f"{name} [{unit}]" if unit else name


def add_legend(axis: Axes) -> None:
    """Write the legend above the axes, right-aligned."""
    axis.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
