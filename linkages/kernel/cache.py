"""Where compiled code is kept: shared by processes that write at once, aware of edits, and done without if need be.

Numba's own files have numbers, given by an index that is written before them: of two processes that save at once, one
can be given the other's code. Here the file of a signature is named after it, and tells what it holds.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from linkages.disk import keep, kept

#: The folders that hold kernels.
_HOLDERS = ("kernel", "laws", "integrate", "planar", "outputs", "results", "engines/compiled")


def cached(compiled: Any, function: Any) -> None:
    """Let the compiler's object of a function keep its code on disk."""
    try:
        compiled._cache = CodeCache(function)
    except RuntimeError:  # numba finds no place
        settings: Any = numba.config
        place, settings.CACHE_DIR = settings.CACHE_DIR, str(temporary_folder())
        try:
            compiled._cache = CodeCache(function)
        except RuntimeError:
            say("not kept")
        else:
            say(f"kept in {temporary_folder()}")
        finally:
            settings.CACHE_DIR = place


def temporary_folder() -> Path:
    """Where compiled code is kept if neither the package's folder nor the user's cache can be written.

    Only in a folder of the user's own, and nobody else's: code is loaded from there.
    """
    path = Path(tempfile.gettempdir()) / f"linkages-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    try:
        path.mkdir(mode=0o700, exist_ok=True)
        seen = path.lstat()
        if os.name == "posix" and (seen.st_uid != os.getuid() or seen.st_mode & 0o077 or path.is_symlink()):
            return Path(os.devnull)
    except OSError:
        return Path(os.devnull)
    return path


@cache
def say(how: str) -> None:
    """Say once that compiled code is not kept where it should be."""
    print(f"warning: compiled code is {how}; set NUMBA_CACHE_DIR to a folder that can be written", file=sys.stderr)


class CodeCache(FunctionCache):
    """Compiled code of one function, a file for each of its signatures.

    Raises
    ------
    RuntimeError
        If there is no folder that can be written.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        stamp = (numba.__version__, self._impl.locator.get_source_stamp(), _stamp())
        self._cache_file = CodeFiles(Path(self._cache_path) / self._impl.filename_base, repr(stamp).encode())

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save code; on a disk that is full it is lost."""
        try:
            super().save_overload(sig, data)
        except OSError as problem:
            say(f"not kept ({self._cache_path}: {problem.strerror})")


class CodeFiles:
    """Files with the code of a function: what numba asks of its own."""

    def __init__(self, base: Path, stamp: bytes) -> None:
        self._base, self._stamp = base, stamp

    def save(self, key: Any, data: Any) -> None:
        """Save the code of a signature, which is the first part of the key."""
        keep(self._path(key), self._stamp, dumps((key, data)))

    def load(self, key: Any) -> Any:
        """Load the code of a signature; None if there is none, or of another edition of the kernels."""
        content = kept(self._path(key), self._stamp)
        if content is None:
            return None
        try:
            found, data = pickle.loads(content)
        except (AttributeError, ImportError):  # of code of a user's own, whose types have other names now
            return None
        return data if found == key else None

    def flush(self) -> None:
        """Forget everything."""
        for path in self._base.parent.glob(f"{self._base.name}.*.nbc"):
            path.unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        return self._base.with_name(f"{self._base.name}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc")


@cache
def _stamp() -> str:
    """Hash of the text of all kernels."""
    here = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for holder in _HOLDERS:
        for path in sorted((here / holder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()
