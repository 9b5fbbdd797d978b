"""Figures of one or more panels in the two widths of a page, with the answer above and the legend below them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from linkages.base.palette import SIZES, SOFT
from linkages.show.plots.presentation import presentation
from linkages.show.plots.style import COLUMN, needs_height, small_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDE = 160.0 / 25.4  # width of figures, unless another one is asked for [in]
_LETTER = 0.66, 0.56  # mean width of letters over the size of the text: semibold, normal
_LINE = 1.3  # height of a line of text over its size
_NEEDED = "needed_height"  # attribute of a figure [in]
_HANDLE = 5  # letters that the line of a legend's entry takes with its gaps


def figure_width() -> float:
    """Return the width of figures [in]: the presented one, or that of a page's text."""
    asked = presentation().size
    return asked[0] if asked else WIDE


def narrow() -> bool:
    """Tell whether figures are for one column of a page."""
    return figure_width() < COLUMN


def make_panels(
    count: int, height: float, most: int = 2, narrowly: int = 1, **options: Any
) -> tuple[Figure, list[Axes]]:
    """Make a figure and its panels (count,) in rows; at most so many in a row, `narrowly` in one column of a page.

    Parameters
    ----------
    height : float
        Of each row with its labels [in at 9 pt].
    options
        Of `matplotlib.figure.Figure.subplots`.
    """
    columns = min(count, narrowly if narrow() else most)
    rows = -(-count // columns)
    figure = page(rows * height)
    axes = list(figure.subplots(rows, columns, squeeze=False, **options).ravel())
    for spare in axes[count:]:
        spare.remove()
    return figure, axes[:count]


def page(height: float) -> Figure:
    """Make a figure without panels, as wide as the page or one of its columns, of a height [in at 9 pt]."""
    import matplotlib as mpl

    from linkages.show.plots.shown import ShownFigure

    figure = ShownFigure(figsize=(figure_width(), 1e-3), layout="constrained")
    grow(figure, height * float(mpl.rcParams["font.size"]) / SIZES[0])
    return figure


def grow(figure: Figure, height: float) -> None:
    """Add to the height of a figure [in], which it then needs; a figure is as high as asked if that is more."""
    import matplotlib as mpl

    asked = presentation().size
    tall = getattr(figure, _NEEDED, 0.0) + height
    setattr(figure, _NEEDED, tall)
    figure.set_size_inches(figure_width(), max(tall, asked[1] if asked else 0.0))
    needs_height(figure, tall * SIZES[0] / float(mpl.rcParams["font.size"]))


def say(figure: Figure, *sentences: str) -> None:
    """Write the answer of a figure above it, each sentence from a new line; it is its alternative text, too."""
    import matplotlib as mpl

    size = float(mpl.rcParams["font.size"])
    letters = max(int(72.0 * figure_width() / (_LETTER[0] * size)), 20)
    lines = [line for one in sentences for line in textwrap.wrap(one.replace(" %", "\u00a0%"), letters)]
    if lines:
        look: dict[str, Any] = {"ha": "left", "fontweight": "bold", "fontsize": size}
        figure.suptitle("\n".join(lines), x=0.01, **look)
        grow(figure, _LINE * size * len(lines) / 72.0)
    figure.set_label(". ".join(one.rstrip(".") for one in sentences) + "." * bool(sentences))


def note(figure: Figure, *sentences: str) -> None:
    """Write a remark below a figure, in small text, each sentence from a new line."""
    size = small_text()
    letters = int(72.0 * figure_width() / (_LETTER[1] * size))
    lines = [line for one in sentences for line in textwrap.wrap(one, letters)]
    if lines:
        figure.supxlabel("\n".join(lines), x=0.01, ha="left", fontsize=size, color=SOFT)
        grow(figure, _LINE * size * len(lines) / 72.0)


def legend_below(figure: Figure, axes: Iterable[Axes] | None = None, **options: Any) -> None:
    """Write one legend for the labels of all panels below them, in as many columns as have room."""
    drawn = figure.axes if axes is None else axes
    pairs = (zip(*axis.get_legend_handles_labels()[::-1], strict=True) for axis in drawn)
    found = options.pop("entries", None) or {label: handle for one in pairs for label, handle in one}
    if not found:
        return
    longest = max(map(len, found)) + _HANDLE
    columns = max(min(int(72.0 * figure_width() / (_LETTER[1] * small_text() * longest)), len(found)), 1)
    look: dict[str, Any] = {"fontsize": small_text(), "handlelength": 1.6, "columnspacing": 1.2}
    figure.legend([*found.values()], [*found], loc="outside lower left", ncols=columns, **look | options)
    grow(figure, _LINE * small_text() * -(-len(found) // columns) / 72.0 + 0.05)
