"""External functions: C functions that are compiled or loaded once and called at their address.

A caller contains no code of an external function. It finds the address by one of three ways:

- by the function's symbol, a digest of its content and types: kernels;
- in a cell that is empty until the first call, which compiles or loads the function: lazy kernels, and recursion;
- in an argument: force laws (`address`, `caller`), compiled for floats, and at the first call for duals, alone and in
  records.
"""

from __future__ import annotations

import ctypes
import gc
import hashlib
import importlib
import inspect
import math
import pickle
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache, partial
from types import FunctionType
from typing import Any, cast

import numba
import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.extending import intrinsic

from linkages.base.kernel import locks, precompiled, shipped
from linkages.base.kernel.cache import read, write
from linkages.base.kernel.dual import DUAL, has_duals, spot_of, with_dual_records, with_duals
from linkages.base.kernel.fingerprint import names_of
from linkages.base.kernel.folder import folder
from linkages.base.kernel.private import COUNTED, OFF, UNCOUNTED, Stored, c_function, one_thread, problem, restored
from linkages.base.signals import deferred

kernels: dict[tuple[str, str], Any] = {}  #: by module and name
failures: list[BaseException] = []  #: of lazy kernels called by compiled code, to be raised in Python
_PREFIX = "linkages_"  # of symbols
_FIND = "linkages-find"  # symbol of `_find`
_FIND_DUAL = "linkages-find-dual"  # and of `_find_dual`
_WORD = ir.IntType(64)
_alive: dict[str, Any] = {}  # external functions by symbol, None while one is compiled
_interrupts: list[list[Any]] = []  # signals that arrived during each of the compilations under way
#: what numpy and arrays have that makes arrays; a function that names none of it is first compiled without counts
_ALLOCATING = {"zeros", "ones", "empty", "full", "eye", "array", "arange", "copy", "concatenate", "sort", "argsort"}
_interpreted: dict[int, Any] = {}  # without a compiler: functions by what stands for their address
_laws: dict[int, tuple[Any, Any, Any]] = {}  # by addresses of laws: the table itself, the function, its signature
_KINDS: tuple[Callable[[Any], Any], ...] = (lambda kind: kind), with_duals, with_dual_records  # of its arguments


def name_of(function: Any, *types_of_call: Any) -> str | None:
    """Name the code of a function for these types, in the package if it is there; None if its content is not known."""
    try:
        own, level = names_of(function, *types_of_call)
    except TypeError:
        return None
    return level if level in shipped.names() else own


def obtain(name: str | None, function: Any, make: Callable[..., Any]) -> Any:
    """Load or compile a function, within `linkages.base.kernel.private.one_thread`.

    Parameters
    ----------
    name : str or None
        Name of the code; None: it is not stored.
    function : function
    make : callable
        ``make(function, stored, **options)`` restores `stored`, or compiles the function, and returns the result.

    Raises
    ------
    LockedError
        If another process is compiling it, within `locks.impatient`.
    """
    found = name and _load(name, function, make)
    place = folder()
    if not found and name and place is not None:
        locks.wait_and_acquire(place, name)
        found = _load(name, function, make)
    try:
        if not found:
            found = _compile(name, function, make)
    finally:
        if name and place is not None:
            locks.release(place, name)
    return found


def _load(name: str, function: Any, make: Callable[..., Any]) -> Any:
    stored = read(name)
    if stored is None or not all(map(_linked, stored.symbols)):
        return None
    try:
        with deferred():  # LLVM calls Python, where an exception would be dropped
            made = make(function, stored)
    except Exception:  # of types that have other names now, or of another version of a package
        return None
    precompiled.loaded()
    return made


def _linked(symbol: str) -> bool:
    """Load the external function with this symbol, if it is one; False if its code is not on disk."""
    if not symbol.startswith(_PREFIX) or _alive.get(symbol):
        return True
    made = _load(symbol.removeprefix(_PREFIX), None, lambda function, stored: restored(stored))
    return made is not None and _link(symbol, made)


def _link(symbol: str, made: Any) -> bool:
    binding.add_symbol(symbol, made.address)
    _alive[symbol] = made  # from now on callers are linked to it, and LLVM takes an unknown symbol for address 0
    return True


def _compile(name: str | None, function: Any, make: Callable[..., Any]) -> Any:
    """Compile a function: without reference counts to arrays if that is possible."""
    if any(_interrupts):
        raise KeyboardInterrupt
    precompiled.compiling()
    renamed = FunctionType(*(getattr(function, f"__{part}__") for part in _PARTS))
    renamed.__module__, renamed.__kwdefaults__ = function.__module__, function.__kwdefaults__
    renamed.__qualname__ = f"{function.__qualname__}.{name or uuid.uuid4().hex}"  # numba's symbols are made of it
    with deferred() as interrupts, _rare_collections():
        _interrupts.append(interrupts)
        try:
            stored = Stored(counts=_makes_arrays(function))
            if not stored.counts:
                with suppress(numba.NumbaError):
                    made = make(renamed, stored := Stored(counts=True), **UNCOUNTED)
            if stored.counts:
                made = make(renamed, stored := Stored(), **COUNTED)
        finally:
            _interrupts.pop()
    if name and stored.content:
        write(name, stored)
    return made


