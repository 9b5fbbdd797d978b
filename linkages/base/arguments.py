"""Arguments of public functions: converted and checked at the call, errors in one line.

A decorator of our own: pydantic's `validate_call` would build schemas of all fields of systems and trajectories.
"""

from __future__ import annotations

import math
import operator
from collections import abc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial, wraps
from inspect import signature
from types import NoneType, UnionType
from typing import Annotated, Any, Generic, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")

_ROUNDING = 1e-12  # times that lie so far beyond an end, relative to it, count as the end
_LONGEST = 40  # most characters of a wrong value in a message
_KINDS = {"U": "texts", "S": "texts", "c": "complex"}  # of numpy's types


def validated(function: F) -> F:
    """Convert and check the arguments of a function by their annotations.

    ``float`` takes finite numbers, ``int`` whole ones, ``str`` texts, a class of ours its instances, ``Callable``
    functions, ``tuple`` as many values as it names. ``Annotated[type, check]`` is converted by ``check``, which raises
    ValueErrors. None passes where the annotation allows it. Other annotations, and unions, are not checked.

    Raises
    ------
    InputError
        When the function is called with an invalid argument: its name, the value and the allowed values.
    """
    parameters = signature(function)
    checks = cache(lambda: _checks(function))

    @wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        given = parameters.bind(*arguments, **named)
        for name in [name for name in checks() if name in given.arguments]:
            try:
                given.arguments[name] = checks()[name](given.arguments[name])
            except ValueError as problem:
                raise InputError("argument", name, str(problem)) from None
        return function(*given.args, **given.kwargs)

    return cast(F, call)


def _checks(function: Callable[..., Any]) -> dict[str, Callable[[Any], Any]]:
    """Return the check of each parameter that has one."""
    found = {}
    for name, hint in get_type_hints(function, include_extras=True).items():
        kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
        given = [kind for kind in kinds if kind is not NoneType]
        check = _check(given[0]) if name != "return" and len(given) == 1 else None
        if check is not None:
            found[name] = partial(_unless_none, check) if NoneType in kinds else check
    return found


def _check(kind: Any) -> Callable[[Any], Any] | None:
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return cast(Callable[[Any], Any], inner[1])
    if origin is tuple and Ellipsis not in inner:
        return partial(items, [_check(one) or (lambda item: item) for one in inner])
    if kind in (int, float):
        return whole if kind is int else number
    if origin is abc.Callable or kind is str:
        return partial(instance, abc.Callable if origin else str, "a function" if origin else "a text")
    ours = isinstance(kind, type) and kind.__module__.partition(".")[0] in ("linkages", "optim")
    if not ours or getattr(kind, "_is_protocol", False):
        return None
    return partial(instance, kind, f"a {kind.__name__} of {kind.__module__.partition('.')[0]}")


def _unless_none(check: Callable[[Any], Any], value: Any) -> Any:
    return None if value is None else check(value)


def instance(kind: Any, what: str, value: Any) -> Any:
    """Return an object of a class; ValueError for others."""
    if not isinstance(value, kind):
        raise ValueError(f"is {_shown(value)}; give {what}")
    return value


def items(checks: Sequence[Callable[[Any], Any]], values: Any) -> tuple[Any, ...]:
    """Convert some values to a tuple, each by its check; ValueError for fewer or more."""
    if np.ndim(values) != 1 or isinstance(values, str) or len(values) != len(checks):
        raise ValueError(f"is {_shown(values)}; give {len(checks)} values")
    return tuple(check(value) for check, value in zip(checks, values, strict=True))


def number(value: Any) -> float:
    """Convert a finite real number; ValueError for texts, truth values, arrays, complex numbers, NaN."""
    try:
        found = math.nan if isinstance(value, str | bytes | bool) or np.ndim(value) else float(value)
    except (TypeError, ValueError):
        found = math.nan
    if not math.isfinite(found):
        raise ValueError(f"is {_shown(value)}; give a finite number")
    return found


def whole(value: Any, least: int | None = None) -> int:
    """Convert a whole number, not less than the least one."""
    try:
        found = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        found = None
    if found is None or (least is not None and found < least):
        raise ValueError(f"is {_shown(value)}; give a whole number" + ("" if least is None else f", {least} or more"))
    return found


