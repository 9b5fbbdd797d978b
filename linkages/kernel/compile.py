"""The compiler of all numerical kernels.

``@kernel`` compiles a function, on its first call, to a unit (`linkages.kernel.units`) that is cached on disk, releases
the GIL and divides as IEEE says. What is not edited is not compiled again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, update_wrapper
from inspect import signature
from typing import Any, TypeVar, cast

from numba import config, types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature

from linkages.kernel import precompiled
from linkages.kernel.cache import CodeCache
from linkages.kernel.units import PartCompiler, UnitCompiler

failures: list[BaseException] = []  #: met where compiled code asked for a lazy kernel, to be raised in Python

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile a function on its own; other kernels call it."""
    return _compiled(function, UnitCompiler)


def inlined_kernel(function: F) -> F:
    """Compile into each caller's body: for small functions, whose arguments cost more to hand over than their work."""
    return _compiled(function, PartCompiler, forceinline=True)


def _compiled(function: F, compiler: type, **options: Any) -> F:
    if getattr(config, "DISABLE_JIT", False):
        return function
    dispatcher = _dispatcher(function, compiler, no_cpython_wrapper=True, **options)
    return cast(F, Kernel(function, dispatcher, compiler.__name__.encode()))


def _dispatcher(function: Any, compiler: type, **options: Any) -> Any:
    """Make numba's object of a function; C functions are made by `linkages.kernel.address`."""
    options |= {"nopython": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    dispatcher: Any = _Dispatcher(function, {}, options, pipeline_class=compiler)
    dispatcher._cache = CodeCache(function, compiler)
    return dispatcher


class _Dispatcher(CPUDispatcher):
    """Numba's object of a function, without the clocks that it starts for each compilation."""

    def compile(self: Any, sig: Any) -> Any:
        """Compile for a signature, or load the code; constants are arguments as others are."""
        kinds, result = normalize_signature(sig)
        kinds = tuple(map(types.unliteral, kinds))
        sig = kinds if result is None else result(*kinds)
        with global_compiler_lock, self._compiling_counter:
            if kinds not in self.overloads:
                compiled = self._cache.load_overload(sig, self.targetctx)
                if compiled is None:
                    self._cache_misses[sig] += 1
                    compiled = self._compiler.compile(kinds, result)
                    self.add_overload(compiled)
                    self._cache.save_overload(sig, compiled)
                else:
                    self._cache_hits[sig] += 1
                    self.targetctx.insert_user_function(compiled.entry_point, compiled.fndesc, [compiled.library])
                    self.add_overload(compiled)
            return self.overloads[kinds].entry_point


class Kernel:
    """A compiled function, which knows how to be called from Python only once that is asked for."""

    def __init__(self, function: Any, compiled: Any, kind: bytes) -> None:
        update_wrapper(self, function)
        precompiled.known()
        self.py_func, self.kind, self._compiled = function, kind, compiled

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Call it from Python."""
        result = self._entry(*arguments, **named)
        if failures:
            problem = failures[0]
            failures.clear()
            raise problem
        return result

    def __reduce__(self) -> str:
        return self.py_func.__qualname__

    @property
    def _numba_type_(self) -> Any:
        return self._compiled._numba_type_

    @property
    def stats(self) -> Any:
        """What numba tells of its cache for calls from Python."""
        return self._entry.stats

    @cached_property
    def _entry(self) -> Any:
        """Function that Python calls."""
        names, name = ", ".join(signature(self.py_func).parameters), self.py_func.__name__
        scope: dict[str, Any] = {"compiled": self, "__name__": self.py_func.__module__}
        exec(f"def {name}({names}):\n    return compiled({names})", scope)
        scope[name].__defaults__ = self.py_func.__defaults__
        return _dispatcher(scope[name], UnitCompiler)
