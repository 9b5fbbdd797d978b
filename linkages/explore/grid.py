"""Sections over a grid of the values of two variables, in rows that are kept on disk as soon as they are finished."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from linkages.base.arguments import Count, Names, Whole, validated, vector
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.disk import keep, kept
from linkages.base.errors import ARGUMENT, InputError, Status
from linkages.engines.compiled.effects import check_varied
from linkages.explore.sections import Section, checked
from linkages.explore.sweep import SweepPoint, points_of
from linkages.input.files.writing import errors_of_writing
from linkages.system import System
from linkages.system.identity import identity

Values = Annotated[Sequence[float] | Array, vector]


@dataclass(frozen=True, repr=False)
class Grid(Brief):
    """Sections at every pair of values of two variables; made by `sweep_grid`.

    Attributes
    ----------
    paths : (str, str)
        Dotted paths of the variables.
    values : ((na,) tuple, (nb,) tuple)
        Values of each variable.
    names : tuple of str
        Names of the outputs.
    transient : int
        Revolutions that were discarded before each section.
    rows : (na,) tuple of (nb,) tuples of SweepPoint
        A row for each value of the first variable; the second one is the `value` of each point.
    status : Status
        INTERRUPTED if the sweep was: the points that are not finished have this status too.
    units : (str, str)
        SI units of the variables; empty for pure numbers.
    """

    paths: tuple[str, str]
    values: tuple[tuple[float, ...], tuple[float, ...]]
    names: tuple[str, ...]
    transient: int
    rows: tuple[tuple[SweepPoint, ...], ...]
    status: Status = Status.OK
    units: tuple[str, str] = ("", "")

    def _facts(self) -> tuple[str, dict[str, str]]:
        failed = sum(point.status is not Status.OK for row in self.rows for point in row)
        ranges = zip(self.paths, self.values, strict=True)
        rows = {path: f"{counted(len(those), 'value')} from {those[0]:g} to {those[-1]:g}" for path, those in ranges}
        size = " x ".join(str(len(those)) for those in self.values)
        line = f"{' and '.join(self.paths)}, {size} values; {failed:,} failed"
        return line, {**rows, "outputs": ", ".join(self.names)}

    def peaks(self, name: str) -> Array:
        """Return the mean of the revolutions' peaks of an output at every pair of values (na, nb); NaN where none."""
        return np.array([[point.mean_peak(name) for point in row] for row in self.rows])


@validated
def sweep_grid(
    system: System,
    path: str,
    values: Values,
    other_path: str,
    other_values: Values,
    names: Names,
    revolutions: Count,
    transient: Whole = 0,
    drive: str | None = None,
    threads: Count | None = None,
    folder: Path | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
    origin: str = ARGUMENT,
) -> Grid:
    """Take a stroboscopic section at every pair of values of two variables, as `linkages.sweep` does for one.

    Parameters
    ----------
    system : System
    path, other_path : str
        Dotted paths of the variables, of the experiment or, with ``sdf.``, of the machine.
    values, other_values : sequence of float
        Values of each variable.
    names : sequence of str
        Recorded outputs; see `linkages.results.outputs.registry`.
    revolutions, transient : int
        Recorded revolutions, and discarded ones before them.
    drive : str, optional
        Drive that defines a revolution; default: see `linkages.explore.flow.period_of`.
    threads : int, optional
        Number of threads; default: number of processors. An executor's work takes one thread each.
    folder : Path, optional
        Folder of the rows: an interrupted sweep continues from them, with identical results.
    executor : Executor, optional
        Where the rows are computed, for instance in other processes; default: here, one after another.
    progress : callable, optional
        Called with the finished fraction, 0 to 1.
    origin : str
        Origin of the values, named in errors.

    Returns
    -------
    Grid
        Ctrl-C ends the sweep, not the call, once a point is finished: the others have the status ``INTERRUPTED``.

    Raises
    ------
    InputError
        If a path, a value or a name is not valid; the corners of the grid are checked before any run.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("four_bar_dry.toml"), {"joints": {}})
    >>> speeds, masses = ("drives.O.speed", [50.0, 100.0]), ("sdf.links.coupler.mass", [0.5, 1.0, 2.0])
    >>> grid = linkages.sweep_grid(system, *speeds, *masses, ["O.torque"], revolutions=1, transient=1)
    >>> peaks = grid.peaks("O.torque")
    >>> peaks.shape, (peaks[1] / peaks[0]).round(6).tolist()  # without gravity: as the square of the speed
    ((2, 3), [4.0, 4.0, 4.0])
    """
    paths = path, other_path
    if path == other_path:
        raise InputError(origin, path, "is given twice; name two variables")
    firsts, seconds = ([float(value) for value in those] for those in (values, other_values))
    if not (firsts and seconds):
        raise InputError("argument", path if not firsts else other_path, "has no values")
    corners = [{paths[0]: a, paths[1]: b} for a in (firsts[0], firsts[-1]) for b in (seconds[0], seconds[-1])]
    checked([system.replaced(corner, origin) for corner in corners], names, revolutions, transient, drive)
    for one, given in zip(paths, (firsts, seconds), strict=True):
        check_varied(system, one, [min(given), max(given)], origin, names)
    base = f"{identity(system)} {(paths, seconds, tuple(names), revolutions, transient, drive)}"
    stores = [_RowStore(folder, k, f"{base} {first!r}") for k, first in enumerate(firsts)]
    rows = [store.read(seconds) for store in stores]
    work = {}
    for k, row in enumerate(rows):
        if missing := [value for value in seconds if value not in row]:
            work[k] = (system, paths, firsts[k], missing, names, revolutions, transient, drive, origin)

    def add(k: int, found: Sequence[SweepPoint]) -> None:
        rows[k] |= {point.value: point for point in found if point.status is not Status.INTERRUPTED}
        stores[k].keep([rows[k][value] for value in seconds if value in rows[k]])

    interrupted = False
    try:
        if executor is None:
            for done, k in enumerate(work):
                look = None if progress is None else lambda part, done=done: progress((done + part) / len(work))
                found, interrupted = _row(*work[k], threads, look)
                add(k, found)
                if interrupted:
                    break
        else:
            _distributed(executor, work, add, progress)
    except KeyboardInterrupt:
        if not any(rows):
            raise
        interrupted = True
    none = Status.INTERRUPTED
    full = tuple(tuple(row.get(value) or SweepPoint(value, None, none) for value in seconds) for row in rows)
    status = none if interrupted else Status.OK
    units = system.value_unit(path), system.value_unit(other_path)
    return Grid(paths, (tuple(firsts), tuple(seconds)), tuple(names), transient, full, status, units)


