"""The engines: interchangeable modules that run an experiment."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from linkages.errors import InputError, nearest

#: Module of each engine; its function ``simulate(mechanism, experiment, progress)`` returns a `Trajectory`.
ENGINES = {"drake": "linkages.engines.drake.simulation", "compiled": "linkages.engines.compiled.simulation"}


def engine(name: str) -> Callable[..., Any]:
    """Load the engine of this name and return its ``simulate``.

    Raises
    ------
    InputError
        If there is no such engine.
    """
    if name not in ENGINES:
        raise InputError("engine", name, f"is unknown; {nearest(name, ENGINES)}")
    return importlib.import_module(ENGINES[name]).simulate
