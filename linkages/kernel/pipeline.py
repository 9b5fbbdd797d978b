"""The way from a function to machine code: those of numba's passes that kernels need, and nothing that only costs time.

Most of a first run is numba's own Python. Of twenty-seven passes half look for what is hardly ever there (`with`,
closures, loops in parallel), and each analyses the function anew. The type of each sum and product is found by
trying dozens of definitions, with a coloured message about each that does not fit. And millions of small objects
are looked through for garbage again and again.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dis import get_instructions
from functools import cache
from types import CodeType
from typing import Any, cast

from numba.core import errors, ir, types
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import FunctionPass, PassManager, register_pass
from numba.core.typed_passes import (
    IRLegalization,
    NativeLowering,
    NoPythonBackend,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.untyped_passes import (
    DeadBranchPrune,
    FixupArgs,
    GenericRewrites,
    IRProcessing,
    ReconstructSSA,
    RewriteSemanticConstants,
    TranslateByteCode,
)


@register_pass(mutates_CFG=False, analysis_only=False)
class Ownership(FunctionPass):
    """References to arrays are counted only in functions that make arrays or are handed new ones."""

    _name = "ownership"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Switch the counting off where nothing is made."""
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


_PASSES = (
    TranslateByteCode,
    FixupArgs,
    IRProcessing,
    RewriteSemanticConstants,
    DeadBranchPrune,
    GenericRewrites,
    ReconstructSSA,
    DeadBranchPrune,
    NopythonTypeInference,
    Ownership,
    PreLowerStripPhis,
    IRLegalization,
    NativeLowering,
    NoPythonBackend,
)
_REST = {"MAKE_FUNCTION", "RAISE_VARARGS"}  # instructions that need more


class ShortCompiler(Compiler):
    """Numba's compiler, which takes the short way where there is one."""

    def define_pipelines(self) -> list[Any]:
        """Choose the passes."""
        return [_short() if _is_plain(self.state.func_id.code) else self._long()]

    def _long(self) -> PassManager:
        (manager,) = super().define_pipelines()
        manager.add_pass_after(Ownership, NopythonTypeInference)
        manager.finalize()
        return cast(PassManager, manager)


def _is_plain(code: CodeType) -> bool:
    """Whether code has no functions within it, no `with` or `try`, and raises nothing."""
    return not (code.co_exceptiontable or _REST & {step.opname for step in get_instructions(code)})


@cache
def _short() -> PassManager:
    manager = PassManager("nopython")
    for each in _PASSES:
        manager.add_pass(each, each.name())
    manager.finalize()
    return manager


_functions: Any = types.Function
_messages: Any = errors
_find = _functions.get_call_type


@contextmanager
def hurried() -> Iterator[None]:
    """Let numba do without what only costs time, while code is compiled; the caller holds its lock."""
    if _functions.get_call_type is not _find:  # within a compilation
        yield
        return
    collecting, colours = gc.isenabled(), _messages._termcolor_inst
    _functions.get_call_type, _messages._termcolor_inst = _remembering(), _Plain()
    gc.disable()  # what numba makes are small objects by the million, nearly all of them in use
    try:
        yield
    finally:
        _functions.get_call_type, _messages._termcolor_inst = _find, colours
        if collecting:
            gc.enable()


def _remembering() -> Callable[..., Any]:
    """Make a search for the signature of a builtin function that remembers what it found, or that nothing fits."""
    known: dict[Any, Any] = {}

    def find(function: Any, context: Any, args: Any, kws: Any) -> Any:
        key = function, context, tuple(args), tuple(kws.items())
        if key not in known:
            try:
                known[key] = _find(function, context, args, kws)
            except errors.TypingError as error:
                known[key] = error
        if isinstance(known[key], Exception):
            raise known[key].with_traceback(None)
        return known[key]

    return find


class _Plain:
    """Messages without colours."""

    def __getattr__(self, name: str) -> Callable[[str], str]:
        return str
