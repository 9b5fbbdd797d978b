"""What moves a `System`: two engines behind one function, and the runs that belong together.

| module   | responsibility                                                                     |
|----------|------------------------------------------------------------------------------------|
| compiled | the compiled engine: milliseconds a run, batches                                   |
| drake    | the Drake engine: a `MultibodyPlant` with systems for its joints and drives        |
| budget   | how many steps a run may take                                                      |
| study    | `simulate`, the ideal linkage beside a run, and how far the run can be trusted     |
| drop     | the smallest machine, whose impact is known                                        |
| threads  | independent runs in threads                                                        |
| precompilation | what the engines are about to call, compiled ahead on an empty cache               |

An engine is a module with ``simulate(system, progress) -> Trajectory`` and ``longest_step(system)``. The engines do not
know each other.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Protocol, cast

from linkages.errors import InputError, nearest

if TYPE_CHECKING:  # the command line reads the names of the engines, and must start at once
    from linkages.results.trajectory import Progress, Trajectory
    from linkages.system import System

#: Module of each engine.
ENGINES = {"drake": "linkages.engines.drake.simulation", "compiled": "linkages.engines.compiled.simulation"}
#: The engine of runs that name none.
DEFAULT = "compiled"


class Engine(Protocol):
    """What the module of an engine holds."""

    @staticmethod
    def simulate(system: System, progress: Progress | None = None) -> Trajectory:
        """Run a system up to its duration."""

    @staticmethod
    def longest_step(system: System) -> float | None:
        """Return the longest step that the engine takes [s]; None if only the accuracy limits it."""


def engine(name: str) -> Engine:
    """Load the engine of this name.

    Raises
    ------
    InputError
        If there is no such engine.
    """
    if name not in ENGINES:
        raise InputError("engine", name, f"is unknown; {nearest(name, ENGINES)}")
    return cast(Engine, importlib.import_module(ENGINES[name]))
