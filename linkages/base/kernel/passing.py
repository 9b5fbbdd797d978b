"""How external functions take and return vectors: in pieces, which processors with and without AVX-512 pass alike.

A vector of eight numbers is in one register if code is compiled for AVX-512, else in two. Code of a wheel is compiled
for less than this processor (`linkages.base.kernel.shipped`), and calls code compiled here, and the reverse.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from llvmlite import ir

_PIECE = 4  # numbers: of an AVX register
_INDEX = ir.IntType(32)


def passed(kind: Any) -> Any:
    """Return LLVM's type as which a value is passed, of a function the type with the types of its values."""
    if isinstance(kind, ir.FunctionType):
        return ir.FunctionType(passed(kind.return_type), [passed(each) for each in kind.args])
    if isinstance(kind, ir.VectorType) and kind.count > _PIECE:
        return ir.ArrayType(ir.VectorType(kind.element, _PIECE), kind.count // _PIECE)
    if isinstance(kind, ir.LiteralStructType):
        return ir.LiteralStructType([passed(each) for each in kind.elements], packed=kind.packed)
    return ir.ArrayType(passed(kind.element), kind.count) if isinstance(kind, ir.ArrayType) else kind


def call(builder: Any, function: Any, kind: Any, values: Sequence[Any]) -> Any:
    """Write a call of an external function; its type before `passed` is `kind`."""
    given = builder.call(function, [_turned(builder, value, passed(value.type)) for value in values])
    return _turned(builder, given, kind.return_type)


def entry(module: Any, name: str, kind: Any) -> str:
    """Write the function that callers of a function reach; return its name, the given one if they need no other."""
    outer = passed(kind)
    if outer == kind:
        return name
    own = ir.Function(module, outer, f"{name}.passed")
    builder = ir.IRBuilder(own.append_basic_block("entry"))
    values = [_turned(builder, value, each) for value, each in zip(own.args, kind.args, strict=True)]
    given = builder.call(ir.Function(module, kind, name), values)
    builder.ret(_turned(builder, given, outer.return_type))
    return str(own.name)


def _turned(builder: Any, value: Any, kind: Any) -> Any:
    """Turn a value to its type as passed, or back."""
    if value.type == kind:
        return value
    if isinstance(kind, ir.VectorType):
        return _joined(builder, [builder.extract_value(value, k) for k in range(value.type.count)])
    turned = ir.Constant(kind, ir.Undefined)
    for k, each in enumerate(kind.elements):
        if isinstance(value.type, ir.VectorType):
            part = _chosen(builder, value, value, range(k * _PIECE, (k + 1) * _PIECE))
        else:
            part = _turned(builder, builder.extract_value(value, k), each)
        turned = builder.insert_value(turned, part, k)
    return turned


def _joined(builder: Any, pieces: list[Any]) -> Any:
    """Join two, four, eight ... vectors."""
    while len(pieces) > 1:
        wide = range(2 * pieces[0].type.count)
        pairs = zip(pieces[::2], pieces[1::2], strict=True)
        pieces = [_chosen(builder, *pair, wide) for pair in pairs]
    return pieces[0]


def _chosen(builder: Any, first: Any, second: Any, places: Iterable[int]) -> Any:
    """Choose entries of two vectors."""
    chosen = [*places]
    return builder.shuffle_vector(first, second, ir.Constant(ir.VectorType(_INDEX, len(chosen)), chosen))
