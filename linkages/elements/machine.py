"""The elements of a machine in arrays, and one compiled loop for each kind.

A machine compiles the loops of the kinds that it has: they are lazy kernels, which contain the kernels of their kind.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.base.arrays import Array, Records
from linkages.base.kernel import kernel, lazy_kernel
from linkages.elements.coordinates import Barrier, Coupled, Edge, Push
from linkages.elements.coupling import COUPLING
from linkages.elements.element import Element, Places
from linkages.elements.friction import FRICTION
from linkages.elements.gear import GEAR
from linkages.elements.gearbox import GEARBOX
from linkages.elements.spring import SPRING
from linkages.elements.stop import STOP
from linkages.elements.torsion_spring import TORSION_SPRING
from linkages.elements.touch import TOUCH
from linkages.mechanics.planar.record_types import MARKER

#: All kinds, in the order in which their forces are added.
KINDS: tuple[Element[Any], ...] = (FRICTION, SPRING, TORSION_SPRING, STOP, GEAR, COUPLING, GEARBOX, TOUCH)

OF_ELEMENTS = {kind.table: kind for kind in KINDS}  #: the kinds, by their tables
TABLES = tuple(kind.table for kind in KINDS if kind.derived is None)  #: of experiments
PUSHING = tuple(kind.table for kind in KINDS if kind.push is not None)  #: whose elements are loads
ACTING = tuple(kind for kind in KINDS if kind.record is not None)  #: the kinds with kernels

#: The records of each kind with kernels, by its table.
Elements: Any = namedtuple("Elements", [kind.table for kind in ACTING])  # type: ignore[misc] # made of the kinds
NO_ELEMENTS = Elements(*(np.zeros(0, kind.record) for kind in ACTING))

Tables = Mapping[str, Mapping[str, Any]]  #: the keys of the elements of each kind, by table and name


def all_elements_of(tables: Tables, kinds: Iterable[Element[Any]] = KINDS) -> Iterator[tuple[Element[Any], str, Any]]:
    """Yield kind, name and keys of all elements."""
    for kind in kinds:
        for name, keys in tables[kind.table].items():
            yield kind, name, keys


def elements_of(tables: Tables) -> Iterator[tuple[Element[Any], str, Any]]:
    """Yield kind, name and keys of the elements with kernels, in the order of their rows."""
    return all_elements_of(tables, ACTING)


def couplings_by_name(tables: Tables) -> dict[str, Coupled]:
    """Return the coordinates that elements couple, by the elements' names."""
    found = ((name, kind.couples(keys)) for kind, name, keys in all_elements_of(tables))
    return {name: one for name, one in found if one is not None}


def pushes_of(tables: Tables) -> list[Push]:
    """List the pushes of elements along coordinates, in the order of `PUSHING`."""
    return [kind.push(keys) for kind, _, keys in all_elements_of(tables) if kind.push is not None]


def contacts_by_label(tables: Tables) -> dict[str, Barrier | Edge]:
    """Return the contacts of elements by their names."""
    parts = all_elements_of(tables)
    return {f"{name}{end}": one for kind, name, keys in parts for end, one in kind.contacts(keys).items()}


def pack_elements(tables: Tables, places: Places) -> Any:
    """Make the records of all elements, as `Elements`."""
    return Elements(*(_records(kind, tables[kind.table], places) for kind in ACTING))


def _records(kind: Element[Any], named: Mapping[str, Any], places: Places) -> Records:
    records: Records = np.zeros(len(named), kind.record)
    for record, keys in zip(records, named.values(), strict=True):
        for field, number in kind.pack(keys, places).items():
            record[field] = number
    return records


def count(elements: Sequence[Records]) -> int:
    """Count the elements, each of which has a row in the table of `tell_elements`."""
    return sum(map(len, elements))


def apart(elements: Sequence[Records]) -> Iterator[Any]:
    """Yield each element alone, in the order of their rows."""
    for kind, records in zip(ACTING, elements, strict=True):
        for k in range(len(records)):
            yield NO_ELEMENTS._replace(**{kind.table: records[k : k + 1]})


def markers_of(elements: Sequence[Records]) -> list[np.record]:
    """List the markers at which elements act, including the markers of their terms."""
    return [marker for records in elements for record in records for marker in _markers(record)]


def _markers(record: Any) -> Iterator[np.record]:
    for name, (kind, *_) in record.dtype.fields.items():
        if kind == MARKER:
            yield record[name]
        elif kind.fields:
            yield from _markers(record[name])


def _loops(duty: str, loop: Callable[[Any], Callable[..., None]]) -> dict[str, Any]:
    """Make the loop of each kind over a duty, as lazy kernels of different names."""
    found = {}
    for kind in ACTING:
        made = loop(getattr(kind, duty))
        made.__qualname__ = made.__name__ = f"{duty}_{kind.table}"
        found[made.__name__] = globals()[made.__name__] = lazy_kernel(made)
    return found


def _acting(act: Any) -> Callable[..., None]:
    def loop(elements: Records, pose: Array, vel: Array, wrench: Array) -> None:
        for k in range(len(elements)):
            act(elements[k], pose, vel, wrench)

    return loop


def _telling(tell: Any) -> Callable[..., None]:
    def loop(elements: Records, first: int, pose: Array, vel: Array, rows: Array) -> None:
        for k in range(len(elements)):
            tell(elements[k], pose, vel, rows[first + k])

    return loop


def _in_turn(head: str, line: str, loops: dict[str, Any], after: str = "") -> Any:
    """Make the kernel that calls the loops of the kinds that a machine has."""
    lines = [head]
    for name, kind in zip(loops, ACTING, strict=True):
        lines += [f"    if len(elements.{kind.table}):", f"        {line.format(loop=name, table=kind.table)}"]
        lines += [f"    {after.format(table=kind.table)}"] if after else []
    names = loops | {"__name__": __name__}
    exec("\n".join(lines), names)
    return kernel(names[head.partition("(")[0].removeprefix("def ")])


#: ``add_elements(elements, pose, vel, wrench)`` adds the forces of all elements to the bodies' wrenches.
add_elements = _in_turn(
    "def add_elements(elements, pose, vel, wrench) -> None:",
    "{loop}(elements.{table}, pose, vel, wrench)",
    _loops("act", _acting),
)
#: ``tell_elements(elements, first, pose, vel, rows)`` fills the rows of all elements, from a first one on.
tell_elements = _in_turn(
    "def tell_elements(elements, first, pose, vel, rows) -> None:",
    "{loop}(elements.{table}, first, pose, vel, rows)",
    _loops("tell", _telling),
    "first += len(elements.{table})",
)
