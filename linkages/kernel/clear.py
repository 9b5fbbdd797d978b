"""Arrays filled with zeros at once: numba's assignment goes row by row, and takes longer to compile."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


@intrinsic
def _clear(typing: Any, array: Any) -> Any:
    if not isinstance(array, types.Array) or array.layout != "C":
        return None

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        byte, word = ir.IntType(8), ir.IntType(64)
        data = builder.bitcast(builder.extract_value(values[0], 4), byte.as_pointer())
        size = builder.mul(builder.extract_value(values[0], 2), builder.extract_value(values[0], 3))
        memset = builder.module.declare_intrinsic("llvm.memset", [byte.as_pointer(), word])
        builder.call(memset, [data, byte(0), size, ir.IntType(1)(0)])
        return context.get_dummy_value()

    return types.void(array), code


#: ``clear(array)``: fill an array, whose entries follow each other without gaps, with zeros.
clear: Callable[[Any], None] = cast(Any, _clear)
