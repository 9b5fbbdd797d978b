"""Arrays filled with zeros at once: numba's assignment goes row by row, and takes longer to compile."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba.core import cgutils, types
from numba.extending import intrinsic


@intrinsic
def _clear(typing: Any, array: Any) -> Any:
    if not isinstance(array, types.Array) or array.layout != "C":
        return None

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        structure = context.make_array(array)(context, builder, value=values[0])
        cgutils.memset(builder, structure.data, builder.mul(structure.nitems, structure.itemsize), 0)
        return context.get_dummy_value()

    return types.void(array), code


#: ``clear(array)``: fill an array, whose entries follow each other without gaps, with zeros.
clear: Callable[[Any], None] = cast(Any, _clear)
