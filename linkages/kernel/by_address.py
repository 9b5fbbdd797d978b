"""Functions by address: compiled once to C functions, and called without becoming a part of what calls them.

Compiled code contains all that it calls: at every level of calls, what is below is optimised and written once more.
A call by address costs a few nanoseconds, and what is called is compiled apart, when it is first needed. With
NUMBA_DISABLE_JIT=1 the addresses are tokens for the Python functions, which are called themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import config
from numba.core import cgutils, types
from numba.core.ccallback import CFunc
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic

from linkages.kernel.cache import CodeCache
from linkages.kernel.units import UnitCompiler

_COMPILING = not getattr(config, "DISABLE_JIT", False)
_alive: dict[int, Any] = {}  # an address is good as long as its function lives


@cache
def address(function: Callable[..., Any], signature: Any) -> int:
    """Compile to a C function, or load it.

    Parameters
    ----------
    function : callable
        A function, plain or made by `linkages.kernel.kernel`.
    signature : numba signature

    Returns
    -------
    int
        Its address in this process. Its code is cached on disk, as that of kernels is.
    """
    plain = getattr(function, "py_func", function)
    if not _COMPILING:
        interpreted = _interpreted(plain, signature.args)
        _alive[id(interpreted)] = interpreted
        return id(interpreted)
    kinds, options = (signature.args, signature.return_type), {"error_model": "numpy"}
    compiled: Any = CFunc(plain, kinds, {}, options, pipeline_class=UnitCompiler)
    compiled._cache = CodeCache(plain, UnitCompiler)
    with global_compiler_lock:
        compiled.compile()
    place = cast(int, compiled.address)
    _alive[place] = compiled
    return place


def _interpreted(function: Callable[..., Any], kinds: Sequence[Any]) -> Callable[..., Any]:
    """Give a function its records with the names of their types, as compiled code does."""
    seen = [np.dtype((np.record, kind.dtype)) if isinstance(kind, types.Record) else None for kind in kinds]

    def call(*arguments: Any) -> Any:
        pairs = zip(arguments, seen, strict=True)
        named = (value if kind is None or not isinstance(value, np.void) else value.view(kind) for value, kind in pairs)
        return function(*named)

    return call


def caller(result: Any) -> Callable[[int, tuple[Any, ...]], Any]:
    """Make ``call(address, arguments)``, for use within compiled code, for C functions with this type of result."""
    if not _COMPILING:
        return lambda address, arguments: _alive[address](*arguments)

    @intrinsic
    def call(typing: Any, address: Any, arguments: Any) -> Any:
        kinds = tuple(types.unliteral(kind) for kind in arguments)

        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            given = zip(cgutils.unpack_tuple(builder, values[1]), arguments, kinds, strict=True)
            passed = [context.cast(builder, value, kind, plain) for value, kind, plain in given]
            return call_at(context, builder, values[0], result, passed)

        return result(types.int64, arguments), code

    return cast(Any, call)


def call_at(context: Any, builder: Any, place: Any, result: Any, values: Sequence[Any]) -> Any:
    """Write a call of the C function at an address, whose result has this type."""
    function = ir.FunctionType(context.get_value_type(result), [value.type for value in values])
    return builder.call(builder.inttoptr(place, function.as_pointer()), values)
