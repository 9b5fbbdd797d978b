"""Compiled code on disk, by content: shared by processes, environments and checkouts, and done without if need be.

The file of a function's code is named after what the function is (`linkages.kernel.fingerprint`) and the types it was
compiled for, and tells which other units it calls; so nothing in it can be stale, whoever wrote it.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from llvmlite import binding
from numba.core.compiler import compile_result
from numba.core.registry import cpu_target
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps

from linkages.disk import keep, kept
from linkages.kernel import locks, precompiled
from linkages.kernel.fingerprint import fingerprint
from linkages.kernel.folder import folder, say
from linkages.kernel.units import PartLibrary, UnitLibrary

_UNUSED = 60 * 86400.0  # s after which code that no process has loaded is removed
_FRESH = 86400.0  # s after which a loaded file is marked as used again
_loaded: dict[str, Code | None] = {}
_files: dict[str, str] = {}  # by the symbol of a unit, the name of its file


class Code(NamedTuple):
    """What a file holds, and the library that this process has made of it."""

    library: Any
    result: bytes  # pickled, what numba wants to know of the function


class CodeCache:
    """Compiled code of one function: what numba asks of its own cache."""

    def __init__(self, function: Any, compiler: type) -> None:
        self._function, self._compiler = function, compiler

    @property
    def cache_path(self) -> str | None:
        """The folder, None if there is none."""
        place = folder()
        return None if place is None else str(place)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Load the code for a signature; None, and a claim on it, if it is not there or something that it calls is not.

        What another process is compiling is waited for.
        """
        rtsys.initialize(context)  # the runtime that the code calls
        name, place = self._name(signature), folder()
        code = None if name is None else _load(name)
        if code is None and name is not None and place is not None:
            locks.wait_and_acquire(place, name)
            code = _load(name)
            if code is not None:
                locks.release(place, name)
        if code is None:
            return None
        try:
            description, environment, typed = pickle.loads(code.result)
        except Exception:  # of types that have other names now, or of another version of a package
            return None
        return compile_result(
            typing_context=context.typing_context,
            target_context=context,
            entry_point=context.get_executable(code.library, description, environment),
            library=code.library,
            environment=environment,
            fndesc=description,
            signature=typed,
            objectmode=False,
            type_annotation="",
            lifted=(),
            reload_init=(),
        )

    def save_overload(self, signature: Any, result: Any) -> None:
        """Save code, and give up the claim on it; on a disk that is full it is lost."""
        name, place, library = self._name(signature), folder(), result.library
        if name is None:
            return
        library._ensure_finalized()
        functions = list(library._final_module.functions)
        called = [f.name for f in functions if f.is_declaration and not f.name.startswith("llvm.")]
        needs = tuple((_files.get(symbol), symbol) for symbol in called)
        if isinstance(library, UnitLibrary):
            code, symbols = library._get_compiled_object(), _defined(library)
            _files.update(dict.fromkeys(symbols, name))
        else:
            code, symbols = library._final_module.as_bitcode(), ()
        result.fndesc.typemap = result.fndesc.calltypes = None
        described = dumps((result.fndesc, result.environment, result.signature))
        _loaded[name] = Code(library, described)
        if place is None:
            return
        content = pickle.dumps((library.name, needs, symbols, code, described))
        try:
            keep(_path(place, name), name.encode(), content)
        except OSError as problem:
            say(f"not kept ({place}: {problem.strerror})")
        locks.release(place, name)
        _prune(place)

    def flush(self) -> None:
        """Do nothing: what is kept fits what it is named after."""

    def _name(self, signature: Any) -> str | None:
        """Name of a file; None for what is not kept."""
        try:
            content = fingerprint(self._function)
        except TypeError:
            return None
        return hashlib.sha256(f"{content} {self._compiler.__name__} {signature}".encode()).hexdigest()[:32]


def _path(place: Path, name: str) -> Path:
    return place / name[:2] / f"{name[2:]}.nbc"


def _defined(library: Any) -> tuple[str, ...]:
    """Symbols that a library defines."""
    module = library._final_module
    return tuple(x.name for xs in (module.functions, module.global_variables) for x in xs if not x.is_declaration)


def _load(name: str) -> Code | None:
    """Load a file, once, and before it those of the units that its code calls."""
    if _loaded.get(name) is None:
        _loaded[name] = _read(name)
        if _loaded[name] is not None:
            precompiled.loaded()
    return _loaded[name]


def _read(name: str) -> Code | None:
    place = folder()
    content = None if place is None else kept(_path(place, name), name.encode())
    if place is None or content is None:
        return None
    try:
        library_name, needs, symbols, code, result = pickle.loads(content)
    except Exception:  # compiled again
        return None
    for need, symbol in needs:
        if need is None and binding.address_of_symbol(symbol) is None:
            cpu_target.target_context.refresh()  # half of numba, for what few functions call
        elif need is not None and not (_load(need) and _files.get(symbol) == need):
            return None
    with suppress(OSError):
        if time.time() - _path(place, name).stat().st_mtime > _FRESH:
            os.utime(_path(place, name))
    codegen = cpu_target.target_context.codegen()
    if symbols:
        library: Any = UnitLibrary(codegen, library_name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(symbols)
        _files.update(dict.fromkeys(symbols, name))
    else:
        library = PartLibrary(codegen, library_name)
        library._final_module = binding.parse_bitcode(code)
        library._finalize_final_module()
    return Code(library, result)


@cache
def _prune(place: Path) -> None:
    """Remove, once in a process, what has not been used for long."""
    for path in (*place.glob("??/*.nbc"), *place.glob("locks/*")):
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > _UNUSED:
                path.unlink()
