"""Compiled code on disk, by fingerprint: shared by processes, environments and checkouts.

The name of a file is a digest of the function's fingerprint and types. A file therefore never becomes out of date.
"""

from __future__ import annotations

import os
import pickle
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

from linkages.base.disk import keep, kept
from linkages.base.kernel.folder import folder, say
from linkages.base.kernel.private import Stored

_UNUSED = 60 * 86400.0  # s after which code that no process has loaded is removed
_FRESH = 86400.0  # s after which a loaded file is marked as used again


def read(name: str) -> Stored | None:
    """Read the code with this name; None if there is none, or it is damaged."""
    place = folder()
    content = None if place is None else kept(_path(place, name), name.encode())
    if place is None or content is None:
        return None
    with suppress(OSError):
        if time.time() - _path(place, name).stat().st_mtime > _FRESH:
            os.utime(_path(place, name))
    try:
        return Stored(*pickle.loads(content))
    except Exception:  # of another program: compiled again
        return None


def write(name: str, stored: Stored) -> None:
    """Write code under this name; if the disk is full, print a warning."""
    place = folder()
    if place is None:
        return
    try:
        keep(_path(place, name), name.encode(), pickle.dumps((stored.content, sorted(stored.symbols))))
    except OSError as problem:
        say(f"not kept ({place}: {problem.strerror})")
    _prune(place)


def _path(place: Path, name: str) -> Path:
    return place / name[:2] / f"{name[2:]}.nbc"


@cache
def _prune(place: Path) -> None:
    """Remove, once in a process, files that no process has used for long."""
    for path in (*place.glob("??/*.nbc"), *place.glob("locks/*")):
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > _UNUSED:
                path.unlink()
