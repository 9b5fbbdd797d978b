"""The folder of compiled code."""

from __future__ import annotations

import os
import sys
import tempfile
from functools import cache
from pathlib import Path

from linkages.base.disk import cache_directory


def folder() -> Path | None:
    """Return the folder of compiled code: NUMBA_CACHE_DIR, the user's cache, or a temporary folder; None without any.

    Code is loaded from there, so it is a folder that no other user can write to.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    return _folder(Path(named) if named else cache_directory() / "compiled")


@cache
def _folder(wanted: Path) -> Path | None:
    problem = _made(wanted)
    if not problem:
        return wanted
    private = temporary_folder()
    if not _made(private, follow_symlinks=False):
        say(f"kept in {private}, because {problem}")
        return private
    say(f"not kept, because {problem}")
    return None


def temporary_folder() -> Path:
    """Return the name of the folder of compiled code that is used if the user's cache cannot be."""
    return Path(tempfile.gettempdir()) / f"linkages-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"


def _made(place: Path, follow_symlinks: bool = True) -> str:
    """Make a folder for this user alone; returns the reason why code cannot be kept there, "" if it can."""
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if os.name == "posix" and (foreign := _foreign(place, follow_symlinks)):
            return f"other users can write to {foreign}"
        with tempfile.TemporaryFile(dir=place):
            return ""
    except OSError:
        return f"{place} cannot be written"


def _foreign(place: Path, follow_symlinks: bool) -> Path | None:
    """Return the folder, or a subfolder or file of it that other users can reach, if they can write to it."""
    if _writable(place, follow_symlinks):
        return place
    if not place.stat().st_mode & 0o011:  # only its owner can enter it
        return None
    within = (path for pattern in ("??", "??/*.nbc") for path in place.glob(pattern))
    return next(filter(_writable, within), None)


def _writable(path: Path, follow_symlinks: bool = True) -> bool:
    """Check whether other users than this one and root can write to a path, or give themselves the right."""
    try:
        seen = path.stat(follow_symlinks=follow_symlinks)
    except FileNotFoundError:  # another process has just removed it
        return False
    return seen.st_uid not in (os.getuid(), 0) or bool(seen.st_mode & 0o022)


@cache
def say(how: str) -> None:
    """Print once that compiled code is not kept where it should be."""
    print(
        f"warning: compiled code is {how}; set NUMBA_CACHE_DIR to a folder that only you can write to", file=sys.stderr
    )
