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
from zipfile import ZIP_DEFLATED, ZipFile

from linkages.base.disk import keep, kept
from linkages.base.kernel import shipped
from linkages.base.kernel.fingerprint import versions
from linkages.base.kernel.folder import folder, say
from linkages.base.kernel.private import Stored

_UNUSED = 60 * 86400.0  # s after which code that no process has loaded is removed
_FRESH = 86400.0  # s after which a loaded file is marked as used again


def read(name: str) -> Stored | None:
    """Read the code with this name; None if there is none, or it is damaged."""
    content = shipped.read(name) if name in shipped.names() else _kept(name)
    if content is None:
        return None
    try:
        return Stored(*pickle.loads(content))
    except Exception:  # of another program: compiled again
        return None


def _kept(name: str) -> bytes | None:
    """Read a file, and mark it as used."""
    place = folder()
    if place is None:
        return None
    with suppress(OSError):
        if time.time() - _path(place, name).stat().st_mtime > _FRESH:
            os.utime(_path(place, name))
    return kept(_path(place, name), name.encode())


def write(name: str, stored: Stored) -> None:
    """Write code under this name; if the disk is full, print a warning."""
    place = folder()
    if place is None:
        return
    try:
        _path(place, name).parent.mkdir(mode=0o700, exist_ok=True)
        keep(_path(place, name), name.encode(), pickle.dumps((stored.content, sorted(stored.symbols))))
    except OSError as problem:
        say(f"not kept ({place}: {problem.strerror})")
    _prune(place)


def pack(place: Path, archive: Path) -> None:
    """Write the code of a folder to an archive for `linkages.base.kernel.shipped`."""
    with ZipFile(archive, "w", ZIP_DEFLATED, compresslevel=9) as packed:
        for path in sorted(place.glob("??/*.nbc")):
            name = path.parent.name + path.stem
            packed.writestr(name, kept(path, name.encode()) or b"")
        packed.comment = versions().encode()


def _path(place: Path, name: str) -> Path:
    return place / name[:2] / f"{name[2:]}.nbc"


@cache
def _prune(place: Path) -> None:
    """Remove, once in a process, files that no process has used for long."""
    for path in (*place.glob("??/*.nbc"), *place.glob("locks/*")):
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > _UNUSED:
                path.unlink()
