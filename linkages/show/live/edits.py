"""Changes of a machine as values by dotted path: other models of joints and links, remedies of warnings, moved pins.

A pin moves in one shown pose: both of its links get the lengths with which the loops stay closed there. The drives'
coordinates, all other pins in their links, and the lines of guides stay. A link with two pins may turn meanwhile, since
its length alone matters; a link with more pins, and the ground, do not. Among the values with this effect those of the
least change, in parts of themselves, are chosen; values that are zero in the file change only if no others suffice.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.files.toml import leaves
from linkages.input.model.mechanism import Joint, Mechanism
from linkages.system import System

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
_BESIDE = 0.02  # radius of a bearing, over the size of a machine without any
_FAR = 1e-3  # error of a place over a move, from which the move is impossible
_ROUNDS = 8  # of Newton's method
_SOFT = 1e-2  # weight of the place of the moved pin against all other places
_FREE = 1e3  # weight of motions of links against changes of lengths
_STEP = 1e-4  # of a difference, over the size of the machine


def models_of(system: System, joint: Joint) -> tuple[str, ...]:
    """Return the models that a joint can have."""
    return {"revolute": ("ideal", "lubricated", "dry", "mixed"), "prismatic": ("ideal", "dry")}.get(joint.type, ())


def with_model(system: System, part: str, name: str, model: str) -> dict[str, Any]:
    """Return the values that give a part, "joint" or "link", a model; what the file does not say is proposed.

    The clearance is `CLEARANCE`, the oil ISO VG 46 at 40 degrees, the material steel, all for the size of the bearing.
    InputError for an unknown part or model.
    """
    known: Mapping[str, Any] = {"joint": system.mechanism.joint, "link": system.mechanism.link}.get(part, {})
    if name not in known:
        raise InputError("page", f"{part} {name}"[:60], f"is no joint or link; {nearest(name, known)}")
    able = models_of(system, known[name]) if part == "joint" else ("rigid", "flexible")
    if model not in able:
        raise InputError("page", f"{part} {name}", f'cannot be "{model}"; one of {", ".join(able) or "no models"}')
    start = f"{part}s.{name}."
    if part == "link" and model == "flexible" and name not in system.mechanism.beam:
        place = f'<link name="{name}"> of {system.mechanism.source.name}'
        raise InputError("page", f"link {name}", f"has no section; give {place} a <linkages:beam>")
    if part == "link" or model == "ideal":
        return {f"{start}model": model}
    given = system.experiment.joints.get(name)
    has = set() if given is None else {key.partition(".")[0] for key, _ in leaves(given.model_dump(exclude_unset=True))}
    sizes, proposed = _sizes(system, known[name]), {}
    if not has & {"clearance", "fit"}:
        proposed["clearance"] = CLEARANCE * 2.0 * sizes[0][1]
    if model in ("lubricated", "mixed") and not has & {"viscosity", "oil"}:
        proposed |= _OIL
    touches = {"dry": ("contact", "friction"), "mixed": ("contact", "friction", "mixed")}.get(model, ())
    solid = _CORNER if known[name].type == "prismatic" else _STEEL | _MIXED
    proposed |= {key: value for key, value in solid.items() if key.partition(".")[0] in set(touches) - has}
    added = {f"sdf.{path}": size for path, size in sizes if path not in system.mechanism.values}
    return added | {f"{start}{key}": value for key, value in proposed.items()} | {f"{start}model": model}


def _sizes(system: System, joint: Joint) -> list[tuple[str, float]]:
    """Return paths and sizes [m] of a joint's bearing or slot, proposed like those of other joints if it has none."""
    kind, keys = ("bearing", ("radius", "length")) if joint.type == "revolute" else ("slot", ("height", "length"))
    others = [own for other in system.mechanism.joints if (own := getattr(other, kind)) is not None]
    size = float(f"{_BESIDE * system.tree.extent:.1g}")
    usual = {
        key: np.median([getattr(own, key) for own in others]) if others else k * size for k, key in enumerate(keys, 1)
    }
    own = getattr(joint, kind)
    return [
        (f"joints.{joint.name}.{kind}.{key}", float(usual[key] if own is None else getattr(own, key))) for key in keys
    ]


