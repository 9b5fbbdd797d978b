"""Units of compiled code: each compiled once, and called by the others by its symbol.

Numba puts the code of all that a function calls into the function, optimised once more at every level of calls. Here
the callers of a unit know no more of it than its name, which says what it is (`linkages.kernel.fingerprint`): so
it is compiled once, and its code in one process or file fits all others. Parts, on the contrary, are made to
be put into their callers; they are never machine code by themselves.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from typing import Any

from llvmlite import binding, ir
from numba.core.cgutils import normalize_ir_text
from numba.core.codegen import JITCodeLibrary
from numba.core.funcdesc import default_mangler

from linkages.kernel import locks, precompiled
from linkages.kernel.fingerprint import fingerprint
from linkages.kernel.ownership import KernelCompiler
from linkages.signals import deferred


class _Library(JITCodeLibrary):
    """Code that is optimised once, as a whole: numba does so three times."""

    def add_ir_module(self, ir_module: Any) -> None:
        """Take over what was compiled, not yet optimised."""
        text = with_short_loops(ir_module)
        if ir_module.name == "cfunc_wrapper":  # the only code that numba asks to leave apart
            text = text.replace(" noinline", "")
        module = binding.parse_assembly(normalize_ir_text(text))
        module.name = ir_module.name
        module.data_layout = self._codegen._data_layout
        self._final_module.link_in(module)


def with_short_loops(module: Any) -> str:
    """Text of a module whose loops LLVM leaves as they are, unless it knows how often they are gone through.

    Loops over bodies, coordinates and modes are gone through a few times: eight rounds at once, and what is to be found
    out before them, cost more than they gain, in compiling too.
    """
    hint = module.add_metadata([ir.MetaDataString(module, "llvm.loop.unroll.runtime.disable")])
    loop = module.add_metadata([hint])
    for function in module.functions:
        before = set()
        for block in function.blocks:
            before.add(block)
            jump = block.terminator
            if isinstance(jump, ir.Branch | ir.ConditionalBranch) and not before.isdisjoint(jump.operands):
                jump.set_metadata("llvm.loop", loop)
    known, own = (each.get_reference() for each in (hint, loop))
    return str(module).replace(f"{own} = !{{ {known} }}", f"{own} = distinct !{{ {own}, {known} }}")


class UnitLibrary(_Library):
    """Code that its callers only declare."""

    def _optimize_final_module(self) -> None:
        """Optimise in one go; numba's own form of a C function becomes a part of it."""
        functions = {function.name: function for function in self._final_module.functions}
        for name, function in functions.items():
            if f"cfunc.{name}" in functions and not function.is_declaration:
                function.linkage = binding.Linkage.internal
        manager, builder = self._codegen._module_pass_manager(loop_vectorize=False)
        manager.run(self._final_module, builder)

    def _finalize_final_module(self) -> None:
        with deferred():
            super()._finalize_final_module()

    def _get_module_for_linking(self) -> Any:
        self._ensure_finalized()
        if self._shared_module is None:
            self._shared_module = binding.parse_assembly(str(self._codegen._create_empty_module(self.name)))
        return self._shared_module


class PartLibrary(_Library):
    """Code that is there for its callers alone."""

    @property
    def codegen(self) -> Any:
        """Where numba sets what a function needs to raise errors: nowhere, as this code is in no place."""
        return self

    def set_env(self, name: str, env: Any) -> None:
        """Do nothing."""

    def _optimize_final_module(self) -> None:
        """Leave it to the callers."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


def _mangled(name: str, kinds: Any, *, abi_tags: Any = (), uid: Any = None) -> str:
    """Name code by its types' full names: numba numbers types of records, otherwise in each process."""
    digest = hashlib.sha256(" ".join(map(str, kinds)).encode()).hexdigest()[:32]
    return str(default_mangler(name, (), abi_tags=(*abi_tags, digest), uid=uid))


class _Named(KernelCompiler):
    """Names code by what the function is, so that names are the same in all processes."""

    library: type[JITCodeLibrary]

    def _compile_bytecode(self) -> Any:
        state = self.state
        with suppress(TypeError):  # not of known content: it is not kept either
            state.func_id.unique_id = fingerprint(state.func_id.func)
        state.targetctx.mangler = _mangled
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        precompiled.compiling()
        try:
            return super()._compile_bytecode()
        except BaseException:
            locks.release_all()
            raise


class UnitCompiler(_Named):
    """Compiles to a unit."""

    library = UnitLibrary


class PartCompiler(_Named):
    """Compiles to a part."""

    library = PartLibrary