_PARTS = "code", "globals", "name", "defaults", "closure"


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Have Python look for cycles rarely, which takes a tenth of a compilation; few of its many objects are in any."""
    often, *others = gc.get_threshold()
    gc.set_threshold(often and max(often, 20_000), *others)
    try:
        yield
    finally:
        gc.set_threshold(often, *others)


def _makes_arrays(function: Any, callers: frozenset[Any] = frozenset()) -> bool:
    """Whether a function, or a kernel that is compiled with it, seems to make arrays."""
    names, callers = inspect.getclosurevars(function), callers | {function}
    called = (*names.nonlocals.values(), *names.globals.values())  # or only of the name of an attribute
    parts = {each.py_func for each in called if getattr(each, "result", each) is None} - callers
    return not _ALLOCATING.isdisjoint(names.unbound) or any(_makes_arrays(part, callers) for part in parts)


def external(function: Any, kinds: tuple[Any, ...], result: Any) -> str:
    """Load or compile an external function for arguments of these types, and return its symbol."""
    name = name_of(function, kinds, result)
    symbol = _symbol(name, function, kinds, result)
    with one_thread:  # what is under way in another one is no recursion
        if not _alive.get(symbol):
            _alive[symbol] = None
            try:
                made = obtain(name, function, partial(c_function, kinds=kinds, result=result, error_model="numpy"))
            except BaseException:
                del _alive[symbol]
                raise
            _link(symbol, made)
    return symbol


def _symbol(name: str | None, function: Any, kinds: tuple[Any, ...], result: Any) -> str:
    return _PREFIX + (name or hashlib.sha256(f"{id(function)} {kinds} {result}".encode()).hexdigest()[:32])


def under_way(function: Any, kinds: tuple[Any, ...], result: Any) -> bool:
    """Whether a function is being compiled: it calls itself."""
    return _alive.get(_symbol(name_of(function, kinds, result), function, kinds, result), 0) is None


def call_symbol(function: Any, context: Any, builder: Any, signature: Any, values: Sequence[Any]) -> Any:
    """Write a call of an external function by its symbol."""
    symbol = external(function, signature.args, signature.return_type)
    kind = _kind(context, signature.return_type, values)
    known = builder.module.globals.get(symbol)
    return builder.call(known or ir.Function(builder.module, kind, symbol), values)


def call_address(context: Any, builder: Any, place: Any, result: Any, values: Sequence[Any]) -> Any:
    """Write a call of the external function at an address."""
    return builder.call(builder.inttoptr(place, _kind(context, result, values).as_pointer()), values)


def _kind(context: Any, result: Any, values: Sequence[Any]) -> Any:
    return ir.FunctionType(context.get_value_type(result), [value.type for value in values])


def call_cell(function: Any, context: Any, builder: Any, signature: Any, values: Sequence[Any]) -> Any:
    """Write a call of a lazy kernel: the first one asks Python, which compiles or loads it, for the address."""
    wanted = pickle.dumps((function.__module__, function.__qualname__, signature.args))
    module, result = builder.module, signature.return_type
    cell = ir.GlobalVariable(module, _WORD, module.get_unique_name("cell"))
    cell.linkage, cell.initializer = "internal", ir.Constant(_WORD, 0)
    text = ir.GlobalVariable(module, ir.ArrayType(ir.IntType(8), len(wanted)), module.get_unique_name("lazy"))
    text.linkage, text.global_constant = "internal", True
    text.initializer = ir.Constant(text.value_type, bytearray(wanted))
    kind = ir.FunctionType(_WORD, [cell.type, ir.IntType(8).as_pointer(), _WORD])
    find = module.globals.get(_FIND) or ir.Function(module, kind, _FIND)
    known = builder.load(cell)
    before = builder.block
    with builder.if_then(builder.icmp_unsigned("==", known, _WORD(0)), likely=False):
        asked = builder.call(find, [cell, builder.bitcast(text, kind.args[1]), _WORD(len(wanted))])
        asking = builder.block
    found = builder.phi(_WORD)
    found.add_incoming(known, before)
    found.add_incoming(asked, asking)
    before = builder.block
    with builder.if_then(builder.icmp_unsigned("!=", found, _WORD(0)), likely=True):
        given = call_address(context, builder, found, result, values)
        calling = builder.block
    value = builder.phi(given.type)
    value.add_incoming(ir.Constant(given.type, None), before)
    value.add_incoming(given, calling)
    return value


@ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
def _find(cell: int, text: int, size: int) -> int:
    """Fill a cell with the address of a lazy kernel; 0 if it cannot be compiled, which Python raises later."""
    try:
        module, name, kinds = pickle.loads(ctypes.string_at(text, size))
        importlib.import_module(module)
        wanted = kernels[module, name]
        symbol = external(wanted.py_func, kinds, wanted.result_for(kinds))
        place = ctypes.c_int64.from_address(cell).value = _alive[symbol].address
        return place
    except BaseException as error:
        failures.append(error)
        return 0


binding.add_symbol(_FIND, cast(int, ctypes.cast(_find, ctypes.c_void_p).value))


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
    if problem:
        _alive[f"{id(plain)} {signature}"] = made = numba.cfunc(signature, error_model="numpy")(plain)
        return cast(int, made.address)
    return cast(int, _alive[external(plain, signature.args, signature.return_type)].address)


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
