"""Tables of a report as data: a command writes them into its record, and the page shows them.

The first cell of a row is its name. Cells are texts for people: four digits, a readable unit; files of results have all
digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from linkages.show.plots.names import name_of_output, name_of_value, sentence
from linkages.show.plots.quantities import number, quantity, uncertain

if TYPE_CHECKING:
    from linkages.explore.sensitivity import Sensitivities
    from linkages.explore.sweep import Sweep

_POLES = 20  # most rows of poles
_TWO_WAYS = ("along the load", "across")


@dataclass(frozen=True)
class PageTable:
    """A table; the first cell of each row is its name."""

    caption: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    text: frozenset[int] = frozenset({0})  # indices of columns with words

    @property
    def content(self) -> dict[str, Any]:
        """Return the table as JSON types."""
        return asdict(self) | {"text": sorted(self.text)}


def page_table(content: Mapping[str, Any]) -> PageTable:
    """Make a table from its content in a record."""
    rows = [tuple(row) for row in content["rows"]]
    return PageTable(content["caption"], tuple(content["head"]), rows, frozenset(content["text"]))


def measured(value: float | None, si: str, digits: int = 4) -> str:
    """Write a value with its readable unit; "-" for none."""
    return "-" if value is None or not math.isfinite(value) else quantity(value, si, digits)


def matrix(found: Sensitivities, unit_of: Callable[[str], str]) -> list[PageTable]:
    """Tabulate the changes of all peaks with 1 % of each value, and the values; `unit_of` gives a path's SI unit."""
    from linkages.show.plots.changes import cell, matrix_of

    table = matrix_of(found)
    rows = [
        (sentence(name), *(cell(float(one)) for one in line))
        for name, line in zip(table.rows, table.changes, strict=True)
    ]
    caption = "Change of peaks with 1 % of each value [%]; -: below 0.01 %, ?: no statement about 1 %"
    values = [
        (sentence(name_of_value(path)), path, measured(value, unit_of(path))) for path, value in found.values.items()
    ]
    values_table = PageTable("Values", ("value", "path", "now"), values, frozenset({0, 1}))
    return [PageTable(caption, ("", *table.columns), rows), values_table]


def modes(content: Mapping[str, Any]) -> list[PageTable]:
    """Tabulate natural frequencies, damping and strain energy, from the content of ``modes.json``."""
    over = content.get("over")
    rows = []
    for k, mode in enumerate(content["modes"]):
        row = [f"Mode {k + 1}", "unstable" if mode["frequency"] is None else number(mode["frequency"])]
        if over:
            values = [line[k] for line in over["frequencies"] if line[k] is not None]
            row += [number(pick(values)) if values else "unstable" for pick in (min, max)]
        shares = sorted(mode["strain"].items(), key=lambda item: -item[1])
        strain = ", ".join(f"{link} {number(100.0 * share, 2)} %" for link, share in shares if share >= 0.005)
        rows.append((*row, number(mode["damping"]), strain or "-"))
    head = (
        "mode",
        "frequency [Hz]",
        *(("lowest [Hz]", "highest [Hz]") if over else ()),
        "damping ratio",
        "strain energy",
    )
    return [PageTable("Modes at rest", head, rows, frozenset({0, len(head) - 1}))]


def linear(content: Mapping[str, Any]) -> list[PageTable]:
    """Tabulate the operating point and the poles of a linear model, from the content of ``linear.json``."""
    upper = [complex(*pole) for pole in content["poles"] if pole[1] >= 0.0]
    poles = [
        (
            f"{number(pole.real)}" + (f" ± {number(pole.imag)} i" if pole.imag else ""),
            number(abs(pole) / (2.0 * math.pi)) if pole.imag else "-",
            number(-pole.real / abs(pole)) if pole.imag else "-",
        )
        for pole in upper[:_POLES]
    ]
    outputs = [
        (sentence(name_of_output(name)), measured(one["value"], one["unit"]))
        for name, one in content["outputs"].items()
    ]
    return [
        PageTable("Operating point", ("output", "value"), outputs),
        PageTable("Poles", ("pole [1/s]", "frequency [Hz]", "damping ratio"), poles),
    ]


def bearing(content: Mapping[str, Any]) -> list[PageTable]:
    """Tabulate the operating point of a bearing, from the content of ``bearing.json``."""
    plain = (
        ("least_film", "m"),
        ("largest_pressure", "Pa"),
        ("flow", "m3/s"),
        ("friction_torque", "N m"),
        ("power", "W"),
    )
    rows = [
        ("Sommerfeld number", number(content["sommerfeld"])),
        ("Eccentricity over the clearance", number(content["eccentricity_ratio"])),
        ("Attitude, from the load", f"{number(math.degrees(content['attitude']))} deg"),
        *((sentence(key.replace("_", " ")), measured(content[key], si)) for key, si in plain),
        ("Threshold speed of a rigid journal", measured(content["threshold_speed"], "rad/s")),
        ("Critical mass", measured(content["critical_mass"], "kg")),
    ]
    ways = [
        (f"{sentence(name)} [{unit}]" if k == 0 else "", *map(number, values))
        for name, unit in (("stiffness", "N/m"), ("damping", "N s/m"))
        for k, values in enumerate(content[name])
    ]
    return [
        PageTable("Operating point", ("quantity", "value"), rows),
        PageTable("Dynamic coefficients", ("", *_TWO_WAYS), ways),
    ]


def sweep(result: Sweep, units: Mapping[str, str], statistics: Callable[[Any, str], Mapping[str, float]]) -> PageTable:
    """Tabulate the mean peaks of a sweep, with their deviations; `statistics` are those of a point and an output."""
    rows = []
    for point in result.points:
        cells = []
        for name in result.names:
            found = statistics(point, name)
            spread = found["peak_std"]
            known = math.isfinite(spread) and spread > 0.0
            value = found["peak_mean"]
            cells.append(uncertain(value, spread, units[name]) if known else measured(value, units[name]))
        rows.append((measured(point.value, result.unit or "1"), *cells))
    head = sentence(name_of_value(result.path)), *(f"peak of the {name_of_output(name)}" for name in result.names)
    return PageTable("Peaks of a revolution: mean ± deviation", head, rows)