def _row(
    system: System,
    paths: tuple[str, str],
    first: float,
    seconds: Sequence[float],
    names: Sequence[str],
    revolutions: int,
    transient: int,
    drive: str | None,
    origin: str,
    threads: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> tuple[list[SweepPoint], bool]:
    """Return the points of one value of the first variable, and whether Ctrl-C ended the runs."""
    systems = [system.replaced({paths[0]: first, paths[1]: second}, origin) for second in seconds]
    return points_of(systems, seconds, names, revolutions, transient, drive, threads, progress)


def _distributed(
    executor: Executor,
    work: Mapping[int, tuple[Any, ...]],
    add: Callable[[int, Sequence[SweepPoint]], None],
    progress: Callable[[float], None] | None,
) -> None:
    """Compute rows by an executor; add each when it is finished."""
    futures = {executor.submit(_row, *arguments): k for k, arguments in work.items()}
    try:
        for done, future in enumerate(as_completed(futures), 1):
            add(futures[future], future.result()[0])
            if progress is not None:
                progress(done / len(work))
    finally:
        for future in futures:
            future.cancel()


class _RowStore:
    """The finished points of a row in a file, which is named by a digest of all inputs."""

    def __init__(self, folder: Path | None, number: int, made_of: str) -> None:
        self.digest = hashlib.sha256(made_of.encode())
        self.path = folder and folder / f"{number + 1:04d}-{self.digest.hexdigest()[:16]}.row"

    def read(self, seconds: Sequence[float]) -> dict[float, SweepPoint]:
        """Return the points that an earlier sweep has finished, by value."""
        content = kept(self.path, self.digest.digest()) if self.path else None
        return {} if content is None else {entry["value"]: _point(entry) for entry in json.loads(content)}

    def keep(self, points: Sequence[SweepPoint]) -> None:
        """Write the finished points, whole or not at all."""
        if self.path and points:
            with errors_of_writing(self.path):
                keep(self.path, self.digest.digest(), json.dumps([_entry(point) for point in points]).encode())


def _entry(point: SweepPoint) -> dict[str, Any]:
    entry: dict[str, Any] = {"value": point.value, "status": point.status.value}
    if (section := point.section) is None:
        return entry
    columns = {"strobe": section.strobe, "low": section.low, "high": section.high}
    lists = {kind: {name: values.tolist() for name, values in column.items()} for kind, column in columns.items()}
    return entry | {"period": section.period, "times": section.times.tolist(), **lists}


def _point(entry: Mapping[str, Any]) -> SweepPoint:
    status = Status(entry["status"])
    if "period" not in entry:
        return SweepPoint(entry["value"], None, status)
    strobe, low, high = (
        {name: np.array(values) for name, values in entry[kind].items()} for kind in ("strobe", "low", "high")
    )
    section = Section(entry["period"], np.array(entry["times"]), strobe, low, high, status)
    return SweepPoint(entry["value"], section, status)
