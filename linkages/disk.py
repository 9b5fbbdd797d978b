"""What is written to disk: whole or not at all; what is kept there between runs is read only if it is sound."""

from __future__ import annotations

import glob
import hashlib
import os
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import platformdirs

_DIGEST = hashlib.sha256().digest_size
_ABANDONED = 3600.0  # s since the last change of what a killed process left


def cache_directory() -> Path:
    """Return the folder for results that are kept between runs: LINKAGES_CACHE, or the platform's user cache."""
    named = os.environ.get("LINKAGES_CACHE")
    return Path(named) if named else platformdirs.user_cache_path("linkages", appauthor=False)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Give a name to write to; what was written there takes the place of `path` at the end, unless an error comes.

    Processes that write one file at once do not meet: the last one stays. What killed ones have left is removed.
    """
    for left in abandoned(path.parent, f".{glob.escape(path.name)}.*.partial*"):
        left.unlink(missing_ok=True)
    partial = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.partial")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def abandoned(folder: Path, pattern: str) -> list[Path]:
    """Find what matches a pattern and has not changed for so long that nobody can be at work on it."""
    found = []
    for path in folder.glob(pattern):
        with suppress(FileNotFoundError):  # of a process that has just finished
            if time.time() - path.stat().st_mtime > _ABANDONED:
                found.append(path)
    return found


def keep(path: Path, identity: bytes, content: bytes) -> None:
    """Store a content, with the identity of what it was made from, for `kept`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as partial:
        partial.write_bytes(hashlib.sha256(identity + content).digest() + content)


def kept(path: Path, identity: bytes) -> bytes | None:
    """Return the content that `keep` stored; None if it is not there, not sound, or of another identity."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    content = data[_DIGEST:]
    return content if hashlib.sha256(identity + content).digest() == data[:_DIGEST] else None
