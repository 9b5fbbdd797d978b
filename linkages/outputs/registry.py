"""Registry of the outputs of a linkage by name: meaning, unit, owner, and the record for the kernels.

A name is ``OWNER.quantity``, or a quantity of the whole linkage. Both engines compute all outputs over time and as
statistics of batches; `table` gives the documentation. Three names derive from others:

``POINT.quantity.jitter``
    The quantity minus its ideal value at the same time, if the drives determine the ideal motion.
``ideal.NAME``
    An output of the linkage with every joint ideal: exact kinematics and inverse dynamics, no run.
``ideal.JOINT.turning_rate``
    Angular velocity of the direction of a joint force [rad/s], counter-clockwise positive.

To add an output: a line in `OWNERS`, and its formula in `linkages.outputs.formulas`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from linkages.errors import AssemblyError, InputError, nearest
from linkages.kernel import Records
from linkages.laws import FILMS
from linkages.model.experiment import FRAME_BENDING, LINK_BENDING, PIN_QUANTITIES, QUANTITIES
from linkages.model.segment_model import HINGE
from linkages.outputs.formulas import (
    BEND,
    CONTACT,
    COORDINATE,
    DRIVE,
    GEAR,
    GUIDE,
    JOINT,
    LINKAGE,
    LOAD,
    OUTPUT,
    POINT,
    WITHIN,
)  # fmt: skip
from linkages.system import System

JITTER, IDEAL, TURNING = ".jitter", "ideal.", "turning_rate"


class Quantity(NamedTuple):
    """Meaning of an output, its unit (and its unit at a prismatic joint), and its code for the kernels."""

    meaning: str
    unit: str
    code: int
    prismatic: str = ""


@dataclass(frozen=True)
class Owner:
    """A kind of element with outputs."""

    kind: int
    label: str  # the name before the dot, in the documentation
    real: bool  # whether only a linkage with clearances has it
    names: Callable[[System], Iterable[str]]  # names of all elements of this kind
    #: Index, other index, marker and constant of `linkages.outputs.formulas.OUTPUT` by the element's name.
    record: Callable[[System, str], tuple[Any, ...]]
    quantities: dict[str, Quantity]
    asked: Callable[[System], Iterable[str]] | None = None  # elements with columns in a run; default: all


def _described(quantities: dict[str, str]) -> dict[str, Quantity]:
    """Make quantities from texts that end with the unit in brackets; codes follow their order."""
    parts = {name: text.removesuffix("]").rpartition(" [") for name, text in quantities.items()}
    return {name: Quantity(meaning, unit, k) for k, (name, (meaning, _, unit)) in enumerate(parts.items())}


_NOWHERE = (0, 0.0, 0.0)
_CONTACT = _described(
    {
        "ex": "eccentricity vector, from the bearing's centre to the journal's, along x_P [m]",
        "ey": "eccentricity vector along y_P [m]",
        "fx": "force on the journal along x_P [N]",
        "fy": "force on the journal along y_P [N]",
        "force": "magnitude of the force [N]",
        "eccentricity_ratio": "length of the eccentricity vector over the radial clearance [1]",
        "power": "power that the force pair delivers [W]",
        "film_thickness": "smallest thickness of the film [m]",
        "penetration": "largest overlap of journal and bearing, negative: their smallest gap [m]",
        "closing": "rate of the penetration [m/s]",
        "sliding": "sliding speed of the journal's surface [m/s]",
        "load": "normal load of the contact, without the film force [N]",
        "mx": "moment of the film on the tilted journal about the bearing's middle, about x_P [N m]",
        "my": "moment of the film on the tilted journal about the bearing's middle, about y_P [N m]",
        "tilting_moment": "magnitude of this moment [N m]",
        "friction_torque": "friction torque on the journal, counter-clockwise [N m]",
    }
)
_TILTED = ("mx", "my", "tilting_moment")
_PASSED = Quantity("power transmitted to the second joint", "W", 1)
_POWER = Quantity("power that the load delivers to the linkage", "W", 2)


def _some(quantities: dict[str, Quantity], *without: str) -> dict[str, Quantity]:
    return {name: quantity for name, quantity in quantities.items() if name not in without}


def _beside(quantities: dict[str, Quantity], *chosen: str) -> dict[str, Quantity]:
    """Choose the quantities of a contact other than a journal bearing, with suitable descriptions."""
    words = {
        "fx": "force on the point along x_P",
        "fy": "force on the point along y_P",
        "penetration": "depth of the point beyond the wall, negative: its distance from it",
        "sliding": "speed of the point along the wall",
        "load": "normal force",
    }
    return {name: quantities[name]._replace(meaning=words.get(name, quantities[name].meaning)) for name in chosen}


def _of_joints(table: str, kind: str) -> Callable[[System], Iterable[str]]:
    """List the stops, frictions, gears or torsion springs of revolute or prismatic joints, see `turns`."""
    turning = kind == "revolute"
    return lambda system: [name for name in getattr(system.experiment, table) if turns(system, table, name) is turning]


def turns(system: System, table: str, name: str) -> bool:
    """Tell whether a stop, friction, gear or spring gives a torque; the second joint of a gear counts."""
    element = getattr(system.experiment, table)[name]
    joint = element.joints[1] if table == "gears" else element.joint
    return joint is None or system.mechanism.joint[joint].type == "revolute"


def _contacts(film: bool, touching: bool) -> Callable[[System], Iterable[str]]:
    """List the contacts with or without film that can or cannot touch."""

    def names(system: System) -> Iterator[str]:
        for (joint, label), model in zip(system.tree.contacts, system.models, strict=False):
            has_film = model.has_film and system.mechanism.joint[joint].bearing is not None
            if (has_film, model.can_touch) == (film, touching):
                yield label

    return names


def _finite_films(system: System) -> Iterator[str]:
    """List the contacts with a film of finite length."""
    for (_, label), model in zip(system.tree.contacts, system.models, strict=False):
        if model.has_film and FILMS[model.film].force is None:
            yield label


def _contact(system: System, name: str) -> tuple[Any, ...]:
    k = [label for _, label in system.contacts].index(name)
    return k, 0, _NOWHERE, float(system.laws["clearance"][k])


def _point(system: System, name: str) -> tuple[Any, ...]:
    return 0, 0, system.tree.named_marker(name), system.mechanism.place[name].angle


def _pins_asked(system: System) -> Iterator[str]:
    """List the joints whose position the experiment reports."""
    asked = {name.rpartition(".")[0] for name in system.experiment.outputs}
    return (name for name in system.mechanism.joint if name in asked)


def _deflection(system: System, name: str) -> tuple[Any, ...]:
    tree, point = system.tree, system.mechanism.point[name]
    beam = system.mechanism.link[point.link].beam
    if beam is None:
        raise AssertionError("a flexible link has a beam")
    first, last = tree.beam_ends(point.link)
    (dx, dy), (x, y) = (beam.end - beam.start) / beam.length, point.origin - beam.start
    return first, last, tree.named_marker(name), float(dx * y - dy * x)


def _within(system: System, name: str) -> tuple[Any, ...]:
    link = system.tree.flexible[name]
    first = list(system.tree.substructures).index(link[0].name)
    return first, first + len(link), _NOWHERE, 0.0


def _guide(system: System, name: str) -> tuple[Any, ...]:
    tree, joint = system.tree, system.mechanism.joint[name]
    k = [owner for owner, _ in tree.contacts].index(name)
    across = (tree.marker(joint.parent, joint.on_parent)[0], float(-joint.direction[1]), float(joint.direction[0]))
    return k, tree.marker(joint.child, joint.on_child)[0], across, float(system.laws["clearance"][k])


def _drive(system: System, name: str) -> tuple[Any, ...]:
    tree = system.tree
    return (*tree.driven, *tree.powered).index(name), tree.coordinates.index(name), _NOWHERE, 0.0


def _load(system: System, name: str) -> tuple[Any, ...]:
    return [load for _, load in system.experiment.loads].index(name), 0, _NOWHERE, 0.0


def _gear(system: System, name: str) -> tuple[Any, ...]:
    gears = system.experiment.gears
    return list(gears).index(name) - len(gears), 0, _NOWHERE, system.tree.coordinate(gears[name].joints[1])[1]


def _loads(*tables: str) -> Callable[[System], Iterable[str]]:
    return lambda system: [name for table, name in system.experiment.loads if table in tables]


#: All kinds of elements with outputs; the first one wins if names are equal.
OWNERS = (
    Owner(POINT, "POINT", False, lambda s: s.mechanism.point, _point, _described(QUANTITIES)),
    Owner(
        POINT, "JOINT", False, lambda s: s.mechanism.joint, _point,
        {name: found for name, found in _described(QUANTITIES | PIN_QUANTITIES).items() if name in PIN_QUANTITIES},
        _pins_asked,
    ),
    Owner(
        CONTACT, "JOINT (film)", True, _contacts(film=True, touching=False), _contact,
        _some(_CONTACT, "penetration", "closing", "sliding", "load", *_TILTED),
    ),
    Owner(
        CONTACT, "JOINT (tilted)", True,
        lambda s: [label for (_, label), model in zip(s.tree.contacts, s.models, strict=False) if model.is_tilted],
        _contact, {name: _CONTACT[name] for name in _TILTED},
    ),
    Owner(
        CONTACT, "JOINT (dry)", True, _contacts(film=False, touching=True), _contact,
        _some(_CONTACT, "film_thickness", *_TILTED),
    ),
    Owner(
        CONTACT, "JOINT (mixed)", True, _contacts(film=True, touching=True), _contact, _some(_CONTACT, *_TILTED)
    ),
    Owner(
        CONTACT, "JOINT (finite film)", True, _finite_films, _contact,
        {"flow": Quantity("volume flow out of the ends of the film", "m3/s", 16)},
    ),
    Owner(
        CONTACT, "JOINT (film with history)", True,
        lambda s: [label for (_, label), model in zip(s.tree.contacts, s.models, strict=False) if model.has_history],
        _contact, {"film_content": Quantity("share of the gap that is filled with oil", "1", 17)},
    ),
    Owner(
        GUIDE, "GUIDE", True,
        lambda s: [name for name in s.tree.play if s.mechanism.joint[name].slot is not None], _guide,
        {
            "eccentricity_ratio": Quantity("largest of its corners'", "1", 0),
            "power": Quantity("power that its force pairs deliver", "W", 1),
            "offset": Quantity("position of the block across its slot", "m", 2),
            "tilt": Quantity("angle of the block in its slot", "rad", 3),
        },
    ),
    Owner(
        JOINT, "JOINT", False, lambda s: s.mechanism.joint,
        lambda s, name: (list(s.mechanism.joint).index(name), 0, _NOWHERE, 0.0),
        {
            "fx": Quantity("force on the joint's child along x_P, without the drive's", "N", 0),
            "fy": Quantity("force on the joint's child along y_P, without the drive's", "N", 1),
            "force": Quantity("magnitude of the force", "N", 2),
            "moment": Quantity("moment on the child about the joint, without the drive's", "N m", 3),
        },
    ),
    Owner(
        DRIVE, "DRIVE", False, lambda s: (*s.tree.driven, *s.tree.powered), _drive,
        {
            "torque": Quantity(
                "torque (prismatic joint: force) of the drive along the joint's coordinate; JOINT.force excludes it",
                "N m", 0, "N",
            ),
            "rate": Quantity("rate of the joint's coordinate", "rad/s", 1, "m/s"),
            "power": Quantity("power delivered by the drive", "W", 2),
        },
    ),
    Owner(
        LOAD, "FORCE", False, _loads("forces"), _load,
        {
            "fx": Quantity("applied force along x_P", "N", 0),
            "fy": Quantity("applied force along y_P", "N", 1),
            "force": Quantity("magnitude of the applied force", "N", 3),
            "power": _POWER,
        },
    ),
    Owner(
        LOAD, "TORQUE", False, _loads("torques"), _load,
        {
            "torque": Quantity("applied torque, counter-clockwise; in a joint: along its coordinate", "N m", 0),
            "power": _POWER,
        },
    ),
    Owner(
        LOAD, "SPRING", False, _loads("springs"), _load,
        {"force": Quantity("tension", "N", 0), "length": Quantity("distance of the ends", "m", 1), "power": _POWER},
    ),
    Owner(
        LOAD, "TORSION SPRING", False, _of_joints("torsion_springs", "revolute"), _load,
        {
            "torque": Quantity("torque against its angle", "N m", 0),
            "angle": Quantity("angle, zero in the reference configuration", "rad", 1),
            "power": _POWER,
        },
    ),
    Owner(
        LOAD, "TORSION SPRING (prismatic)", False, _of_joints("torsion_springs", "prismatic"), _load,
        {
            "force": Quantity("force against its displacement", "N", 0),
            "displacement": Quantity("displacement, zero in the reference configuration", "m", 1),
            "power": _POWER,
        },
    ),
    Owner(
        LOAD, "FRICTION (revolute)", False, _of_joints("frictions", "revolute"), _load,
        {"torque": Quantity("friction in an ideal joint, along its coordinate", "N m", 0), "power": _POWER},
    ),
    Owner(
        LOAD, "FRICTION (prismatic)", False, _of_joints("frictions", "prismatic"), _load,
        {"force": Quantity("friction in an ideal joint, along its coordinate", "N", 0), "power": _POWER},
    ),
    Owner(
        GEAR, "GEAR (revolute)", False, _of_joints("gears", "revolute"), _gear,
        {"torque": Quantity("torque on the second joint, along its coordinate", "N m", 0), "power": _PASSED},
    ),
    Owner(
        GEAR, "GEAR (prismatic)", False, _of_joints("gears", "prismatic"), _gear,
        {"force": Quantity("force on the second joint, along its coordinate", "N", 0), "power": _PASSED},
    ),
    Owner(
        CONTACT, "STOP (revolute)", True, _of_joints("stops", "revolute"), _contact,
        {
            "torque": Quantity("magnitude of the reaction torque", "N m", 11),
            "penetration": Quantity("angle beyond the stop; negative: distance to it", "rad", 8),
            "closing": Quantity("rate of the penetration", "rad/s", 9),
            "power": _POWER._replace(code=6),
        },
    ),
    Owner(
        CONTACT, "STOP (prismatic)", True, _of_joints("stops", "prismatic"), _contact,
        _beside(_CONTACT, "force", "penetration", "closing", "sliding", "load", "power"),
    ),
    Owner(
        CONTACT, "CONTACT", True, lambda s: s.experiment.contacts, _contact,
        _beside(_CONTACT, "fx", "fy", "force", "penetration", "closing", "sliding", "load", "power"),
    ),
    Owner(
        BEND, "FRAME (flexible link)", False,
        lambda s: [frame.name for frame in s.mechanism.frames if frame.link in s.tree.flexible],
        _deflection, _described(FRAME_BENDING),
    ),
    Owner(WITHIN, "LINK (flexible)", False, lambda s: s.tree.flexible, _within, _described(LINK_BENDING)),
    Owner(COORDINATE, "q", False, lambda s: (), lambda s, name: (), {}),
    Owner(
        LINKAGE, "", False, lambda s: ("",), lambda s, name: (0, 0, _NOWHERE, 0.0),
        {
            "kinetic_energy": Quantity("kinetic energy of the whole linkage", "J", 0),
            "potential_energy": Quantity("energy of weight, springs and flexible links", "J", 1),
            "strain_energy": Quantity("energy of flexible links", "J", 2),
            "damping_power": Quantity("power dissipated by the damping of flexible links", "W", 3),
        },
    ),
)  # fmt: skip


def names(system: System, ideal: bool = False) -> list[str]:
    """List all outputs of a system without jitter; `ideal`: of the linkage with every joint ideal."""
    found = {f"q.{name}": None for name in system.tree.coordinates}
    for owner, things in _asked(system, ideal):
        for thing in things:
            found |= {_joined(thing, name): None for name in owner.quantities}
    return list(found)


def count(system: System) -> int:
    """Return how many outputs `names` lists, faster."""
    return len(system.tree.coordinates) + _distinct(tuple(tuple(things) for _, things in _asked(system, False)))


@lru_cache(maxsize=64)  # systems of one linkage have the same elements
def _distinct(asked: tuple[tuple[str, ...], ...]) -> int:
    """Count the outputs of elements of each of `OWNERS`."""
    owned = zip(OWNERS, asked, strict=True)
    return len({(thing, name) for owner, things in owned for thing in things for name in owner.quantities})


def find(system: System, name: str, ideal: bool = False) -> tuple[Any, ...]:
    """Return the record (see `linkages.outputs.formulas.OUTPUT`) of an output.

    Raises
    ------
    InputError
        If the output is unknown.
    """
    return _record(system, name, *_find(system, name, ideal))


def _find(system: System, name: str, ideal: bool) -> tuple[Owner, Quantity, str, int]:
    """Find the kind of elements, the quantity, the element, and whether the output is a jitter."""
    plain = name.removesuffix(JITTER)
    owner, quantity, thing = _look_up(system, plain, ideal)
    jitter = int(plain != name)
    if jitter and (owner.kind != POINT or ideal):
        raise _wrong(system, name, "jitter exists only for the motion of a link or frame")
    return owner, quantity, thing, jitter


def _record(system: System, name: str, owner: Owner, quantity: Quantity, thing: str, jitter: int) -> tuple[Any, ...]:
    if jitter and not _determinate(system):
        raise _wrong(system, name, "the prescribed drives do not determine an ideal motion")
    if owner.kind == COORDINATE:
        return COORDINATE, 0, system.tree.coordinates.index(thing), 0, 0, _NOWHERE, 0.0
    at, other, marker, constant = owner.record(system, thing)
    return owner.kind, quantity.code, at, other, jitter, marker, constant


def has_jitter(system: System, name: str) -> bool:
    """Check whether an output has a jitter: it belongs to a point, and the drives determine the motion."""
    return _look_up(system, name, ideal=False)[0].kind == POINT and _determinate(system)


def unit(system: System, name: str) -> str:
    """Return the SI unit of an output.

    Raises
    ------
    InputError
        If the output is unknown.
    """
    if name.removeprefix(IDEAL).endswith(f".{TURNING}"):
        return "rad/s"
    plain = name.removeprefix(IDEAL).removesuffix(JITTER)
    if plain.removeprefix("q.").partition(HINGE)[0] in system.tree.flexible:  # of a run with rigid segments
        return "rad"
    owner, quantity, thing = _look_up(system, plain, ideal=name.startswith(IDEAL))
    joint = system.mechanism.joint.get(thing)
    slides = joint is not None and joint.type == "prismatic"
    if owner.kind == COORDINATE:
        floats, _, part = thing.rpartition(".")  # x, y or angle of a floating link, or a mode
        return "m" if slides or (floats and part != "angle") else "rad"
    return quantity.prismatic if slides and quantity.prismatic else quantity.unit


def check_output(system: System, name: str) -> None:
    """Check that an output exists, including ``ideal.`` outputs.

    Raises
    ------
    InputError
        If the output is unknown.
    """
    plain = name.removeprefix(IDEAL)
    joint, _, quantity = plain.rpartition(".")
    if plain == name or quantity != TURNING or joint not in system.mechanism.joint:
        find(system, plain, ideal=plain != name)


def default_outputs(system: System) -> tuple[str, ...]:
    """List the experiment's outputs, force and eccentricity of each contact, torques of the drives."""
    labels = [label for _, label in system.tree.contacts]
    return (
        *system.experiment.outputs,
        *(f"{label}.{name}" for label in labels for name in ("force", "eccentricity_ratio")),
        *(f"{name}.torque" for name in system.experiment.drives),
    )


