"""Common style of all figures: palette, line styles, axis labels, legends. Importable without matplotlib."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from linkages.base.errors import notice
from linkages.base.palette import AXIS_LINE, DATA_LINE, GRID_LINE, GRID_SHADE, INK, LEAST_SIZE, LINKS, SIZES, SOFT
from linkages.input.model.output_names import QUANTITIES, SHAPE_QUANTITIES
from linkages.input.model.skeleton import OTHER
from linkages.show.plots.presentation import presentation, shown

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

#: Colours of curves that belong to no link; see `linkages.base.palette`.
COLORS = LINKS
#: Line styles in the order of the colours.
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))


def look(k: int) -> dict[str, Any]:
    """Return colour and line of curve k of a figure; the first 36 differ."""
    return {"color": COLORS[k % len(COLORS)], "ls": LINES[(k + k // len(COLORS)) % len(LINES)]}


#: Position of legends: above the axes, right-aligned.
LEGEND: dict[str, Any] = {"ncols": 2, "loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}

_STYLE: dict[Any, Any] = {
    "font.size": SIZES[0],
    "font.sans-serif": ["DejaVu Sans"],
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.labelpad": 6.0,
    "axes.linewidth": AXIS_LINE,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.alpha": GRID_SHADE,
    "grid.linewidth": GRID_LINE,
    "grid.color": SOFT,
    "lines.linewidth": DATA_LINE,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.unicode_minus": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.dpi": 150,
    "legend.frameon": False,
    "pdf.fonttype": 42,  # text remains text; fonts are embedded
    "svg.fonttype": "none",
    "svg.hashsalt": "linkages",  # the same figure gives the same bytes
}
_PRINT = {
    "font.size": 7,
    "figure.dpi": 300,
    **{f"{axis}tick.major.{key}": value for axis in "xy" for key, value in (("width", 0.5), ("size", 2.5))},
}
_DATES: dict[str, dict[str, Any]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}  # none in the files
_DESCRIPTION = {"png": "Description", "pdf": "Subject", "svg": "Description"}
#: Margins of stacked axes [inches], and the gap between two of them.
_LEFT, _RIGHT, _TOP, _BOTTOM, _GAP = 0.98, 0.22, 0.34, 0.46, 0.14
_SHALLOW = 0.62  # least height of a panel on average [inches]
COLUMN = 100.0 / 25.4  # width of figures below which they have one column of a page [in]
_LEAST = "least_height"  # attribute of a figure [in]
_WIDE = 1.25  # of a figure, in parts of its margins: those of smaller ones shrink
_SMALL = math.radians(0.1)  # smaller angles are shown in mrad or less [rad]
_TINY = 1e-3  # pure numbers below it are drawn as multiples of a power of ten
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_RAISED = str.maketrans("23", "²³")
#: Prefixes of units and their factors, the largest first.
_PREFIXED = {
    "m": (("", 1.0), ("m", 1e3), ("µ", 1e6), ("n", 1e9)),
    "m/s": (("", 1.0), ("m", 1e3), ("µ", 1e6)),
    "m/s2": (("k", 1e-3), ("", 1.0), ("m", 1e3), ("µ", 1e6)),
    "rad/s2": (("k", 1e-3), ("", 1.0)),
    "rad": (("", 1.0), ("m", 1e3), ("µ", 1e6), ("n", 1e9)),
    "N": (("k", 1e-3), ("", 1.0), ("m", 1e3), ("µ", 1e6)),
    "N m": (("k", 1e-3), ("", 1.0), ("m", 1e3), ("µ", 1e6)),
    "J": (("k", 1e-3), ("", 1.0), ("m", 1e3), ("µ", 1e6)),
    "Pa": (("G", 1e-9), ("M", 1e-6), ("k", 1e-3), ("", 1.0)),
    "Pa s": (("", 1.0), ("m", 1e3)),
    "W": (("k", 1e-3), ("", 1.0), ("m", 1e3)),
    "N/m": (("M", 1e-6), ("k", 1e-3), ("", 1.0)),
}
#: Units that have no prefix, their readable ones and factors, the largest first.
_OTHERS = {
    "kg": (("kg", 1.0), ("g", 1e3)),
    "kg m2": (("kg m2", 1.0), ("kg mm2", 1e6)),
    "m3/s": (("m3/s", 1.0), ("cm3/s", 1e6)),
}


def figure_style() -> AbstractContextManager[None]:
    """Return a context with the style of all figures, as presented; settings outside are unchanged."""
    import matplotlib as mpl

    asked = presentation()
    small = asked.style == "print" or (asked.size is not None and asked.size[0] < COLUMN)
    return mpl.rc_context(_STYLE | (_PRINT if small else {}))


def resize(figure: Figure) -> None:
    """Give a figure the presented size, if there is one, or the height that its panels need."""
    if asked := presentation().size:
        width, height = figure.get_size_inches()
        figure.set_size_inches(asked[0], max(asked[1] or asked[0] * height / width, getattr(figure, _LEAST, 0.0)))


def needs_height(figure: Figure, least: float) -> None:
    """Give a figure at least a height [in at 9 pt], however small it is asked to be; its texts would overlap else."""
    import matplotlib as mpl

    setattr(figure, _LEAST, least * mpl.rcParams["font.size"] / SIZES[0])
    resize(figure)


def small_text() -> float:
    """Return the size of notes [pt]."""
    import matplotlib as mpl

    return max(0.85 * float(mpl.rcParams["font.size"]), LEAST_SIZE)


def write_answer(axis: Axes, answer: str, note: str = "", second: bool = False) -> None:
    """Write the answer of a panel above it, and a note: at the right, or in a second line, both from the left edge."""
    from matplotlib.transforms import blended_transform_factory

    line, figure = 1.35 * small_text(), axis.figure
    across = figure.transFigure if second and figure is not None else axis.transAxes
    left = blended_transform_factory(across, axis.transAxes)
    start = 0.02 if second else 0.0
    above: dict[str, Any] = {"textcoords": "offset points", "va": "bottom"}
    if answer:
        high = 3.0 + line * (second and bool(note))
        axis.annotate(answer, (start, 1.0), (0.0, high), left, fontweight="bold", **above)
    if note:
        place, side = ((start, 1.0), "left") if second else ((1.0, 1.0), "right")
        axis.annotate(note, place, (0.0, 3.0), left, ha=side, color=SOFT, fontsize=small_text(), **above)


def stacked_axes(figure: Figure, heights: Sequence[float], gap: float = _GAP, left: float = _LEFT) -> NDArray[Any]:
    """Add axes (n,) of relative heights over one abscissa, from the top, within fixed margins [inches].

    A figure that is too small for its panels gets the height that they need.
    matplotlib's constrained layout measures every text several times, which takes longer than the drawing.
    """
    import matplotlib as mpl

    count, top = len(heights), max(_TOP, gap)
    needs_height(figure, top + _BOTTOM + (count - 1) * gap + count * _SHALLOW)
    width, height = figure.get_size_inches() * _STYLE["font.size"] / mpl.rcParams["font.size"]
    width, height = max(width, _WIDE * (left + _RIGHT)), max(height, _WIDE * (top + _BOTTOM))
    mean = (height - top - _BOTTOM - (count - 1) * gap) / count
    sides = {"left": left / width, "right": 1.0 - _RIGHT / width}
    ends = {"top": 1.0 - top / height, "bottom": _BOTTOM / height}
    grid = {**sides, **ends, "hspace": gap / mean, "height_ratios": heights}
    return figure.subplots(count, 1, sharex=True, squeeze=False, gridspec_kw=grid)[:, 0]


def write_figure(figure: Figure, path: Path) -> Path:
    """Write a figure with the presented format, whose ending is added to the path; return the path."""
    path = path.with_name(f"{path.name}.{presentation().format}")
    save_figure(figure, path, presentation().format)
    return path


def save_figure(figure: Figure, path: Path, format: str) -> None:
    """Write a figure with the presented size; as PNG the bytes of `Figure.savefig`, which draws every figure twice."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    resize(figure)
    with warnings.catch_warnings(record=True) as said:
        warnings.filterwarnings("always", "constrained_layout not applied")
        if format == "png":
            FigureCanvasAgg(figure).print_png(path, metadata=_described(figure, format))
        else:
            with figure_style():
                figure.savefig(path, format=format, metadata=_described(figure, format))
    for one in said:
        if "constrained_layout not applied" in str(one.message):
            notice(f"{path.name} is too small for its panels, which overlap; give a larger size")
        else:
            warnings.warn(one.message, stacklevel=2)


