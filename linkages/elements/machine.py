"""The elements of a machine in arrays, and one compiled loop for each kind.

A machine compiles the loops of the kinds that it has: they are lazy kernels, which contain the kernels of their kind.
The kinds whose kernels read functions come last, so that the inputs of functions are computed once for all of them.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.base.arrays import Array, Records
from linkages.base.kernel import kernel, lazy_kernel, record_type
from linkages.elements.controller import CONTROLLER
from linkages.elements.coordinates import Barrier, Coupled, Edge, Push
from linkages.elements.coupling import COUPLING
from linkages.elements.drive import DRIVE
from linkages.elements.element import VALUE, Element, Places, Slides
from linkages.elements.flexible_link import FLEXIBLE_LINK
from linkages.elements.force import FORCE
from linkages.elements.friction import FRICTION
from linkages.elements.gear import GEAR
from linkages.elements.gearbox import GEARBOX
from linkages.elements.motor import MOTOR
from linkages.elements.outputs import Source
from linkages.elements.spring import SPRING
from linkages.elements.state import STATE
from linkages.elements.stop import STOP
from linkages.elements.torque import TORQUE
from linkages.elements.torsion_spring import TORSION_SPRING
from linkages.elements.touch import TOUCH
from linkages.input.functions.definitions import Function, Quantity, named
from linkages.mechanics.planar.functions import given_at, value_of
from linkages.mechanics.planar.motion import Curves
from linkages.mechanics.planar.record_types import MARKER

#: All kinds, in the order of their outputs and of their states in the state vector.
KINDS: tuple[Element[Any], ...] = (
    *(DRIVE, FLEXIBLE_LINK, FORCE, TORQUE, FRICTION, SPRING, TORSION_SPRING, STATE, MOTOR, CONTROLLER),
    *(STOP, GEAR, COUPLING, GEARBOX, TOUCH),
)

OF_ELEMENTS = {kind.table: kind for kind in KINDS}  #: the kinds, by their tables
#: The kinds that are models of parts of a machine; the kinds whose elements have names of their own, in own tables.
OF_PARTS = tuple(kind for kind in KINDS if kind.part)
NAMED = tuple(kind for kind in KINDS if kind.derived is None and not kind.part)
TABLES = tuple(kind.table for kind in NAMED)  #: of experiments
PUSHING = tuple(kind.table for kind in KINDS if kind.push is not None)  #: whose elements are loads
DEFINING = tuple(kind for kind in KINDS if kind.quantities is not None)  #: the kinds that define quantities
_PLAIN = tuple(kind for kind in KINDS if kind.record is not None and kind.functions is None)
_READING = tuple(kind for kind in KINDS if kind.record is not None and kind.functions is not None)
#: The kinds that act on bodies, in the order in which their forces are added, and of their rows.
ACTING = _PLAIN + _READING

#: A quantity that elements define, as an output.
TOLD = record_type(function="i8")

_named_tuple: Any = namedtuple  # whose fields no type checker knows
#: The records of each kind that acts on bodies, by its table; then those of the quantities.
Elements: Any = _named_tuple("Elements", [*(kind.table for kind in ACTING), "told"])
NO_ELEMENTS = Elements(*(np.zeros(0, kind.record) for kind in ACTING), np.zeros(0, TOLD))

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


def outputs_of_part(tables: Tables, part: str, name: str, slides: Slides, *sources: Source) -> set[str]:
    """Return the names of the outputs of the models of a joint or link, with these sources; default: with all."""
    known = (
        kind.outputs_of(tables[kind.table][name], slides) for kind in _modelling(part) if name in tables[kind.table]
    )
    return {key for found in known for one in found if one.source in (sources or Source) for key in one.texts}


def outputs_of_models(part: str, *sources: Source) -> dict[str, str]:
    """Return the meanings of the outputs that models of a joint or link can have, with these sources; default: all."""
    every = (one for kind in _modelling(part) for one in kind.outputs if one.source in (sources or Source))
    return {key: text for one in every for key, text in one.texts.items()}


def absent_model(part: str, name: str, output: str) -> str:
    """Return what a joint or link lacks for an output, and the remedy; empty if no model has the output."""
    kinds = (kind for kind in _modelling(part) if any(output in one.texts for one in kind.outputs))
    return next((kind.absent(name) for kind in kinds), "")


def _modelling(part: str) -> list[Element[Any]]:
    return [kind for kind in OF_PARTS if kind.part == part]


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
    records = [_records(kind, tables[kind.table], places, add) for kind in ACTING]
    told = np.array([add([named(name)]) for name in quantities_of(tables)], np.int64)
    return Elements(*records, told.view(TOLD))


def _records(
    kind: Element[Any], named: Mapping[str, Any], places: Places, add: Callable[[Sequence[Function]], int]
) -> Records:
    records: Records = np.zeros(len(named), kind.record)
    for record, (name, keys) in zip(records, named.items(), strict=True):
        for field, key in kind.values.items():
            record[field] = getattr(keys, key)
        for field, number in kind.pack(keys, places).items():
            record[field] = number
        for field, functions in kind.functions_of(keys, name).items():
            record[field] = add(functions)
    return records


def fills_of(tables: Tables) -> Iterator[tuple[str, str, int, str]]:
    """Yield the values that records of elements have as they are: path, table, index of the record, field."""
    for kind in ACTING:
        for k, name in enumerate(tables[kind.table]):
            for field, key in kind.values.items():
                yield f"{kind.path(name)}.{key}", kind.table, k, field


def record_of(elements: Any, tables: Tables, table: str, name: str) -> np.record:
    """Return the record of an element by its table and name."""
    found: np.record = getattr(elements, table)[list(tables[table]).index(name)]
    return found


def count(elements: Sequence[Records]) -> int:
    """Count the elements and quantities, each of which has a row in the table of `tell_elements`."""
    return sum(map(len, elements))


def apart(elements: Any) -> Iterator[Any]:
    """Yield each element alone, in the order of their rows."""
    for kind in ACTING:
        records = getattr(elements, kind.table)
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


def _loops(loop: Callable[[Element[Any]], Callable[..., None]]) -> dict[str, Any]:
    """Make the loop of each kind over a duty, by the kind's table."""
    return {kind.table: _lazy(f"{loop.__name__.removeprefix('_')}_{kind.table}", loop(kind)) for kind in ACTING}


