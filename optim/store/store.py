"""`Store`: an SQLite file that keeps every evaluation and every iteration of a study as they come.

A population is one transaction; the file is in write-ahead mode, so that what is committed survives a killed process
and others can read meanwhile. Numbers are kept exactly, as little-endian float64; nothing is ever unpickled.

| table       | row                                                                                            |
|-------------|------------------------------------------------------------------------------------------------|
| meta        | key, JSON: task, versions, names of the columns, elapsed time                                   |
| evaluations | design, objectives, constraints (in the file's units), status, reason; in the order of asking   |
| iterations  | best designs and their objectives, the algorithm's state as JSON                                |
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError
from linkages.files.writing import whole
from optim.evaluate.evaluations import OK, Evaluations
from optim.evaluate.limits import FEASIBLE
from optim.problem.study import Array
from optim.store.sqlite import APPLICATION, SCHEMA, check_content, check_header, guarded

TABLES = ("meta", "evaluations", "iterations")

_TABLES = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE evaluations (
    id INTEGER PRIMARY KEY, design BLOB NOT NULL UNIQUE, objectives BLOB NOT NULL, constraints BLOB NOT NULL,
    status TEXT NOT NULL, reason TEXT NOT NULL);
CREATE TABLE iterations (
    step INTEGER PRIMARY KEY, iteration INTEGER NOT NULL, iterations INTEGER NOT NULL, evaluations INTEGER NOT NULL,
    best BLOB NOT NULL, objectives BLOB NOT NULL, violation BLOB NOT NULL, state TEXT NOT NULL);
"""


@dataclass(frozen=True)
class Iteration:
    """State of an algorithm after an iteration.

    Attributes
    ----------
    step : int
        Number among all that were reported.
    iteration, iterations : int
        The algorithm's own number of it, and how many there are at most.
    evaluations : int
        Designs asked for so far.
    best : (k, n) array
        Best designs.
    objectives : (k, no) array
        Theirs, smaller is better.
    violation : (k,) array
    state : str
        JSON.
    """

    step: int
    iteration: int
    iterations: int
    evaluations: int
    best: Array
    objectives: Array
    violation: Array
    state: str

    @property
    def best_feasible(self) -> Array:
        """Least value of each objective (no,) among the best designs that satisfy the constraints; NaN if none does."""
        feasible = self.objectives[self.violation <= FEASIBLE]
        return feasible.min(axis=0) if len(feasible) else np.full(self.objectives.shape[1], np.nan)

    def same(self, other: Iteration) -> bool:
        """Whether two iterations agree to the last bit."""
        return all(
            a.tobytes() == b.tobytes() if isinstance(a, np.ndarray) else a == b
            for a, b in ((getattr(self, key), getattr(other, key)) for key in self.__dataclass_fields__)
        )


