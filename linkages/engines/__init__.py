"""Simulation of a `System`: two engines behind one function, and groups of related runs.

| module         | responsibility                                                              |
|----------------|-----------------------------------------------------------------------------|
| compiled       | the compiled engine: milliseconds for a run, batches                        |
| drake          | the Drake engine: a `MultibodyPlant` with systems for its joints and drives |
| methods        | integration methods of each engine, and the method of a run                 |
| budget         | largest number of steps of a run                                            |
| assessment     | `simulate`; a run with its ideal linkage and error estimate                 |
| drop           | drop test: the smallest mechanism, with a known impact                      |
| threads        | independent runs in threads                                                 |
| precompilation | plans to compile the engines' kernels on an empty cache                     |

An engine is a module with ``simulate(system, progress) -> Trajectory`` and ``longest_step(system)``. The engines do not
know each other.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Protocol, cast

from linkages.base.errors import InputError, nearest

if TYPE_CHECKING:  # the command line imports this module for the names of the engines, and must start fast
    from linkages.results.trajectory import TimeReport, Trajectory
    from linkages.system import System

#: Module of each engine.
ENGINES = {"drake": "linkages.engines.drake.simulation", "compiled": "linkages.engines.compiled.simulation"}
#: Default engine.
DEFAULT = "compiled"


class Engine(Protocol):
    """Interface of an engine's module."""

    @staticmethod
    def simulate(system: System, progress: TimeReport | None = None) -> Trajectory:
        """Run a system up to its duration."""

    @staticmethod
    def longest_step(system: System) -> float | None:
        """Return the longest step that the engine takes [s]; None if only the accuracy limits it."""


def engine(name: str) -> Engine:
    """Import the engine with this name.

    Raises
    ------
    InputError
        If the engine is unknown.
    """
    if name not in ENGINES:
        raise InputError("engine", name, f"is unknown; {nearest(name, ENGINES)}")
    return cast(Engine, importlib.import_module(ENGINES[name]))