def _described(figure: Figure, format: str) -> dict[str, Any]:
    """Return the metadata of a file: no dates, and the answer of the figure, which pages have as alternative text."""
    said = str(figure.get_label())
    return {**_DATES.get(format, {}), **({_DESCRIPTION[format]: said} if said else {})}


def engineering(unit: str, largest: float) -> tuple[str, float]:
    """Return the most readable unit for values up to a magnitude, and the factor from the SI unit."""
    if unit in presentation().units:
        name, factor = shown(unit)
        return typeset(name), factor
    for prefix, factor in _PREFIXED.get(unit, ()):
        if largest * factor >= 1.0:
            return f"{prefix}{typeset(unit)}", factor
    for name, factor in _OTHERS.get(unit, ()):
        if largest * factor >= 1.0:
            return typeset(name), factor
    return ("", 1.0) if unit == "1" else (typeset(unit), 1.0)


def readable(unit: str, largest: float) -> tuple[str, float]:
    """Return unit and factor of values over time as `engineering`, but of angles in degrees."""
    if unit == "rad" and largest >= _SMALL and unit not in presentation().units:
        return "deg", 180.0 / math.pi
    if unit == "1" and 0.0 < largest < _TINY:
        power = 3 * math.ceil(-math.log10(largest) / 3.0)
        return f"10⁻{str(power).translate(_POWERS)}", 10.0**power
    return engineering(unit, largest)


def round_length(most: float) -> tuple[float, str]:
    """Return the largest of 1, 2, 5, 10, ... up to a length [m], and its text."""
    decade = 10.0 ** math.floor(math.log10(most))
    length = decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= most)
    return length, f"{length:g} m" if length >= 1.0 else f"{1e3 * length:g} mm"


def asked_points(outputs: Iterable[str]) -> list[str]:
    """Return the distinct points with reported translational outputs."""
    parts = (name.rpartition(".") for name in outputs)
    moving = {*QUANTITIES, *SHAPE_QUANTITIES} - {"angle", "omega", "alpha"}
    return list(dict.fromkeys(point for point, _, what in parts if what in moving))


def color_for(colors: Mapping[str, str] | None, output: str) -> str:
    """Return the colour of an output's curve: its link's (`System.colors`), if they are known."""
    return COLORS[0] if colors is None else colors.get(output.partition(".")[0], OTHER)


def typeset(unit: str) -> str:
    """Write a unit with its exponent raised: m/s2 as m/s²."""
    return unit.translate(_RAISED)


def axis_label(name: str, unit: str, between: str = " ") -> str:
    """Join a name and its unit; without brackets if there is no unit."""
    return f"{name}{between}[{unit}]" if unit else name
