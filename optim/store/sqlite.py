"""SQLite files: recognised by their first bytes, every row sealed by a checksum, with errors of one line."""

from __future__ import annotations

import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from linkages import InputError, RunError

SCHEMA = 2  # version of the tables
UNSEALED = 1  # the version before: no seals
APPLICATION = 0x6C6E6B73  # "lnks": tells a study from other SQLite files

#: SQLite's errors that are not of the file's content: there is no room, or others use it.
_TRANSIENT = (
    sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED, sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_NOMEM,
)  # fmt: skip


@contextmanager
def guarded(path: Path) -> Iterator[None]:
    """Turn SQLite's errors into one line.

    RunError if the disk is full or fails: committed content is kept. InputError if the file is damaged.
    """
    try:
        yield
    except (sqlite3.DatabaseError, UnicodeDecodeError) as problem:  # names that are no text any more
        if getattr(problem, "sqlite_errorcode", 0) & 0xFF in _TRANSIENT:
            raise RunError(
                f"{path}: {problem}; what it holds is kept: make room or wait, and continue with --resume"
            ) from None
        raise InputError(
            path, "", f"is damaged ({problem}); it was left as it is: restore it, or give another --out"
        ) from None


def check_header(path: Path) -> None:
    """Check the first bytes, before SQLite opens the file and perhaps changes it.

    InputError if it is no SQLite file, not a study's, or of another version.
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
    if schema not in (UNSEALED, SCHEMA):
        raise InputError(path, "", f"has version {schema} of the file format; this program reads version {SCHEMA}")


def put(db: sqlite3.Connection, table: str, columns: str, rows: Iterable[Sequence[Any]], how: str = "INSERT") -> None:
    """Store rows, each with its seal."""
    marks = ",".join("?" * (columns.count(",") + 2))
    db.executemany(f"{how} INTO {table} ({columns}, seal) VALUES ({marks})", ((*row, _seal(row)) for row in rows))


def _seal(row: Sequence[Any]) -> int:
    return zlib.crc32(repr(tuple(row)).encode())


def seal_all(db: sqlite3.Connection, tables: Mapping[str, str]) -> None:
    """Make a file of the version before one of this version; the first column of a table tells its rows apart."""
    if _version(db) == SCHEMA:
        return
    with db:
        db.execute("BEGIN")
        for table, columns in tables.items():
            db.execute(f"ALTER TABLE {table} ADD COLUMN seal INTEGER NOT NULL DEFAULT 0")
            rows = db.execute(f"SELECT {columns} FROM {table}").fetchall()
            key = columns.partition(",")[0]
            db.executemany(f"UPDATE {table} SET seal = ? WHERE {key} = ?", [(_seal(row), row[0]) for row in rows])
        db.execute(f"PRAGMA user_version = {SCHEMA}")


def _version(db: sqlite3.Connection) -> int:
    return int(db.execute("PRAGMA user_version").fetchone()[0])


def check_content(db: sqlite3.Connection, tables: Mapping[str, str]) -> None:
    """Check that the file is whole, and has these tables with these columns, and rows that are as they were stored.

    Rows of a file of the version before have no seal to be checked by. A DatabaseError names the fault.
    """
    found = db.execute("PRAGMA integrity_check(1)").fetchone()[0]
    if found != "ok":
        raise sqlite3.DatabaseError(found)
    sealed = _version(db) == SCHEMA
    for table, columns in tables.items():
        for *row, seal in db.execute(f"SELECT {columns}, {'seal' if sealed else 'NULL'} FROM {table}"):
            if sealed and seal != _seal(row):
                raise sqlite3.DatabaseError(f"a row of {table} is not as it was stored")
