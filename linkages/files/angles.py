"""Angles of descriptions: a number other than zero needs a unit, since 40 is more often 40 degrees than 40 radians."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from linkages.files.drafting import DraftError
from linkages.files.formula import parse
from linkages.files.unit_conversion import is_quantity, si, without_units

_INVERSE = {"asin", "acos", "atan", "atan2"}
_SUMS = {"add", "sub", "min", "max", "hypot"}
_SIGNS = {"pos", "neg", "abs"}


def check_angles(data: Mapping[str, Any]) -> None:
    """Check that every angle of a description without repetitions is zero or has a unit.

    A formula is an angle if each of its terms is: a quantity such as "30 deg", `pi`, an inverse trigonometric
    function, an angle times or divided by a number, or a parameter that is an angle.

    Raises
    ------
    DraftError
        If an angle has no unit: the path of the first one, and two correct notations.
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
