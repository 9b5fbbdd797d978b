"""Requests, runs of some designs at one operating point, and their answer: statistics of outputs in windows."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkages import InputError
from linkages.base.arguments import shaped
from optim.evaluate.evaluations import OK
from optim.problem.study import Array, OperatingPoint

#: Statistics for functionals, in this order.
STATISTICS = ("minimum", "maximum", "mean", "rms")

# compiled loops use all threads already, and must not be entered by two threads of a worker at once
_ONE_AT_A_TIME = threading.Lock()


@dataclass(frozen=True)
class Request:
    """Runs of some designs at one operating point: the work of one process."""

    point: OperatingPoint
    values: Array  # (m, np) values of the point's paths
    limits: Array  # (2, np) least and greatest values in the study
    outputs: tuple[str, ...]  # names of `linkages.results.outputs.registry`
    windows: Array  # (nw, 2) times [s]
    threads: int | None  # of the compiled engine
    progress: Callable[[float], None] | None = None  # called with the finished fraction; None in another process


@dataclass(frozen=True)
class Statistics:
    """The answer to a request: `STATISTICS` of each output in each window, (4, m, nw, no); how each run ended."""

    values: Array
    status: list[str]
    reason: list[str]


#: Answers a request.
RequestEngine = Callable[[Request], Statistics]


def run_compiled(request: Request) -> Statistics:
    """Run the designs of a request as a batch of the compiled engine."""
    from linkages.engines.compiled.batch.batch import run_batch

    point = request.point
    last = {path: k for k, path in enumerate(point.paths)}  # of equal paths the last counts
    columns = list(last.values())
    with _ONE_AT_A_TIME:
        found = run_batch(
            point.system,
            list(last),
            request.values[:, columns],
            request.outputs,
            request.windows,
            request.threads,
            request.progress,
            limits=request.limits[:, columns],
        )
    values = np.stack([found.statistics[name] for name in STATISTICS])
    return Statistics(values, [state.value for state in found.status], found.reason)


def run_parts(engines: Mapping[str, RequestEngine], request: Request) -> Statistics:
    """Have a request answered by several engines; a design that fails with one of them has failed.

    Engines are named by the prefix of the names of their outputs; "": of all others.
    """
    others = [prefix for prefix in engines if prefix]
    owners = [next(filter(name.startswith, others), "") for name in request.outputs]
    parts = []
    for prefix, run in engines.items():
        columns = [k for k, owner in enumerate(owners) if owner == prefix]
        if columns:
            outputs = tuple(request.outputs[k] for k in columns)
            parts.append((columns, _answer(run, dataclasses.replace(request, outputs=outputs))))
    order = np.argsort([k for columns, _ in parts for k in columns])
    values = np.concatenate([found.values for _, found in parts], axis=3)[..., order]
    verdicts = [
        next(((s, r) for s, r in verdict if s != OK), (OK, ""))
        for verdict in zip(*(zip(found.status, found.reason, strict=True) for _, found in parts), strict=True)
    ]
    return Statistics(values, [status for status, _ in verdicts], [reason for _, reason in verdicts])


def _answer(run: RequestEngine, request: Request) -> Statistics:
    """Have a request answered by one engine; InputError if the answer does not fit it."""
    found, m = run(request), len(request.values)
    shape = len(STATISTICS), m, len(request.windows), len(request.outputs)
    shaped(found.values, shape, "engine", "statistics")
    if not len(found.status) == len(found.reason) == m:
        problem = f"returned {len(found.status)} statuses and {len(found.reason)} reasons for {m} designs; give as many"
        raise InputError("argument", "engine", problem)
    return found


def joined(parts: Sequence[Statistics]) -> Statistics:
    """Put the answers for one operating point together again."""
    return Statistics(
        np.concatenate([part.values for part in parts], axis=1),
        [state for part in parts for state in part.status],
        [reason for part in parts for reason in part.reason],
    )