class Store:
    """A study's file; see `create`, `open_store` and `read_store`."""

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

    # -- the study itself -------------------------------------------------------------------------

    def meta(self, key: str) -> Any:
        """Return one of the values given to `create`."""
        with guarded(self.path):
            row = self._db.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
        if row is None:
            raise InputError(self.path, key, "is missing: the file is damaged")
        return json.loads(row[0])

    # -- evaluations -------------------------------------------------------------------------------

    def add(self, designs: Array, found: Evaluations, elapsed: float) -> None:
        """Store a population, whole or not at all; `elapsed` is the study's time so far [s]."""
        rows = [
            (_blob(x), _blob(f), _blob(g), status, reason)
            for x, f, g, status, reason in zip(
                designs, found.objectives, found.constraints, found.status, found.reason, strict=True
            )
        ]
        with guarded(self.path), self._db:
            self._db.executemany(
                "INSERT INTO evaluations (design, objectives, constraints, status, reason) VALUES (?,?,?,?,?)",
                rows,
            )
            self._set("elapsed", elapsed)

    def evaluations(self) -> tuple[Array, Evaluations]:
        """Every design (m, n), in the order of asking, and its evaluation."""
        with guarded(self.path):
            rows = self._db.execute(
                "SELECT design, objectives, constraints, status, reason FROM evaluations ORDER BY id"
            ).fetchall()
        designs = self._matrix([row[0] for row in rows], len(self.variables))
        return designs, self._evaluations([row[1:] for row in rows])

    def count(self) -> tuple[int, dict[str, int]]:
        """Count evaluations, and those that are not ok by status."""
        with guarded(self.path):
            rows = self._db.execute(
                "SELECT status, COUNT(*) FROM evaluations GROUP BY status ORDER BY 1"
            ).fetchall()
        return sum(n for _, n in rows), {status: n for status, n in rows if status != OK}

    # -- iterations --------------------------------------------------------------------------------

    def iteration(self, step: int) -> Iteration | None:
        """Return an iteration, if it is there."""
        found = self._iterations("WHERE step = ?", (step,))
        return found[0] if found else None

    def add_iteration(self, row: Iteration, elapsed: float) -> None:
        """Store an iteration."""
        values = (
            row.step,
            row.iteration,
            row.iterations,
            row.evaluations,
            _blob(row.best),
            _blob(row.objectives),
            _blob(row.violation),
            row.state,
        )
        with guarded(self.path), self._db:
            self._db.execute("INSERT INTO iterations VALUES (?,?,?,?,?,?,?,?)", values)
            self._set("elapsed", elapsed)

    def iterations(self) -> list[Iteration]:
        """Every iteration, in order."""
        return self._iterations("ORDER BY step", ())

    # -- inside ------------------------------------------------------------------------------------

    def _set(self, key: str, value: Any) -> None:
        self._db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (key, json.dumps(value)))

    def _iterations(self, which: str, arguments: tuple[int, ...]) -> list[Iteration]:
        with guarded(self.path):
            rows = self._db.execute(f"SELECT * FROM iterations {which}", arguments).fetchall()
        return [
            Iteration(
                step,
                number,
                total,
                count,
                _array(best, self.path).reshape(-1, len(self.variables)),
                _array(objectives, self.path).reshape(-1, len(self.objectives)),
                _array(violation, self.path),
                state,
            )
            for step, number, total, count, best, objectives, violation, state in rows
        ]

    def _evaluations(self, rows: Sequence[tuple[Any, ...]]) -> Evaluations:
        return Evaluations(
            self._matrix([row[0] for row in rows], len(self.objectives)),
            self._matrix([row[1] for row in rows], len(self.constraints)),
            tuple(row[2] for row in rows),
            tuple(row[3] for row in rows),
        )

    def _matrix(self, blobs: Sequence[bytes], width: int) -> Array:
        arrays = [_array(blob, self.path) for blob in blobs]
        if any(len(array) != width for array in arrays):
            raise InputError(self.path, "", "is damaged: a row has the wrong length")
        return np.array(arrays).reshape(len(arrays), width)


def create(path: Path, meta: dict[str, Any]) -> Store:
    """Create the file of a study.

    Parameters
    ----------
    path : Path
    meta : dict
        JSON types; "variables", "objectives" and "constraints" name the columns.

    Raises
    ------
    InputError
        If the file exists already.
    RunError
        If it cannot be written.
    """
    if path.exists():
        raise InputError(path, "", "exists already")
    with whole(path) as partial, guarded(path):
        for leftover in (partial, partial.with_name(partial.name + "-journal")):  # of a killed process
            leftover.unlink(missing_ok=True)
        db = _connect(partial)
        db.executescript(f"PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {SCHEMA}; {_TABLES}")
        with db:
            db.executemany("INSERT INTO meta VALUES (?, ?)", [(k, json.dumps(v)) for k, v in meta.items()])
        db.close()
    return open_store(path)


def open_store(path: Path) -> Store:
    """Open the file of a study to continue it.

    Raises
    ------
    InputError
        If it is not the file of a study, is damaged, or of another version.
    """
    check_header(path)
    with guarded(path):
        db = _connect(path)
        db.execute("PRAGMA journal_mode = WAL")
        db.execute("PRAGMA synchronous = NORMAL")
        check_content(db, TABLES)
    return Store(path, db)


def read_store(path: Path) -> Store:
    """Open the file of a study to read it, even while another process writes.

    Raises
    ------
    InputError
        As `open_store`.

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
        db = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
        check_content(db, TABLES)
    return Store(path, db)


def _connect(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, timeout=10.0)


def _blob(array: Array) -> bytes:
    return np.ascontiguousarray(array, dtype="<f8").tobytes()


def _array(blob: bytes, path: Path) -> Array:
    if not isinstance(blob, bytes) or len(blob) % 8:
        raise InputError(path, "", "is damaged: a row has the wrong length")
    return np.frombuffer(blob, dtype="<f8").astype(np.float64)
