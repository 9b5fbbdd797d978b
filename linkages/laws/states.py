"""States of contacts: numbers that a contact remembers, declared by its laws.

| kind       | how it changes                                       | example                          |
|------------|------------------------------------------------------|----------------------------------|
| latched    | takes its value when bodies come into contact        | speed of approach                |
| continuous | at a rate that the law returns                       | bristles; a spring with a damper |
| cells      | from step to step of a run, by a law of their own    | content of a film that remembers |

The latched speed of approach belongs to every contact. A contact or friction law declares its continuous states as
`State` objects next to its function, which takes their values before the record of the joint, and returns their rates
after its force or coefficient. They are part of the state vector of a run, behind the rates of the joints.

All laws of one contact share `STATES` places: the contact law's states begin at the first one, those of the friction
law end at the last one. So the compiled functions of all laws with states have the same arguments and results.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from linkages.base.kernel import Array, caller, inlined_kernel

#: Most continuous states of one contact.
STATES = 3
#: Names of the latched states of a contact: its speed of approach [m/s].
LATCHED_NAMES = ("approach",)
#: Number of these.
LATCHED = len(LATCHED_NAMES)
#: What a contact remembers: latched states, then continuous ones.
Remembered = tuple[float, float, float, float]
#: Number of all, and place of the first continuous one.
REMEMBERED, FIRST_STATE = LATCHED + STATES, LATCHED
#: Rates of a contact without states.
NO_RATES = (0.0, 0.0, 0.0)
#: Memory of a contact that has not begun: an infinite speed of approach gives no damping.
NEW: Remembered = (np.inf, 0.0, 0.0, 0.0)
#: Fields of the record of a contact with the magnitudes of its states, in their units; 0: no such state.
SCALES = tuple(f"scale_{place}" for place in range(STATES))

_F = types.float64
#: What a law with states returns, compiled: its force or coefficient, and the rates of all states of a contact.
WITH_RATES = types.UniTuple(_F, 1 + STATES)
#: ``call_with_states(address, (..., state, state, state, joint))`` within kernels.
call_with_states = caller(WITH_RATES)


class State(NamedTuple):
    """A continuous state that a contact or friction law declares.

    Attributes
    ----------
    name : str
        Name of the argument of the law.
    unit : str
        SI unit; "1" for a pure number.
    scale : float or callable
        Magnitude, of which the error control permits a part: a number, or a function of the values in the table of the
        law (a mapping). A small one costs steps; the lengths of a machine count as some of its clearances.
    meaning : str
        One phrase for lists.
    start : float
        Value at the start of a run.

    Examples
    --------
    >>> from linkages.laws import State
    >>> State("creep", "m", 1e-4, "length of the damper").start
    0.0
    """

    name: str
    unit: str
    scale: float | Callable[[Mapping[str, Any]], float]
    meaning: str = ""
    start: float = 0.0

    def magnitude(self, values: Mapping[str, Any]) -> float:
        """Compute the magnitude for the values of a law's table."""
        return float(self.scale(values)) if callable(self.scale) else float(self.scale)


def check_states(states: Sequence[State]) -> list[str]:
    """Return the names of the states of a law; ValueError if a contact has no room for them, or a name is no name."""
    for state in states:
        if not isinstance(state, State):
            raise ValueError(f"{state!r} is not a linkages.laws.State")
    names = [state.name for state in states]
    if len(states) > STATES:
        raise ValueError(f"has {len(states)} states; at most {STATES} are possible")
    for name in names:
        if not (isinstance(name, str) and name.isidentifier()) or names.count(name) > 1:
            raise ValueError(f"state {name!r}: the name must be letters, digits and underscores, and no other state's")
    return names


def places(kind: str, count: int) -> range:
    """Return the places of a law's states in its contact."""
    return range(count) if kind == "contact" else range(STATES - count, STATES)


def set_scales(record: Any, kind: str, states: Sequence[State], values: Mapping[str, Any]) -> None:
    """Write the number of a law's states and their magnitudes into a record of `linkages.laws.PARAMETERS`."""
    record[f"{kind}_states"] = len(states)
    for place, state in zip(places(kind, len(states)), states, strict=True):
        record[SCALES[place]] = state.magnitude(values)


@inlined_kernel
def remembered_of(memory: Array) -> Remembered:
    """Return what a contact remembers from the beginning of its line of memory."""
    return memory[0], memory[1], memory[2], memory[3]


@cache
def contact_with_states(force: Callable[..., Any], count: int) -> Callable[..., Any]:
    """Give a contact law with states the arguments and results of all contact laws with states."""
    law, after = inlined_kernel(getattr(force, "py_func", force)), (STATES - count) * (0.0,)

    def called(
        delta: float, ddelta: float, ddelta0: float, a: float, b: float, c: float, joint: np.record
    ) -> tuple[float, float, float, float]:
        found = law(*((delta, ddelta, ddelta0) + (a, b, c)[:count] + (joint,)))  # noqa: RUF005 - numba's tuples
        return (found[0],) + found[1:] + after  # noqa: RUF005

    return called


@cache
def friction_with_states(coefficient: Callable[..., Any], count: int) -> Callable[..., Any]:
    """Give a friction law with states the arguments and results of all friction laws with states."""
    law, first, before = (
        inlined_kernel(getattr(coefficient, "py_func", coefficient)),
        STATES - count,
        (STATES - count) * (0.0,),
    )

    def called(v: float, a: float, b: float, c: float, joint: np.record) -> tuple[float, float, float, float]:
        found = law(*((v,) + (a, b, c)[first:] + (joint,)))  # noqa: RUF005 - numba's tuples
        return (found[0],) + before + found[1:]  # noqa: RUF005

    return called
