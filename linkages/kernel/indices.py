"""Indices of arrays within this package's kernels are never negative, but for constants such as ``a[-1]``.

To an index that is no constant numba adds the array's length where it is negative: a comparison and a choice at each
access, which in kernels of a few operations cost up to a fifth of their time. Laws that users register, and all other
code, are left as they are. ``NUMBA_BOUNDSCHECK=1`` finds indices that are out of bounds, negative ones too.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.np import arrayobj

_adding_length = arrayobj.fix_integer_index


def are_ours(function: Any) -> bool:
    """Whether a function is one of this package's."""
    return str(function.__module__).partition(".")[0] == __name__.partition(".")[0]


def take_as_they_are(context: Any) -> None:
    """Let code that is made in this context (numba's target context of one function) take indices as they are."""
    context.indices_as_they_are = True


def _fix_integer_index(context: Any, builder: Any, kind: Any, index: Any, size: Any) -> Any:
    if isinstance(index, ir.Constant) or not getattr(context, "indices_as_they_are", False):
        return _adding_length(context, builder, kind, index, size)
    return context.cast(builder, index, kind, types.intp)


arrayobj.fix_integer_index = _fix_integer_index
