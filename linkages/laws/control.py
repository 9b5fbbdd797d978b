"""Controllers that are functions in Python: compiled code calls them between two steps; they are not compiled."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types

from linkages.base.kernel import address, caller
from linkages.base.kernel.lazy_calls import failures
from linkages.base.kernel.private import OFF
from linkages.laws.parameters import Parameter

_F = types.float64
_CALLED = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_double)
_alive: list[Any] = []  # callbacks and their tables

#: ``call_controller(address, (place, arguments, results))`` within kernels: numbers begin at this place in memory, the
#: arguments with the time first; the function fills the results, which follow them. Exceptions are raised when
#: the kernel returns to Python; the results are then not numbers.
call_controller = caller(_F)


class ControlLaw(NamedTuple):
    """A registered controller: the function, and the names of its parameters after the time."""

    function: Callable[..., float | Sequence[float]]
    names: tuple[str, ...]
    parameters: tuple[Parameter, ...] = ()  # files declare its own

    @property
    def address(self) -> int:
        """Address for `call_controller` in this process."""
        return _address(self.function)


#: The controllers an experiment can name.
CONTROLLERS: dict[str, ControlLaw] = {}


@cache
def _address(function: Callable[..., float | Sequence[float]]) -> int:
    def call(place: float, arguments: float, results: float) -> float:
        count, size = int(arguments), int(arguments + results)
        numbers = np.ctypeslib.as_array((ctypes.c_double * size).from_address(int(place)))
        try:
            numbers[count:] = _called(function, numbers[:count].tolist(), int(results))
        except BaseException as error:
            if OFF:
                raise
            numbers[count:] = np.nan
            failures.append(error)
        return 0.0

    if OFF:
        return address(call, _F(_F, _F, _F))
    made = _CALLED(call)
    table = (ctypes.c_int64 * 1)(ctypes.cast(made, ctypes.c_void_p).value or 0)
    _alive.append((made, table))
    return ctypes.addressof(table)


def _called(function: Callable[..., float | Sequence[float]], arguments: list[float], results: int) -> Any:
    """Return the results of a function, (results,); ValueError if these are not so many finite numbers."""
    name = getattr(function, "__name__", repr(function))
    try:
        found = function(*arguments)
        numbers = np.ravel(np.asarray(found, np.float64))
    except Exception as error:
        error.add_note(f"in the controller {name} at t = {arguments[0]:g} s")
        raise
    if len(numbers) != results or not np.isfinite(numbers).all():
        wanted = "1 finite number" if results == 1 else f"{results} finite numbers, the output and then its memory"
        raise ValueError(f"the controller {name} returned {found!r} at t = {arguments[0]:g} s; it must return {wanted}")
    return numbers
