"""Calls of force laws at an address, which is an argument of the caller.

A law is compiled for floats, and at the first call for duals, alone and in records.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, cast

import numba
import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.extending import intrinsic

from linkages.base.kernel.dual import DUAL, has_duals, spot_of, with_dual_records, with_duals
from linkages.base.kernel.external import call_address, external
from linkages.base.kernel.lazy_calls import failures
from linkages.base.kernel.private import OFF
from linkages.base.kernel.stored import alive

_FIND_DUAL = "linkages-find-dual"  # symbol of `_find_dual`
_WORD = ir.IntType(64)
_interpreted: dict[int, Any] = {}  # without a compiler: functions by a number in place of their address
_laws: dict[int, tuple[Any, Any, Any]] = {}  # by addresses of laws: the table itself, the function, its signature
_KINDS: tuple[Callable[[Any], Any], ...] = (lambda kind: kind), with_duals, with_dual_records  # of its arguments


@cache
def address(function: Callable[..., Any], signature: Any) -> int:
    """Compile a function to a C function, or load it.

    Parameters
    ----------
    function : callable
        A function, plain or made by `linkages.base.kernel.kernel`.
    signature : numba signature

    Returns
    -------
    int
        For `caller`, in this process: address of a table, the addresses of the function for floats, for duals, and for
        duals in records too, which are found at the first call. With NUMBA_DISABLE_JIT=1 it stands for the Python
        function.
    """
    plain = getattr(function, "py_func", function)
    if OFF:
        records = (isinstance(kind, types.Record) and np.dtype((np.record, kind.dtype)) for kind in signature.args)
        made = _with_records(plain, tuple(records))
        _interpreted[id(made)] = made
        return id(made)
    table = (ctypes.c_int64 * len(_KINDS))(_compiled(plain, signature))
    place = ctypes.addressof(table)
    _laws[place] = table, plain, signature
    return place


def _compiled(plain: Callable[..., Any], signature: Any) -> int:
    """Compile a function to a C function, or load it, and return its address."""
    return cast(int, alive[external(plain, signature.args, signature.return_type)].address)


@ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)
def _find_dual(place: int, which: int) -> int:
    """Fill an entry of a law's table with the address of the function for duals; -1 if it does not compile for them."""
    table, plain, signature = _laws[place]
    try:
        table[which] = _compiled(plain, with_duals(signature.return_type)(*map(_KINDS[which], signature.args)))
    except numba.NumbaError:
        table[which] = -1
    except BaseException as error:
        failures.append(error)
        return -1
    return int(table[which])


binding.add_symbol(_FIND_DUAL, cast(int, ctypes.cast(_find_dual, ctypes.c_void_p).value))


def _call_dual(context: Any, builder: Any, table: Any, which: int, result: Any, values: Sequence[Any]) -> Any:
    """Write a call of one of a law's functions for duals, which `_find_dual` finds at the first call."""
    known = spot_of(builder, builder.load(builder.gep(table, [_WORD(which)])))
    module, kind = builder.module, ir.FunctionType(_WORD, [_WORD, _WORD])
    find = module.globals.get(_FIND_DUAL) or ir.Function(module, kind, _FIND_DUAL)
    with builder.if_then(builder.icmp_signed("==", builder.load(known), _WORD(0)), likely=False):
        builder.store(builder.call(find, [builder.ptrtoint(table, _WORD), _WORD(which)]), known)
    found = spot_of(builder, _no_number(context.get_value_type(result)))
    with builder.if_then(builder.icmp_signed(">", builder.load(known), _WORD(0)), likely=True):
        builder.store(call_address(context, builder, builder.load(known), result, values), found)
    return builder.load(found)


def _no_number(kind: Any) -> Any:
    """Make the constant of this type whose numbers are not numbers."""
    if isinstance(kind, ir.DoubleType):
        return kind(math.nan)
    parts = kind.elements if isinstance(kind, ir.LiteralStructType) else [kind.element] * kind.count
    return ir.Constant(kind, [_no_number(part) for part in parts])


def _with_records(function: Callable[..., Any], seen: Sequence[Any]) -> Callable[..., Any]:
    """Give a function its records with the names of their types, as compiled code does."""

    def call(*arguments: Any) -> Any:
        pairs = zip(arguments, seen, strict=True)
        named = (value.view(kind) if kind and isinstance(value, np.void) else value for value, kind in pairs)
        return function(*named)

    return call


def caller(result: Any) -> Callable[[int, tuple[Any, ...]], Any]:
    """Make ``call(address, arguments)``, for use within kernels, for C functions with this type of result.

    The functions take floats, to which other real numbers are converted, records and arrays. With a dual among the
    arguments all floats are duals, and so is the result; not a number if the function does not compile for them. With a
    record of duals, records and arrays are of duals all.
    """
    if OFF:
        return lambda address, arguments: _interpreted[address](*arguments)

    @intrinsic
    def call(typing: Any, address: Any, arguments: Any) -> Any:
        numbers = types.Integer, types.Boolean, types.Float
        kinds = tuple(types.float64 if isinstance(kind, numbers) else kind for kind in arguments)
        in_records = any(isinstance(kind, types.Record) and has_duals(kind) for kind in kinds)
        which = 2 if in_records else int(any(map(has_duals, kinds)))
        kinds, given_back = (tuple(map(with_duals, kinds)), with_duals(result)) if which else (kinds, result)
        for kind in kinds:
            if kind not in (types.float64, DUAL) and not isinstance(kind, types.Record | types.Array):
                raise numba.TypingError(f"takes real numbers and records, not {kind}")

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            given = (builder.extract_value(values[1], k) for k in range(len(kinds)))
            passed = [context.cast(builder, *each) for each in zip(given, arguments, kinds, strict=True)]
            table = builder.inttoptr(values[0], _WORD.as_pointer())
            if which:
                return _call_dual(context, builder, table, which, given_back, passed)
            return call_address(context, builder, builder.load(table), given_back, passed)

        return given_back(types.int64, arguments), code

    return cast(Any, call)
