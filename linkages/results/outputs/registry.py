"""Registry of the outputs of a linkage by name: meaning, unit, owner, and the record for the kernels.

A name is ``OWNER.quantity``, or a quantity of the whole linkage. Both engines compute all outputs over time and as
statistics of batches; `table` gives the documentation. Three names derive from others:

``POINT.quantity.jitter``
    The quantity minus its ideal value at the same time, if the drives determine the ideal motion.
``ideal.NAME``
    An output of the linkage with every joint ideal: exact kinematics and inverse dynamics, no run.
``ideal.JOINT.turning_rate``
    Angular velocity of the direction of a joint force [rad/s], counter-clockwise positive.

To add an output: a line in the quantities of its element, in one of the modules that `OWNERS` lists, and its formula
there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from linkages.base.errors import AssemblyError, InputError, nearest
from linkages.base.kernel import Records
from linkages.elements.coordinates import HINGE
from linkages.results.outputs import elements
from linkages.results.outputs.bodies import COORDINATES, LINKAGE, POINTS
from linkages.results.outputs.contacts import PLAY
from linkages.results.outputs.joints import FORCES
from linkages.results.outputs.quantity import OUTPUT, READS, Declaration, OutputFormula, Owner
from linkages.results.outputs.states import OWN
from linkages.system import System

JITTER, IDEAL, TURNING = ".jitter", "ideal.", "turning_rate"

#: Where a user finds all outputs.
LISTED = "`linkages keys` lists all kinds"

_FORCES = (*elements.BETWEEN, *FORCES, *elements.EFFORTS, *elements.FORCES)
#: All kinds of elements with outputs; the first one wins if names are equal.
OWNERS = (*POINTS, *PLAY, *_FORCES, *elements.CONTACTS, *elements.LINKS, *LINKAGE, *OWN)

#: The formulas of all quantities and their numbers, which the records of outputs hold.
FORMULAS: dict[OutputFormula, int] = {}
for _owner in (*OWNERS, COORDINATES):
    for _quantity in _owner.quantities.values():
        FORMULAS.setdefault(_quantity.formula, len(FORMULAS))


def names(system: System, ideal: bool = False) -> list[str]:
    """List all outputs of a system without jitter; `ideal`: of the linkage with every joint ideal."""
    found = {f"q.{name}": None for name in system.tree.coordinates}
    for owner in OWNERS:
        if not (ideal and owner.real):
            for thing in (owner.asked or owner.names)(system):
                found |= {_joined(thing, name): None for name in owner.quantities}
    return list(found)


def _find(system: System, name: str, ideal: bool) -> Callable[[System], tuple[Any, ...]]:
    """Return a function that makes the `OUTPUT` with a name, for systems with the elements of this one."""
    plain = name.removesuffix(JITTER)
    owner, quantity, thing = _look_up(system, plain, ideal)
    jitter = plain != name
    if jitter and (owner not in POINTS or ideal):
        raise _wrong(system, name, "jitter exists only for the motion of a link or frame")
    if jitter and not _determinate(system):
        raise _wrong(system, name, "the prescribed drives do not determine an ideal motion")
    number, read = FORMULAS[quantity.formula], [part in quantity.formula.reads for part in READS]
    return lambda one: (number, quantity.column, *owner.place(one, thing), jitter, *read)


def has_jitter(system: System, name: str) -> bool:
    """Check whether an output has a jitter: it belongs to a point, and the drives determine the motion."""
    return _look_up(system, name, ideal=False)[0] in POINTS and _determinate(system)


def unit(system: System, name: str) -> str:
    """Return the SI unit of an output; InputError if it is unknown."""
    if name.removeprefix(IDEAL).endswith(f".{TURNING}"):
        return "rad/s"
    plain = name.removeprefix(IDEAL).removesuffix(JITTER)
    if plain.removeprefix("q.").partition(HINGE)[0] in system.tree.deformable:  # of a run with rigid segments
        return "rad"
    owner, quantity, thing = _look_up(system, plain, ideal=name.startswith(IDEAL))
    if owner.unit is not None:
        return owner.unit(system, thing)
    joint = system.joints.get(thing)
    slides = joint is not None and joint.type == "prismatic"
    if owner is COORDINATES:
        floats, _, part = thing.rpartition(".")  # x, y or angle of a floating link, or a mode
        return "m" if slides or (floats and part != "angle") else "rad"
    return quantity.prismatic if slides and quantity.prismatic else quantity.unit


def check_output(system: System, name: str) -> None:
    """Check that an output exists, including ``ideal.`` outputs; InputError if it is unknown."""
    plain = name.removeprefix(IDEAL)
    joint, _, quantity = plain.rpartition(".")
    if plain == name or quantity != TURNING or joint not in system.joints:
        _find(system, plain, ideal=plain != name)


def check_outputs(system: System) -> None:
    """Check that the experiment's outputs exist; InputError for the first unknown one."""
    for name in system.settings.outputs:
        check_output(system, name)


