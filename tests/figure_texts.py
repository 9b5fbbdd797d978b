"""Texts of figures as boxes: which are seen, and whether one is cut off or lies on another."""

from itertools import combinations

from matplotlib.axes import Axes
from matplotlib.text import Text

LEAST = 6.5  # size of text in one column of a page [pt]
_TOLERANCE = 2.0  # pixels


def boxes(figure):
    """Return all texts of a figure that are seen, with their boxes [px]."""
    renderer, hidden = figure.canvas.get_renderer(), set()
    for axes in figure.findobj(Axes):
        hidden |= set() if axes.get_visible() else set(axes.findobj(Text))
        for axis in (axes.xaxis, axes.yaxis):
            ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
            hidden |= {label for tick in ticks for label in (tick.label1, tick.label2)}
            shown = axis._update_ticks() if axes.axison else []
            hidden -= {label for tick in shown for label in (tick.label1, tick.label2) if label.get_visible()}
    texts = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return [(text, text.get_window_extent(renderer)) for text in texts if text not in hidden]


def faults(figure):
    """Name the texts of a figure that are too small, cut off, or on another one."""
    width, height, found = figure.bbox.width, figure.bbox.height, []
    known = boxes(figure)
    for text, box in known:
        if text.get_fontsize() < LEAST - 1e-9:
            found.append(f"{text.get_text()!r} is small")
        if min(box.x0, box.y0, width - box.x1, height - box.y1) < -_TOLERANCE:
            found.append(f"{text.get_text()!r} is cut off")
    for (one, box), (other, beside) in combinations(known, 2):
        across = min(box.x1, beside.x1) - max(box.x0, beside.x0)
        up = min(box.y1, beside.y1) - max(box.y0, beside.y0)
        if min(across, up) > _TOLERANCE:
            found.append(f"{one.get_text()!r} lies on {other.get_text()!r}")
    return found
