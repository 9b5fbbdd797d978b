"""`Parcel`: what many pieces of work for other processes share, such as a system; each process unpickles it once."""

from __future__ import annotations

import os
import pickle
import platform
from functools import lru_cache
from typing import Any

from linkages.base.errors import RunError
from linkages.base.packages import installed
from linkages.input.files.versions import determining

_KEPT = 8  # parcels that a process keeps: operating points of a study, and of the studies before


class Parcel:
    """An object that many requests share; another process unpickles it once and keeps it."""

    def __init__(self, content: Any) -> None:
        self.content = content
        self._pickled: bytes | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what another process makes the parcel of."""
        if self._pickled is None:
            self._pickled = _pickled(self.content)
        return _opened, (self._pickled, tuple(determining().items()))


@lru_cache(maxsize=_KEPT)
def _opened(pickled: bytes, there: tuple[tuple[str, str], ...]) -> Parcel:
    """Unpickle a parcel of a process with these package versions; RunError if they are others here."""
    here = determining()
    for package, version in there:
        if here[package] != version:
            raise RunError(
                f"worker process {os.getpid()} on {platform.node()} has {package} {here[package]}, and {version} is"
                " needed; install the same version"
            )
    return Parcel(pickle.loads(pickled))


def _pickled(content: Any) -> bytes:
    """Pickle an object; functions of a user's script, such as laws, by their code."""
    try:
        pickled = pickle.dumps(content, protocol=pickle.HIGHEST_PROTOCOL)
    except (pickle.PicklingError, AttributeError):
        if not installed("cloudpickle"):
            raise
        pickled = b"__main__"
    if b"__main__" in pickled and installed("cloudpickle"):
        import cloudpickle

        pickled = cloudpickle.dumps(content)
    return pickled
