"""User-written functions of time, positions and speeds: formulas and tables, as programs for kernels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache, partial, reduce
from typing import NamedTuple

import numpy as np

from linkages.base.errors import nearest
from linkages.input.files.formula import Formula, parse, shown
from linkages.input.files.toml import check_increasing
from linkages.mechanics.planar.jets import CODES
from linkages.mechanics.planar.motion import INPUT, NUMBER, TABLE, Pieces, Program

TIME = "t"

#: Positions and speeds that a load can depend on: of a link or frame, in plane axes, and of a joint, with their units.
#: For a prismatic joint read m for rad.
OF_POINTS = {"x": "m", "y": "m", "angle": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s"}
OF_JOINTS = {"coordinate": "rad", "rate": "rad/s"}

#: Quantities of motors and controllers, and of states as outputs, with their units.
OF_OWN = {
    "current": "A", "voltage": "V", "torque": "N m", "speed": "rad/s", "slip": "1", "electrical_power": "W",
    "losses": "W", "energy": "J", "temperature": "degC", "error": "SI", "output": "SI", "integral": "SI", "value": "SI",
}  # fmt: skip


class Definition(NamedTuple):
    """A formula whose names stand for numbers, for other names, or for themselves; or a table over its value."""

    formula: Formula
    names: Mapping[str, float | str] = {}
    table: tuple[list[float], list[float]] | None = None  # places, and values there: a monotone cubic


class Curve(NamedTuple):
    """A curve over the time, or over a position or speed, by its name."""

    curve: Pieces | Program
    over: str = TIME


#: A function that an element gives: a constant, a curve, or a formula of the time, positions, speeds and quantities.
Function = float | Curve | Definition


class Call(NamedTuple):
    """A controller in Python, by name: it gives this state and others after it."""

    function: str
    arguments: tuple[str, ...]  # quantities
    results: int  # number of states; 0 after the first one


class Quantity(NamedTuple):
    """A named quantity of the experiment: a state with the formula of its rate or next value, or a formula alone."""

    definition: Definition
    is_state: bool = False
    start: float = 0.0
    scale: float = 1.0
    period: float = 0.0  # between the samples of a state [s]; 0: continuous
    call: Call | None = None  # gives the next value instead of the formula


@lru_cache(maxsize=64)  # parsing a long formula takes a second
def formula(text: str, of_state: bool = True) -> Formula:
    """Read a formula of the time t and of values, and optionally of positions, speeds and states; errors as `parse`."""
    found = parse(text, (*OF_POINTS, *OF_JOINTS, *OF_OWN))
    for name in sorted(found.names):
        if "." in name and not of_state:
            raise ValueError(f'"{shown(text)}" has "{name}"; it may have {TIME}, the time')
    return found


def named(name: str) -> Definition:
    """Return the definition that is the value of a quantity."""
    return Definition(Formula(name, frozenset({name}), (name,)))


def constant(name: str, value: float) -> Quantity:
    """Return the quantity that is a number."""
    return Quantity(named(name)._replace(names={name: value}))


def over_time(text: str, values: Mapping[str, float]) -> Definition:
    """Read a formula of the time t and of named values; errors as `formula`, and for other names in it."""
    found = formula(text, of_state=False)
    if unknown := sorted(found.names - {TIME, *values}):
        known = ", ".join([f"{TIME}, the time", *values])
        raise ValueError(f'"{shown(text)}" has "{unknown[0]}"; it may have {known}')
    return Definition(found, values)


def names_in(function: Function) -> set[str]:
    """Return the names that a function reads: the time, positions, speeds, quantities."""
    if isinstance(function, Definition):
        meant = {function.names.get(name, name) for name in function.formula.names}
        return {name for name in meant if isinstance(name, str)}
    return {function.over} if isinstance(function, Curve) else set()


def inputs_of(given: Definition, quantities: Mapping[str, Quantity], inside: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the names of the inputs of a definition: signals, states, the time.

    KeyError with the name of a quantity that depends on itself.
    """
    for name in sorted(given.formula.names):
        meant = given.names.get(name, name)
        if not isinstance(meant, str):
            continue
        if meant in quantities and not quantities[meant].is_state:
            if meant in inside:
                raise KeyError(meant)
            yield from inputs_of(quantities[meant].definition, quantities, (*inside, meant))
        else:
            yield meant


def program(
    given: Formula | Definition,
    inputs: Mapping[str, int],
    quantities: Mapping[str, Quantity] | None = None,
    tables: Callable[[tuple[list[float], list[float]]], int] | None = None,
) -> Program:
    """Translate a formula; `inputs` are the indices of its names, and `quantities` others that are formulas.

    `tables` gives the index of the function that is a table.

    Examples
    --------
    >>> from linkages.input.functions.definitions import formula, program
    >>> program(formula("2*t"), {"t": 0}).steps.tolist()  # a number, the time, their product
    [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0], [17.0, 0.0, 1.0]]
    """
    steps: dict[tuple[float, float, float], int] = {}  # each step once: generated formulas repeat terms

    def add(code: float, first: float, second: float = 0.0) -> int:
        return steps.setdefault((code, first, second), len(steps))

    def apply(name: str, arguments: list[int]) -> int:
        if name == "pos":
            return arguments[0]
        if len(arguments) == 1:
            return add(CODES[name], arguments[0])
        return reduce(partial(add, CODES[name]), arguments)

    known, numbers = quantities or {}, dict[tuple[int, str], float]()

    def translate(one: Definition) -> int:
        def name(text: str) -> int:
            meant = one.names.get(text, text)
            if not isinstance(meant, str):  # values apart, that equal numbers can follow different values
                return add(NUMBER, meant, numbers.setdefault((id(one), text), 1.0 + len(numbers)))
            if meant in known and not known[meant].is_state:
                return translate(known[meant].definition)
            return add(INPUT, inputs[meant])

        value = one.formula.fold(lambda number: add(NUMBER, number), name, apply)
        return value if one.table is None or tables is None else add(TABLE, tables(one.table), value)

    translate(given if isinstance(given, Definition) else Definition(given))
    return Program(np.array([*steps], dtype=np.float64))


def table_over(signal: int, table: int) -> Program:
    """Return a program that evaluates a table (a piecewise polynomial, by its index) at an input (by its index)."""
    return Program(np.array([(INPUT, signal, 0), (TABLE, table, 0)], dtype=np.float64))


def check_table(over: str | None, at: list[float] | None, values: object, many: str) -> None:
    """Check a table over a position or speed: equally many places and values, places increasing."""
    if (over is None) != (at is None):
        raise ValueError("over and at must both be given: the position or speed of the table, and its values")
    if over is None or at is None:
        return
    check_increasing("places at", at, many, values if isinstance(values, list) else [])
    part = over.rpartition(".")[2]
    if "." not in over or part not in (*OF_POINTS, *OF_JOINTS):
        raise ValueError(f'over is "{over}"; give POINT.x or the like: {nearest(part, (*OF_POINTS, *OF_JOINTS))}')
