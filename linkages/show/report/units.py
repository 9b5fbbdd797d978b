"""The numbers of a summary in the units that a table shows."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from linkages.input.model.experiment import BENDING_QUANTITIES, QUANTITIES
from linkages.input.model.functions import OF_OWN
from linkages.show.plots.presentation import shown


def output_unit(name: str) -> str:
    """Return the SI unit of an output of a link, frame, motor or controller: "m/s2"."""
    quantity = name.rpartition(".")[2]
    known = (QUANTITIES | BENDING_QUANTITIES).get(quantity)
    return OF_OWN.get(quantity, "SI") if known is None else known.rpartition("[")[2].rstrip("]")


def as_shown(summary: dict[str, Any]) -> dict[str, Any]:
    """Return a summary with its numbers in the presented units; the keys ``unit`` remain those of SI."""
    found = deepcopy(summary)
    windows = found.get("windows", {}).values()
    for numbers in (found, *windows):
        for part in (numbers, numbers.get("ideal") or {}):
            _scale(part)
    for name, one in found.get("measured", {}).items():
        _times(one, _unit(name, found["drives"]), "peak", "rms", "largest")
    return found


def _scale(numbers: dict[str, Any]) -> None:
    """Scale the numbers of a run, a window, or their ideal motion."""
    drives = numbers.get("drives", {})
    for name, one in numbers.get("outputs", {}).items():
        _times(one, output_unit(name), "min", "max", "peak")
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
        _times(one, _unit(name, drives), "peak")
    errors = numbers.get("error", {})
    for key in errors:
        _times(errors, _unit(key.removesuffix(".peak"), drives), key)


def _unit(name: str, drives: dict[str, Any]) -> str:
    """Return the SI unit of an output, a force, a torque; "1" of a ratio."""
    owner, _, quantity = name.rpartition(".")
    of_drive = drives.get(owner, {}).get("unit", "N m")
    kinds = {"force": "N", "torque": of_drive, "eccentricity_ratio": "1"}
    return kinds[quantity] if quantity in kinds else output_unit(name)


def _times(entry: dict[str, Any], si: str, *keys: str) -> None:
    for key in keys:
        if entry.get(key) is not None:
            entry[key] *= shown(si)[1]
