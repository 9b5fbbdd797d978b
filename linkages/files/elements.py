"""Numbers in elements, and in annotations (the package's elements, with the prefix ``linkages``)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from linkages.arrays import Array
from linkages.errors import InputError, nearest
from linkages.files.magnitudes import decimal, implausible

_UNITS = {"m": "metres"}


def numbers(path: Path, element: ET.Element, count: int, where: str) -> Array:
    """Read the required count of numbers of an element.

    Parameters
    ----------
    path : Path
        File named in errors.
    element : Element
    count : int
    where : str
        Name of the element in errors.

    Raises
    ------
    InputError
        If the element has another count, or text that is not a number.
    """
    words = (element.text or "").split()
    try:
        values = np.array([decimal(word) for word in words])
    except ValueError:
        raise InputError(path, where, f'"{" ".join(words)}" is not {_count(count)}') from None
    if len(values) != count:
        raise InputError(path, where, f"has {_count(len(values))}; {count} are needed")
    for problem in filter(None, map(implausible, values.tolist())):
        raise InputError(path, where, problem)
    return values


def number(path: Path, parent: ET.Element, key: str, where: str, default: float | None = None) -> float:
    """Read the number in the child `key` of an element, optional if there is a default; errors as `numbers`."""
    element = parent.find(key)
    if element is None:
        if default is None:
            raise InputError(path, where, f"has no <{key}>")
        return default
    return float(numbers(path, element, 1, f"{where}/<{key}>")[0])


def annotation(element: ET.Element, kind: str) -> ET.Element | None:
    """Find ``<linkages:KIND>`` in an element."""
    return next((child for child in element if child.tag.endswith(f":{kind}")), None)


def parts(path: Path, element: ET.Element, where: str, keys: Iterable[str]) -> dict[str, ET.Element]:
    """Return the elements of an annotation by name; `keys` are the known names."""
    found = {child.tag.rpartition(":")[2]: child for child in element}
    for key, child in found.items():
        if key not in keys:
            raise InputError(path, where, f"<{key}> is unknown; {nearest(key, keys)}")
        if ":" not in child.tag:
            raise InputError(path, where, f"write <linkages:{key}>, not <{key}>")
    return found


def sizes(
    path: Path,
    element: ET.Element,
    where: str,
    units: Mapping[str, str],
    defaults: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, float]:
    """Read the positive numbers of an annotation; keys of `units` without a default are mandatory.

    Raises
    ------
    InputError
        If a number is missing, unknown or not positive.
    """
    found, values = parts(path, element, where, units), dict(defaults)
    for key, unit in units.items():
        if key in found:
            values[key] = float(numbers(path, found[key], 1, f"{where}/<linkages:{key}>")[0])
        if key not in values:
            raise InputError(path, where, f"has no <linkages:{key}>; give it in {_UNITS.get(unit, unit)}")
        if values[key] <= 0.0:
            raise InputError(path, f"{where}/<linkages:{key}>", f"is {values[key]:g} {unit}; it must be positive")
    return values


def _count(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"
