"""Work in a process beside, while this one goes on."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

_PATIENCE = 120.0  # s; more than plots take. A process that waits for a thread that it has not would never end


@contextmanager
def beside(works: Sequence[Callable[[], None]]) -> Iterator[None]:
    """Do work that leaves nothing but files, beside what the context holds; at its end all is done.

    What goes wrong there is done once more here, at the end, and so is all of it where processes cannot be split
    safely, or where the work does not end in time. Ctrl-C is answered here alone: where it ends the context, it ends
    the work.

    Parameters
    ----------
    works : sequence of callables
        One after another, in one process.
    """
    if not works or sys.platform != "linux":
        yield
        _all(works)
        return
    process = multiprocessing.get_context("fork").Process(target=_quietly, args=(works,))
    started, collecting = False, gc.isenabled()
    gc.disable()  # until `_quietly`
    with suppress(OSError):  # no more processes, or no memory for one
        process.start()
        started = True
    if collecting:
        gc.enable()
    try:
        yield
        if started:
            process.join(_PATIENCE)
    finally:
        if started:
            process.kill()
            process.join()
    if not started or process.exitcode != 0:
        _all(works)


def _all(works: Sequence[Callable[[], None]]) -> None:
    for work in works:
        work()


def _quietly(works: Sequence[Callable[[], None]]) -> None:
    gc.freeze()  # nothing of the other process ends here: Drake's Meshcat would wait for threads that are only there
    gc.enable()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        _all(works)
    except BaseException:  # said when it is met again
        sys.exit(1)
