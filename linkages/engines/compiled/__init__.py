"""The compiled engine: the same mechanisms and laws as Drake's, a thousand times faster, for batches of runs.

| module         | what it holds                                                                          |
|----------------|----------------------------------------------------------------------------------------|
| model          | a mechanism and an experiment as plain arrays                                          |
| reference      | named tuples by reference in compiled code; calls: functions by address                |
| equations      | equations of motion, driven coordinates eliminated                                     |
| jacobian       | their Jacobian: tangent (exact mechanics), partials (the contacts' laws)               |
| projection     | back onto the closure of ideal loops after each step                                   |
| radau          | Radau IIA of order 5; factor: LU of small matrices                                     |
| dormand_prince | Dormand and Prince's explicit pair 5(4)                                                |
| stepper        | what a method keeps between two attempts at a step                                     |
| driver         | steps, error control, location of events, for any method and problem                   |
| replay         | states between steps                                                                   |
| signals        | outputs by name, for summaries; ideal: the ideal linkage beside a run                  |
| summary        | extremes, mean and rms of signals over windows                                         |
| runs           | all of it bound together                                                               |
| machine        | `Machine`: an assembled mechanism as an object that runs                               |
| simulation     | `simulate`: a run as a `linkages.results.trajectory.Trajectory`                                |
| batch          | `simulate_batch`: many runs in parallel threads                                        |
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkages.engines.compiled.batch import Batch as Batch
    from linkages.engines.compiled.batch import simulate_batch as simulate_batch
    from linkages.engines.compiled.simulation import simulate as simulate

_HOME = {"Batch": "batch", "simulate_batch": "batch", "simulate": "simulation"}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'linkages.engines.compiled' has no attribute '{name}'")
    import importlib

    return getattr(importlib.import_module(f"linkages.engines.compiled.{_HOME[name]}"), name)
