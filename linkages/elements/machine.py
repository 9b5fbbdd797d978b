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
from linkages.elements.controller import CONTROLLER
from linkages.elements.coordinates import Barrier, Coupled, Edge, Push
from linkages.elements.coupling import COUPLING
from linkages.elements.element import Element, Places
from linkages.elements.force import FORCE
from linkages.elements.friction import FRICTION
from linkages.elements.gear import GEAR
from linkages.elements.gearbox import GEARBOX
from linkages.elements.motor import MOTOR
from linkages.elements.spring import SPRING
from linkages.elements.state import STATE
from linkages.elements.stop import STOP
from linkages.elements.torque import TORQUE
from linkages.elements.torsion_spring import TORSION_SPRING
from linkages.elements.touch import TOUCH
from linkages.input.functions.definitions import Function, Quantity
from linkages.mechanics.planar.functions import Functions, given_at
from linkages.mechanics.planar.record_types import MARKER

#: All kinds, in the order in which their forces are added, and their states are in the state vector.
KINDS: tuple[Element[Any], ...] = (
    *(FORCE, TORQUE, FRICTION, SPRING, TORSION_SPRING, STATE, MOTOR, CONTROLLER),
    *(STOP, GEAR, COUPLING, GEARBOX, TOUCH),
)

OF_ELEMENTS = {kind.table: kind for kind in KINDS}  #: the kinds, by their tables
TABLES = tuple(kind.table for kind in KINDS if kind.derived is None)  #: of experiments
PUSHING = tuple(kind.table for kind in KINDS if kind.push is not None)  #: whose elements are loads
ACTING = tuple(kind for kind in KINDS if kind.record is not None)  #: the kinds that act on bodies
DEFINING = tuple(kind for kind in KINDS if kind.quantities is not None)  #: the kinds that define quantities

#: The records of each kind that acts on bodies, by its table.
Elements: Any = namedtuple("Elements", [kind.table for kind in ACTING])  # type: ignore[misc] # made of the kinds
NO_ELEMENTS = Elements(*(np.zeros(0, kind.record) for kind in ACTING))

Tables = Mapping[str, Mapping[str, Any]]  #: the keys of the elements of each kind, by table and name


def all_elements_of(tables: Tables, kinds: Iterable[Element[Any]] = KINDS) -> Iterator[tuple[Element[Any], str, Any]]:
    """Yield kind, name and keys of all elements."""
    for kind in kinds:
        for name, keys in tables[kind.table].items():
            yield kind, name, keys


def elements_of(tables: Tables) -> Iterator[tuple[Element[Any], str, Any]]:
    """Yield kind, name and keys of the elements that act on bodies, in the order of their rows."""
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


def quantities_of(tables: Tables) -> dict[str, Quantity]:
    """Return the quantities that elements define, by the names that formulas have for them."""
    found: dict[str, Quantity] = {}
    for kind in DEFINING:
        for name, keys in tables[kind.table].items():
            found |= kind.quantities(keys, name) if kind.quantities is not None else {}
    return found


def owner_of(tables: Tables, quantity: str) -> tuple[str, str]:
    """Return table and name of the element that defines a quantity."""
    name = quantity.partition(".")[0]
    return next((kind.table, name) for kind in DEFINING if name in tables[kind.table])


def functions_of(tables: Tables) -> Iterator[tuple[str, str, Function]]:
    """Yield table, name and each function of the elements."""
    for kind, name, keys in all_elements_of(tables):
        for functions in kind.functions_of(keys, name).values():
            yield from ((kind.table, name, function) for function in functions)


def pack_elements(tables: Tables, places: Places, add: Callable[[Sequence[Function]], int]) -> Any:
    """Make the records of all elements, as `Elements`; ``add`` adds functions, and returns the index of the first."""
    return Elements(*(_records(kind, tables[kind.table], places, add) for kind in ACTING))


def _records(
    kind: Element[Any], named: Mapping[str, Any], places: Places, add: Callable[[Sequence[Function]], int]
) -> Records:
    records: Records = np.zeros(len(named), kind.record)
    for record, (name, keys) in zip(records, named.items(), strict=True):
        for field, number in kind.pack(keys, places).items():
            record[field] = number
        for field, functions in kind.functions_of(keys, name).items():
            record[field] = add(functions)
    return records


