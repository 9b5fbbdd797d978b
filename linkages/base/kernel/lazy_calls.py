"""Calls of lazy kernels: the address is in a cell that is empty until the first call, which compiles or loads it."""

from __future__ import annotations

import ctypes
import importlib
import pickle
from collections.abc import Sequence
from typing import Any, cast

from llvmlite import binding, ir

from linkages.base.kernel.external import call_address, external
from linkages.base.kernel.stored import alive

kernels: dict[tuple[str, str], Any] = {}  #: by module and name
failures: list[BaseException] = []  #: of functions that compiled code called first, to be raised in Python
_FIND = "linkages-find"  # symbol of `_find`
_WORD = ir.IntType(64)


def call_cell(function: Any, context: Any, builder: Any, signature: Any, values: Sequence[Any]) -> Any:
    """Write a call of a lazy kernel: the first one asks Python, which compiles or loads it, for the address."""
    wanted = pickle.dumps((function.__module__, function.__qualname__, signature.args))
    module, result = builder.module, signature.return_type
    cell = ir.GlobalVariable(module, _WORD, module.get_unique_name("cell"))
    cell.linkage, cell.initializer = "internal", ir.Constant(_WORD, 0)
    text = ir.GlobalVariable(module, ir.ArrayType(ir.IntType(8), len(wanted)), module.get_unique_name("lazy"))
    text.linkage, text.global_constant = "internal", True
    text.initializer = ir.Constant(text.value_type, bytearray(wanted))
    kind = ir.FunctionType(_WORD, [cell.type, ir.IntType(8).as_pointer(), _WORD])
    find = module.globals.get(_FIND) or ir.Function(module, kind, _FIND)
    known = builder.load(cell)
    before = builder.block
    with builder.if_then(builder.icmp_unsigned("==", known, _WORD(0)), likely=False):
        asked = builder.call(find, [cell, builder.bitcast(text, kind.args[1]), _WORD(len(wanted))])
        asking = builder.block
    found = builder.phi(_WORD)
    found.add_incoming(known, before)
    found.add_incoming(asked, asking)
    before = builder.block
    with builder.if_then(builder.icmp_unsigned("!=", found, _WORD(0)), likely=True):
        given = call_address(context, builder, found, result, values)
        calling = builder.block
    value = builder.phi(given.type)
    value.add_incoming(ir.Constant(given.type, None), before)
    value.add_incoming(given, calling)
    return value


@ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
def _find(cell: int, text: int, size: int) -> int:
    """Fill a cell with the address of a lazy kernel; 0 if it cannot be compiled, which Python raises later."""
    try:
        module, name, kinds = pickle.loads(ctypes.string_at(text, size))
        importlib.import_module(module)
        wanted = kernels[module, name]
        symbol = external(wanted.py_func, kinds, wanted.result_for(kinds))
        place = ctypes.c_int64.from_address(cell).value = alive[symbol].address
        return place
    except BaseException as error:
        failures.append(error)
        return 0


binding.add_symbol(_FIND, cast(int, ctypes.cast(_find, ctypes.c_void_p).value))
