"""How all figures look: one style, one palette."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl

#: Okabe and Ito's palette: distinct to colour-blind readers, and in grey.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")

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
    return mpl.rc_context(_STYLE)
