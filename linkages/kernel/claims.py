"""Who compiles what: a claim is a lock on a byte of a file in the cache's folder, gone with the process that holds it.

So processes that need the same code at once compile it once between them; one that has other work does that first.
Where there are no such locks, each compiles for itself.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from pathlib import Path

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows
    fcntl = None  # type: ignore[assignment]

_LONGEST = 120.0  # s that another process is waited for: it may have been stopped
_LOOK = 0.02  # s between two looks
_patient = ContextVar("patient", default=True)
_held: set[tuple[Path, str]] = set()  # by this process


def claim(place: Path, name: str) -> bool:
    """Claim a name for this process; False if another one has it."""
    if not _lock(place, name, True):
        return False
    _held.add((place, name))
    return True


class ClaimedError(Exception):
    """Another process has claimed what is needed."""


@contextmanager
def impatient() -> Iterator[None]:
    """Raise `ClaimedError` rather than wait: there is other work."""
    before = _patient.set(False)
    try:
        yield
    finally:
        _patient.reset(before)


def wait_and_claim(place: Path, name: str) -> None:
    """Claim a name as soon as no other process has it; do without if one has had it for too long.

    Raises
    ------
    ClaimedError
        If another process has it, within `impatient`.
    """
    end = time.monotonic() + _LONGEST
    while not claim(place, name) and time.monotonic() < end:
        if not _patient.get():
            raise ClaimedError
        time.sleep(_LOOK)


def release(place: Path, name: str) -> None:
    """Give up a claim."""
    if (place, name) in _held:
        _held.remove((place, name))
        _lock(place, name, False)


def release_all() -> None:
    """Give up all claims, where compilation has failed."""
    for place, name in tuple(_held):
        release(place, name)


@cache
def _file(place: Path) -> int:
    """Open the file of claims; open for good, as closing it would give up all of them."""
    return os.open(place / "claims", os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)


def _lock(place: Path, name: str, take: bool) -> bool:
    """Lock a name's byte or unlock it; False if another process holds it."""
    if fcntl is None:
        return True
    byte = int(name[:15], 16)
    with suppress(OSError):  # a file system without locks
        descriptor = _file(place)
        try:
            fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB if take else fcntl.LOCK_UN, 1, byte)
        except (BlockingIOError, PermissionError):  # POSIX leaves the choice between the two
            return False
    return True
