"""The numbers of a summary in the units that a table shows."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from linkages.input.files.writing import content_of
from linkages.results.outputs.registry import OWNERS
from linkages.show.plots.presentation import shown


def output_unit(name: str, drives: Mapping[str, Any] = MappingProxyType({})) -> str:
    """Return the SI unit of an output: "m/s2"; `drives` are the summary's. "SI" where its name does not tell it."""
    owner, _, quantity = name.rpartition(".")
    unit, prismatic = _declared().get(quantity, ("", ""))
    slides = drives.get(owner, {}).get("unit") == "N"
    return (prismatic if slides and prismatic else unit) or "SI"


@cache
def _declared() -> dict[str, tuple[str, str]]:
    """Return the unit of each quantity, and its unit at a prismatic joint; the first declaration with both counts."""
    found: dict[str, tuple[str, str]] = {}
    for owner in OWNERS:
        for name, one in owner.quantities.items():
            if name not in found or (one.prismatic and not found[name][1]):
                found[name] = one.unit, one.prismatic
    return found


def as_shown(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return a summary with its numbers in the presented units; the keys ``unit`` remain those of SI."""
    found: dict[str, Any] = content_of(summary)
    windows = found.get("windows", {}).values()
    for numbers in (found, *windows):
        for part in (numbers, numbers.get("ideal") or {}):
            _scale(part)
    for name, one in found.get("measured", {}).items():
        _times(one, output_unit(name, found["drives"]), "peak", "rms", "largest")
    return found


def _scale(numbers: dict[str, Any]) -> None:
    """Scale the numbers of a run, a window, or their ideal motion."""
    drives = numbers.get("drives", {})
    for name, one in numbers.get("outputs", {}).items():
        _times(one, output_unit(name, drives), "min", "max", "peak")
    for joint in numbers.get("joints", {}).values():
        _times(joint["force"], "N", "peak")
        _times(joint.get("film_thickness", {}), "m", "min")
    for one in (*drives.values(), *numbers.get("loads", {}).values()):
        kind = "torque" if "torque" in one else "force"
        _times(one[kind], one.get("unit", "N m" if kind == "torque" else "N"), "peak")
        _times(one, "J", "work")
    for link in numbers.get("links", {}).values():
        for quantity, one in link.items():
            _times(one, output_unit(f".{quantity}"), "peak")
            _times(one, "m", "place")
    for name, one in numbers.get("difference", {}).items():
        _times(one, output_unit(name, drives), "peak")
    errors = numbers.get("error", {})
    for key in errors:
        _times(errors, output_unit(key.removesuffix(".peak"), drives), key)


def _times(entry: dict[str, Any], si: str, *keys: str) -> None:
    for key in keys:
        if entry.get(key) is not None:
            entry[key] *= shown(si)[1]
