"""Integration methods of each engine, and the method of a run."""

from __future__ import annotations

from linkages.base.errors import InputError, notice
from linkages.base.kernel.precompiled import expect
from linkages.base.kernel.private import OFF
from linkages.input.model.experiment_tables import IMPLICIT
from linkages.results.outputs.registry import check_outputs
from linkages.system import System

#: Explicit and implicit methods of each engine by their names in experiments; the first of a tuple is the default.
METHODS = {
    "compiled": (("dormand_prince_5_4",), ("radau_iia_5",)),
    "drake": (("runge_kutta5", "runge_kutta3", "bogacki_shampine3"), ("radau3", "radau1", "implicit_euler")),
}

#: Drake's ``runge_kutta5`` has the tableau of Dormand and Prince.
_SAME = {("drake", "dormand_prince_5_4"): "runge_kutta5"}


def is_implicit(system: System) -> bool:
    """Whether the integration method of a run is implicit: as the experiment's, else for stiff joint laws."""
    given = system.settings.integrator
    return system.stiff if given is None else given in IMPLICIT


def expect_run(system: System, engine: str) -> None:
    """Check the outputs of a run, and have its kernels compiled if the cache of compiled code is empty."""
    check_outputs(system)
    expect(f"linkages.engines.precompilation:{engine}", *((is_implicit(system),) if engine == "compiled" else ()))


def method(system: System, engine: str) -> str:
    """Choose the integration method of a run: the experiment's, else an implicit one for stiff joint laws.

    If the engine does not have the experiment's, its default method of the same kind is used, with a notice on standard
    error. InputError for the compiled engine's implicit method without a compiler.
    """
    given = system.settings.integrator
    if OFF and engine == "compiled" and is_implicit(system):
        problem = "the implicit method needs the compiler; unset it, or set solver.integrator to dormand_prince_5_4"
        raise InputError("environment", "NUMBA_DISABLE_JIT", problem)
    own = METHODS[engine][is_implicit(system)]
    if given is None or given in own:
        return given or own[0]
    if (engine, given) in _SAME:
        return _SAME[engine, given]
    notice(f"solver.integrator: the {engine} engine does not have {given} and uses {own[0]}")
    return own[0]
