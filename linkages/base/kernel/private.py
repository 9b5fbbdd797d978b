"""Private names of numba and its layout of arrays, outside its documented interface; no other module uses them.

| name                    | reason                                            |
|-------------------------|---------------------------------------------------|
| CFunc                   | C functions whose code can be stored              |
| _cache                  | where a function reads and writes its code        |
| CompileResult           | compiled code of one function                     |
| _reduce                 | compiled code as bytes                            |
| _rebuild                | compiled code from bytes                          |
| consts                  | which environments of numba's functions are empty |
| dumps                   | pickles of numba's types and environments         |
| rtsys                   | numba's runtime: called by restored code; arrays  |
| refresh                 | numba's C functions, called by restored code      |
| cpu_target              | what numba's runtime and C functions belong to    |
| AttributeTemplate       | attributes of references to named tuples          |
| _numba_type_            | types of packed named tuples, found quickly       |
| _dmm                    | how records of duals are read                     |
| _nrt                    | no reference counts in kernels that own no array  |
| no_cpython_wrapper      | no wrapper for Python where only kernels call     |
| no_cfunc_wrapper        | no C function of an inlined kernel                |
| global_compiler_lock    | one thread at a time loads or compiles            |

Another version of numba may lack one of them: `TESTED` are the versions with which the tests pass, others are refused.

References, lanes and blocks of memory rely on numba's layout of arrays: at import, `array_words` is compared with
numba's own words of one array.
"""

from __future__ import annotations

import ctypes
import pickle
import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple, cast

import numba
import numpy as np
from llvmlite import binding, ir
from numba import config

__all__ = ["ARRAY_DATA", "COUNTED", "INLINED", "NAMES", "OFF", "TESTED", "UNCOUNTED", "AttributeTemplate", "Stored"]
__all__ += ["array_field", "array_words", "c_function", "one_thread", "python_function", "restored"]
__all__ += ["without_owner"]

NAMES = re.findall(r"^\| (\w+) +\|", __doc__, re.M)[1:]
TESTED = "0.62", "0.69"  #: the least version of numba, and the first untested one, as in pyproject.toml
OFF = bool(getattr(config, "DISABLE_JIT", False))  #: nothing is compiled
#: of numba's structure of an array, one word each, the last two a word for each axis
_FIELDS = "owner", "parent", "size", "itemsize", "data", "lengths", "strides"
ARRAY_DATA = 8 * _FIELDS.index("data")  #: bytes before the address of an array's contents


def array_words(array: Any, data: int, lengths: tuple[int, ...], strides: tuple[int, ...]) -> tuple[int, ...]:
    """Return the words of an array with contents at this address; it has no owner, so no reference is counted."""
    return 0, 0, array.size, array.itemsize, data, *lengths, *strides


def array_field(builder: Any, array: Any, name: str) -> Any:
    """Write the reading of a field of an array: its ``data``, ``lengths`` or ``strides``."""
    return builder.extract_value(array, _FIELDS.index(name))


def without_owner(builder: Any, array: Any) -> Any:
    """Write the removal of an array's owner."""
    owner = _FIELDS.index("owner")
    return builder.insert_value(array, ir.Constant(array.type.elements[owner], None), owner)


def _compare_words() -> None:
    """Compare `array_words` with numba's words of an array whose fields all differ; numba may not tell its own.

    ImportError if they differ.
    """
    rtsys.initialize(cpu_target.target_context)
    telling = binding.address_of_symbol("NRT_adapt_ndarray_from_python")
    array = np.zeros((3, 10), np.int16)[:, ::2]
    expected = array_words(array, array.ctypes.data, array.shape, array.strides)
    told = (ctypes.c_int64 * 64)()  # room for more
    if telling:
        ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.py_object, ctypes.c_void_p)(telling)(array, told)
        if told[_FIELDS.index("parent")] != id(array) or tuple(told[2 : len(expected)]) != expected[2:]:
            raise _unsupported()


def _unsupported() -> ImportError:
    """Make the error of a version of numba with which the tests do not pass."""
    wanted = "numba>={},<{}".format(*TESTED)
    return ImportError(f'numba {numba.__version__} is not supported; run `pip install "{wanted}"`', name="numba")


def _numbers(version: str) -> tuple[int, ...]:
    """Return the first two numbers of a version."""
    return tuple(int(part) for part in version.split(".")[:2])


try:
    from numba.core.ccallback import CFunc
    from numba.core.compiler import CompileResult
    from numba.core.compiler_lock import global_compiler_lock as one_thread  # held by the thread that loads or compiles
    from numba.core.registry import cpu_target
    from numba.core.runtime.nrt import rtsys
    from numba.core.serialize import dumps
    from numba.core.typing.templates import AttributeTemplate
except ImportError as missing:
    raise _unsupported() from missing
if not _numbers(TESTED[0]) <= _numbers(numba.__version__) < _numbers(TESTED[1]):
    raise _unsupported()
if not OFF:
    _compare_words()

