"""Simulation of a `System`: two engines behind one function, and groups of related runs.

| module         | responsibility                                                              |
|----------------|-----------------------------------------------------------------------------|
| compiled       | the compiled engine: milliseconds for a run, batches                        |
| drake          | the Drake engine: a `MultibodyPlant` with systems for its joints and drives |
| methods        | integration methods of each engine, and the method of a run                 |
| budget         | largest number of steps of a run                                            |
| assessment     | `simulate`; a run with its ideal linkage and error estimate                 |
| drop           | drop test: the smallest mechanism, with a known impact                      |
| repetition     | settings of the run that estimates the errors of a run                      |
| threads        | independent runs in threads                                                 |
| cluster        | an executor on a Dask cluster                                               |
| parcels        | what many pieces of work for other processes share                          |
| numerics       | numbers that tune engines, batches and derivatives, with unit and effect    |
| precompilation | plans to compile the engines' kernels on an empty cache                     |

An engine is a module with ``simulate(system, progress) -> Trajectory`` and ``longest_step(system)``, the longest step
that it takes [s], None if only the accuracy limits it. The engines do not know each other.
"""

from __future__ import annotations

import importlib
from types import ModuleType

from linkages.base.errors import InputError, nearest
from linkages.base.packages import check_installed

#: Module of each engine.
ENGINES = {"drake": "linkages.engines.drake.simulation", "compiled": "linkages.engines.compiled.simulation"}
#: Package that an engine needs besides the dependencies of all systems.
PACKAGES = {"drake": "pydrake"}
#: Default engine.
DEFAULT = "compiled"


def check_engine(name: str) -> None:
    """Raise an InputError if no engine has this name, or its package is not installed; imports nothing."""
    if name not in ENGINES:
        raise InputError("engine", name, f"is unknown; {nearest(name, ENGINES)}")
    if name in PACKAGES:
        check_installed(PACKAGES[name], "engine", name)


def engine(name: str) -> ModuleType:
    """Import the engine with this name; InputError as by `check_engine`."""
    check_engine(name)
    return importlib.import_module(ENGINES[name])