def pack(system: System, wanted: Iterable[str], ideal: bool = False) -> Records:
    """Make the records of named outputs.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    return packer(system, wanted, ideal)(system)


def packer(system: System, wanted: Iterable[str], ideal: bool = False) -> Callable[[System], Records]:
    """Return a function that makes the records of named outputs for systems with the elements of this one.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    found = [(name, *_find(system, name, ideal)) for name in wanted]
    return lambda one: np.array([_record(one, *each) for each in found], OUTPUT)


def table() -> Iterator[tuple[str, str, str]]:
    """Yield name, meaning and unit of every output for the documentation; kinds of joints share rows."""
    kinds: dict[tuple[str, str, Quantity], list[str]] = {}
    for owner in OWNERS:
        label, _, kind = owner.label.removesuffix(")").partition(" (")
        for name, quantity in owner.quantities.items():
            kinds.setdefault((label, name, quantity), []).append(kind)
    for (label, name, quantity), found in kinds.items():
        also = f" or {quantity.prismatic}" if quantity.prismatic else ""
        shown = f"{label} ({', '.join(found)})" if found[0] else label
        yield _joined(shown, name), quantity.meaning, quantity.unit + also
    yield "q.COORDINATE", "coordinate of the spanning tree: of a joint, a floating link, a mode or a hinge", "rad or m"
    yield f"POINT.quantity{JITTER}", "a point's quantity minus its value in the ideal linkage", "its own"
    yield f"{IDEAL}NAME", "an output of the linkage with every joint ideal", "its own"
    yield f"{IDEAL}JOINT.{TURNING}", "rate at which the direction of a joint force turns", "rad/s"


