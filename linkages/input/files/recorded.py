"""Data files of measurements: columns with units of CSV, MATLAB, Parquet and NumPy files."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.base.packages import needed
from linkages.input.files.magnitudes import decimal_or_nan
from linkages.input.files.reading import read_arrays, read_whole
from linkages.input.files.toml import leaves
from linkages.input.files.unit_conversion import si

_MOST = 500_000_000  # largest size of a data file [bytes]
_ASIDE = re.compile(r"(.*?)\s*\(([^()]*)\)")  # a name, and text in parentheses at its end
_HEADING = re.compile(r"\s*(.*?)\s*(?:\[([^][]*)\])?\s*")  # name, and unit in brackets


@dataclass(frozen=True, eq=False)
class Recording:
    """A data file.

    Attributes
    ----------
    path : Path
    columns : mapping of str to array
        Columns by name, (n,) each; entries that are no numbers are NaN.
    units : mapping of str to str
        Units that the file states, by column.
    """

    path: Path
    columns: Mapping[str, Array]
    units: Mapping[str, str]

    def named(self, name: str) -> str:
        """Return the column that a name means: its heading, with or without its unit in brackets or parentheses.

        If no heading fits, capital and small letters count as equal. A ValueError has one sentence with the error and
        the remedy.
        """
        if name in self.columns:
            return name
        bare, unit = split(name)
        for same in (str, str.casefold):
            found = [
                key
                for key in self.columns
                if same(self.bare(key)) == same(bare) and unit in ("", self.units.get(key) or split(key)[1])
            ]
            if len(found) > 1:
                raise ValueError(f'{self.path.name} has several columns "{name}"; give one of {", ".join(found)}')
            if found:
                return found[0]
        raise ValueError(f'{self.path.name} has no column "{name}"; {nearest(name, self.columns)}')

    def bare(self, column: str) -> str:
        """Return the name of a column without its unit."""
        return column if self.units.get(column) else split(column)[0]

    def stated(self, name: str, unit: str, given: str | None = None) -> str:
        """Return the unit of a column: `given`, or else the file's, or else `unit`.

        The file's unit also stands in parentheses at the end of the name, if it is of the same kind as `unit`.
        """
        column = self.named(name)
        return given or self.units.get(column) or _aside(column, unit)

    def column(self, name: str, unit: str, given: str | None = None) -> Array:
        """Return a column in `unit`; it is in the unit of `stated`.

        A ValueError has one sentence with the error and the remedy.
        """
        stated = self.stated(name, unit, given)
        name = self.named(name)
        try:
            zero, one = (0.0, 1.0) if stated == unit else (si(f"{x} {stated}", unit) for x in (0, 1))
        except ValueError as problem:
            raise ValueError(f'the unit of column "{name}" {problem}'.replace('"0 ', '"')) from None
        with np.errstate(over="ignore"):
            values = self.columns[name] * (one - zero)
        lost = np.isinf(values) & np.isfinite(self.columns[name])
        if lost.any():
            row = int(lost.argmax())
            raise ValueError(
                f'column "{name}" has {self.columns[name][row]:g} {stated} in row {row + 1}, too large in {unit}'
            )
        return values + zero if zero else values


def split(heading: str) -> tuple[str, str]:
    """Split a heading into its name and its unit in brackets, or in parentheses if it is one; else empty.

    Examples
    --------
    >>> from linkages.input.files.recorded import split
    >>> split("Time (s)"), split("angle [deg]"), split("force (left)")
    (('Time', 's'), ('angle', 'deg'), ('force (left)', ''))
    """
    head, aside = _HEADING.fullmatch(heading), _ASIDE.fullmatch(heading)
    if head and head[2]:
        return head[1], head[2]
    with suppress(ValueError):
        return (aside[1], aside[2]) if aside and math.isfinite(si(f"1 {aside[2]}")) else (heading, "")
    return heading, ""


def _aside(name: str, unit: str) -> str:
    """Return the unit in parentheses at the end of a column's name if it is of the same kind as a unit, else that."""
    aside = _ASIDE.fullmatch(name)
    try:
        return aside[2] if aside and math.isfinite(si(f"1 {aside[2]}", unit)) else unit
    except ValueError:  # it is no unit, or of another kind
        return unit


