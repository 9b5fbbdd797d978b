"""SQLite files: recognised by their first bytes, checked, with errors of one line."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from linkages import InputError, RunError

SCHEMA = 1  # version of the tables
APPLICATION = 0x6C6E6B73  # "lnks": tells a study from other SQLite files


@contextmanager
def guarded(path: Path) -> Iterator[None]:
    """Turn SQLite's errors into one line.

    Raises
    ------
    RunError
        If the disk is full or fails: what was committed is kept.
    InputError
        If the file is damaged.
    """
    try:
        yield
    except sqlite3.OperationalError as problem:
        raise RunError(
            f"{path}: {problem}; what it holds is kept: make room or wait, and continue with --resume"
        ) from None
    except sqlite3.DatabaseError as problem:
        raise InputError(
            path, "", f"is damaged ({problem}); it was left as it is: restore it, or give another --out"
        ) from None


def check_header(path: Path) -> None:
    """Check the first bytes, before SQLite opens the file and perhaps changes it.

    Raises
    ------
    InputError
        If it is no SQLite file, not a study's, or of another version.
    """
    try:
        with open(path, "rb") as file:
            header = file.read(100)
    except OSError as problem:
        raise InputError(path, "", f"cannot be read ({problem.strerror})") from None
    if header[:16] != b"SQLite format 3\0":
        raise InputError(path, "", "is not the file of a study, or its beginning is damaged")
    application, schema = int.from_bytes(header[68:72], "big"), int.from_bytes(header[60:64], "big")
    if application != APPLICATION:
        raise InputError(path, "", "is an SQLite file, but not that of a study")
    if schema != SCHEMA:
        raise InputError(path, "", f"has version {schema} of the file format; this program reads version {SCHEMA}")


def check_content(db: sqlite3.Connection, tables: Iterable[str]) -> None:
    """Check that the file is whole and has these tables.

    Raises
    ------
    sqlite3.DatabaseError
        Naming what is wrong.
    """
    found = db.execute("PRAGMA quick_check(1)").fetchone()[0]
    if found != "ok":
        raise sqlite3.DatabaseError(found)
    there = {row[0] for row in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    for table in tables:
        if table not in there:
            raise sqlite3.DatabaseError(f"it has no table {table}")