def default_outputs(system: System) -> tuple[str, ...]:
    """List the experiment's outputs, force and eccentricity of each contact, torques of the drives."""
    labels = [label for _, label in system.tree.contacts]
    found = [*system.settings.outputs]
    found += [f"{label}.{name}" for label in labels for name in ("force", "eccentricity_ratio")]
    found += [f"{name}.torque" for name in system.drives]
    return tuple(dict.fromkeys(found))


def pack(system: System, wanted: Iterable[str], ideal: bool = False) -> Records:
    """Make the records of named outputs; InputError if a name is unknown."""
    return packer(system, wanted, ideal)(system)


def packer(system: System, wanted: Iterable[str], ideal: bool = False) -> Callable[[System], Records]:
    """Return a function that makes records as `pack`, for systems with the elements of this one."""
    found = [_find(system, name, ideal) for name in wanted]
    return lambda one: np.array([record(one) for record in found], OUTPUT)


def table() -> Iterator[tuple[str, str, str]]:
    """Yield name, meaning and unit of every output for the documentation; kinds of joints share rows."""
    kinds: dict[tuple[str, str, Declaration], list[str]] = {}
    for owner in (*OWNERS, COORDINATES):
        label, _, kind = owner.label.removesuffix(")").partition(" (")
        for name, quantity in owner.quantities.items():
            found = kinds.setdefault((label, name, quantity), [])
            found += [kind] if kind not in found else []
    for (label, name, quantity), found in kinds.items():
        also = f" or {quantity.prismatic}" if quantity.prismatic else ""
        shown = f"{label} ({', '.join(found)})" if found[0] else label
        yield _joined(shown, name), quantity.meaning, quantity.unit + also
    yield f"POINT.quantity{JITTER}", "a point's quantity minus its value in the ideal linkage", "its own"
    yield f"{IDEAL}NAME", "an output of the linkage with every joint ideal", "its own"
    yield f"{IDEAL}JOINT.{TURNING}", "rate at which the direction of a joint force turns", "rad/s"


def _joined(thing: str, quantity: str) -> str:
    return f"{thing}.{quantity}" if thing else quantity


def _look_up(system: System, name: str, ideal: bool) -> tuple[Owner, Declaration, str]:
    if name.startswith("q.") and name.removeprefix("q.") in system.tree.coordinates:
        return COORDINATES, COORDINATES.quantities["COORDINATE"], name.removeprefix("q.")
    thing, dot, quantity = name.rpartition(".")
    for owner in OWNERS:
        suits = quantity in owner.quantities and bool(dot) == bool(thing) and not (ideal and owner.real)
        if suits and thing in owner.names(system):
            return owner, owner.quantities[quantity], thing
    known = names(system, ideal)
    same = [other for other in known if other.startswith(f"{name.partition('.')[0]}.")]
    raise _wrong(system, name, f"is unknown; {nearest(name, same or known, place=LISTED)}")


def _wrong(system: System, name: str, reason: str) -> InputError:
    return InputError(system.description.source, f'output "{name}"', reason)


def _determinate(system: System) -> bool:
    try:
        return system.determinate
    except AssemblyError:  # the run reports the error
        return True