def read_recording(path: Path) -> Recording:
    """Read a data file (``.csv``, ``.txt``, ``.mat``, ``.parquet``, ``.npz``); InputError if it cannot be read."""
    try:
        state = path.stat()
    except (OSError, ValueError):
        state = None  # the reader states the reason
    return _read(path, state and (state.st_mtime_ns, state.st_size))


@lru_cache(maxsize=8)
def _read(path: Path, state: object) -> Recording:
    read = _READERS.get(path.suffix.lower())
    if read is None:
        raise InputError(path, "", f"is no data file; its name must end in {', '.join(_READERS)}")
    try:
        found = read(path)
    except InputError:
        raise
    except Exception as problem:  # the readers raise a dozen types
        raise InputError(path, "", f"cannot be read ({' '.join(str(problem).split())})") from None
    columns = {name: values for name, (values, _) in found.items()}
    if len({len(values) for values in columns.values()}) > 1:
        raise InputError(path, "", "has columns of different lengths")
    return Recording(path, columns, {name: unit for name, (_, unit) in found.items() if unit})


_Found = dict[str, tuple[Array, str]]


def _read_text(path: Path) -> _Found:
    """Read separated values: commas; semicolons, tabs or spaces, with decimal points or commas; # starts a comment."""
    text = read_whole(path, _MOST).decode("utf-8-sig", "replace")
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise ValueError("a line of headings and lines of numbers are needed")
    mark = next((mark for mark in "\t;," if mark in lines[0]), " ")
    rows = csv.reader(lines, delimiter=mark, skipinitialspace=True)
    heads = [_HEADING.fullmatch(cell) for cell in next(rows)]
    names = [(head[1], head[2] or "") if head else ("", "") for head in heads]
    if len({name for name, _ in names}) < len(names):
        raise ValueError("two columns have the same heading")
    values, count = np.full((len(lines) - 1, len(names)), np.nan), 0
    for count, row in enumerate(rows, 1):  # one at a time: as lists of texts, long files take ten times the memory
        if any(cell.strip() for cell in row[len(names) :]):
            why = "decimal commas need semicolons or tabs between the columns"
            raise ValueError(f"row {count} has more cells than the {len(names)} headings; {why}")
        for k, cell in enumerate(row[: len(names)]):
            values[count - 1, k] = decimal_or_nan(cell if mark == "," else cell.replace(",", "."))
    values = values[:count]
    if np.isfinite(values).sum() == 0:
        raise ValueError("it has no numbers below its line of headings")
    if np.isnan(values[0]).all() and lines[1].replace(mark, "").strip():
        raise ValueError(f'row 1 is "{lines[1].strip()}", without numbers; write units into the headings, as t [ms]')
    return {name: (values[:, k].copy(), unit) for k, (name, unit) in enumerate(names)}


def _read_matlab(path: Path) -> _Found:
    """Read vectors of a MATLAB file; fields of structures are named with dots."""
    from scipy.io import loadmat

    content = loadmat(path, simplify_cells=True)
    units = content.pop("units", {})
    stated = dict(leaves(units)) if isinstance(units, Mapping) else {}
    found = ((name, np.asarray(value)) for name, value in leaves(content) if not name.startswith("__"))
    return _vectors(found, {name: str(unit) for name, unit in stated.items() if isinstance(unit, str)})


def _read_parquet(path: Path) -> _Found:
    found = needed("pyarrow.parquet", str(path)).read_table(path)
    units = {field.name: (field.metadata or {}).get(b"units", b"").decode() for field in found.schema}
    return _vectors(((name, found[name].to_numpy()) for name in found.column_names), units)


def _read_archive(path: Path) -> _Found:
    return _vectors(read_arrays(path).items(), {})


def _vectors(found: Iterable[tuple[str, Any]], units: Mapping[str, str]) -> _Found:
    vectors = ((name, np.squeeze(value)) for name, value in found if np.issubdtype(value.dtype, np.number))
    return {name: (value.astype(np.float64), units.get(name, "")) for name, value in vectors if value.ndim == 1}


_READERS = {
    ".csv": _read_text,
    ".txt": _read_text,
    ".mat": _read_matlab,
    ".parquet": _read_parquet,
    ".npz": _read_archive,
}
