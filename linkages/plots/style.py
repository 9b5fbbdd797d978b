"""How all figures look: one style, one palette, one list of line styles. Loads without matplotlib."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

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


def figure_style() -> AbstractContextManager[None]:
    """Return a context in which figures are drawn alike; settings outside are left alone."""
    import matplotlib as mpl

    return mpl.rc_context(_STYLE)