def numbers(values: Any, dimensions: int | None = None, finite: bool = True) -> Array:
    """Convert real numbers to a new array of this many dimensions; ValueError for others, and for masked ones."""
    if np.ma.is_masked(values):
        raise ValueError("have masked entries; fill them, or leave their rows out")
    try:
        found = np.array(values, order="C")
        found = found.astype(np.float64, copy=False) if found.dtype.kind in "biufO" else found  # O: such as fractions
    except (TypeError, ValueError) as problem:
        raise ValueError(f"are no table of numbers: {problem}") from None
    if found.dtype != np.float64:
        raise ValueError(f"are no real numbers but {_KINDS.get(found.dtype.kind, found.dtype.name)}")
    if dimensions not in (None, found.ndim):
        wanted = "a list of numbers" if dimensions == 1 else "a table, a line for each"
        raise ValueError(f"have {found.ndim} dimensions; give {wanted}")
    if finite and not np.isfinite(found).all():
        raise ValueError(f"have {found[~np.isfinite(found)][0]}; give finite numbers")
    return found


def lines(values: Any) -> Array:
    """Convert a table of numbers (m, n), of which a single line may be a list; NaN is allowed."""
    found = numbers(values, finite=False)
    if found.ndim > 2:
        raise ValueError(f"have {found.ndim} dimensions; give a table, a line for each")
    return np.atleast_2d(found)


def names(values: Any) -> tuple[Any, ...]:
    """Convert names to a tuple; ValueError for one text, of which Python would take the letters."""
    return tuple(instance(str, "a list of names", name) for name in several(values))


def several(values: Any) -> tuple[Any, ...]:
    """Convert the items of a list to a tuple; ValueError for a text."""
    if isinstance(values, str):
        raise ValueError(f'is a text; give a list: ["{values}"]')
    try:
        return tuple(values)
    except TypeError:
        raise ValueError(f"is {_shown(values)}; give a list of names") from None


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


#: Whole numbers from 0 and from 1 on, and a number of threads.
Whole = Annotated[int, partial(whole, least=0)]
Count = Annotated[int, partial(whole, least=1)]
#: Lists of names.
Names = Annotated[Sequence[str], names]
#: Finite numbers: (n,) and (m, n) arrays.
vector = partial(numbers, dimensions=1)
Vector = Annotated[Array, vector]
Matrix = Annotated[Array, partial(numbers, dimensions=2)]
#: (m, n) array, of which a single line may be a list; NaN is allowed.
Lines = Annotated[Any, lines]


@dataclass(frozen=True)
class Dense(Generic[T]):
    """A function of times that refuses times outside its range: ``dense(times)``."""

    function: Callable[[Array], T]  # takes times (n,) [s]
    start: float  # of the range [s]
    end: float  # of the range [s]

    @validated
    def __call__(self, times: Vector) -> T:
        """Evaluate the function at times (n,) in any order; InputError for other arrays and for times outside."""
        return self.function(inside(times, self.start, self.end))


def fitting(values: Array, count: int, argument: str, what: str) -> Array:
    """Return an array whose last axis has one number for each of `count` things; InputError for others."""
    if values.shape[-1] != count:
        raise InputError("argument", argument, f"have {values.shape[-1]} numbers for {count} {what}; give as many")
    return values


def shaped(values: Any, shape: tuple[int, ...], argument: str, what: str) -> Array:
    """Return numbers of an argument, such as a function's result, as an array of this shape; InputError for others."""
    try:
        found = numbers(values, finite=False)
    except ValueError as problem:
        raise InputError("argument", argument, f"its {what} {problem}") from None
    if found.shape != shape:
        raise InputError("argument", argument, f"its {what} have the shape {found.shape}; they must have {shape}")
    return found


def inside(times: Array, start: float, end: float, argument: str = "times") -> Array:
    """Return times that lie in a range, ends included; InputError names the first that does not."""
    slack = _ROUNDING * max(abs(start), abs(end))
    beyond = np.flatnonzero((times < start - slack) | (times > end + slack))
    if len(beyond):
        problem = f"have {times[beyond[0]]:g} s, outside the run from {start:g} to {end:g} s; give times within it"
        raise InputError("argument", argument, problem)
    return np.clip(times, start, end)