def _lazy(name: str, function: Any, makes_arrays: bool = False) -> Any:
    """Make a lazy kernel of a function, under a name of this module."""
    function.__qualname__ = function.__name__ = name
    globals()[name] = lazy_kernel(makes_arrays=makes_arrays)(function)
    return globals()[name]


def _act(kind: Element[Any]) -> Callable[..., None]:
    act: Any = kind.act

    def loop(elements: Records, pose: Array, vel: Array, wrench: Array) -> None:
        for k in range(len(elements)):
            act(elements[k], pose, vel, wrench)

    def reading(elements: Records, curves: Curves, inputs: Array, pose: Array, vel: Array, wrench: Array) -> None:
        for k in range(len(elements)):
            act(elements[k], (curves, inputs), pose, vel, wrench)

    return loop if kind.functions is None else reading


def _tell(kind: Element[Any]) -> Callable[..., None]:
    tell: Any = kind.tell

    def loop(elements: Records, first: int, pose: Array, vel: Array, rows: Array) -> None:
        for k in range(len(elements)):
            tell(elements[k], pose, vel, rows[first + k])

    def reading(
        elements: Records, curves: Curves, inputs: Array, first: int, pose: Array, vel: Array, rows: Array
    ) -> None:
        for k in range(len(elements)):
            tell(elements[k], (curves, inputs), pose, vel, rows[first + k])

    return loop if kind.functions is None else reading


@lazy_kernel
def tell_quantities(
    told: Records, curves: Curves, inputs: Array, first: int, pose: Array, vel: Array, rows: Array
) -> None:
    """Fill the rows of the quantities: their values."""
    for k in range(len(told)):
        row = rows[first + k]
        row[:] = 0.0
        row[VALUE] = value_of((curves, inputs), told[k].function)


def _in_turn(duty: str, parameters: str, loops: dict[str, Any], after: str = "") -> Any:
    """Make the kernel that calls the loops of the kinds that a machine has; see `_calls`."""
    head = f"(elements, functions, t, v, {parameters}) -> None:"
    plain = [kind.table for kind in _PLAIN]
    reading = [table for table in loops if table not in plain]
    lines = [f"def {duty}_elements{head}", *_calls(plain, parameters, after)]
    lines += [f"    if {' or '.join(f'len(elements.{table})' for table in reading)}:"]
    lines += [f"        reading(elements, functions, t, v, {parameters})"]
    inner = [f"def reading{head}", "    curves, inputs = given_at(functions, t, v, pose, vel)"]
    inner += _calls(reading, f"curves, inputs, {parameters}", after)
    made = _made("reading", inner, loops)
    return kernel(_made(f"{duty}_elements", lines, loops | {"reading": _lazy(f"{duty}_reading", made, True)}))


def _calls(tables: Iterable[str], parameters: str, after: str) -> Iterator[str]:
    """Yield the lines that call the loops of some tables."""
    for table in tables:
        yield f"    if len(elements.{table}):"
        yield f"        {table}(elements.{table}, {parameters})"
        if after:
            yield f"    {after.format(table=table)}"


def _made(name: str, lines: Iterable[str], names: Mapping[str, Any]) -> Any:
    """Make a function of its lines, which call others by name."""
    known = {**names, "given_at": given_at, "__name__": __name__}
    exec("\n".join(lines), known)
    return known[name]


#: ``add_elements(elements, functions, t, v, pose, vel, wrench)`` adds the forces of all elements at time t [s] to the
#: bodies' wrenches; v ends with the additional states.
add_elements = _in_turn("add", "pose, vel, wrench", _loops(_act))
#: ``tell_elements(elements, functions, t, v, first, pose, vel, rows)`` fills the rows of all elements, then of the
#: quantities that they define, from a first one on.
tell_elements = _in_turn(
    "tell", "first, pose, vel, rows", _loops(_tell) | {"told": tell_quantities}, "first += len(elements.{table})"
)