def record_of(elements: Any, tables: Tables, table: str, name: str) -> np.record:
    """Return the record of an element by its table and name."""
    found: np.record = getattr(elements, table)[list(tables[table]).index(name)]
    return found


def count(elements: Sequence[Records]) -> int:
    """Count the elements, each of which has a row in the table of `tell_elements`."""
    return sum(map(len, elements))


def apart(elements: Any) -> Iterator[Any]:
    """Yield each element alone, in the order of their rows."""
    for table, records in zip(elements._fields, elements, strict=True):
        for k in range(len(records)):
            yield NO_ELEMENTS._replace(**{table: records[k : k + 1]})


def markers_of(elements: Sequence[Records]) -> list[np.record]:
    """List the markers at which elements act, including the markers of their terms."""
    return [marker for records in elements for record in records for marker in _markers(record)]


def _markers(record: Any) -> Iterator[np.record]:
    for name, (kind, *_) in record.dtype.fields.items():
        if kind == MARKER:
            yield record[name]
        elif kind.fields:
            yield from _markers(record[name])


def _loops(loop: Callable[[Element[Any]], Callable[..., None]]) -> dict[str, Any]:
    """Make the loop of each kind over a duty, as lazy kernels of different names."""
    found = {}
    for kind in ACTING:
        made = loop(kind)
        name = f"{loop.__name__.removeprefix('_')}_{kind.table}"
        made.__qualname__ = made.__name__ = name
        found[name] = globals()[name] = lazy_kernel(makes_arrays=kind.functions is not None)(made)
    return found


def _act(kind: Element[Any]) -> Callable[..., None]:
    act: Any = kind.act

    def loop(elements: Records, pose: Array, vel: Array, wrench: Array) -> None:
        for k in range(len(elements)):
            act(elements[k], pose, vel, wrench)

    def loop_with_functions(
        elements: Records, functions: Functions, t: float, v: Array, pose: Array, vel: Array, wrench: Array
    ) -> None:
        given = given_at(functions, t, v, pose, vel)
        for k in range(len(elements)):
            act(elements[k], given, pose, vel, wrench)

    return loop if kind.functions is None else loop_with_functions


def _tell(kind: Element[Any]) -> Callable[..., None]:
    tell: Any = kind.tell

    def loop(elements: Records, first: int, pose: Array, vel: Array, rows: Array) -> None:
        for k in range(len(elements)):
            tell(elements[k], pose, vel, rows[first + k])

    def loop_with_functions(
        elements: Records, functions: Functions, t: float, v: Array, first: int, pose: Array, vel: Array, rows: Array
    ) -> None:
        given = given_at(functions, t, v, pose, vel)
        for k in range(len(elements)):
            tell(elements[k], given, pose, vel, rows[first + k])

    return loop if kind.functions is None else loop_with_functions


def _in_turn(name: str, parameters: str, loops: dict[str, Any], after: str = "") -> Any:
    """Make the kernel that calls the loops of the kinds that a machine has."""
    lines = [f"def {name}(elements, functions, t, v, {parameters}) -> None:"]
    for loop, kind in zip(loops, ACTING, strict=True):
        given = "" if kind.functions is None else "functions, t, v, "
        lines += [f"    if len(elements.{kind.table}):", f"        {loop}(elements.{kind.table}, {given}{parameters})"]
        lines += [f"    {after.format(table=kind.table)}"] if after else []
    names = loops | {"__name__": __name__}
    exec("\n".join(lines), names)
    return kernel(names[name])


#: ``add_elements(elements, functions, t, v, pose, vel, wrench)`` adds the forces of all elements at time t [s] to the
#: bodies' wrenches; v ends with the additional states.
add_elements = _in_turn("add_elements", "pose, vel, wrench", _loops(_act))
#: ``tell_elements(elements, functions, t, v, first, pose, vel, rows)`` fills the rows of all elements, from a first one
#: on.
tell_elements = _in_turn("tell_elements", "first, pose, vel, rows", _loops(_tell), "first += len(elements.{table})")
