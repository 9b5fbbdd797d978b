"""The value that a dotted path has in an experiment, or in its SDF file: where a design starts from."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from linkages.errors import InputError, nearest
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism

_POSE = ("x", "y", "z", "roll", "pitch", "yaw")


def value_at(mechanism: Mechanism, experiment: Experiment, path: str) -> float:
    """Return the number at a dotted path.

    Raises
    ------
    InputError
        If there is no such path, or no number there.
    """
    if path.startswith("sdf."):
        return _in_machine(mechanism, experiment, path)
    here: Any = experiment
    for part in path.split("."):
        if isinstance(here, BaseModel):
            known: Mapping[str, Any] = {key: getattr(here, key) for key in type(here).model_fields}
        else:
            known = here if isinstance(here, Mapping) else {}
        if part not in known:
            raise InputError(experiment.source, path, f'has no "{part}"; {nearest(part, known)}')
        here = known[part]
    if here is None:
        raise InputError(
            experiment.source, path, "has no value in the experiment; give one there, or nominal"
        )
    if isinstance(here, bool) or not isinstance(here, int | float):
        raise InputError(experiment.source, path, "is not a number, and cannot be a design variable")
    return float(here)


def _in_machine(mechanism: Mechanism, experiment: Experiment, path: str) -> float:
    _, kind, name, *rest = (*path.split("."), "", "")
    key = ".".join(part for part in rest if part)
    inner = path.removeprefix("sdf.")
    if inner in experiment.sdf_overrides:
        return experiment.sdf_overrides[inner]
    values: dict[str, float] = {}
    if kind == "links" and name in mechanism.link:
        link = mechanism.link[name]
        values = {"mass": link.mass, "inertia": link.inertia}
        values |= {f"com.{axis}": float(x) for axis, x in zip("xyz", link.com_local, strict=True)}
    elif kind == "joints" and name in mechanism.joint:
        joint = mechanism.joint[name]
        if joint.bearing is not None:
            values = {"bearing.radius": joint.bearing.radius, "bearing.length": joint.bearing.length}
        if joint.slot is not None:
            values = {"slot.length": joint.slot.length, "slot.height": joint.slot.height}
    elif not (kind == "frames" and name in mechanism.point):
        known: dict[str, Mapping[str, Any]] = {
            "links": mechanism.link,
            "joints": mechanism.joint,
            "frames": mechanism.point,
        }
        near = nearest(name, known[kind]) if kind in known else nearest(kind, known)
        raise InputError(mechanism.source, path, f"there is no such value; {near}")
    values |= {f"pose.{axis}": x for axis, x in zip(_POSE, _pose(mechanism, kind, name), strict=True)}
    if key not in values:
        raise InputError(mechanism.source, path, f"there is no such value; {nearest(key, values)}")
    return values[key]


def _pose(mechanism: Mechanism, kind: str, name: str) -> list[float]:
    """Numbers of an element's own <pose>, as written in the file."""
    for element in ET.parse(mechanism.source).iter(kind.removesuffix("s")):
        if element.get("name") == name:
            return [float(word) for word in element.findtext("pose", "0 0 0 0 0 0").split()]
    return [0.0] * 6
