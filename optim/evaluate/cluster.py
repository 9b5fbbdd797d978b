"""Evaluations on a Dask cluster: an executor like any other.

Workers import this package and read the mechanism's file under the path it has here: install the same versions, and
share the folder. The requests of a worker that dies go to the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from linkages import InputError, RunError
from linkages.files.versions import versions

_ANSWER, _WORKER = 10.0, 10.0  # seconds to wait for the scheduler, and for a first worker
_RETRIES = 5  # deaths of its worker that a request survives


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Connect to a scheduler; yields an executor and the number of worker threads.

    Parameters
    ----------
    address : str
        Address of the scheduler: ``tcp://host:8786``.

    Raises
    ------
    InputError
        If Dask is not installed, or no scheduler answers.
    RunError
        If there is no worker, or workers have other versions than this process.
    """
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--cluster", address, 'needs Dask: pip install "linkages[cluster]"') from None
    try:
        client = Client(address, timeout=_ANSWER, set_as_default=False)
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
                if package != "python" and there[package] != here[package]:
                    raise RunError(
                        f"cluster {address}: worker {worker} has {package} {there[package]}, here is {here[package]};"
                        " install the same version"
                    )
        yield client.get_executor(retries=_RETRIES), sum(client.nthreads().values())
