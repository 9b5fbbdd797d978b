"""Code of functions: loaded from disk, or compiled and kept there. LLVM links external functions by their symbols."""

from __future__ import annotations

import gc
import inspect
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FunctionType
from typing import Any

import numba
from llvmlite import binding

from linkages.base.kernel import locks, precompiled, shipped
from linkages.base.kernel.cache import read, write
from linkages.base.kernel.fingerprint import names_of
from linkages.base.kernel.folder import folder
from linkages.base.kernel.private import COUNTED, UNCOUNTED, Stored, restored
from linkages.base.signals import deferred

PREFIX = "linkages_"  #: of symbols
alive: dict[str, Any] = {}  #: external functions by symbol, None while one is compiled
undeclared: list[str] = []  #: kernels that were compiled twice: they count references, which ``makes_arrays`` declares
_interrupts: list[list[Any]] = []  # signals that arrived during each of the compilations under way
_PARTS = "code", "globals", "name", "defaults", "closure"


def name_of(function: Any, *types_of_call: Any) -> str | None:
    """Name the code of a function for these types, in the package if it is there; None if its content is not known."""
    try:
        own, level = names_of(function, *types_of_call)
    except TypeError:
        return None
    return level if level in shipped.names() else own


def obtain(name: str | None, function: Any, make: Callable[..., Any], returns_arrays: bool = False) -> Any:
    """Load or compile a function, within `linkages.base.kernel.private.one_thread`.

    Parameters
    ----------
    name : str or None
        Name of the code; None: it is not stored.
    function : function
    make : callable
        ``make(function, stored, **options)`` restores `stored`, or compiles the function, and returns the result.
    returns_arrays : bool
        The result may hold arrays.

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
            found = _compile(name, function, make, returns_arrays or counts_references(function))
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
    if not symbol.startswith(PREFIX) or alive.get(symbol):
        return True
    made = _load(symbol.removeprefix(PREFIX), None, lambda function, stored: restored(stored))
    return made is not None and link(symbol, made)


def link(symbol: str, made: Any) -> bool:
    """Have LLVM link callers to an external function; returns True."""
    binding.add_symbol(symbol, made.address)
    alive[symbol] = made  # from now on callers are linked to it, and LLVM takes an unknown symbol for address 0
    return True


def _compile(name: str | None, function: Any, make: Callable[..., Any], counts: bool) -> Any:
    """Compile a function that counts references to arrays, or does not; one that must, and is not declared, twice."""
    if any(_interrupts):
        raise KeyboardInterrupt
    precompiled.compiling()
    with deferred() as interrupts, _rare_collections():
        _interrupts.append(interrupts)
        try:
            made, stored = (None, None) if counts else _uncounted(name, function, make)
            if stored is None:
                stored = Stored()
                made = make(_renamed(function, name), stored, **COUNTED)
                undeclared.extend([] if counts else [f"{function.__module__}.{function.__qualname__}"])
        finally:
            _interrupts.pop()
    if name and stored.content:
        write(name, stored)
    return made


def _uncounted(name: str | None, function: Any, make: Callable[..., Any]) -> tuple[Any, Stored | None]:
    """Compile a function that does not count references; without a result if it must."""
    stored = Stored()
    with suppress(numba.NumbaError):
        made = make(_renamed(function, name), stored, **UNCOUNTED)
        if not stored.counts:
            return made, stored
    return None, None


def _renamed(function: Any, name: str | None) -> FunctionType:
    """Copy a function under another name: numba's symbols are made of it."""
    renamed = FunctionType(*(getattr(function, f"__{part}__") for part in _PARTS))
    renamed.__module__, renamed.__kwdefaults__ = function.__module__, function.__kwdefaults__
    renamed.__qualname__ = f"{function.__qualname__}.{name or uuid.uuid4().hex}"
    return renamed


@contextmanager
def _rare_collections() -> Iterator[None]:
    """Have Python look for cycles rarely, which takes a tenth of a compilation; few of its many objects are in any."""
    often, *others = gc.get_threshold()
    gc.set_threshold(often and max(often, 20_000), *others)
    try:
        yield
    finally:
        gc.set_threshold(often, *others)


def counts_references(function: Any, callers: frozenset[Any] = frozenset()) -> bool:
    """Whether a function, or a kernel that is compiled into it, makes arrays: as declared; a function of a user may."""
    names, callers = inspect.getclosurevars(function), callers | {function}
    called = (*names.nonlocals.values(), *names.globals.values())  # or only of the name of an attribute
    parts = {each.py_func for each in called if getattr(each, "result", each) is None} - callers
    return getattr(function, "makes_arrays", True) or any(counts_references(part, callers) for part in parts)
