"""External functions: C functions that are compiled or loaded once; callers contain their symbols, not their code."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import partial
from typing import Any

from llvmlite import ir

from linkages.base.kernel import passing
from linkages.base.kernel.private import c_function, one_thread
from linkages.base.kernel.stored import PREFIX, alive, link, name_of, obtain


def external(function: Any, kinds: tuple[Any, ...], result: Any) -> str:
    """Load or compile an external function for arguments of these types, and return its symbol."""
    name = name_of(function, kinds, result)
    symbol = _symbol(name, function, kinds, result)
    with one_thread:  # what is under way in another one is no recursion
        if not alive.get(symbol):
            alive[symbol] = None
            try:
                types = {"kinds": kinds, "result": result, "entry": passing.entry}
                made = obtain(name, function, partial(c_function, **types, error_model="numpy"))
            except BaseException:
                del alive[symbol]
                raise
            link(symbol, made)
    return symbol


def _symbol(name: str | None, function: Any, kinds: tuple[Any, ...], result: Any) -> str:
    return PREFIX + (name or hashlib.sha256(f"{id(function)} {kinds} {result}".encode()).hexdigest()[:32])


def under_way(function: Any, kinds: tuple[Any, ...], result: Any) -> bool:
    """Whether a function is being compiled: it calls itself."""
    return alive.get(_symbol(name_of(function, kinds, result), function, kinds, result), 0) is None


def call_symbol(function: Any, context: Any, builder: Any, signature: Any, values: Sequence[Any]) -> Any:
    """Write a call of an external function by its symbol."""
    symbol = external(function, signature.args, signature.return_type)
    kind = _kind(context, signature.return_type, values)
    known = builder.module.globals.get(symbol)
    return passing.call(builder, known or ir.Function(builder.module, passing.passed(kind), symbol), kind, values)


def call_address(context: Any, builder: Any, place: Any, result: Any, values: Sequence[Any]) -> Any:
    """Write a call of the external function at an address."""
    kind = _kind(context, result, values)
    return passing.call(builder, builder.inttoptr(place, passing.passed(kind).as_pointer()), kind, values)


def _kind(context: Any, result: Any, values: Sequence[Any]) -> Any:
    return ir.FunctionType(context.get_value_type(result), [value.type for value in values])
