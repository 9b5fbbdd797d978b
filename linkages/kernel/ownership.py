"""Numba's compiler with one pass added: references to arrays are counted only in functions that make arrays.

Kernels read and write arrays that Python owns. Numba counts their owners in every function all the same, with an
atomic operation for each array that is loaded or handed over; a right-hand side takes a third longer with it.
"""

from __future__ import annotations

from typing import Any

from numba.core import ir
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.typed_passes import NopythonTypeInference


@register_pass(mutates_CFG=False, analysis_only=False)
class Ownership(FunctionPass):
    """Switch the counting of references off in a function that neither makes arrays nor receives new ones."""

    _name = "ownership"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Decide for the function that is compiled."""
        made = _owns(state.return_type, state) or any(_makes(each, state) for each in state.calltypes)
        state.targetctx = state.targetctx.subtarget(enable_nrt=made)
        return False


def _makes(expression: Any, state: Any) -> bool:
    """Whether an expression gives an array of its own: by a call, by arithmetic, by an array of indices."""
    result = state.calltypes[expression]
    if result is None or not isinstance(expression, ir.Expr):
        return False
    if expression.op == "getitem":
        return _owns(state.typemap[expression.index.name], state)
    return expression.op != "static_getitem" and _owns(result.return_type, state)


def _owns(kind: Any, state: Any) -> bool:
    """Whether values of a type hold memory whose owners are counted."""
    return bool(state.targetctx.data_model_manager[kind].contains_nrt_meminfo())


class KernelCompiler(Compiler):
    """Numba's compiler with the pass `Ownership` after the inference of types."""

    def define_pipelines(self) -> list[Any]:
        """Add the pass to numba's own list."""
        (manager,) = super().define_pipelines()
        manager.add_pass_after(Ownership, NopythonTypeInference)
        manager.finalize()
        return [manager]
