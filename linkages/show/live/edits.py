"""Changes of parts as values by dotted path: other models of joints and links."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.elements.element import Modelled
from linkages.elements.machine import OF_PARTS
from linkages.input.files.toml import leaves
from linkages.system import System
from linkages.system.joints import SystemJoint

_OF_LINKS = [(kind, kind.choice) for kind in OF_PARTS if kind.part == "link" and kind.choice is not None]
CLEARANCE = 1e-3  # proposed radial clearance, over the diameter of the bearing [1]
_OIL = {"oil.grade": 46, "oil.temperature": 40.0}
_MIXED = {"mixed.law": "blend", "mixed.transition": 2e-6}  # roughness of turned surfaces
_STEEL = {
    "contact.law": "lankarani-nikravesh", "contact.restitution": 0.9, "contact.youngs_modulus": 2.1e11,
    "contact.poissons_ratio": 0.3, "friction.law": "ambrosio", "friction.coefficient": 0.1,
}  # fmt: skip
_CORNER = {
    "contact.law": "flores", "contact.restitution": 0.6, "contact.stiffness": 1e10,  # of a corner of 5 mm radius
    "friction.law": "coulomb", "friction.coefficient": 0.1, "friction.v_1": 1e-2,
}  # fmt: skip
_NODES = 24  # of a profile of wear
_BESIDE = 0.02  # radius of a bearing, over the size of a machine without any


def parts(system: System) -> dict[str, list[dict[str, Any]]]:
    """Return joints and links with the models that they can have."""
    joints = [
        {"name": name, "type": joint.type, "driven": joint.has_drive, "models": models_of(joint)}
        | {"model": joint.model}
        for name, joint in system.joints.items()
    ]
    links = []
    for link in system.links:
        for kind, choice in _OF_LINKS:
            model = choice.chosen(system.parts[kind.table].get(link))
            links.append({"name": link, "model": model, "models": choice.offered(_modelled(system, link))})
    return {"joints": joints, "links": links}


def models_of(joint: SystemJoint) -> tuple[str, ...]:
    """Return the models that a joint can have."""
    return {"revolute": ("ideal", "lubricated", "dry", "mixed"), "prismatic": ("ideal", "dry")}.get(joint.type, ())


def with_model(system: System, part: str, name: str, model: str) -> dict[str, Any]:
    """Return the values that give a part, "joint" or "link", a model; missing values are proposed.

    The clearance is `CLEARANCE`, the oil ISO VG 46 at 40 degrees, the material steel, all for the size of the bearing.
    InputError for an unknown part or model.
    """
    parts: dict[str, Mapping[str, Any]] = {"joint": system.joints, "link": system.links}
    known = parts.get(part, {})
    if name not in known:
        raise InputError("page", f"{part} {name}"[:60], f"is no joint or link; {nearest(name, known)}")
    if part == "link":
        return _model_of_link(system, name, model)
    able = models_of(known[name])
    if model not in able:
        raise InputError("page", f"{part} {name}", f'cannot be "{model}"; one of {", ".join(able) or "no models"}')
    start = f"{part}s.{name}."
    if model == "ideal":
        return {f"{start}model": model}
    given = system.experiment.joints.get(name)
    has = set() if given is None else {key.partition(".")[0] for key, _ in leaves(given.model_dump(exclude_unset=True))}
    sizes, proposed = _sizes(system, known[name]), dict[str, Any]()
    if not has & {"clearance", "fit"}:
        proposed["clearance"] = CLEARANCE * 2.0 * sizes[0][1]
    if model in ("lubricated", "mixed") and not has & {"viscosity", "oil"}:
        proposed |= _OIL
    touches = {"dry": ("contact", "friction"), "mixed": ("contact", "friction", "mixed")}.get(model, ())
    solid = _CORNER if known[name].type == "prismatic" else _STEEL | _MIXED
    proposed |= {key: value for key, value in solid.items() if key.partition(".")[0] in set(touches) - has}
    added = {f"sdf.{path}": size for path, size in sizes if path not in system.machine_values}
    return added | {f"{start}{key}": value for key, value in proposed.items()} | {f"{start}model": model}


def _model_of_link(system: System, name: str, model: str) -> dict[str, Any]:
    """Return the values that give a link a model, of all kinds that are models of links."""
    found: dict[str, Any] = {}
    for _, choice in _OF_LINKS:
        try:
            found |= choice.values(_modelled(system, name), model)
        except ValueError as problem:
            raise InputError("page", f"link {name}", str(problem)) from None
    return found


def without_determined(values: dict[str, Any], name: str) -> dict[str, Any]:
    """Return values by path without those that the others of a link make meaningless."""
    starts = tuple(start for _, choice in _OF_LINKS for start in choice.determines(name, values))
    return {path: value for path, value in values.items() if not path.startswith(starts)} if starts else values


def _modelled(system: System, name: str) -> Modelled:
    return Modelled(name, system.links[name], _pins(system, name))


def _pins(system: System, link: str) -> list[Array]:
    """Return the different places of joints on a link."""
    found: list[Array] = []
    for joint in system.joints.values():
        for owner, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            if owner == link and all(np.hypot(*(place - other)) > 1e-9 for other in found):
                found.append(place)
    return found


def with_addition(system: System, name: str, kind: str) -> dict[str, Any]:
    """Return the values that give a joint a feed groove on top, or wear with a shallow recess below.

    InputError for an unknown joint or addition.
    """
    if name not in system.joints or kind not in ("groove", "wear"):
        raise InputError("page", f"{name} {kind}"[:60], "is no groove or wear of a joint")
    if kind == "groove":
        groove = {"angle": 1.5708, "extent": 0.5, "length": 0.8, "pressure": 1e5}
        new = {"film": "finite", "cavitation": "reynolds"} | {f"groove.{key}": value for key, value in groove.items()}
    else:
        depth = 0.1 * (system.joints[name].clearance or 0.0)
        turn = np.linspace(0.0, 2.0 * np.pi, _NODES, endpoint=False)
        depths = np.maximum(-np.sin(turn) - 0.5, 0.0) * 2.0 * depth
        new = {"wear.coefficient": 1e-16, "wear.nodes": _NODES}
        new["wear.bearing_depth"] = "[" + ",".join(f"{one:.2g}" for one in depths) + "]"
    return {f"joints.{name}.{key}": value for key, value in new.items()}


def _sizes(system: System, joint: SystemJoint) -> list[tuple[str, float]]:
    """Return paths and sizes [m] of a joint's bearing or slot, as of other joints if it has none."""
    kind, keys = ("bearing", ("radius", "length")) if joint.type == "revolute" else ("slot", ("height", "length"))
    others = [own for other in system.joints.values() if (own := getattr(other, kind)) is not None]
    size = float(f"{_BESIDE * system.tree.extent:.1g}")
    usual = {
        key: np.median([getattr(own, key) for own in others]) if others else k * size for k, key in enumerate(keys, 1)
    }
    own = getattr(joint, kind)
    return [
        (f"joints.{joint.name}.{kind}.{key}", float(usual[key] if own is None else getattr(own, key))) for key in keys
    ]
