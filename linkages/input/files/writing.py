"""Atomic writing of files and folders, and a lock against a second writer."""

from __future__ import annotations

import errno
import json
import math
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from linkages.base import disk
from linkages.base.errors import InputError, RunError
from linkages.base.signals import deferred

_NO_FILE_NAME = re.compile(r"[%/\\\0]")
_NO_ROOM = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO)


def file_name(name: str) -> str:
    """Encode the name of a link, joint or output as a file name; decode with `urllib.parse.unquote`.

    Examples
    --------
    >>> from linkages.input.files.writing import file_name
    >>> file_name("arm/link.x")
    'arm%2Flink.x'
    """
    return _NO_FILE_NAME.sub(lambda found: f"%{ord(found[0]):02X}", name)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Provide a temporary file that replaces `path` at the end of the block; errors as `errors_of_writing`."""
    with errors_of_writing(path), disk.whole(path) as partial:
        yield partial


@contextmanager
def errors_of_writing(path: Path) -> Iterator[None]:
    """Convert an OSError of writing to an InputError, or to a RunError if the disk is full."""
    try:
        yield
    except OSError as problem:
        text = f"cannot be written ({problem.strerror or problem})"
        full = problem.errno in _NO_ROOM
        raise (RunError(f"{path}: {text}") if full else InputError("--out", str(path), text)) from None


@contextmanager
def locked(path: Path, content: Path) -> Iterator[None]:
    """Hold a lock, a file at `path`, until the end of the block or of the process.

    Raises
    ------
    InputError
        If another process or thread holds it (the message names `content`, which it protects), or the file cannot be
        written.
    """
    import filelock  # 50 ms of import time

    lock = filelock.FileLock(path, blocking=False)
    with errors_of_writing(path):
        try:
            lock.acquire()
        except filelock.Timeout:  # an OSError
            refusal = "is in use by another process; wait for it, or give another --out"
            raise InputError(content, "", refusal) from None
    try:
        yield
    finally:
        lock.release()


def json_text(content: Any, indent: int | None = None) -> str:
    """Return JSON with a final newline, in one line without `indent`; numbers that are not finite become null."""
    content = content_of(content)
    try:
        return json.dumps(content, indent=indent, allow_nan=False) + "\n"
    except ValueError:
        return json.dumps(_finite(content), indent=indent, allow_nan=False) + "\n"


def write_json(path: Path, content: Any, indent: int | None = 1) -> None:
    """Write a JSON file, whole or not at all; see `json_text`. OSErrors are the caller's, such as `OutputFolder`."""
    with disk.whole(path) as partial:
        partial.write_text(json_text(content, indent), encoding="utf-8")


def finite(value: float) -> float | None:
    """Return a number as JSON knows it: None where it is not finite."""
    return float(value) if math.isfinite(value) else None


def _finite(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content


class OutputFolder:
    """Collects files in a hidden folder and moves them into `path` together at the end; errors as `errors_of_writing`.

    Files that match patterns of `stale`, from an earlier run, are removed unless the current run writes them. At the
    end `names` has the written files in alphabetical order.
    """

    def __init__(self, path: Path, stale: Sequence[str] = ()) -> None:
        self.path, self.stale = path, stale
        self.names: list[str] = []

    def __enter__(self) -> Path:
        with errors_of_writing(self.path):
            self.path.mkdir(parents=True, exist_ok=True)
            for left in disk.abandoned(self.path, ".partial-*"):
                shutil.rmtree(left, ignore_errors=True)
            self.partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=self.path))
        return self.partial

    def __exit__(self, kind: type[BaseException] | None, problem: BaseException | None, _: object) -> None:
        try:
            with errors_of_writing(self.path):
                if isinstance(problem, OSError):
                    raise problem
                if kind is None:
                    with deferred(whole=True):
                        self._move()
        finally:
            shutil.rmtree(self.partial, ignore_errors=True)

    def _move(self) -> None:
        self.names = sorted(file.name for file in self.partial.iterdir())
        for old in {path for pattern in self.stale for path in self.path.glob(pattern)}:
            if old.is_dir():
                shutil.rmtree(old)
            elif old.name not in self.names:
                old.unlink()
        for name in self.names:
            (self.partial / name).replace(self.path / name)


def content_of(value: Any) -> Any:
    """Return a value with entries as dicts, at any depth."""
    if isinstance(value, Mapping):
        return {key: content_of(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [content_of(one) for one in value]
    return value
