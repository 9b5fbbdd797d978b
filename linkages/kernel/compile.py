"""The compiler of all numerical kernels.

``@kernel`` is numba's ``njit`` with one set of options and a cache that notices edits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

from linkages.kernel.cache import cached

F = TypeVar("F", bound=Callable[..., Any])


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
    compiled = njit(nogil=True, error_model="numpy", forceinline=forceinline, **options)(function)
    if compiled is not function:  # as with NUMBA_DISABLE_JIT=1
        cached(compiled, function)
    return cast(F, compiled)
