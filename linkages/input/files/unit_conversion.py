"""Values with units, "0.1 mm" or "300 r/min", in SI units; pint is imported only for such a value."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Any

_UNSIGNED = r"(?>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"  # atomic: 2e-4 is not a 2 with the unit e-4
_FRACTION = rf"(?:{_UNSIGNED}\s*/\s*)?{_UNSIGNED}"  # 1/2 mm is half a millimetre
_NUMBER = rf"[-+]?{_FRACTION}"
_NAME = r"[A-Za-zµμ°%]+"
_FACTOR = rf"{_NAME}(?:\^?-?\d)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*((?:1\s*/\s*)?{_FACTOR}(?:\s*[ */·]\s*{_FACTOR})*)\s*")
_IN_FORMULA = re.compile(rf"(?<![\w.])({_FRACTION})\s*({_FACTOR})(?![\w.(])")

_WITH_COMMA = re.compile(r"([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)(\s*[A-Za-zµμ°%].*)?")

#: SI units, one of each usual kind.
_SI = ("m", "rad", "kg", "kg m2", "Pa", "kg/m3", "m2", "m4", "s", "rad/s", "m/s", "N", "N m", "N/m", "N m/rad")

#: Units of a prismatic joint by the corresponding units of a revolute one.
SLIDING = {"rad": "m", "rad/s": "m/s", "N m": "N", "N m s/rad": "N s/m", "N m/rad": "N/m"}


def is_quantity(text: str) -> bool:
    """Check whether a text is a number followed by a unit.

    Examples
    --------
    >>> from linkages.input.files.unit_conversion import is_quantity
    >>> is_quantity("0.1 mm"), is_quantity("0.1"), is_quantity("2*a")
    (True, False, False)
    """
    return _QUANTITY.fullmatch(text) is not None


def decimal_comma(text: str) -> str:
    """Say how a number with a decimal comma is written, as the end of a message; empty for other texts.

    Examples
    --------
    >>> from linkages.input.files.unit_conversion import decimal_comma
    >>> decimal_comma("0,2 mm")
    '; it has a decimal comma: write 0.2 mm'
    """
    found = _WITH_COMMA.fullmatch(text.strip())
    return f"; it has a decimal comma: write {found[1]}.{found[2]}{found[3] or ''}" if found else ""


def si(text: str, unit: str = "") -> float:
    """Read a number with its unit, in `unit` (default: SI units of any dimension).

    The text is such as "0.1 mm", "1/2 mm", "300 r/min", "7850 kg/m3"; a division applies to the next number or unit
    alone. Angles are not pure numbers here: "50 Hz" is not an angular velocity, "50 r/s" is one. A ValueError has one
    sentence with the error and the remedy.

    Examples
    --------
    >>> from linkages.input.files.unit_conversion import si
    >>> si("0.1 mm", "m"), si("300 r/min", "rad/s")
    (0.0001, 31.41592653589793)
    """
    found = _QUANTITY.fullmatch(text)
    if found is None:
        remedy = decimal_comma(text) or '; give a number, or a number with its unit such as "0.1 mm"'
        raise ValueError(f'is "{text}"{remedy}')
    units = _registry()
    above, _, below = found[1].partition("/")
    try:
        given = units.Quantity(float(above) / float(below or "1"), units.parse_units(_for_pint(found[2])))
    except ZeroDivisionError:
        raise ValueError(f'is "{text}"; nothing can be divided by 0') from None
    except AttributeError:  # raised by pint for an unknown unit
        raise ValueError(f'is "{text}"; the unit "{found[2]}" is unknown') from None
    try:
        return float((given.to(units.parse_units(_for_pint(unit))) if unit else given.to_base_units()).magnitude)
    except (TypeError, ValueError, AttributeError):  # raised by pint for other dimensions and invalid units
        raise ValueError(f'is "{text}"; it must be measured in {unit}, or a unit of the same kind') from None


def si_unit(text: str) -> str:
    """Return the SI unit of a number with its unit; empty for an unusual kind.

    Examples
    --------
    >>> from linkages.input.files.unit_conversion import si_unit
    >>> si_unit("60 mm"), si_unit("30 deg")
    ('m', 'rad')
    """
    for unit in _SI:
        with suppress(ValueError):
            si(text, unit)
            return unit
    return ""


def read(value: Any, unit: str) -> Any:
    """Convert every quantity in a value or list to its number in `unit`; other items are unchanged."""
    if isinstance(value, list):
        return [read(item, unit) for item in value]
    return si(value, unit) if isinstance(value, str) and is_quantity(value) else value


def read_either(value: Any, unit: str) -> Any:
    """Convert like `read`, for revolute or prismatic joints: also m instead of rad, N instead of N m."""
    try:
        return read(value, unit)
    except ValueError as problem:
        if unit not in SLIDING:
            raise
        try:
            return read(value, SLIDING[unit])
        except ValueError:
            raise problem from None


def without_units(formula: str, names: set[str], write: Callable[[str], str] | None = None, unit: str = "") -> str:
    """Replace each ``5 mm`` in a formula with single units by its number in SI units, or by the text of `write`.

    With `names` of the formula's values "2 a" lacks a ``*`` if there is a value ``a``; it is not two years. A text that
    is one quantity must be measured in `unit` (default: any). ValueError if a unit is unknown or of another kind, a
    ``*`` is missing, or a quantity next to ``/`` or ``**`` can be read in two ways.

    Examples
    --------
    >>> from linkages.input.files.unit_conversion import without_units
    >>> without_units("2*a + 5 mm - 1/4 mm", {"a"})
    '2*a + 0.005 - 0.00025'
    """

    def replaced(found: re.Match[str]) -> str:
        if re.search(_NAME, found[2])[0] in names:  # type: ignore[index]  # it has a name
            advice = f"write {found[1]}*{found[2]}, or rename a value"
            raise ValueError(f'"{found[0]}" is a quantity, or lacks a *; {advice}')
        before, after = formula[: found.start()].rstrip(), formula[found.end() :].lstrip()
        if before.endswith(("/", "**")) or after.startswith("**"):
            raise ValueError(f'"{formula}" can be read in two ways; put its quantity in parentheses: ({found[0]})')
        return write(found[0]) if write else repr(si(found[0], unit if whole else ""))

    whole = _QUANTITY.fullmatch(formula)
    return replaced(whole) if whole else _IN_FORMULA.sub(replaced, formula)


def _for_pint(unit: str) -> str:
    return re.sub(rf"({_NAME})\^?(-?\d)", r"\1**\2", unit.replace("·", " "))


@cache
def _registry() -> Any:
    """Make the registry of units; the radian is a separate dimension, so that frequencies are not speeds."""
    import pint  # a second of import time

    units: Any = pint.UnitRegistry(on_redefinition="ignore")
    for line in "radian = [angle] = rad", "@alias revolution = rev = r", "turns_per_minute = r / minute = rpm":
        units.define(line)
    return units
