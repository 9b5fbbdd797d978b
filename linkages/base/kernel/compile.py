"""The compiler of all numerical kernels.

| decorator        | compiled                                   | called by other kernels                    |
|------------------|--------------------------------------------|--------------------------------------------|
| `kernel`         | by itself, when a caller is compiled       | as an external function                    |
| `lazy_kernel`    | by itself, at the first call               | as an external function, through a cell    |
| `inlined_kernel` | with each caller                           | inlined                                    |

An external function (`linkages.base.kernel.external`) returns nothing, a number or a tuple of numbers, as its
annotation says. A `kernel` with another result, or without an annotation, is compiled with each caller. All kernels
divide as IEEE says. Calls from Python release the GIL.

References to arrays are counted where a kernel makes arrays. Declare it, ``@kernel(makes_arrays=True)``: else it is
compiled twice.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property, partial, update_wrapper
from inspect import Signature, signature
from typing import Any, TypeVar, cast, get_args, get_type_hints, overload

import numba
from numba import types
from numba.extending import lower_builtin, type_callable, typeof_impl

from linkages.base.kernel import precompiled
from linkages.base.kernel.by_reference import shape
from linkages.base.kernel.dual import has_duals, with_duals
from linkages.base.kernel.external import call_symbol, external, under_way
from linkages.base.kernel.fingerprint import LAZY
from linkages.base.kernel.lazy_calls import call_cell, failures, kernels
from linkages.base.kernel.private import COUNTED, INLINED, OFF, UNCOUNTED, one_thread, python_function
from linkages.base.kernel.stored import counts_references, name_of, obtain

F = TypeVar("F", bound=Callable[..., Any])
_NUMBERS = {None: types.none, float: types.float64, int: types.int64, bool: types.boolean}


@overload
def kernel(function: F) -> F: ...
@overload
def kernel(*, makes_arrays: bool) -> Callable[[F], F]: ...
def kernel(function: Any = None, *, makes_arrays: bool = False) -> Any:
    """Compile a function by itself; other kernels call it."""
    return _decorator(b"kernel", makes_arrays, function)


@overload
def inlined_kernel(function: F) -> F: ...
@overload
def inlined_kernel(*, makes_arrays: bool) -> Callable[[F], F]: ...
def inlined_kernel(function: Any = None, *, makes_arrays: bool = False) -> Any:
    """Compile a small function into the body of each caller."""
    return _decorator(b"inlined", makes_arrays, function)


@overload
def lazy_kernel(function: F) -> F: ...
@overload
def lazy_kernel(*, makes_arrays: bool) -> Callable[[F], F]: ...
def lazy_kernel(function: Any = None, *, makes_arrays: bool = False) -> Any:
    """Compile a function at its first call, also if compiled code calls it.

    Raises
    ------
    TypeError
        If its result is not annotated as None, float, int, bool or a tuple of these.
    """
    return _decorator(LAZY, makes_arrays, function)


def _decorator(kind: bytes, makes_arrays: bool, function: Any) -> Any:
    """Make a kernel of this kind of a function; without the function, return the decorator."""
    if function is None:
        return partial(_made, kind=kind, makes_arrays=makes_arrays)
    return _made(function, kind, makes_arrays)


def _made(function: Any, kind: bytes, makes_arrays: bool) -> Any:
    if OFF:
        return function
    if kind == LAZY and _result(function) is None:
        given, what = function.__annotations__.get("return"), "None, float, int, bool, or a tuple of these"
        raise TypeError(f"the lazy kernel {function.__qualname__} returns {given}; annotate its result as {what}")
    function.makes_arrays = makes_arrays
    return Kernel(function, kind)


class Kernel:
    """A compiled function."""

    def __init__(self, function: Any, kind: bytes) -> None:
        update_wrapper(self, function)
        self.py_func, self.kind = function, kind
        self._entries: dict[Any, Any] = {}  # what Python calls, by the types of the arguments
        precompiled.known()
        kernels[function.__module__, function.__qualname__] = self
        type_callable(self)(self._type_call)
        lower_builtin(self, types.VarArg(types.Any))(self._write_call)

    @cached_property
    def _signature(self) -> Signature:
        return signature(self.py_func)

    @cached_property
    def result(self) -> Any:
        """Type of an external function's result; None if callers contain the function."""
        return None if self.kind == b"inlined" else _result(self.py_func)

    @cached_property
    def inlined(self) -> Any:
        """Function that is compiled with each caller."""
        counts = counts_references(self.py_func) or not _returns_numbers(self.py_func)
        options: Any = (
            INLINED
            | (COUNTED if counts else UNCOUNTED)
            | {"error_model": "numpy", "forceinline": self.kind == b"inlined"}
        )
        return numba.njit(**options)(self.py_func)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Call it from Python."""
        if named or len(arguments) != len(self._signature.parameters):
            bound = self._signature.bind(*arguments, **named)
            bound.apply_defaults()
            arguments = bound.args
        return _call(self.entry(*arguments), *arguments)

    def entry(self, *arguments: Any) -> Any:
        """Compile or load the function that Python calls with arguments of these types."""
        key = tuple(map(shape, arguments))
        if key not in self._entries:
            with one_thread:
                self._entries[key] = self._entries.get(key) or self._entry(tuple(map(numba.typeof, arguments)))
        return self._entries[key]

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    def _entry(self, kinds: tuple[Any, ...]) -> Any:
        """Compile or load the function for calls from Python."""
        make = partial(python_function, kinds=kinds, error_model="numpy")
        return obtain(name_of(self.py_func, kinds), self.py_func, make, not _returns_numbers(self.py_func))

    def prepare(self, *kinds: Any) -> None:
        """Compile or load the external function for arguments of these numba types."""
        external(self.py_func, kinds, self.result_for(kinds))

    def result_for(self, kinds: Any) -> Any:
        """Type of the result for arguments of these types: its floats are duals if an argument has duals."""
        return with_duals(self.result) if any(map(has_duals, kinds)) else self.result

    def _type_call(self, context: Any) -> Callable[..., Any]:
        """Make the function that types a call by another kernel."""

        def type_call(*given: Any, **named: Any) -> Any:
            kinds = tuple(map(types.unliteral, self._signature.bind(*given, **named).args))
            return self.result_for(kinds)(*kinds)

        cast(Any, type_call).__signature__ = self._signature
        return type_call

    def _write_call(self, context: Any, builder: Any, typed: Any, values: Any) -> Any:
        """Write a call by another kernel; defaults become arguments."""
        missing = [each.default for each in self._signature.parameters.values()][len(values) :]
        kinds = tuple(map(numba.typeof, missing))
        typed = typed.return_type(*typed.args, *kinds)
        values = [*values, *(context.get_constant(*each) for each in zip(kinds, missing, strict=True))]
        lazy = self.kind == LAZY or under_way(self.py_func, typed.args, typed.return_type)
        return (call_cell if lazy else call_symbol)(self.py_func, context, builder, typed, values)


def _call(entry: Any, *arguments: Any) -> Any:
    """Call a compiled function; raise what kept the lazy kernels that it calls from being compiled."""
    result = entry(*arguments)
    if failures:
        error = failures[0]
        failures.clear()
        raise error
    return result


def bound(function: F, *arguments: Any) -> F:
    """Return a kernel for arguments of these types alone: a call from Python does not find out the types again."""
    return cast(F, partial(_call, function.entry(*arguments))) if isinstance(function, Kernel) else function


@typeof_impl.register(Kernel)
def _type_of(kernel: Kernel, context: Any) -> Any:
    return None if kernel.result else numba.typeof(kernel.inlined)


def _result(function: Any) -> Any:
    """Find the numba type of an external function's result in its annotation; None if it is no number."""
    kind = _annotation(function)
    with suppress(KeyError, TypeError):
        parts = get_args(kind)
        return types.Tuple([_NUMBERS[part] for part in parts]) if parts else _NUMBERS[kind]
    return None


def _annotation(function: Any) -> Any:
    """Return the annotation of a function's result; Any if it is not known."""
    kind = function.__annotations__.get("return", Any)
    with suppress(NameError, TypeError):
        return eval(kind, function.__globals__) if isinstance(kind, str) else kind
    return Any


def _returns_numbers(function: Any) -> bool:
    """Whether the result holds numbers alone, no array, whose references would be counted."""
    waiting = [_annotation(function)]
    while waiting:
        kind = waiting.pop()
        parts = get_args(kind) or (tuple(get_type_hints(kind).values()) if isinstance(kind, type) else ())
        if not parts and kind not in _NUMBERS:
            return False
        waiting.extend(parts)
    return True