def _joined(thing: str, quantity: str) -> str:
    return f"{thing}.{quantity}" if thing else quantity


def _asked(system: System, ideal: bool) -> Iterator[tuple[Owner, Iterable[str]]]:
    """Yield each kind of elements with the names of the elements that have columns in a run."""
    for owner in OWNERS:
        if not (ideal and owner.real):
            yield owner, (owner.asked or owner.names)(system)


def _look_up(system: System, name: str, ideal: bool) -> tuple[Owner, Quantity, str]:
    if name.startswith("q.") and name.removeprefix("q.") in system.tree.coordinates:
        coordinate = next(owner for owner in OWNERS if owner.kind == COORDINATE)
        return coordinate, Quantity("", "", 0), name.removeprefix("q.")
    thing, dot, quantity = name.rpartition(".")
    for owner in OWNERS:
        suits = quantity in owner.quantities and bool(dot) == bool(thing) and not (ideal and owner.real)
        if suits and thing in owner.names(system):
            return owner, owner.quantities[quantity], thing
    known = names(system, ideal)
    same = [other for other in known if other.startswith(f"{name.partition('.')[0]}.")]
    raise _wrong(system, name, f"is unknown; {nearest(name, same or known)}")


def _wrong(system: System, name: str, reason: str) -> InputError:
    return InputError(system.experiment.source, f'output "{name}"', reason)


def _determinate(system: System) -> bool:
    try:
        return system.determinate
    except AssemblyError:  # the run reports the error
        return True
