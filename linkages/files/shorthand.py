"""Expansion of shorthand in descriptions: one entry for many links, values with units."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from linkages.files.angles import check_angles
from linkages.files.described_beam import UNITS as BEAM_UNITS
from linkages.files.drafting import DraftError
from linkages.files.formula import CONSTANTS, FUNCTIONS, parse
from linkages.files.unit_conversion import without_units

_RANGE = re.compile(r"\{(\w+)=(-?\d+)\.\.(-?\d+)\}")
_MOST = 1000  # most names that one line defines
_NAME = re.compile(r"[A-Za-z_]\w*")
_INDEXED = re.compile(r"\{([^{}]*)\}(?=(\s*\*\*)?)")  # and an optional power
_EXACT = 2.0**53  # every smaller integer is exact as a float


#: Unit of each key's quantities; the third of a point's three values is an angle.
_UNITS = {"points": "m", "section": "m", "bearing": "m", "density": "kg/m3"}
_OF_LINK = {"section": "m", "mass": "kg", "inertia": "kg m2", **BEAM_UNITS}


def written_out(data: dict[str, Any], stored: bool = False) -> dict[str, Any]:
    """Expand repetitions, and replace quantities by numbers in SI units.

    Parameters
    ----------
    data : dict
        A description.
    stored : bool
        Whether the description comes from an SDFormat file, whose angles are numbers in rad.

    Raises
    ------
    DraftError
        If a name, a repetition or a unit is wrong, or an angle has no unit.
    """
    for kind in ("parameters", "points", "links"):
        if kind in data:
            data[kind] = dict(_repeated(kind, data[kind]))
            for name in data[kind]:
                if not _NAME.fullmatch(name) or name in CONSTANTS or name in FUNCTIONS or name == "world":
                    raise DraftError(
                        f"{kind}.{name}", "cannot be a name; use letters, digits and _, no name of formulas"
                    )
    names = set(data.get("parameters", {}))
    if both := names & set(data["points"]):
        raise DraftError(f"points.{min(both)}", "is also a parameter; choose another name")
    if not stored:
        check_angles(data)
    links = {name: _link(link, names, f"links.{name}") for name, link in data["links"].items()}
    return {
        key: links if key == "links" else _si(value, names, key, _UNITS.get(key, "")) for key, value in data.items()
    }


def _link(value: Any, names: set[str], where: str) -> Any:
    """Replace quantities in a link and its tables by numbers; names of points are unchanged."""
    if not isinstance(value, dict):
        return value
    found = {}
    for key, item in value.items():
        if isinstance(item, dict):
            found[key] = _link(item, names, f"{where}.{key}")
        else:
            found[key] = item if key == "points" else _si(item, names, f"{where}.{key}", _OF_LINK.get(key, ""))
    return found


def _repeated(where: str, table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Expand ``"P{k=0..6}" = ...{k}...`` into one entry for each k."""
    for key, value in table.items():
        found = _RANGE.search(key)
        if found is None:
            yield key, value
            continue
        index, first, last = found[1], int(found[2]), int(found[3])
        if not 0 <= last - first < _MOST:
            raise DraftError(f"{where}.{key}", f"must count upwards, {_MOST} names at most")
        for count in range(first, last + 1):
            yield _RANGE.sub(str(count), key), _counted(value, index, count, f"{where}.{key}")


def _counted(value: Any, index: str, count: int, where: str) -> Any:
    """Replace ``{k}``, ``{k-1}`` in texts by their values."""

    def number(found: re.Match[str]) -> str:
        try:
            result = parse(found[1])({index: float(count)})
        except (ValueError, KeyError):
            raise DraftError(where, f'"{found[0]}" is not a formula of {index}') from None
        if math.isnan(result):
            raise DraftError(where, f'"{found[0]}" has no finite value for {index} = {count}')
        text = str(int(result)) if result.is_integer() and abs(result) < _EXACT else repr(result)
        return f"({text})" if found[2] and result < 0.0 else text  # -2**2 is -4

    if isinstance(value, dict):
        return {key: _counted(item, index, count, where) for key, item in value.items()}
    if isinstance(value, list):
        return [_counted(item, index, count, where) for item in value]
    return _INDEXED.sub(number, value) if isinstance(value, str) else value


def _si(value: Any, names: set[str], where: str, unit: str = "") -> Any:
    """Replace quantities by numbers."""
    if isinstance(value, dict):
        return {key: _si(item, names, f"{where}.{key}", unit) for key, item in value.items()}
    if isinstance(value, list):
        units = [unit, unit, "rad"] if where.startswith("points.") and len(value) == 3 else [unit] * len(value)
        return [_si(item, names, where, own) for item, own in zip(value, units, strict=True)]
    try:
        return without_units(value, names, unit=unit) if isinstance(value, str) else value
    except ValueError as problem:
        raise DraftError(where, str(problem)) from None
