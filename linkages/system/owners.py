"""Which value fills which numbers of a system's arrays as it is: a register by the value's path.

Packing declares these values where it writes them: `Element.values`, `linkages.system.law_records.values_of`, and below
for links, drives and gravity. A path is in the register only if it fills nothing but these numbers; what follows from
several values, or from geometry, has no entry. Scales of errors and of time are no numbers in this sense.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from linkages.base.arrays import Records
from linkages.elements.machine import DEFINING, fills_of
from linkages.mechanics.planar.motion import Motions
from linkages.system.law_records import values_of
from linkages.system.system import System

_BODIES = "bodies.records", "stiff.records"
_WORD = 8  # bytes of a number


class Fill(NamedTuple):
    """A number of an array that a value fills.

    Attributes
    ----------
    array : str
        Name of the array, of a named tuple within another as "bodies.records".
    place : int
        Of the number in it.
    rate : float
        Derivative with respect to the value; 1: the number is the value itself.
    """

    array: str
    place: int
    rate: float = 1.0


def owners(system: System) -> Mapping[str, list[Fill]]:
    """Return the numbers that values fill, by the path of the value.

    The names of arrays are those of `linkages.mechanics.planar.arrays.Arrays`, and "places" and "speeds" of the drives
    at t = 0. A path without numbers changes only where or how fast drives start.
    """
    found = defaultdict[str, list[Fill]](list)
    for path, fill in _of_laws(system):
        found[path].append(fill)
    if system.tree.deformable or system.film_steps or _any_follows_all(system):
        return found  # modes, films with history and torques of the ideal machine follow all other values
    for part in (_of_elements, _of_links, _of_drives, _of_gravity):
        for path, fill in part(system):
            found[path].append(fill)
    return found


def _any_follows_all(system: System) -> bool:
    """Check for quantities that are computed from the ideal machine."""
    tables = system.parts
    return any(
        True for kind in DEFINING for name, keys in tables[kind.table].items() for _ in kind.ideal_efforts(keys, name)
    )


def _of_laws(system: System) -> Iterator[tuple[str, Fill]]:
    for k, (name, _) in enumerate(system.tree.contacts):
        joint = system.joints[name]
        for field, key in values_of(system.models[k], joint.bearing).items():
            yield f"joints.{name}.{key}", Fill("laws", _place(system.laws, k, field))


def _of_elements(system: System) -> Iterator[tuple[str, Fill]]:
    for path, table, k, field in fills_of(system.parts):
        yield path, Fill(f"elements.{table}", _place(getattr(system.elements, table), k, field))


def _of_links(system: System) -> Iterator[tuple[str, Fill]]:
    """Yield masses and moments of inertia, unless negligible ones or rotors follow them."""
    tree, given = system.tree, system.links
    if any(link.mass == 0.0 or link.inertia == 0.0 for link in given.values()):
        return
    for name, link in given.items():
        for key in ("mass", "inertia"):
            if getattr(tree.links[name], key) == getattr(link, key) and link.beam is None:
                place = _place(tree.bodies.records, tree.index[name], key)
                yield from ((f"sdf.links.{name}.{key}", Fill(array, place)) for array in _BODIES)


def _of_drives(system: System) -> Iterator[tuple[str, Fill]]:
    """Yield places and speeds of drives at one speed, and of drives by a constant torque or force their start too."""
    tree = system.tree
    for k, name in enumerate(tree.driven):
        if not (system.drives[name].varies or system.drives[name].ramp):
            end = _first_piece(system.motions, k)
            yield f"drives.{name}.angle", Fill("places", k)
            yield f"drives.{name}.angle", Fill("motion_c", end - 1)
            yield f"drives.{name}.speed", Fill("speeds", k)
            yield f"drives.{name}.speed", Fill("motion_c", end - 2)
    for k, name in enumerate(tree.powered):
        yield f"drives.{name}.angle", Fill("places", len(tree.driven) + k)
        yield f"drives.{name}.speed", Fill("speeds", len(tree.driven) + k)
        if not system.drives[name].varies:
            effort = "force" if system.drives[name].torque is None else "torque"
            yield f"drives.{name}.{effort}", Fill("torque_c", _first_piece(system.torques, k) - 1)


def _of_gravity(system: System) -> Iterator[tuple[str, Fill]]:
    for axis, rates in zip("xyz", system.basis[:, :2], strict=True):
        for k, rate in enumerate(rates.tolist()):
            yield f"gravity.{axis}", Fill("gravity", k, rate)


def _first_piece(motions: Motions, k: int) -> int:
    """Return the place after the coefficients of the first piece of a motion; the last one is the constant."""
    _, pieces, order = motions.coefficients.shape
    return (k * pieces + 1) * order


def _place(records: Records, k: int, field: str) -> int:
    """Return the place of a number among those of an array of records."""
    layout = records.dtype.fields
    assert layout is not None
    return int(k * records.dtype.itemsize + layout[field][1]) // _WORD
