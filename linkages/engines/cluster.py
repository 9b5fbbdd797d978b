"""Runs on a Dask cluster: an executor like any other.

Workers import this package and read the mechanism's file under the path it has here: install the same versions, and
share the folder. The work of a worker that dies goes to the others.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager

from linkages.base.errors import InputError, RunError
from linkages.base.packages import needed
from linkages.input.files.versions import versions

_ANSWER, _WORKER = 10.0, 10.0  # seconds to wait for the scheduler, and for a first worker
_RETRIES = 5  # deaths of its worker that a piece of work survives


@contextmanager
def cluster(address: str, remedy: str) -> Iterator[tuple[Executor, int]]:
    """Connect to a scheduler, ``tcp://host:8786``; yields an executor and the number of worker threads.

    InputError if Dask is not installed, or no scheduler answers. RunError if there is no worker, if a worker has other
    package versions than this process, or if the connection is lost while the executor is in use: `remedy` then says
    how to continue.
    """
    distributed = needed("distributed", "--cluster", address)
    try:
        client = distributed.Client(address, timeout=_ANSWER, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise InputError("--cluster", address, f"no scheduler answers ({problem})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=_WORKER)
        except TimeoutError:
            raise RunError(f"cluster {address}: has no workers; start some with: dask worker {address}") from None
        here = versions()
        for worker, there in client.run(versions).items():
            for package in here:
                if package not in ("python", "drake") and there[package] != here[package]:  # nothing there runs Drake
                    raise RunError(
                        f"cluster {address}: worker {worker} has {package} {there[package]}, here is {here[package]};"
                        " install the same version"
                    )
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # the error below says it in one line
        try:
            yield client.get_executor(retries=_RETRIES), sum(client.nthreads().values())
        except Exception as problem:
            if client.status == "running" and not isinstance(problem, CancelledError):
                raise
            raise RunError(
                f"cluster {address}: the connection to the scheduler is lost; the results up to now are kept:"
                f" start the scheduler and its workers, and {remedy}"
            ) from None
