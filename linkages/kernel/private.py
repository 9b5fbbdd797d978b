"""Private names of numba, outside its documented interface; no other module of the package uses one.

| name                    | reason                                            | fallback                              |
|-------------------------|---------------------------------------------------|---------------------------------------|
| CFunc                   | C functions whose code can be stored              | plain kernels                         |
| _cache                  | where a function reads and writes its code        | plain kernels                         |
| CompileResult           | compiled code of one function                     | plain kernels                         |
| _reduce                 | compiled code as bytes                            | plain kernels                         |
| _rebuild                | compiled code from bytes                          | plain kernels                         |
| consts                  | which environments of numba's functions are empty | none                                  |
| get_llvm_str            | symbols that compiled code calls                  | plain kernels                         |
| dumps                   | pickles of numba's types and environments         | plain kernels                         |
| rtsys                   | numba's runtime, called by restored code          | plain kernels                         |
| refresh                 | numba's C functions, called by restored code      | plain kernels                         |
| AttributeTemplate       | attributes of references to named tuples          | none                                  |
| _numba_type_            | types of packed named tuples, found quickly       | none                                  |
| _nrt                    | no reference counts in kernels that own no array  | LINKAGES_KERNELS=plain                |
| no_cpython_wrapper      | no wrapper for Python where only kernels call     | LINKAGES_KERNELS=plain                |
| no_cfunc_wrapper        | no C function of an inlined kernel                | LINKAGES_KERNELS=plain                |

Plain kernels are compiled by `numba.njit` and kept in numba's own cache: the first compilation takes longer, the digits
are the same. `linkages doctor` reports them. The environment variable LINKAGES_KERNELS=plain asks for them.
"""

from __future__ import annotations

import os
import pickle
import re
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numba
from llvmlite import binding
from numba import config, types
from numba.core.typing.templates import AttributeTemplate

__all__ = ["COUNTED", "INLINED", "NAMES", "OFF", "UNCOUNTED", "AttributeTemplate", "Stored", "c_function", "problem"]
__all__ += ["python_function", "restored"]

NAMES = re.findall(r"^\| (\w+) +\|", __doc__, re.M)[1:]
OFF = bool(getattr(config, "DISABLE_JIT", False))  #: nothing is compiled
#: why kernels are plain; empty if they are not
problem = "LINKAGES_KERNELS is plain" if os.environ.get("LINKAGES_KERNELS") == "plain" else ""
try:
    from numba.core.ccallback import CFunc
    from numba.core.compiler import CompileResult
    from numba.core.runtime.nrt import rtsys
    from numba.core.serialize import dumps

    for _name in ("_reduce", "_rebuild"):
        getattr(CompileResult, _name)
except (ImportError, AttributeError) as missing:
    problem = str(missing)

UNCOUNTED, COUNTED = {"_nrt": False}, {"_nrt": True}  #: options: whether references to arrays are counted
INLINED = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  #: options of functions that only kernels call


class Stored:
    """Compiled code of one function, in the place of numba's cache.

    Parameters
    ----------
    content : bytes, optional
        The code; without it, the function is compiled, and the code is then here.
    symbols : iterable of str
        Symbols that the code calls.
    counts : bool, optional
        Whether the code counts references to arrays.
    """

    cache_path = None

    def __init__(self, content: bytes = b"", symbols: Any = (), counts: bool = False) -> None:
        self.content, self.symbols, self.counts = content, set(symbols), counts

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the code, None if the function is to be compiled."""
        if not self.content:
            return None
        rtsys.initialize(context)
        if any(binding.address_of_symbol(symbol) is None for symbol in self.symbols):
            context.refresh()  # imports half of numba, which few kernels need
        return CompileResult._rebuild(context, *pickle.loads(self.content))

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the code, unless it refers to a function that no other process can find."""
        with suppress(TypeError, AttributeError, pickle.PicklingError):
            *parts, environments = result._replace(type_annotation="")._reduce()
            read = tuple(one for one in environments if one.consts)  # the others would import numba's modules alone
            self.content = dumps((*parts, read))
        text = result.library.get_llvm_str()  # only now it is all there
        declared = re.findall(r'^declare [^@]*@"?([^"( ]+)', text, re.M)
        self.symbols = {symbol for symbol in declared if not symbol.startswith("llvm.")}
        self.counts = re.search(r"call .*@NRT_", text) is not None

    def flush(self) -> None:
        """Do nothing: the code fits its fingerprint."""


def c_function(function: Callable[..., Any], stored: Stored, kinds: Any, result: Any, **options: Any) -> Any:
    """Compile or restore a C function; its attribute `address` is its address."""
    made: Any = CFunc(function, (kinds, result), {}, options)
    made._cache = stored
    made.compile()
    return made


def python_function(function: Callable[..., Any], stored: Stored, kinds: Any, **options: Any) -> Any:
    """Compile or restore a function that Python calls with arguments of these types."""
    made: Any = numba.njit(nogil=True, **options)(function)
    made._cache = stored
    made.compile(kinds)
    return made


def restored(stored: Stored) -> Any:
    """Restore a C function without the Python function."""
    return c_function(lambda: None, stored, (), types.none)
