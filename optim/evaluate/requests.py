"""Runs of some designs at one operating point: what engines are asked for, and what they answer."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, Status
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism, load_mechanism
from linkages.system.assembly import AssemblyError
from optim.evaluate.evaluations import OK
from optim.problem.study import OperatingPoint

Array = NDArray[np.float64]

# compiled loops use all threads already, and must not be entered by two threads of a worker at once
_ONE_BATCH = threading.Lock()


@dataclass(frozen=True)
class Batch:
    """Runs of some designs at one operating point: what a process, or a machine, is asked for."""

    point: OperatingPoint
    values: Array
    outputs: tuple[str, ...]
    windows: Array
    threads: int | None


@dataclass(frozen=True)
class Statistics:
    """Of each output in each window, (m, nw, no): what functionals are made of."""

    minimum: Array
    maximum: Array
    mean: Array
    rms: Array
    status: list[str]
    reason: list[str]


def run_batch(batch: Batch) -> Statistics:
    """Run designs through the compiled engine."""
    from linkages.engines.compiled import simulate_batch

    with _ONE_BATCH:
        found = simulate_batch(
            batch.point.mechanism,
            batch.point.experiment,
            batch.point.paths,
            batch.values,
            outputs=batch.outputs,
            windows=batch.windows,
            threads=batch.threads,
        )
    status = [state.value for state in found.status]
    return Statistics(found.minimum, found.maximum, found.mean, found.rms, status, list(found.reason))


def run_each(batch: Batch, statistics: Callable[[int, Mechanism, Experiment], Array]) -> Statistics:
    """Run designs one after the other; what is wrong with one is its status.

    Parameters
    ----------
    batch : Batch
    statistics : callable
        From a design's number, machine and experiment to minimum, maximum, mean and rms of each output in each window,
        (4, nw, no). It may raise InputError or AssemblyError.
    """
    found = np.full((4, len(batch.values), len(batch.windows), len(batch.outputs)), np.nan)
    status, reason = [OK] * len(batch.values), [""] * len(batch.values)
    for i, line in enumerate(batch.values):
        try:
            values = dict(zip(batch.point.paths, map(float, line), strict=True))
            experiment = batch.point.experiment.replaced(values)
            mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
            found[:, i] = statistics(i, mechanism, experiment)
        except InputError as problem:
            status[i], reason[i] = Status.BAD_INPUT.value, str(problem)
        except AssemblyError as problem:
            status[i], reason[i] = problem.status.value, str(problem)
    minimum, maximum, mean, rms = found
    return Statistics(minimum, maximum, mean, rms, status, reason)


def joined(parts: Iterable[Statistics]) -> Statistics:
    """Put batches of one operating point together again."""
    found = list(parts)

    def whole(key: str) -> Array:
        return np.concatenate([getattr(part, key) for part in found])

    return Statistics(
        whole("minimum"),
        whole("maximum"),
        whole("mean"),
        whole("rms"),
        [state for part in found for state in part.status],
        [reason for part in found for reason in part.reason],
    )
