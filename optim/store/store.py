"""`Store`: an SQLite file that keeps every evaluation and every iteration of a study as they come.

A population is one transaction; the file is in write-ahead mode, so that committed content survives a killed process
and others can read meanwhile; on a network file system in rollback mode, where a reader may have to wait. Numbers are
kept exactly, as little-endian float64; nothing is ever unpickled. Every row has a checksum, and a file with a row that
does not fit its own is refused: a changed number looks like any other.

| table       | row                                                                                            |
|-------------|------------------------------------------------------------------------------------------------|
| meta        | key, JSON: task, versions, names of the columns, elapsed time                                   |
| evaluations | design, objectives, constraints (in the file's units), status, reason; in the order of asking   |
| iterations  | best designs and their objectives, the algorithm's state as JSON                                |
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError
from linkages.base.disk import on_network
from linkages.input.files.writing import whole
from optim.evaluate.evaluations import OK, Evaluations
from optim.problem.study import Array
from optim.store.sqlite import APPLICATION, SCHEMA, check_content, check_header, guarded, put, seal_all

_TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL, seal INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE evaluations (
    id INTEGER PRIMARY KEY, design BLOB NOT NULL UNIQUE, objectives BLOB NOT NULL, constraints BLOB NOT NULL,
    status TEXT NOT NULL, reason TEXT NOT NULL, seal INTEGER NOT NULL);
CREATE TABLE iterations (
    step INTEGER PRIMARY KEY, iteration INTEGER NOT NULL, iterations INTEGER NOT NULL, evaluations INTEGER NOT NULL,
    best BLOB NOT NULL, objectives BLOB NOT NULL, violation BLOB NOT NULL, state TEXT NOT NULL,
    seal INTEGER NOT NULL);
"""

#: Columns of each table; the seal of a row is a checksum of them.
COLUMNS = {
    "meta": "key, value",
    "evaluations": "design, objectives, constraints, status, reason",
    "iterations": "step, iteration, iterations, evaluations, best, objectives, violation, state",
}


@dataclass(frozen=True)
class Iteration:
    """State of an algorithm after an iteration."""

    step: int  # number among all that were reported
    iteration: int  # the algorithm's own number of it
    iterations: int  # how many there are at most
    evaluations: int  # designs evaluated so far
    best: Array  # (k, n) best designs
    objectives: Array  # (k, no) theirs, smaller is better
    violation: Array  # (k,)
    state: str  # JSON

    def same(self, other: Iteration) -> bool:
        """Whether two iterations agree to the last bit."""
        return all(
            a.tobytes() == b.tobytes() if isinstance(a, np.ndarray) else a == b
            for a, b in ((getattr(self, key), getattr(other, key)) for key in self.__dataclass_fields__)
        )


