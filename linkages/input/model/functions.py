"""User-written functions of time, positions and speeds: formulas and tables, as programs for kernels."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache, partial, reduce

import numpy as np

from linkages.base.errors import nearest
from linkages.input.files.formula import Formula, parse, shown
from linkages.input.files.toml import check_increasing
from linkages.mechanics.planar.jets import CODES
from linkages.mechanics.planar.motion import INPUT, NUMBER, TABLE, Program

TIME = "t"

#: Positions and speeds that a load can depend on: of a link or frame, in plane axes, and of a joint, with their units.
#: For a prismatic joint read m for rad.
OF_POINTS = {"x": "m", "y": "m", "angle": "rad", "vx": "m/s", "vy": "m/s", "omega": "rad/s"}
OF_JOINTS = {"coordinate": "rad", "rate": "rad/s"}


@lru_cache(maxsize=64)  # parsing a long formula takes a second
def formula(text: str, of_state: bool = True) -> Formula:
    """Read a formula of the time t and optionally of positions and speeds such as ``slider.x``; errors as `parse`."""
    found = parse(text, (*OF_POINTS, *OF_JOINTS))
    for name in sorted(found.names):
        if name != TIME and not (of_state and "." in name):
            known = f"{TIME}, the time" + (", or POINT.x, JOINT.rate and the like" if of_state else "")
            raise ValueError(f'"{shown(text)}" has "{name}"; it may have {known}')
    return found


def program(given: Formula, inputs: Mapping[str, int]) -> Program:
    """Translate a formula; `inputs` are the indices of its names.

    Examples
    --------
    >>> from linkages.input.model.functions import formula, program
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

    last = given.fold(lambda value: add(NUMBER, value), lambda name: add(INPUT, inputs[name]), apply)
    assert last == len(steps) - 1
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
