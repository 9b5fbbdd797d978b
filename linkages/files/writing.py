"""Atomic writing of files and folders."""

from __future__ import annotations

import errno
import json
import math
import re
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from linkages import disk
from linkages.errors import InputError, RunError
from linkages.signals import deferred

_NO_FILE_NAME = re.compile(r"[%/\\\0]")
_NO_ROOM = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO)


def file_name(name: str) -> str:
    """Encode the name of a link, joint or output as a file name; decode with `urllib.parse.unquote`.

    Examples
    --------
    >>> from linkages.files.writing import file_name
    >>> file_name("arm/link.x")
    'arm%2Flink.x'
    """
    return _NO_FILE_NAME.sub(lambda found: f"%{ord(found[0]):02X}", name)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Provide a temporary file that replaces `path` at the end of the block.

    Raises
    ------
    InputError
        If the place is not writable.
    RunError
        If the disk is full.
    """
    with errors_of_writing(path), disk.whole(path) as partial:
        yield partial


@contextmanager
def errors_of_writing(path: Path) -> Iterator[None]:
    """Convert an OSError of writing to an InputError, or to a RunError if the disk is full."""
    try:
        yield
    except OSError as problem:
        raise _refusal(path, problem) from None


def _refusal(path: Path, problem: OSError) -> InputError | RunError:
    """Distinguish a place that is not writable from a full disk."""
    text = f"cannot be written ({problem.strerror or problem})"
    return RunError(f"{path}: {text}") if problem.errno in _NO_ROOM else InputError("--out", str(path), text)


def json_text(content: Any, indent: int | None = None) -> str:
    """Return JSON with a final newline; non-finite numbers, which JSON lacks, become null.

    Parameters
    ----------
    content : dict, list, str, number or None
        Content of JSON types, and tuples.
    indent : int, optional
        Spaces for each level; default: one line.
    """
    try:
        return json.dumps(content, indent=indent, allow_nan=False) + "\n"
    except ValueError:
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
        Patterns of files of an earlier run, which are removed unless the current run writes them.

    Attributes
    ----------
    names : list of str
        Names of the written files in alphabetical order; set at the end.

    Raises
    ------
    InputError
        If the folder cannot be written.
    RunError
        If the disk is full.
    """

    def __init__(self, out: Path, stale: Sequence[str] = ()) -> None:
        self.out, self.stale = out, stale
        self.names: list[str] = []

    def __enter__(self) -> Path:
        try:
            self.out.mkdir(parents=True, exist_ok=True)
            for left in disk.abandoned(self.out, ".partial-*"):
                shutil.rmtree(left, ignore_errors=True)
            self.partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=self.out))
        except OSError as problem:
            raise _refusal(self.out, problem) from None
        return self.partial

    def __exit__(self, kind: type[BaseException] | None, problem: BaseException | None, _: object) -> None:
        try:
            if kind is None:
                with deferred(whole=True):
                    self._move()
        except OSError as refusal:
            problem = refusal
        finally:
            shutil.rmtree(self.partial, ignore_errors=True)
        if isinstance(problem, OSError):
            raise _refusal(self.out, problem) from None

    def _move(self) -> None:
        self.names = sorted(file.name for file in self.partial.iterdir())
        for old in {path for pattern in self.stale for path in self.out.glob(pattern)}:
            if old.is_dir():
                shutil.rmtree(old)
            elif old.name not in self.names:
                old.unlink()
        for name in self.names:
            (self.partial / name).replace(self.out / name)
