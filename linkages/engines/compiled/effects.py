"""Values that change no number of a run: they are found by comparison, and refused with the path that does.

Two systems whose runs read the same numbers (`linkages.engines.compiled.run.job.Given`) have the same results. Places
of links in the reference configuration are compared apart: where the start and all places on the links stay, they
change coordinates only, and no motion.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError, RunError, listed
from linkages.base.kernel.block import Contents, contents
from linkages.elements.machine import OF_ELEMENTS, all_elements_of
from linkages.engines.compiled.run.job import make_given
from linkages.engines.numerics import EFFECTS_SAME, EFFECTS_STEP
from linkages.input.functions.definitions import TIME
from linkages.input.model.mechanism import Frame, Link
from linkages.mechanics.planar.kinematics import poses_at
from linkages.results.derivatives import Direction
from linkages.results.outputs.registry import pack
from linkages.system import System
from linkages.system.identity import input_tables

#: Keys of an experiment that are no model: the extent and accuracy of the run, and its report.
_SETTINGS = frozenset(
    (
        "mechanism",
        "title",
        "units",
        "duration",
        "start",
        "outputs",
        "data",
        "report",
        "report_from",
        "windows",
        "solver",
    )
)
#: Keys of joints and links that other computations than a compiled run read, and these.
_ELSEWHERE = {
    "wear": "`linkages wear` and lives of studies use it",
    "heat": "the heat balance of `linkages simulate` uses it",
    "yield_strength": "a warning uses it",
    "segments": "Drake's runs use it",
}
_POSE = ("x", "y", "z", "roll", "pitch", "yaw")


def varied(system: System, path: str, values: Sequence[float], outputs: Sequence[str] = ()) -> str:
    """Say why values of a path change nothing in a run; empty if they change a number.

    Parameters
    ----------
    system : System
    path : str
        Dotted path, see `linkages.System.replaced`.
    values : sequence of float
        Values to compare with each other; one alone is compared with the system's, or one near it if it is that.
    outputs : sequence of str
        Requested outputs, in addition to the experiment's.
    """
    if path.partition(".")[0] in _SETTINGS:
        return ""
    if len(set(values)) == 1 and _numbers_at(system, path) == values[0]:
        values = near(system, path)
    found = [system] if len(set(values)) == 1 else []
    try:
        found += [system.replaced({path: float(value)}) for value in values]
        same = not any(differ(one, other, outputs) for one, other in combinations(found, 2))
    except (InputError, AssemblyError, RunError):  # the run will report it
        return ""
    return explained(system, path) if same else ""


def explained(system: System, path: str) -> str:
    """Say that a value changes no number, what uses it, and which path acts instead."""
    return f"changes no number of the model: {_reason(system, path)}"


def check_varied(
    system: System, path: str, values: Sequence[float], origin: str | Path, outputs: Sequence[str] = ()
) -> None:
    """Refuse to vary a path whose values change nothing in a run: InputError with the path that does, see `varied`."""
    if problem := varied(system, path, values, outputs):
        raise InputError(origin, path, problem)


def check_differentiated(system: System, wrt: Sequence[str | Direction], outputs: Sequence[str]) -> None:
    """Refuse derivatives with respect to a value, or values that follow one, that change nothing in a run."""
    for one in wrt:
        paths = [one] if isinstance(one, str) else [*one.rates]
        said = [varied(system, path, near(system, path), outputs) for path in paths]
        if said and all(said):
            raise InputError("argument", "wrt", f"{paths[0]} {said[0]}")


def near(system: System, path: str) -> list[float]:
    """Return the value at a path, and one near it."""
    value = system.value(path)
    if isinstance(value, int):
        return [value, value + 1]
    return [value, value * (1.0 + EFFECTS_STEP) if value else _unit(system, path)]


def without_effect(system: System, before: System, path: str) -> str:
    """Say why a replaced number changes nothing; empty if it does. `before` is the system without it.

    Numbers that a run does not read but another command does, and values equal to those before, are allowed.
    """
    new, old = (_numbers_at(one, path) for one in (system, before))
    if new is None or new == old or path.partition(".")[0] in _SETTINGS or _is_used_elsewhere(system, path):
        return ""
    try:
        same = not differ(system, before)
    except (AssemblyError, RunError):  # the run will report it
        return ""
    return explained(before, path) if same else ""


def differ(one: System, other: System, outputs: Sequence[str] = ()) -> bool:
    """Check whether the runs of two systems, and the requested outputs, read different numbers."""
    wanted = [*dict.fromkeys((*one.settings.outputs, *outputs))]
    first, second = (_numbers(each, wanted) for each in (one, other))
    if first.structure != second.structure:
        return True
    return not np.array_equal(first.words, second.words) and not _same_motion(one, other, wanted)


def _numbers(system: System, outputs: Sequence[str]) -> Contents:
    return contents(make_given(system, pack(system, outputs), np.array([[0.0, system.settings.duration]])))


# -- the same linkage in another reference configuration ---------------------------------------------------------------


def _same_motion(one: System, other: System, outputs: Sequence[str]) -> bool:
    """Check whether nothing but the reference configuration differs, from which no part counts a coordinate."""
    if input_tables(one, without=("sdf",)) != input_tables(other, without=("sdf",)):
        return False
    if _counts_from_reference(one) or one.tree.coordinates != other.tree.coordinates:
        return False
    if np.abs(one.basis - other.basis).max() > EFFECTS_SAME:
        return False
    size, owners = one.tree.extent, {name.rpartition(".")[0] for name in outputs}
    parts = [(_inertias(each), _places(each, owners, size), _start(each, size)) for each in (one, other)]
    return all(
        first.shape == second.shape and bool(np.all(np.abs(first - second) <= EFFECTS_SAME))
        for first, second in zip(*parts, strict=True)
    )


def _counts_from_reference(system: System) -> bool:
    """Check for parts that count coordinates or directions from the reference configuration."""
    counting = any(kind.from_reference(keys) for kind, _, keys in all_elements_of(system.parts))
    oriented = any(model.feed or model.is_tilted or model.is_worn for model in system.models)
    reading = {*system.functions_read} - {TIME}
    return counting or bool(system.quantities) or oriented or bool(reading)


def _inertias(system: System) -> Array:
    """Return masses [kg] and moments of inertia [kg m2] of the links, sizes of bearings and slots [m]."""
    sizes = [
        tuple(vars(part).values()) for joint in system.joints.values() for part in (joint.bearing, joint.slot) if part
    ]
    return np.array([*((link.mass, link.inertia) for link in system.links.values()), *sizes])


def _places(system: System, owners: Collection[str], size: float) -> Array:
    """Return mass centres, joints and frames in the axes of their links, over a size.

    Along a guide any place on the parent is the same; the moment acts at the place on the child. Of frames that are
    `owners` of outputs the direction counts too.
    """
    links = system.links
    found = [local(links, link.name, link.com) / size for link in links.values()]
    for joint in system.joints.values():
        rail, along = (turned(links, link, joint.direction) for link in (joint.parent, joint.child))
        place = local(links, joint.parent, joint.on_parent) / size
        found += [place - (place @ rail) * rail, local(links, joint.child, joint.on_child) / size, rail, along]
    for frame in system.frames:
        found.append(local(links, frame.link, frame.origin) / size)
        if frame.name in owners:
            found.append(turned(links, frame.link, np.array([np.cos(frame.angle), np.sin(frame.angle)])))
    return np.concatenate(found)


def _start(system: System, size: float) -> Array:
    """Return positions over a size and directions of the links, and the rates, at the start of the ideal linkage."""
    tree = system.tree
    poses = poses_at(tree.bodies, system.assembly.q)
    found: list[Any] = [system.assembly.v]
    for link in system.links.values():
        x, y, turn, cosine, sine = poses[tree.index[link.name], :5]
        way = link.origin - tree.drawn[tree.index[link.name]]
        place = np.array([x + cosine * way[0] - sine * way[1], y + sine * way[0] + cosine * way[1]])
        found += [place / size, [np.cos(link.angle + turn), np.sin(link.angle + turn)]]
    return np.concatenate(found)


def local(links: Mapping[str, Link], link: str, place: Array) -> Array:
    """Return a place (2,) of the reference configuration in the axes of a link [m]; unchanged for the world."""
    return place if link == "world" else turned(links, link, place - links[link].origin)


def turned(links: Mapping[str, Link], link: str, direction: Array) -> Array:
    """Return a direction (2,) of the reference configuration in the axes of a link; unchanged for the world."""
    if link == "world":
        return direction
    cosine, sine = np.cos(links[link].angle), np.sin(links[link].angle)
    return np.array([[cosine, sine], [-sine, cosine]]) @ direction


# -- the value that acts -----------------------------------------------------------------------------------------------


def _reason(system: System, path: str) -> str:
    """Say what uses the value at a path, and which path acts instead."""
    table, name, *keys = [*path.split("."), ""]
    if table == "sdf":
        return _of_machine(system, path)
    if idle := _idle(system, table, name):
        return idle
    for key in set(keys) & _ELSEWHERE.keys():
        return f"only {_ELSEWHERE[key]}"
    if table == "joints":
        return _of_joint(system, name)
    return "no model or law that is chosen uses it"


def _idle(system: System, table: str, name: str) -> str:
    """Say why an element as a whole does not act; empty if it does."""
    return OF_ELEMENTS[table].idle(system.parts[table].get(name), name) if table in OF_ELEMENTS else ""


def _of_machine(system: System, path: str) -> str:
    _, kind, name, *keys = [*path.split("."), "", ""]
    if keys[0] in ("bearing", "slot"):
        return _of_joint(system, name)
    if keys[0] in ("pose", "com") and _is_across(system.basis, keys[1]):
        return "it is across the plane of motion"
    instead = [*_instead(system, path, kind, name, keys[1])] if keys[0] == "pose" else []
    said = [f"of joint {joint} is {other}" for joint, other in instead[:3]]
    known = f"; the place {listed(said)}" if said else ""
    if kind == "joints":
        return _of_axis(system, name, keys[1])
    return ("it moves the reference configuration only" if kind == "links" else "only the drawing uses it") + known


def _is_used_elsewhere(system: System, path: str) -> bool:
    """Check whether another computation than a compiled run reads the value."""
    table, name, *_ = [*path.split("."), ""]
    return not _idle(system, table, name) and bool(set(path.split(".")) & _ELSEWHERE.keys())


def _of_joint(system: System, name: str) -> str:
    if name not in system.play:
        return f"joint {name} is ideal; give it a clearance with joints.{name}.model"
    return f"the model and the laws of joint {name} do not use it"


def _of_axis(system: System, name: str, key: str) -> str:
    joint = system.joints[name]
    if joint.type == "revolute":
        return "a revolute joint has no direction in the plane"
    frames = (f"sdf.frames.{frame.name}.pose.{key}" for frame in system.frames if frame.link == joint.parent)
    turning = next((path for path in frames if _acts(system, path)), "")
    return "its direction belongs to a frame" + (f"; {turning} turns it" if turning else "")


def _is_across(basis: Array, key: str) -> bool:
    """Check whether a part of a pose is normal to a plane that axes of the world span."""
    normal = int(np.argmax(np.abs(basis[:, 2])))
    in_plane = [axis for k, axis in enumerate("xyz") if k != normal] + [_POSE[3 + normal]]
    return bool(abs(basis[normal, 2]) > 1.0 - EFFECTS_SAME) and key in _POSE and key not in in_plane


def _instead(system: System, path: str, kind: str, name: str, key: str) -> Iterator[tuple[str, str]]:
    """Find the joints at a frame, or on a link, and the path that moves each on this link."""
    place = system.points.get(name) if kind != "joints" else None
    if place is None:
        return
    keys = (key,) if key in "xyz" else tuple(k for k in "xyz" if not _is_across(system.basis, k))
    for joint in system.joints.values():
        for link, at in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            if link != place.link or (kind == "frames" and not _is_at(system, place, at)):
                continue
            frames = [f for f in system.frames if f.link == link and _is_at(system, f, at)]
            starts = [*(f"sdf.frames.{frame.name}" for frame in frames), f"sdf.joints.{joint.name}"]
            tried = [f"{start}.pose.{k}" for start in starts for k in keys]
            if other := next((one for one in tried if one != path and _acts(system, one)), None):
                yield joint.name, other
                break


def _is_at(system: System, frame: Frame, place: Array) -> bool:
    return float(np.abs(frame.origin - place).max()) <= 1e-6 * system.tree.extent


def _acts(system: System, path: str) -> bool:
    """Check whether a value that is changed a little changes a number."""
    try:
        return differ(system, system.replaced({path: system.value(path) + _unit(system, path)}))
    except (InputError, AssemblyError, RunError):
        return False


def _unit(system: System, path: str) -> float:
    return EFFECTS_STEP * (system.tree.extent if system.value_unit(path) == "m" else 1.0)


def _numbers_at(system: System, path: str) -> float | Collection[float] | None:
    """Return the number or the list of numbers at a path; None where there is none."""
    with suppress(InputError):
        return system.value(path)
    value: Any = input_tables(system)
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    is_list = isinstance(value, list) and all(isinstance(one, int | float) for one in value)
    return value if is_list else None
