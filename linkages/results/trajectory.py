"""Results of a run: named columns over time, status, provenance; save and load."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arguments import Dense, Vector, inside, validated
from linkages.base.arrays import Array, Records
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, RunError, Status, UnknownNameError, nearest_names
from linkages.input.files import table_formats
from linkages.input.files.reading import read_arrays
from linkages.input.files.writing import whole
from linkages.mechanics.planar.closure import LOOSE, loop_errors
from linkages.results import numerics
from linkages.results.derivatives import NONE, Derivatives
from linkages.results.outputs.columns import Columns
from linkages.system.tree import Tree

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


#: Function called with the simulated time [s] at intervals.
TimeReport = Callable[[float], None]
#: Dense output: columns at times.
Evaluate = Callable[[Array], Columns]


@dataclass(frozen=True)
class Interpolated:
    """Linear interpolation between the samples of a run; false, because it is no dense output."""

    columns: Columns

    def __bool__(self) -> bool:
        return False

    @validated
    def __call__(self, times: Vector) -> Columns:
        """Interpolate all columns at times (n,) in any order; InputError for times outside the run."""
        known = self.columns["time"]
        at = inside(times, float(known[0]), float(known[-1]))
        return {name: np.interp(at, known, column) for name, column in self.columns.items()}


@dataclass(frozen=True, repr=False)
class Trajectory(Brief):
    """A run, or an ideal motion: ``run["A.force"]`` is a column, ``"A.force" in run`` checks for one.

    Attributes
    ----------
    time : (nt,) array
        Sample times [s]: every step of the integrator.
    columns : dict of (nt,) arrays
        Columns by name; see `linkages.results.outputs.registry`.
    status : Status
        OK, or why the run ended before its duration.
    provenance : dict
        Engine, settings, versions, wall time.
    evaluate : callable or None
        Function that gives all columns at times (n,) of the run, in any order (dense output); InputError for times
        outside. Of a run that was loaded from a file it interpolates linearly between the samples, and is false.
    units : dict of str
        SI unit of each column; empty if unknown.
    jumps : (nj,) array
        Times at which states are sampled [s]; columns have the values after them.
    accuracy : float or None
        Of the run; it decides where means and integrals need values within steps. None if loaded from a file.
    sensitivity : Derivatives
        Derivatives of the columns with respect to values: ``run.sensitivity[PATH][OUTPUT]``; empty unless requested.
    """

    time: Array
    columns: Columns
    status: Status
    provenance: dict[str, Any] = field(default_factory=dict)
    evaluate: Evaluate | None = None
    units: dict[str, str] = field(default_factory=dict)
    sensitivity: Derivatives = field(default_factory=lambda: NONE)
    jumps: Array = field(default_factory=lambda: np.zeros(0))
    accuracy: float | None = None

    def __post_init__(self) -> None:
        if isinstance(self.evaluate, Interpolated):
            object.__setattr__(self, "evaluate", Interpolated(self.columns))
        elif self.evaluate is not None and len(self.time):
            function = self.evaluate.function if isinstance(self.evaluate, Dense) else self.evaluate
            object.__setattr__(self, "evaluate", Dense(function, float(self.time[0]), float(self.time[-1])))

    def __getitem__(self, name: str) -> Array:
        if name not in self.columns:
            raise UnknownNameError("trajectory", "", f'has no column "{name}"; {nearest_names(name, self.columns)}')
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def _facts(self) -> tuple[str, dict[str, str]]:
        engine, size = self.provenance.get("engine", "unknown"), len(self.time)
        span = f"{self.time[0]:g} to {self.time[-1]:g} s" if size else "no time"
        line = f"{engine} engine, {self.status.value}, {span}, {counted(size, 'sample')} of"
        line += f" {counted(len(self.columns), 'column')}"
        status = self.status.value if self.status is Status.OK else f"{self.status.value}: {self.status.remedy}"
        rows = {"status": status}
        for name in self.columns:
            owner, dot, quantity = name.rpartition(".")
            unit = self.units.get(name, "")
            label = owner if dot else "of all"
            shown = f"{quantity} [{unit}]" if unit else quantity
            rows[label] = f"{rows[label]}, {shown}" if label in rows else shown
        return line, rows

    @validated
    def within(self, start: float, end: float) -> Trajectory:
        """Return the part of the trajectory between two of its times [s], with samples at both.

        Values between samples are evaluated, or interpolated for a loaded trajectory. InputError if a time lies outside
        the run, or the end is not after the start.
        """
        if not start < end:
            raise InputError("argument", "end", f"is {end:g} s, not after the start of {start:g} s; give a later end")
        edges = inside(np.array([start, end]), float(self.time[0]), float(self.time[-1]), "start and end")
        between_them = (self.time > edges[0]) & (self.time < edges[1])
        known = {name: np.interp(edges, self.time, column) for name, column in self.columns.items()}
        new = self.time[np.searchsorted(self.time, edges)] != edges
        if self.evaluate and new.any():
            for name, values in self.evaluate(edges[new]).items():
                known[name][new] = values
        columns = {n: np.concatenate([known[n][:1], c[between_them], known[n][1:]]) for n, c in self.columns.items()}
        rates, time = self.sensitivity, columns["time"]
        if rates:
            rates = replace(rates, times=time)
        return replace(self, time=time, columns=columns, sensitivity=rates)

    def save(self, path: str | Path, compress: bool = False) -> None:
        """Write to an ``.npz`` file without pickle, atomically; RunError if the file cannot be written.

        With `compress` the file has about half the size, and takes a hundred times longer.
        """
        write = np.savez_compressed if compress else np.savez
        header = json.dumps({"status": self.status.value, "provenance": self.provenance, "units": self.units})
        with whole(Path(path)) as partial, open(partial, "wb") as file:
            write(file, header=np.array(header), **self.columns)  # type: ignore[arg-type]  # no column is named allow_pickle

    @property
    def about(self) -> dict[str, str]:
        """Return the status, and the provenance as JSON."""
        return {"status": self.status.value, "provenance": json.dumps(self.provenance)}

    def to_dataframe(self) -> pd.DataFrame:
        """Return the columns as a pandas DataFrame over the time [s]; ``attrs["units"]`` has their units.

        InputError if pandas is not installed.

        Examples
        --------
        >>> import linkages
        >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
        >>> frame = linkages.ideal(system).to_dataframe()
        >>> frame.index.name, frame.attrs["units"]["slider7.ax"]
        ('time', 'm/s2')
        """
        return table_formats.dataframe(self.columns, self.units)

    def to_xarray(self) -> xr.Dataset:
        """Return the columns as an xarray Dataset over the time; variables have units, the dataset has the status.

        InputError if xarray is not installed.

        Examples
        --------
        >>> import linkages
        >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
        >>> data = linkages.ideal(system).to_xarray()
        >>> data["slider7.ax"].attrs["units"], data.attrs["status"]
        ('m/s2', 'ok')
        """
        return table_formats.dataset(self.columns, self.units, self.about)


def load_trajectory(path: str | Path) -> Trajectory:
    """Read a file of `Trajectory.save`.

    Parameters
    ----------
    path : str or Path
        An ``.npz`` file.

    Returns
    -------
    Trajectory
        Without dense output: `Trajectory.evaluate` interpolates linearly between the samples.

    Raises
    ------
    InputError
        If the file cannot be read or is not a trajectory.

    Examples
    --------
    >>> import linkages, tempfile
    >>> run = linkages.ideal(linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1}))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(f"{folder}/trajectory.npz")
    ...     loaded = linkages.load_trajectory(f"{folder}/trajectory.npz")
    >>> loaded.status.value, bool((loaded["slider7.ax"] == run["slider7.ax"]).all())
    ('ok', True)
    """
    path = Path(path)
    try:
        return _trajectory(read_arrays(path))
    except (ValueError, KeyError, TypeError, RecursionError) as problem:
        raise InputError(path, "", f"is not a trajectory written by linkages ({problem})") from None


def _trajectory(columns: dict[str, NDArray[Any]]) -> Trajectory:
    """Make a trajectory from the arrays of a file."""
    header = json.loads(str(columns.pop("header")))
    status, provenance, units = Status(header["status"]), dict(header["provenance"]), dict(header.get("units", {}))
    time = columns["time"]
    if time.ndim != 1 or not len(time) or not np.all(np.diff(time, prepend=time[0]) >= 0.0):
        raise ValueError("its times do not increase")
    for name, column in columns.items():
        if column.dtype != np.float64 or column.shape != time.shape:
            raise ValueError(f"its column {name} is not a list of as many numbers as there are times")
    if not all(isinstance(unit, str) for unit in units.values()):
        raise ValueError("its units are not texts")
    return Trajectory(time, columns, status, provenance, Interpolated(columns), units)


def sample(
    steps: Array, evaluate: Evaluate, status: Status, provenance: dict[str, Any], loops: Loops | None = None
) -> Trajectory:
    """Make a trajectory by evaluating a run at its steps; RunError if nothing remains.

    The trajectory ends before the first non-finite number and before the first open loop; its status is then NOT_FINITE
    (unless it is JAMMED) or LOOP_OPEN. The largest loop error is added to the provenance.
    """
    columns = _in_parts(evaluate, steps)
    finite = np.ones(len(steps), dtype=bool)
    for column in columns.values():
        finite &= np.isfinite(column)
    count = len(steps)
    if not np.all(finite):
        count, status = int(np.argmin(finite)), Status.JAMMED if status is Status.JAMMED else Status.NOT_FINITE
        if count == 0:
            raise RunError(f"{status.value} at the start; {status.remedy}")
    if loops is not None:
        errors = loops.errors(columns)[:count]
        loose = errors > LOOSE * loops.tree.extent
        if loose[1:].any():
            count = max(int(np.argmax(loose)), 1)
            status = Status.LOOP_OPEN if status is Status.OK else status
        provenance = provenance | {"loop_error": float(errors[:count].max())}
    kept = {name: column[:count] for name, column in columns.items()}
    return Trajectory(steps[:count], kept, status, provenance, evaluate)


def values_at(trajectory: Trajectory, times: Array) -> Columns:
    """Evaluate a trajectory at times [s]; interpolate one without dense output."""
    if trajectory.evaluate:
        return trajectory.evaluate(times)
    return {name: np.interp(times, trajectory.time, column) for name, column in trajectory.columns.items()}


def _in_parts(evaluate: Evaluate, times: Array) -> Columns:
    """Evaluate a run at many times with little more memory than the columns take."""
    columns: Columns = {}
    for first in range(0, len(times), numerics.TRAJECTORY_AT_ONCE):
        part = evaluate(times[first : first + numerics.TRAJECTORY_AT_ONCE])
        if not columns:  # rows of one array, whose memory is free at once when nothing needs them; zeros need none
            ordered = sorted(part, key=lambda name: not part[name].any())
            rows = dict(zip(ordered, np.zeros((len(part), len(times))), strict=True)) | {"time": times}
            columns = {name: rows[name] for name in part}
        for name, values in part.items():
            if values.any():
                columns[name][first : first + len(values)] = values
    return columns


class Loops(NamedTuple):
    """Loops that a trajectory must keep closed."""

    tree: Tree  # tree with the trajectory's coordinates, columns ``q.COORDINATE``
    rows: Records  # closure rows: `Tree.loop_rows` for a run, `Tree.closure_rows` if all joints are ideal

    def errors(self, columns: Columns) -> Array:
        """Compute the largest loop error (nt,) at each sample [m, rad]."""
        if not len(self.rows):
            return np.zeros(len(columns["time"]))
        q, last = [columns[f"q.{name}"] for name in self.tree.coordinates], len(columns["time"])
        parts = (
            np.stack([x[first : first + numerics.TRAJECTORY_AT_ONCE] for x in q], axis=1)
            for first in range(0, last, numerics.TRAJECTORY_AT_ONCE)
        )
        return np.concatenate([loop_errors(self.tree.bodies, self.rows, part) for part in parts])
