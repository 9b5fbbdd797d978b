"""Kernels that are compiled when they are first called: what most machines never call costs them nothing.

Compiled code calls a lazy kernel through a cell that belongs to the place of the call. The cell is empty at first;
then Python is asked, which compiles the kernel to a C function or loads it, and fills the cell with its address.
After that a call is a load and an indirect call. Which kernel is meant stands in the calling code by name and types,
so that it need not be compiled anew when the kernel is edited, and so that it can be kept on disk as all other code.

The type of the result is that of the annotation: nothing, a number, or a tuple of numbers. There are no
default values.
"""

from __future__ import annotations

import ctypes
import importlib
import pickle
from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any, TypeVar, cast, get_args

from llvmlite import binding, ir
from numba import config
from numba.core import cgutils, types
from numba.core.serialize import dumps
from numba.core.typing.templates import make_intrinsic_template

from linkages.kernel.by_address import address, call_at
from linkages.kernel.compile import Kernel, failures
from linkages.kernel.fingerprint import LAZY

F = TypeVar("F", bound=Callable[..., Any])

_FIND = "linkages_find_lazy_kernel"  # symbol of `_find`
_NUMBERS = {None: types.none, float: types.float64, int: types.int64, bool: types.boolean}
_kernels: dict[tuple[str, str], LazyKernel] = {}


def lazy_kernel(function: F) -> F:
    """Compile a function when it is first called, from compiled code too.

    Raises
    ------
    TypeError
        If its result is not annotated, or by something else than None, float, int, bool or a tuple of these.
    """
    if getattr(config, "DISABLE_JIT", False):
        return function
    made = _kernels[function.__module__, function.__qualname__] = LazyKernel(function)
    return cast(F, made)


class LazyKernel(Kernel):
    """A function that is compiled when it is first called."""

    def __init__(self, function: Any) -> None:
        super().__init__(function, None, LAZY)
        self.result = _result(function)
        self._signature = signature(function)
        template = make_intrinsic_template(self, self._type_call(), function.__name__)
        self._compiled = types.Function(template)

    @property
    def _numba_type_(self) -> Any:
        return self._compiled

    def prepare(self, *kinds: Any) -> None:
        """Compile for arguments of these numba types, or load the code."""
        address(self.py_func, self.result(*kinds))

    def _type_call(self) -> Callable[..., Any]:
        """Make what types a call and gives what writes it, as numba's intrinsics do."""

        def type_call(typing: Any, *arguments: Any, **named: Any) -> Any:
            arguments = self._signature.bind(*arguments, **named).args
            kinds = tuple(types.unliteral(kind) for kind in arguments)
            return self.result(*arguments), self._call(kinds)

        own = [Parameter("typing", Parameter.POSITIONAL_ONLY), *self._signature.parameters.values()]
        cast(Any, type_call).__signature__ = self._signature.replace(parameters=own)
        return type_call

    def _call(self, kinds: tuple[Any, ...]) -> Callable[..., Any]:
        """Make what writes a call with arguments of these types."""
        wanted = dumps((self.py_func.__module__, self.py_func.__qualname__, kinds))

        def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
            word, module = ir.IntType(64), builder.module
            cell = cgutils.add_global_variable(module, word, module.get_unique_name("lazy"))
            cell.linkage, cell.initializer = "internal", ir.Constant(word, 0)
            known = builder.load(cell)
            place = cgutils.alloca_once_value(builder, known)
            with builder.if_then(builder.icmp_unsigned("==", known, known.type(0)), likely=False):
                text = context.insert_const_bytes(module, wanted)
                kind = ir.FunctionType(word, [word.as_pointer(), text.type, word])
                find = cgutils.get_or_insert_function(module, kind, _FIND)
                builder.store(builder.call(find, [cell, text, word(len(wanted))]), place)
            found = builder.load(place)
            result = cgutils.alloca_once(builder, context.get_value_type(self.result), zfill=True)
            with builder.if_then(builder.icmp_unsigned("!=", found, known.type(0)), likely=True):
                passed = [context.cast(builder, *each) for each in zip(values, typed.args, kinds, strict=True)]
                builder.store(call_at(context, builder, found, self.result, passed), result)
            return builder.load(result)

        return code


def _result(function: Any) -> Any:
    """Find the numba type of a function's result from its annotation."""
    given = function.__annotations__.get("return", "missing")
    kind = eval(given, function.__globals__) if isinstance(given, str) and given != "missing" else given
    try:
        parts = get_args(kind)
        return types.Tuple([_NUMBERS[part] for part in parts]) if parts else _NUMBERS[kind]
    except (KeyError, TypeError):
        what = "annotate its result as None, float, int, bool, or a tuple of these"
        raise TypeError(f"the lazy kernel {function.__qualname__} returns {kind}; {what}") from None


@ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
def _find(cell: int, text: int, size: int) -> int:
    """Fill a cell with the address of the kernel that is wanted; 0 if it cannot be compiled, which Python is told."""
    try:
        module, name, kinds = pickle.loads(ctypes.string_at(text, size))
        importlib.import_module(module)
        wanted = _kernels[module, name]
        place = address(wanted.py_func, wanted.result(*kinds))
        ctypes.c_int64.from_address(cell).value = place
        return place
    except BaseException as problem:
        failures.append(problem)
        return 0


binding.add_symbol(_FIND, cast(int, ctypes.cast(_find, ctypes.c_void_p).value))
