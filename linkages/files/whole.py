"""Files that are written whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from linkages.errors import RunError


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Give a name to write to; what was written there takes the place of `path` at the end.

    Raises
    ------
    RunError
        If it cannot be written: the disk may be full.
    """
    partial = path.with_name(f".{path.name}.partial")
    try:
        yield partial
        partial.replace(path)
    except OSError as problem:
        raise RunError(f"{path}: cannot be written ({problem.strerror})") from None
    finally:
        partial.unlink(missing_ok=True)
