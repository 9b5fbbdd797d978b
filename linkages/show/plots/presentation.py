"""How results are shown: units; format, size and style of figures; a setting of a block, like numpy's print options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from pathlib import Path

from linkages.base.errors import InputError, nearest
from linkages.input.files.unit_conversion import si as to_si

FORMATS, STYLES = ("png", "pdf", "svg"), ("screen", "print")
_SIZE = re.compile(r"(\d+\.?\d*)\s*(?:x\s*(\d+\.?\d*)\s*)?(mm|cm|in)")
_INCH = {"mm": 1.0 / 25.4, "cm": 1.0 / 2.54, "in": 1.0}
_SI = ("m", "rad", "m/s", "rad/s", "m/s2", "rad/s2", "N", "N m", "J", "W", "Pa", "Pa s", "m3/s", "kg", "kg m2", "N/m")
_EXACT = 1e-12  # relative rounding of a size in inches
_LARGEST = 50.0  # width or height of a figure [in]
_LEAST = 40.0 / 25.4, 30.0 / 25.4  # width and height that leave room for curves beside the texts at the axes [in]


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
    units : mapping of str to (str, float)
        Units of tables, figures, CSV files and pages by SI unit, and their factors; default: SI units with prefixes.
    """

    format: str = "png"
    size: tuple[float, float] | None = None
    style: str = "screen"
    units: Mapping[str, tuple[str, float]] = field(default_factory=dict)


_current: ContextVar[Presentation] = ContextVar("presentation")


def presentation() -> Presentation:
    """Return how results are shown here."""
    return _current.get(Presentation())


@contextmanager
def presented(
    format: str | None = None, size: str | None = None, style: str | None = None, units: str | None = None
) -> Iterator[None]:
    """Show results in a block like this; None keeps what holds outside.

    Parameters
    ----------
    format, style : str, optional
        See `Presentation`.
    size : str, optional
        Width and height of figures, such as "85x60mm", or the width alone; at least 40x30mm.
    units : str, optional
        Units such as "mm, deg, r/min", each instead of the SI unit of its kind.

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
    asked = _size(size) if size else outside.size
    inside = Presentation(format or outside.format, asked, style or outside.style, outside.units)
    token = _current.set(inside)
    try:
        show_in(units)
        yield
    finally:
        _current.reset(token)


def show_in(units: str | None, where: tuple[str | Path, str] = ("argument", "units")) -> None:
    """Show results in these units up to the end of the block of `presented`; `where` names them in an InputError."""
    if units:
        _current.set(replace(presentation(), units=_units(units, where)))


def shown(si: str) -> tuple[str, float]:
    """Return the unit in which tables show numbers of an SI unit, and its factor."""
    return presentation().units.get(si, (si, 1.0))


def shown_unit(si: str) -> str:
    """Return the unit in which tables show numbers of an SI unit."""
    return shown(si)[0]


def _units(text: str, where: tuple[str | Path, str]) -> dict[str, tuple[str, float]]:
    found: dict[str, tuple[str, float]] = {}
    for name in (part.strip() for part in text.split(",")):
        for si in _SI:
            try:
                factor = to_si(f"1 {name}", si)
            except ValueError:
                continue
            if si == "N m" and "J" in name:
                continue
            if si in found:
                raise InputError(*where, f'has two units instead of {si}, "{found[si][0]}" and "{name}"; give one')
            found[si] = name, 1.0 / factor
            break
        else:
            raise InputError(*where, f'has "{name}"; give units of {", ".join(_SI)}, such as "mm, deg, r/min"')
    return found


def _size(text: str) -> tuple[float, float]:
    found = _SIZE.fullmatch(text.strip())
    width, height = (_INCH[found[3]] * float(part or 0.0) for part in found.groups()[:2]) if found else (0.0, 0.0)
    if not (0.0 < width <= _LARGEST and height <= _LARGEST) or (found and found[2] and not height):
        raise InputError("argument", "size", f'is "{text}"; write the width and height, or the width, as 85x60mm')
    if width < (1.0 - _EXACT) * _LEAST[0] or 0.0 < height < (1.0 - _EXACT) * _LEAST[1]:
        least = f"{25.4 * _LEAST[0]:.0f} mm wide and {25.4 * _LEAST[1]:.0f} mm high, or larger"
        raise InputError("argument", "size", f'is "{text}", too small for the texts at the axes; write {least}')
    return width, height
