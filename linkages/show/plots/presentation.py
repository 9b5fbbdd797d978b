"""How results are shown: the format, size and style of figures; a setting of a block, like numpy's print options."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from linkages.base.errors import InputError, nearest

FORMATS, STYLES = ("png", "pdf", "svg"), ("screen", "print")
_SIZE = re.compile(r"(\d+\.?\d*)\s*(?:x\s*(\d+\.?\d*)\s*)?(mm|cm|in)")
_INCH = {"mm": 1.0 / 25.4, "cm": 1.0 / 2.54, "in": 1.0}
_LARGEST = 50.0  # width or height of a figure [in]


@dataclass(frozen=True)
class Presentation:
    """How results are shown.

    Attributes
    ----------
    format : str
        Of the files of figures: "png", "pdf", "svg".
    size : tuple of float, optional
        Width and height of figures [in]; a height 0 keeps their proportions. Default: each figure has its own size.
    style : str
        "screen", or "print": smaller text, thinner lines, 300 dots per inch.
    """

    format: str = "png"
    size: tuple[float, float] | None = None
    style: str = "screen"


_current: ContextVar[Presentation] = ContextVar("presentation")


def presentation() -> Presentation:
    """Return how results are shown here."""
    return _current.get(Presentation())


@contextmanager
def presented(format: str | None = None, size: str | None = None, style: str | None = None) -> Iterator[None]:
    """Show results in a block like this; None keeps what holds outside.

    Parameters
    ----------
    format, style : str, optional
        See `Presentation`.
    size : str, optional
        Width and height of figures, such as "85x60mm", or the width alone.

    Raises
    ------
    InputError
        If one of them is unknown.

    Examples
    --------
    >>> from linkages.plots import presented
    >>> from linkages.show.plots.presentation import presentation
    >>> with presented(format="pdf", size="85x60mm", style="print"):
    ...     presentation().format
    'pdf'
    """
    for name, given, known in (("format", format, FORMATS), ("style", style, STYLES)):
        if given not in (None, *known):
            raise InputError("argument", name, f'is "{given}"; {nearest(str(given), known)}')
    outside = presentation()
    inside = Presentation(format or outside.format, _size(size) if size else outside.size, style or outside.style)
    token = _current.set(inside)
    try:
        yield
    finally:
        _current.reset(token)


def _size(text: str) -> tuple[float, float]:
    found = _SIZE.fullmatch(text.strip())
    width, height = (_INCH[found[3]] * float(part or 0.0) for part in found.groups()[:2]) if found else (0.0, 0.0)
    if not (0.0 < width <= _LARGEST and height <= _LARGEST) or (found and found[2] and not height):
        raise InputError("argument", "size", f'is "{text}"; write the width and height, or the width, as 85x60mm')
    return width, height
