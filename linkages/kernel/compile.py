"""The compiler of all numerical kernels.

``@kernel`` is numba's ``njit`` with one set of options and a cache that notices edits.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])

#: The folders that hold kernels.
_HOLDERS = ("kernel", "laws", "integrate", "planar", "outputs", "results", "engines/compiled")


def kernel(function: F) -> F:
    """Compile a function, on its first call, to code that is cached on disk, releases the GIL and divides as IEEE says.

    Numba recompiles a function when its own file changes; but compiled callers contain their callees, so that an
    edited law would not reach the kernels that were compiled with the old one. Here every kernel is compiled anew
    when any file with kernels has changed.
    """
    return _compiled(function)


def inlined_kernel(function: F) -> F:
    """Compile as `kernel` does, into each caller's body: for functions whose many arrays cost time to hand over."""
    return _compiled(function, forceinline=True)


def template(function: F) -> F:
    """Compile for each set of compiled functions among its arguments, as a part of the caller, which is cached."""
    options: Any = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # Python does not call it
    return cast(F, njit(nogil=True, error_model="numpy", **options)(function))


def _compiled(function: F, forceinline: bool = False) -> F:
    options: Any = {"no_cfunc_wrapper": True}  # C functions are made by `linkages.kernel.address`
    compiled = njit(cache=True, nogil=True, error_model="numpy", forceinline=forceinline, **options)(function)
    note_edits(compiled)
    return cast(F, compiled)


def note_edits(compiled: Any) -> None:
    """Let the cache of a compiled function notice edits of any file with kernels."""
    file = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    if file is None:  # there is none with NUMBA_DISABLE_JIT=1
        return
    file._source_stamp = (file._source_stamp, _stamp())
    load_index = file._load_index

    def load_index_or_none() -> Any:
        try:
            return load_index()
        except (AttributeError, ImportError):  # of code whose types have other names now
            return {}

    file._load_index = load_index_or_none


@cache
def _stamp() -> str:
    """Hash of the text of all kernels."""
    here = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for holder in _HOLDERS:
        for path in sorted((here / holder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()
