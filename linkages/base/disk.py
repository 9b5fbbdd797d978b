"""Atomic writing of files, and a cache on disk whose entries are verified when read."""

from __future__ import annotations

import errno
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
#: Beginnings of the names of network file systems.
_NETWORKS = ("nfs", "cifs", "smb", "lustre", "gpfs", "beegfs", "ceph", "afs", "sshfs", "glusterfs", "pvfs2", "panfs")
_ABANDONED = 3600.0  # age of a temporary file after which its process counts as killed [s]


def cache_directory() -> Path:
    """Return the folder for results cached between runs: LINKAGES_CACHE, or the platform's user cache."""
    named = os.environ.get("LINKAGES_CACHE")
    return Path(named) if named else platformdirs.user_cache_path("linkages", appauthor=False)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Provide a temporary file that replaces `path` at the end of the block, unless an error occurs.

    Concurrent writers are safe; the last one wins. Files left by killed processes are removed.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    for left in abandoned(path.parent, f".{glob.escape(path.name)}.*.partial*"):
        left.unlink(missing_ok=True)
    partial = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.partial")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def on_network(path: Path, mounts: Path = Path("/proc/mounts")) -> bool:
    """Tell whether a path is on a network file system, as far as the system lists its mounts.

    Processes on other computers see its files, but share neither memory nor all kinds of locks.
    """
    try:
        lines = [line.split() for line in mounts.read_text(encoding="utf-8").splitlines()]
    except OSError:  # not Linux
        return False
    place = path.absolute().resolve()
    found = [(len(where), kind) for _, where, kind, *_ in lines if place.is_relative_to(where)]
    return bool(found) and max(found)[1].removeprefix("fuse.").startswith(_NETWORKS)


def abandoned(folder: Path, pattern: str) -> list[Path]:
    """Find the files that match a pattern and were last changed long ago, so that no process writes them."""
    found = []
    for path in folder.glob(pattern):
        with suppress(FileNotFoundError):  # file of a process that has just ended
            if time.time() - path.stat().st_mtime > _ABANDONED:
                found.append(path)
    return found


def keep(path: Path, identity: bytes, content: bytes) -> None:
    """Store a content with the identity of its source, for `kept`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as partial:
        partial.write_bytes(hashlib.sha256(identity + content).digest() + content)


def kept(path: Path, identity: bytes) -> bytes | None:
    """Return the content that `keep` stored; None if it is missing, damaged, or has another identity."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    content = data[_DIGEST:]
    return content if hashlib.sha256(identity + content).digest() == data[:_DIGEST] else None
