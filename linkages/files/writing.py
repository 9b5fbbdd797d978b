"""Files and folders that are written whole or not at all."""

from __future__ import annotations

import json
import math
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from linkages.errors import InputError, RunError


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


def json_text(content: Any, indent: int | None = None) -> str:
    """Return JSON and a line's end; numbers that are not finite, which JSON does not have, become null.

    Parameters
    ----------
    content : dict, list, str, number or None
        What JSON has, and tuples.
    indent : int, optional
        Spaces for each level; default all in one line.
    """
    return json.dumps(_finite(content), indent=indent, allow_nan=False) + "\n"


def _finite(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content


class OutputFolder:
    """Collects files in a hidden folder and moves them into place together at the end.

    Parameters
    ----------
    out : Path
    stale : sequence of str
        Patterns of files that an earlier run may have left there: they are removed where this one writes none.

    Attributes
    ----------
    names : list of str
        What was written, in the order of the alphabet; known at the end.

    Raises
    ------
    InputError
        On entry, if the folder cannot be written.
    """

    def __init__(self, out: Path, stale: Sequence[str] = ()) -> None:
        self.out, self.stale = out, stale
        self.names: list[str] = []

    def __enter__(self) -> Path:
        try:
            self.out.mkdir(parents=True, exist_ok=True)
            self.partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=self.out))
        except OSError as problem:
            raise InputError("--out", str(self.out), f"cannot be written ({problem.strerror})") from None
        return self.partial

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.names = sorted(file.name for file in self.partial.iterdir())
            for old in {path for pattern in self.stale for path in self.out.glob(pattern)}:
                if old.name not in self.names:
                    old.unlink()
            for name in self.names:
                (self.partial / name).replace(self.out / name)
        shutil.rmtree(self.partial, ignore_errors=True)