def remedies(system: System, warning: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the values by which a warning can be heeded at once, each with a label."""
    named = [name for name in re.findall(r" in ([^ ,]+)", warning["what"]) if name in system.experiment.joints]
    said = warning["remedy"]
    for text, label, key, choice in (
        ('film = "finite"', "use the finite film", "film", "finite"),
        ("such as flores", "use the law flores", "contact.law", "flores"),
        ("such as johnson", "use the law johnson", "contact.law", "johnson"),
    ):
        if text in said and named:
            yield {
                "label": f"{label} in {', '.join(named)}",
                "values": {f"joints.{name}.{key}": choice for name in named},
            }
    thick = [name for name in named if system.experiment.joints[name].viscosity]
    if "raise the viscosity" in said and thick:
        values = {path: 2.0 * system.value(path) for path in (f"joints.{name}.viscosity" for name in thick)}
        yield {"label": f"double the viscosity in {', '.join(thick)}", "values": values}


class Places:
    """Where the joints are in their links, and how the lengths of a machine change that."""

    def __init__(self, system: System) -> None:
        self.system, mechanism = system, system.mechanism
        self._ends = [(joint, link) for joint in mechanism.joints for link in (joint.parent, joint.child)]
        self._local = _local(mechanism)
        lengths = [path for path in mechanism.values if _is_length(mechanism, path)]
        if any(path.startswith("parameters.") for path in lengths):
            lengths = [path for path in lengths if path.startswith("parameters.")]
        # what is zero is moved only if nothing else has the effect: first frames, then links, but no joint in its link
        usual = [path for path in lengths if mechanism.values[path]]
        frames = [path for path in lengths if path.startswith("frames.")]
        links = [path for path in lengths if path.startswith("links.")]
        self._tried = [list(dict.fromkeys(some)) for some in (usual, usual + frames, usual + frames + links)]
        self._slopes: dict[str, Array] = {}

    def moved(self, name: str, way: Array, angles: Mapping[str, float]) -> dict[str, float]:
        """Return the values that move the pin of a joint by `way` (2,) [m] in a pose with these angles of links [rad].

        Where it is not free, it moves as near as it can; InputError if it cannot move at all.
        """
        extent, best, least = self.system.tree.extent, {}, float(np.hypot(*way)) * (1.0 - _FAR)
        together = self._together(name)
        for paths in self._tried:
            values = np.array([self.system.mechanism.values[path] for path in paths])
            scale = np.abs(values) + 1e-3 * extent * (values == 0.0)
            change, left = self._change(paths, scale, together, way, angles)
            if left < least * (1.0 - _FAR):
                kept = np.abs(change) > 1e-7 * extent
                new = zip(np.array(paths)[kept].tolist(), (values + change)[kept].tolist(), strict=True)
                best, least = {f"sdf.{path}": float(f"{value:.9g}") for path, value in new}, left
            if left <= _FAR * float(np.hypot(*way)):
                break
        if not best:
            raise InputError("page", f"joint {name}", "cannot move there: no length of the file has this effect")
        return best

    def _together(self, name: str) -> set[str]:
        """Return the names of the joints at the place of a joint: each shares a link and the place in it with another."""
        found, near = {name}, 1e-5 * self.system.tree.extent
        for _ in self._ends:
            for (joint, link), here in zip(self._ends, self._local, strict=True):
                same = [
                    other.name
                    for (other, its), there in zip(self._ends, self._local, strict=True)
                    if its == link != "world"
                    and other.type == joint.type == "revolute"
                    and np.hypot(*(there - here)) < near
                ]
                if joint.name in found:
                    found |= set(same)
        return found

    def _change(
        self, paths: Sequence[str], scale: Array, moved: set[str], way: Array, angles: Mapping[str, float]
    ) -> tuple[Array, float]:
        """Find the least change (m,) of values, in parts of a scale (m,), and how far the pin stays away [m]."""
        slopes = np.array([self._slope(path) for path in paths]).reshape(len(paths), -1, 2)
        links = list(dict.fromkeys(link for _, link in self._ends if link != "world"))
        pose, change = np.zeros((len(links) + 1, 3)), np.zeros(len(paths))  # the last pose is the ground's
        pose[:-1, 2] = [angles.get(link, self.system.mechanism.link[link].angle) for link in links]
        body = [links.index(link) if link in links else -1 for _, link in self._ends]
        across = [self._across(joint, angles) for joint, _ in self._ends]
        moves = np.array([joint.name in moved for joint, _ in self._ends])
        goal = np.array([_turn(pose[b, 2]) @ own for b, own in zip(body, self._local, strict=True)]) + np.outer(
            moves, way
        )
        left = np.zeros((len(body), 2))
        for round_ in range(_ROUNDS + 1):
            matrix = np.zeros((len(body), 2, len(paths) + pose.size))
            for k, b in enumerate(body):
                turn = _turn(pose[b, 2])
                arm = turn @ (self._local[k] + change @ slopes[:, k])
                left[k] = across[k] @ (goal[k] - arm - pose[b, :2])
                matrix[k, :, : len(paths)] = scale * (turn @ slopes[:, k].T)
                if b >= 0:  # the motions of links cost nothing
                    at = len(paths) + 3 * b
                    matrix[k, :, at : at + 3] = _FREE * np.array([[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]])
                matrix[k] = across[k] @ matrix[k]
            if round_ < _ROUNDS:
                weight = np.where(moves, _SOFT, 1.0)[:, None]
                whole = (weight[..., None] * matrix).reshape(2 * len(body), -1)
                found = np.linalg.lstsq(whole, (weight * left).ravel(), rcond=1e-12)[0]
                change = change + scale * found[: len(paths)]
                pose = pose + _FREE * found[len(paths) :].reshape(pose.shape)
        return change, float(np.abs(left).max())

    def _across(self, joint: Joint, angles: Mapping[str, float]) -> Array:
        """Return the matrix of the part of a move that changes a joint's place: for a guide, the part across its line."""
        if joint.type != "prismatic":
            return np.eye(2)
        link = self.system.mechanism.link.get(joint.parent)
        turn = 0.0 if link is None else angles.get(link.name, link.angle) - link.angle
        normal = _turn(turn) @ [-joint.direction[1], joint.direction[0]]
        return np.outer(normal, normal)

    def _slope(self, path: str) -> Array:
        """Return the derivative of the local places with respect to a length."""
        if path not in self._slopes:
            step = _STEP * self.system.tree.extent
            other = self.system.replaced({f"sdf.{path}": self.system.mechanism.values[path] + step})
            self._slopes[path] = (_local(other.mechanism) - self._local) / step
        return self._slopes[path]


def _is_length(mechanism: Mechanism, path: str) -> bool:
    """Return whether a value can be a length: a part of a place, or a parameter."""
    if path.startswith("parameters."):
        return mechanism.units.get(path, "m") == "m"
    return path.endswith((".pose.x", ".pose.y", ".pose.z"))


def _local(mechanism: Mechanism) -> Array:
    """Return the places of the joints in their parents and children, in turn (2 n, 2), link axes [m]."""
    found = []
    for joint in mechanism.joints:
        for name, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            link = mechanism.link.get(name)
            found.append(place if link is None else _turn(-link.angle) @ (place - link.origin))
    return np.array(found)


def _turn(angle: float) -> Array:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])
