"""Independent runs in threads: results do not depend on the number of threads; an error ends all of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import nullcontext
from typing import TypeVar, cast

from linkages.base.errors import RunError
from linkages.base.kernel.precompiled import processors
from linkages.base.signals import stopping
from linkages.engines.numerics import THREADS_LOOK

T = TypeVar("T")


def in_threads(
    work: Callable[[int], T],
    count: int,
    threads: int | None = None,
    look: Callable[[], None] | None = None,
    stop: Callable[[], None] | None = None,
) -> list[T]:
    """Return work(0), ..., work(count - 1), computed in threads.

    The first error is raised at once, and drops pending work. The number of threads, the calling one included, is the
    number of processors by default. `look` is called at intervals (with several threads every `THREADS_LOOK`) and at
    the end; `stop` at an error or an interruption, to end running work. With `stop` the calling thread does no work, so
    that interruptions reach it. RunError if the threads cannot be started, for instance without memory for their
    stacks.
    """
    if stop is None and (threads == 1 or count == 1):
        results = []
        for k in range(count):
            results.append(work(k))
            if look is not None:
                look()
        return results
    waiting, results = iter(range(count)), cast(list[T], [None] * count)

    def work_through() -> None:
        for k in waiting:  # which all threads share
            results[k] = work(k)

    number = min(threads or processors(), max(count, 1))
    pool = ThreadPoolExecutor(number)
    try:
        try:
            jobs = {pool.submit(work_through) for _ in range(number)}
        except RuntimeError as problem:  # raised by the interpreter: errors of the work are raised in `result`
            raise RunError(f"the threads of {count} runs cannot be started ({problem}): use fewer threads") from None
        while jobs:
            done, jobs = wait(jobs, timeout=THREADS_LOOK, return_when=FIRST_EXCEPTION)
            for job in done:
                job.result()
            if look is not None:
                look()
        pool.shutdown()
        return results
    except BaseException as problem:
        deque(waiting, maxlen=0)  # nothing waits any more
        if stop is not None:
            stop()
        with stopping() if isinstance(problem, KeyboardInterrupt) else nullcontext():
            pool.shutdown(cancel_futures=True)
        raise
