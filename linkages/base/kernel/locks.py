"""Which process compiles which kernel: a lock for each, which ends with the process that holds it.

Processes that need the same code at once compile it once between them; a process that has other work does that first.
On a file system without locks each process compiles for itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from filelock import FileLock, Timeout

_LONGEST = 120.0  # s to wait for another process, which may have been stopped
_LOOK = 0.02  # s between two attempts to take a lock
_patience = ContextVar("patience", default=_LONGEST)
_held: dict[tuple[Path, str], FileLock] = {}  # by this process


def acquire(place: Path, name: str, patience: float = 0.0) -> bool:
    """Claim a name for this process, waiting so long [s] for another one that has it; False if that was too short."""
    if (place, name) in _held:
        return True
    with suppress(OSError, NotImplementedError):  # a file system without locks
        folder = place / "locks"
        folder.mkdir(exist_ok=True)
        lock = FileLock(folder / name, thread_local=False)
        try:
            lock.acquire(timeout=patience, poll_interval=_LOOK)
        except Timeout:
            return False
        _held[place, name] = lock
    return True


class LockedError(Exception):
    """Another process has claimed the kernel."""


@contextmanager
def impatient() -> Iterator[None]:
    """Raise `LockedError` rather than wait: there is other work."""
    before = _patience.set(0.0)
    try:
        yield
    finally:
        _patience.reset(before)


def wait_and_acquire(place: Path, name: str) -> None:
    """Claim a name as soon as no other process has it; do without if one has had it for too long.

    LockedError if another process has it, within `impatient`.
    """
    patience = _patience.get()
    if not acquire(place, name, patience) and not patience:
        raise LockedError


def release(place: Path, name: str) -> None:
    """Give up a claim."""
    lock = _held.pop((place, name), None)
    if lock is not None:
        lock.release()
        with suppress(OSError):
            Path(lock.lock_file).unlink()  # two processes that compile the same kernel would only lose time