UNCOUNTED, COUNTED = {"_nrt": False}, {"_nrt": True}  #: options: whether references to arrays are counted
INLINED = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  #: options of functions that only kernels call


class Stored:
    """Compiled code of one function, in the place of numba's cache.

    Without content the function is compiled, and the code is then here. `symbols` are those that the code calls;
    `counts` is whether it counts references to arrays.
    """

    cache_path = None

    def __init__(self, content: bytes = b"", symbols: Any = ()) -> None:
        self.content, self.symbols, self.counts = content, set(symbols), False
        self._result: Any = None  # of the compilation
        self.complete: Callable[[Any], object] = lambda result: None  #: is called with it, before it is final

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the code, None if the function is to be compiled."""
        if not self.content:
            return None
        self._load_called()
        return CompileResult._rebuild(context, *pickle.loads(self.content))

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the compiled code."""
        self._result = result
        self.complete(result)

    def flush(self) -> None:
        """Do nothing: the code fits its fingerprint."""

    def keep(self, text: str) -> None:
        """Keep the code, unless it refers to a function that no other process can find; `text` is LLVM's language."""
        with suppress(TypeError, AttributeError, pickle.PicklingError):
            *parts, environments = self._result._replace(type_annotation="")._reduce()
            read = tuple(one for one in environments if one.consts)  # the others would import numba's modules alone
            self.content = dumps((*parts, read))
        self._note(text)

    def keep_object_code(self, name: str, text: str) -> None:
        """Keep the object code of the C function with this name, unless it reads Python's objects."""
        (_, _, (code, _)), *_, environments = self._result._reduce()
        if not any(one.consts for one in environments):
            self.content = pickle.dumps((name, code))
        self._note(text)

    @property
    def library(self) -> Any:
        """The library with the compiled code."""
        return self._result.library

    def object_code(self) -> tuple[str, bytes]:
        """Return name and object code of the C function, all that it calls being loaded."""
        self._load_called()
        return cast(tuple[str, bytes], pickle.loads(self.content))

    def _note(self, text: str) -> None:
        """Record the functions that the code calls."""
        declared = re.findall(r'^declare [^@]*@"?([^"( ]+)', text, re.M)
        self.symbols = {symbol for symbol in declared if not symbol.startswith("llvm.")}
        self.counts = re.search(r"call .*@NRT_", text) is not None

    def _load_called(self) -> None:
        """Load numba's C functions if the code calls one that is not loaded; its runtime is."""
        if any(binding.address_of_symbol(symbol) is None for symbol in self.symbols):
            cpu_target.target_context.refresh()  # imports half of numba, which few kernels need


def c_function(
    function: Callable[..., Any], stored: Stored, kinds: Any, result: Any, entry: Callable[..., str], **options: Any
) -> CFunction:
    """Compile or load a C function.

    ``entry(module, name, type)`` writes the function that callers reach, which calls this one, and returns its name.
    """
    if stored.content:
        return restored(stored)
    names: list[str] = []
    made: Any = CFunc(function, (kinds, result), {}, options)
    made._cache, stored.complete = stored, lambda result: names.append(_with_entry(result, entry))
    made.compile()
    stored.keep_object_code(names[0], made.inspect_llvm())
    return CFunction(stored.library.get_pointer_to_function(names[0]), made)


def _with_entry(result: Any, entry: Callable[..., str]) -> str:
    """Add the entry to a compiled C function, and return its name."""
    context, made = cpu_target.target_context, result.fndesc
    given_back, *taken = map(context.get_value_type, (made.restype, *made.argtypes))
    module = context.create_module("entry")
    name = entry(module, made.llvm_cfunc_wrapper_name, ir.FunctionType(given_back, taken))
    if name != made.llvm_cfunc_wrapper_name:
        result.library.add_ir_module(module)
    return name


def python_function(function: Callable[..., Any], stored: Stored, kinds: Any, **options: Any) -> Any:
    """Compile or load a function that Python calls with arguments of these types."""
    made: Any = numba.njit(nogil=True, **options)(function)
    made._cache, fresh = stored, not stored.content
    made.compile(kinds)
    if fresh:
        stored.keep(*made.inspect_llvm().values())
    return made


class CFunction(NamedTuple):
    """A C function that was compiled or loaded."""

    address: int
    owner: Any = None  #: of its code


_loaded: dict[str, CFunction] = {}  #: by name


def restored(stored: Stored) -> CFunction:
    """Load the object code of a C function, without the Python function."""
    name, code = stored.object_code()
    if name not in _loaded:
        engine = _engine()
        engine.add_object_file(binding.object_file.ObjectFileRef.from_data(code))
        engine.finalize_object()
        _loaded[name] = CFunction(engine.get_function_address(name))
    return _loaded[name]


@cache
def _engine() -> Any:
    """Return LLVM's engine that holds the C functions."""
    machine = binding.Target.from_default_triple().create_target_machine(jit=True)
    return binding.create_mcjit_compiler(binding.parse_assembly(""), machine)
