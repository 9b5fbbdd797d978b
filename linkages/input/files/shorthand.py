"""Expansion of shorthand in descriptions: one entry for many links, values with units; angles need a unit.

A number that is an angle, other than zero, needs a unit, since 40 is more often 40 degrees than 40 radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from linkages.input.files.beams import MATERIAL, SECTIONS
from linkages.input.files.drafting import DraftError
from linkages.input.files.formula import CONSTANTS, FUNCTIONS, parse
from linkages.input.files.unit_conversion import is_quantity, si, without_units

_RANGE = re.compile(r"\{(\w+)=(-?\d+)\.\.(-?\d+)\}")
_MOST = 1000  # most names that one line defines
_NAME = re.compile(r"[A-Za-z_]\w*")
_INDEXED = re.compile(r"\{([^{}]*)\}(?=(\s*\*\*)?)")  # and an optional power
_EXACT = 2.0**53  # every smaller integer is exact as a float
_INVERSE = {"asin", "acos", "atan", "atan2"}
_SUMS = {"add", "sub", "min", "max", "hypot"}
_SIGNS = {"pos", "neg", "abs"}

#: Unit of each key's quantities; the third of a point's three values is an angle.
_UNITS = {"points": "m", "section": "m", "bearing": "m", "density": "kg/m3"}
_OF_LINK = {"section": "m", "mass": "kg", "inertia": "kg m2", "com": "m"}
_OF_LINK |= {key: unit for kind in (*SECTIONS.values(), MATERIAL) for key, unit in kind.items() if unit != "1"}


def written_out(data: dict[str, Any], stored: bool = False) -> dict[str, Any]:
    """Expand repetitions, and replace quantities by numbers in SI units; DraftError for a wrong one.

    Angles of a description that is `stored` in an SDFormat file are numbers in rad.
    """
    for kind in ("parameters", "points", "links"):
        if kind in data:
            data[kind] = dict(_repeated(kind, data[kind]))
            for name in data[kind]:
                if not _NAME.fullmatch(name) or name in {*CONSTANTS, *FUNCTIONS, "world"}:
                    problem = "cannot be a name; use letters, digits and _, no name of formulas"
                    raise DraftError(f"{kind}.{name}", problem)
    names = set(data.get("parameters", {}))
    if both := names & set(data["points"]):
        raise DraftError(f"points.{min(both)}", "is also a parameter; choose another name")
    if not stored:
        _check_angles(data)
    links = {
        name: _si(link, names, f"links.{name}", "", _OF_LINK) if isinstance(link, dict) else link
        for name, link in data["links"].items()
    }
    plain = {key: _si(value, names, key, _UNITS.get(key, "")) for key, value in data.items() if key != "links"}
    return {key: links if key == "links" else plain[key] for key in data}


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


def _si(value: Any, names: set[str], where: str, unit: str, units: Mapping[str, str] = MappingProxyType({})) -> Any:
    """Replace quantities by numbers; in a table with `units` by key, the names of points are unchanged."""
    if isinstance(value, dict):
        return {
            key: item if units and key == "points" else _si(item, names, f"{where}.{key}", units.get(key, unit), units)
            for key, item in value.items()
        }
    if isinstance(value, list):
        own = [unit, unit, "rad"] if where.startswith("points.") and len(value) == 3 else [unit] * len(value)
        return [_si(item, names, where, of) for item, of in zip(value, own, strict=True)]
    try:
        return without_units(value, names, unit=unit) if isinstance(value, str) else value
    except ValueError as problem:
        raise DraftError(where, str(problem)) from None


# -- angles ------------------------------------------------------------------------------------------------------------


def _check_angles(data: Mapping[str, Any]) -> None:
    """Check that every angle of a description without repetitions is zero or has a unit.

    A formula is an angle if each of its terms is: a quantity such as "30 deg", `pi`, an inverse trigonometric
    function, an angle times or divided by a number, or a parameter that is an angle.
    """
    parameters, points = data.get("parameters", {}), data.get("points", {})
    for name, value in points.items():
        if isinstance(value, list) and len(value) == 3 and value[2] not in points:
            _check(value[2], parameters, f"points.{name}")
    for name, link in data.get("links", {}).items():
        text = link["points"] if isinstance(link, dict) else link
        _check(text.partition(" along ")[2].partition(" at ")[2].strip() or 0, parameters, f"links.{name}")


def _check(value: Any, parameters: Mapping[str, Any], where: str) -> None:
    if _is_angle(value, parameters, ()):
        return
    if isinstance(value, str) and is_quantity(value):
        raise DraftError(where, f'the angle is "{value}"; it must be measured in rad or deg')
    try:
        advice = f'write "{float(value):.15g} deg" or "{float(value):.15g} rad"'
    except ValueError:
        advice = 'give its numbers a unit, such as "40 deg" or "40 rad"'
    raise DraftError(where, f"the angle {value} has no unit; {advice}")


def _is_angle(value: Any, parameters: Mapping[str, Any], asked: tuple[str, ...]) -> bool:
    """Check whether a value is an angle; drafting reports values that are wrong for other reasons."""
    if not isinstance(value, str):
        return isinstance(value, bool) or not isinstance(value, int | float) or value == 0

    def named(name: str) -> bool:
        if name in asked or (name not in parameters and "." not in name):
            return True
        return name in parameters and _is_angle(parameters[name], parameters, (*asked, name))

    try:
        formula = parse(without_units(value, set(parameters), lambda quantity: "pi" if _turns(quantity) else "1"))
    except ValueError:
        return True
    return formula.fold(lambda number: number in (0.0, math.pi), named, _of_terms)


def _turns(quantity: str) -> bool:
    try:
        si(quantity, "rad")
    except ValueError:
        return False
    return True


def _of_terms(function: str, angles: list[bool]) -> bool:
    """Check whether a function or operator gives an angle, given which arguments are angles."""
    if function in _INVERSE:
        return True
    if function in _SUMS:
        return all(angles)
    if function == "mul":
        return any(angles)
    if function == "truediv":
        return angles[0] and not angles[1]
    return function in _SIGNS and angles[0]
