"""Runs on a Dask cluster: an executor like any other.

Workers import this package and read the mechanism's file under the path it has here: install the same versions, and
share the folder. Workers may come and go: the work of one that dies goes to the others.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from linkages.base.errors import InputError, RunError, notice
from linkages.base.packages import needed
from linkages.engines.numerics import CLUSTER_LEAST, CLUSTER_LOOK, CLUSTER_RETRIES, CLUSTER_SAID
from linkages.input.files.versions import determining

WAIT = 60.0  #: time to wait for a scheduler and for a first worker, by default [s]


@contextmanager
def cluster(address: str, remedy: str, wait: float = WAIT) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Connect to a scheduler; yields an executor and a function that returns the number of worker threads by now.

    The address is ``tcp://host:8786``, or the path of the file that a scheduler writes (``.json``). For the scheduler
    and its first worker `wait` is the time that they have to appear [s].

    InputError if Dask is not installed, or no scheduler answers. RunError if there is no worker, if a worker has other
    package versions than this process, or if the connection is lost while the executor is in use: `remedy` then says
    how to continue.
    """
    distributed = needed("distributed", "--cluster", address)
    until = time.monotonic() + wait
    with _client(distributed, address, until) as client:
        _wait_for_worker(client, address, until)
        _check_versions(client, address)
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # the error below says it in one line
        try:
            # work of equal arguments is not the same work: the keys need no digests of them
            yield client.get_executor(retries=CLUSTER_RETRIES, pure=False), lambda: sum(client.nthreads().values())
        except Exception as problem:
            if client.status == "running" and not isinstance(problem, CancelledError):
                raise
            raise RunError(
                f"cluster {address}: the connection to the scheduler is lost; the results up to now are kept:"
                f" start the scheduler and its workers, and {remedy}"
            ) from None


def _client(distributed: Any, address: str, until: float) -> Any:
    """Connect to the scheduler of an address or file before a time [s]."""
    given: dict[str, Any] = {"address": address}
    if address.endswith(".json"):
        _wait_for_file(address, until)
        given = {"scheduler_file": address}
    try:
        return distributed.Client(**given, timeout=max(until - time.monotonic(), CLUSTER_LEAST), set_as_default=False)
    except (OSError, ValueError, KeyError) as problem:
        raise InputError("--cluster", address, f"no scheduler answers ({problem})") from None


def _wait_for_file(address: str, until: float) -> None:
    """Wait until a scheduler has written its file; InputError if it does not."""
    while not (Path(address).is_file() and Path(address).stat().st_size):
        if time.monotonic() > until:
            remedy = f"start one with: dask scheduler --scheduler-file {address}; or give a longer --wait"
            raise InputError("--cluster", address, f"no scheduler has written this file; {remedy}")
        time.sleep(CLUSTER_LOOK)


def _wait_for_worker(client: Any, address: str, until: float) -> None:
    """Wait for a first worker; RunError if there is none."""
    left = max(until - time.monotonic(), CLUSTER_LEAST)
    try:
        client.wait_for_workers(1, timeout=min(left, CLUSTER_SAID))
        return
    except TimeoutError:
        if left > CLUSTER_SAID:
            notice(f"waiting for workers of {address}, up to {left:.0f} s")
    try:
        client.wait_for_workers(1, timeout=max(left - CLUSTER_SAID, CLUSTER_LOOK))
    except TimeoutError:
        start = f"--scheduler-file {address}" if address.endswith(".json") else address
        remedy = f"start some with: dask worker {start}; or give a longer --wait"
        raise RunError(f"cluster {address}: has no workers; {remedy}") from None


def _check_versions(client: Any, address: str) -> None:
    """Raise a RunError if a worker that is there has other versions; `Parcel` checks later ones."""
    here = determining()  # nothing there runs Drake
    for worker, there in client.run(determining).items():
        for package in here:
            if there[package] != here[package]:
                raise RunError(
                    f"cluster {address}: worker {worker} has {package} {there[package]}, here is {here[package]};"
                    " install the same version"
                )
