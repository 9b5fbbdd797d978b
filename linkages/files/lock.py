"""One process at a time: an advisory lock that ends with the process that holds it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import BinaryIO

from linkages.errors import InputError

if os.name == "nt":
    import msvcrt

    def _acquire(file: BinaryIO) -> None:
        file.seek(1 << 20)  # far behind the text: other processes can still read who holds it
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]

else:
    import fcntl

    def _acquire(file: BinaryIO) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


class Lock:
    """Held from entry to exit; a process that dies, however, holds it no longer.

    The file stays when the lock is released: removing it would let two processes lock two files of one name.

    Raises
    ------
    InputError
        On entry, if another process holds it, or it cannot be made.
    """

    def __init__(self, path: Path, what: Path) -> None:
        self.path = path
        self.what = what

    def __enter__(self) -> Lock:
        try:
            self._file = open(self.path, "a+b")  # open as long as the lock is held
        except OSError as problem:
            raise InputError(self.path, "", f"cannot be written ({problem.strerror})") from None
        try:
            _acquire(self._file)
        except OSError:
            self._file.seek(0)
            holder = self._file.read(20).decode(errors="replace").strip()
            self._file.close()
            by = f"process {holder}" if holder else "another process"
            refusal = f"is in use by {by}; wait for it, or give another --out"
            raise InputError(self.what, "", refusal) from None
        with contextlib.suppress(OSError):  # a full disk: held all the same, but nobody learns by whom
            self._file.truncate(0)
            self._file.write(str(os.getpid()).encode())
            self._file.flush()
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
