"""Code that will soon be needed, compiled by further processes: on an empty cache all processors have work.

A *plan* is a function of a module, ``"module:function"``, that returns jobs: functions without arguments, which compile
what they call. `expect` names a plan; nothing comes of it until so much has been compiled that the cache must be empty.
What one process compiles the others wait for (`linkages.base.kernel.locks`) and load.
"""

from __future__ import annotations

import atexit
import importlib
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from linkages.base.kernel import locks
from linkages.base.kernel.folder import folder
from linkages.base.signals import end_with_parent

_EMPTY = 4  # kernels compiled in a process after which the cache is taken for empty
_MOST = 3  # further processes: there are few jobs, and they share much
_PAUSE = 0.1  # s, where other processes are compiling what all jobs need
_plans: list[tuple[str, tuple[Any, ...]]] = []
_beside: list[subprocess.Popen[bytes]] = []
_compiled = 0  # kernels, in this process
_loaded = 0  # others
_known = 0  # all that there are
_assisting = False  # whether this process is a further one
_told: list[Callable[[int, int], None]] = []


def expect(plan: str, *settings: Any) -> None:
    """Say what will be needed: a plan, and settings for it (text, numbers, bool)."""
    if (plan, settings) not in _plans:
        _plans.append((plan, settings))
    if _compiled >= _EMPTY:
        _start()


def tell(listener: Callable[[int, int], None]) -> None:
    """Call a function before each compilation in this process: with how many kernels are ready, and how many known."""
    _told.append(listener)


def known() -> None:
    """Take note that there is a kernel."""
    global _known
    _known += 1


def counts() -> tuple[int, int]:
    """Return how many kernels this process has compiled, and how many it has loaded."""
    return _compiled, _loaded


def loaded() -> None:
    """Take note that a kernel was loaded."""
    global _loaded
    _loaded += 1


def compiling() -> None:
    """Take note that a kernel is compiled in this process."""
    global _compiled
    for listener in _told:
        listener(_compiled + _loaded, _known)
    _compiled += 1
    if _compiled == _EMPTY:
        _start()


def _start() -> None:
    """Start processes for the plans, once: they end with this one, whatever ends it."""
    if _assisting or _beside or not _plans or not sys.executable:
        return
    atexit.register(_end)
    for k in range(min(processors() - 1, _MOST)):
        code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import assist; assist({_plans!r}, {k})"
        quiet = subprocess.DEVNULL
        with suppress(OSError):  # no more processes: it takes longer alone
            command = [sys.executable, "-c", code]
            _beside.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=quiet, stderr=quiet))


def processors() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _end() -> None:
    for process in _beside:
        process.kill()
        process.wait()
        if process.stdin is not None:
            process.stdin.close()


def assist(plans: list[tuple[str, tuple[Any, ...]]], which: int) -> None:
    """Work through plans, in a further process: the first one from the beginning, the others from further on.

    There is one of each number for all processes that fill a cache. A job that needs what another process is compiling
    is put off until the next one is done.
    """
    global _assisting
    _assisting, place = True, folder()
    if place is None or not locks.acquire(place, f"{which:x}"):
        return
    end_with_parent(lambda: os._exit(0))
    jobs: list[Callable[[], Any]] = []
    for plan, settings in plans:
        module, _, function = plan.partition(":")
        made = getattr(importlib.import_module(module), function)(*settings)
        first = which * len(made) // (_MOST + 1)
        jobs += made[first:] + made[:first]
    while jobs:
        for k, job in enumerate(jobs):
            if _done(job):
                del jobs[k]
                break
        else:
            time.sleep(_PAUSE)


def _done(job: Callable[[], Any]) -> bool:
    """Do a job; False if another process is compiling what it needs."""
    try:
        with locks.impatient():
            job()
    except locks.LockedError:
        return False
    return True
