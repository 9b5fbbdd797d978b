"""One process at a time: an advisory lock that ends with the process that holds it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import filelock

from linkages.errors import InputError


@contextmanager
def locked(path: Path, content: Path) -> Iterator[None]:
    """Hold a lock until the end of the block; it ends with the process.

    Parameters
    ----------
    path : Path
        File of the lock.
    content : Path
        File that the lock protects, for the message.

    Raises
    ------
    InputError
        If another process or thread holds the lock, or if its file cannot be written.
    """
    lock = filelock.FileLock(path, blocking=False)
    try:
        lock.acquire()
    except filelock.Timeout:
        refusal = "is in use by another process; wait for it, or give another --out"
        raise InputError(content, "", refusal) from None
    except OSError as problem:
        raise InputError(path, "", f"cannot be written ({problem.strerror})") from None
    try:
        yield
    finally:
        lock.release()