class Store:
    """A study's file; made by `create`, `open_store` and `optim.read_store`.

    Attributes
    ----------
    path : Path
        The file.
    variables, objectives, constraints : list of str
        Paths of the variables, names of the others.
    """

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._db = connection
        self.variables: list[str] = self.meta("variables")
        self.objectives: list[str] = self.meta("objectives")
        self.constraints: list[str] = self.meta("constraints")

    def close(self) -> None:
        """Close the file; the write-ahead log goes into it."""
        self._db.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def meta(self, key: str) -> Any:
        """Return one of the values given to `create`."""
        rows = self._rows("SELECT value FROM meta WHERE key = ?", key)
        if not rows:
            raise InputError(self.path, key, "is missing: the file is damaged")
        return json.loads(rows[0][0])

    def add(self, designs: Array, found: Evaluations, elapsed: float) -> None:
        """Store a population, whole or not at all; `elapsed` is the study's time so far [s]."""
        blobs = (map(_blob, numbers) for numbers in (designs, found.objectives, found.constraints))
        rows = zip(*blobs, found.status, found.reason, strict=True)
        self._insert("evaluations", rows, elapsed)

    def evaluations(self) -> tuple[Array, Evaluations]:
        """Return every design (m, n), in the order of the requests, and its evaluation."""
        rows = self._rows(f"SELECT {COLUMNS['evaluations']} FROM evaluations ORDER BY id")
        *blobs, status, reason = ([row[k] for row in rows] for k in range(5))
        widths = (len(names) for names in (self.variables, self.objectives, self.constraints))
        designs, objectives, constraints = map(self._matrix, blobs, widths)
        return designs, Evaluations(objectives, constraints, tuple(status), tuple(reason))

    def count(self) -> tuple[int, dict[str, int]]:
        """Count evaluations, and, by status, the failed ones."""
        rows = self._rows("SELECT status, COUNT(*) FROM evaluations GROUP BY status ORDER BY 1")
        return sum(n for _, n in rows), {status: n for status, n in rows if status != OK}

    def iteration(self, step: int) -> Iteration | None:
        """Return an iteration, if it is stored."""
        return next(iter(self._iterations("WHERE step = ?", step)), None)

    def add_iteration(self, row: Iteration, elapsed: float) -> None:
        """Store an iteration."""
        values = [_blob(x) if isinstance(x, np.ndarray) else x for x in vars(row).values()]
        self._insert("iterations", [values], elapsed)

    def iterations(self) -> list[Iteration]:
        """Return every iteration, in order."""
        return self._iterations("ORDER BY step")

    def _rows(self, query: str, *arguments: Any) -> list[Any]:
        with guarded(self.path):
            return self._db.execute(query, arguments).fetchall()

    def _insert(self, table: str, rows: Iterable[Sequence[Any]], elapsed: float) -> None:
        with guarded(self.path), self._db:
            put(self._db, table, COLUMNS[table], rows)
            put(self._db, "meta", COLUMNS["meta"], [("elapsed", json.dumps(elapsed))], "INSERT OR REPLACE")

    def _iterations(self, which: str, *arguments: int) -> list[Iteration]:
        found, rows = [], self._rows(f"SELECT {COLUMNS['iterations']} FROM iterations {which}", *arguments)
        for step, number, total, count, *blobs, state in rows:
            best, objectives, violation = (_array(blob, self.path) for blob in blobs)
            best = best.reshape(-1, len(self.variables))
            objectives = objectives.reshape(-1, len(self.objectives))
            found.append(Iteration(step, number, total, count, best, objectives, violation, state))
        return found

    def _matrix(self, blobs: Sequence[bytes], width: int) -> Array:
        arrays = [_array(blob, self.path) for blob in blobs]
        if any(len(array) != width for array in arrays):
            raise InputError(self.path, "", "is damaged: a row has the wrong length")
        return np.array(arrays).reshape(len(arrays), width)


def create(path: Path, meta: dict[str, Any]) -> Store:
    """Create the file of a study.

    `meta` has JSON types; "variables", "objectives" and "constraints" name the columns. InputError if the file exists
    already, RunError if it cannot be written.
    """
    if path.exists():
        raise InputError(path, "", "exists already")
    with whole(path) as partial, guarded(path):
        db = _connect(partial)
        db.executescript(f"PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {SCHEMA}; {_TABLES}")
        with db:
            put(db, "meta", COLUMNS["meta"], [(k, json.dumps(v)) for k, v in meta.items()])
        db.close()
    return open_store(path)


def open_store(path: Path) -> Store:
    """Open the file of a study to continue it; InputError if it is none, is damaged, or of another version."""
    check_header(path)
    with guarded(path):
        db = _connect(path)
        network = on_network(path)  # without the shared memory of the write-ahead log
        db.execute(f"PRAGMA journal_mode = {'DELETE' if network else 'WAL'}")
        db.execute(f"PRAGMA synchronous = {'FULL' if network else 'NORMAL'}")
        check_content(db, COLUMNS)
        seal_all(db, COLUMNS)
    return Store(path, db)


def read_store(path: Path) -> Store:
    """Open the file of a study to read it, even while another process writes; errors as `open_store`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "study.sqlite"
    >>> result = optim.optimise(study, file, algorithm={"name": "ga", "population": 4, "generations": 1})
    >>> with optim.read_store(file) as store:
    ...     designs, found = store.evaluations()
    >>> len(designs) == result["evaluations"]
    True
    """
    check_header(path)
    with guarded(path):
        # a shared file with the writer, unless the folder is read-only
        alone = not os.access(path.parent, os.W_OK) and not path.with_name(path.name + "-wal").exists()
        db = sqlite3.connect(f"{path.resolve().as_uri()}?{'immutable=1' if alone else 'mode=ro'}", uri=True)
        check_content(db, COLUMNS)
    return Store(path, db)


def _connect(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, timeout=10.0)


def _blob(array: Array) -> bytes:
    return np.ascontiguousarray(array, dtype="<f8").tobytes()


def _array(blob: bytes, path: Path) -> Array:
    if not isinstance(blob, bytes) or len(blob) % 8:
        raise InputError(path, "", "is damaged: a row has the wrong length")
    return np.frombuffer(blob, dtype="<f8").astype(np.float64)
