"""Private names of numba, outside its documented interface; no other module of the package uses one.

| name                    | reason                                            | fallback                              |
|-------------------------|---------------------------------------------------|---------------------------------------|
| _cache                  | where a function reads and writes its code        | plain kernels                         |
| CompileResult           | compiled code of one function                     | plain kernels                         |
| _reduce                 | compiled code as bytes                            | plain kernels                         |
| _rebuild                | compiled code from bytes                          | plain kernels                         |
| consts                  | which environments of numba's functions are empty | none                                  |
| fndesc                  | the symbol of a compiled function                 | plain kernels                         |
| get_pointer_to_function | the address of a compiled function                | LINKAGES_KERNELS=plain                |
| call_conv               | calls at an address, with errors handed on        | LINKAGES_KERNELS=plain                |
| dumps                   | pickles of numba's types and environments         | plain kernels                         |
| rtsys                   | numba's runtime, called by restored code          | plain kernels                         |
| refresh                 | numba's C functions, called by restored code      | plain kernels                         |
| AttributeTemplate       | attributes of references to named tuples          | none                                  |
| _nrt                    | no reference counts in kernels that own no array  | LINKAGES_KERNELS=plain                |
| no_cpython_wrapper      | no wrapper for Python where only kernels call     | LINKAGES_KERNELS=plain                |
| no_cfunc_wrapper        | no C function, which nothing calls                | LINKAGES_KERNELS=plain                |

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
from numba import config
from numba.core.typing.templates import AttributeTemplate

__all__ = [
    "COUNTED",
    "FOR_KERNELS",
    "NAMES",
    "OFF",
    "UNCOUNTED",
    "AttributeTemplate",
    "Stored",
    "problem",
    "write_call",
]
__all__ += ["function_for_kernels", "function_for_python", "type_of_function"]

NAMES = re.findall(r"^\| (\w+) +\|", __doc__, re.M)[1:]
OFF = bool(getattr(config, "DISABLE_JIT", False))  #: nothing is compiled
#: why kernels are plain; empty if they are not
problem = "LINKAGES_KERNELS is plain" if os.environ.get("LINKAGES_KERNELS") == "plain" else ""
try:
    from numba.core.compiler import CompileResult
    from numba.core.runtime.nrt import rtsys
    from numba.core.serialize import dumps

    for _name in ("_reduce", "_rebuild", "fndesc"):
        getattr(CompileResult, _name)
except (ImportError, AttributeError) as missing:
    problem = str(missing)

UNCOUNTED, COUNTED = {"_nrt": False}, {"_nrt": True}  #: options: whether references to arrays are counted
FOR_PYTHON = {"nogil": True, "no_cfunc_wrapper": True}  #: options of functions that Python calls
FOR_KERNELS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  #: options of functions that only kernels call


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

    Attributes
    ----------
    result : CompileResult
        The function, once it is compiled or restored.
    """

    cache_path = None

    def __init__(self, content: bytes = b"", symbols: Any = (), counts: bool = False) -> None:
        self.content, self.symbols, self.counts = content, set(symbols), counts
        self.result: Any = None

    @property
    def address(self) -> int:
        """Address of the function, for `write_call`."""
        return int(self.result.library.get_pointer_to_function(self.result.fndesc.llvm_func_name))

    def compile(self, function: Callable[..., Any], signature: Any, **options: Any) -> Any:
        """Compile or restore a function, and return numba's object of it."""
        restored = bool(self.content)
        made: Any = numba.njit(**options)(function)
        made._cache = self
        made.compile(signature)
        if not restored:
            self._read(*made.inspect_llvm().values())
        return made

    def _read(self, text: str) -> None:
        """Find the symbols that code calls, in its text."""
        declared = re.findall(r'^declare [^@]*@"?([^"( ]+)', text, re.M)
        self.symbols = {symbol for symbol in declared if not symbol.startswith("llvm.")}
        self.counts = re.search(r"call .*@NRT_", text) is not None

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the code, None if the function is to be compiled."""
        if not self.content:
            return None
        rtsys.initialize(context)
        if any(binding.address_of_symbol(symbol) is None for symbol in self.symbols):
            context.refresh()  # imports half of numba, which few kernels need
        self.result = CompileResult._rebuild(context, *pickle.loads(self.content))
        return self.result

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the code, unless it refers to a function that no other process can find."""
        with suppress(TypeError, AttributeError, pickle.PicklingError):
            *parts, environments = result._replace(type_annotation="")._reduce()
            read = tuple(one for one in environments if one.consts)  # the others would import numba's modules alone
            self.content = dumps((*parts, read))
        self.result = result

    def flush(self) -> None:
        """Do nothing: the code fits its fingerprint."""


def function_for_kernels(function: Callable[..., Any], stored: Stored, signature: Any, **options: Any) -> Stored:
    """Compile or restore a function that kernels call at its address."""
    stored.compile(function, signature, **FOR_KERNELS, **options)
    return stored


def function_for_python(function: Callable[..., Any], stored: Stored, kinds: Any, **options: Any) -> Any:
    """Compile or restore a function that Python calls with arguments of these types."""
    return stored.compile(function, kinds, **FOR_PYTHON, **options)


def write_call(context: Any, builder: Any, function: Any, signature: Any, values: Any) -> Any:
    """Write a call of a compiled function; an error that it raises is handed on."""
    status, result = context.call_conv.call_function(builder, function, signature.return_type, signature.args, values)
    with builder.if_then(status.is_error, likely=False):
        context.call_conv.return_status_propagate(builder, status)
    return result


def type_of_function(context: Any, signature: Any) -> Any:
    """Return the LLVM type of a compiled function."""
    return context.call_conv.get_function_type(signature.return_type, signature.args)
