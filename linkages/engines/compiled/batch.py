"""Many runs of one experiment that differ in some values: summaries, not trajectories."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.brief import Brief, counted
from linkages.engines.compiled.designs import Bench, Designs, designs_of
from linkages.engines.compiled.job import Given
from linkages.engines.compiled.rows import NO_IDEAL
from linkages.engines.compiled.runner import STATUS
from linkages.engines.compiled.statistics import STATISTICS
from linkages.engines.threads import in_threads
from linkages.errors import AssemblyError, InputError, Status
from linkages.files.table_formats import needed
from linkages.integrate.driver import DONE
from linkages.kernel import Array, Indices
from linkages.kernel.block import contents
from linkages.outputs.registry import default_outputs, pack
from linkages.system import System
from linkages.system.ideal_motion import cause

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_AT_ONCE = 32  # most runs in one call of compiled code
_PARTS = 4  # calls for each thread, at least


@dataclass(frozen=True, repr=False)
class Batch(Brief):
    """Summaries of m runs: nw windows, no outputs.

    Attributes
    ----------
    variables : tuple of str
        Dotted paths that differ between the runs.
    values : (m, nv) array
    outputs : tuple of str
        See `linkages.outputs.registry`.
    windows : (nw, 2) array
        Times [s].
    statistics : dict of (m, nw, no) arrays
        By the names of `linkages.engines.compiled.statistics.STATISTICS`, over continuous time within each window; NaN
        where the run failed. Each is an attribute too: ``batch.rms``.
    status : list of Status
    reason : list of str
        Why a run failed, empty otherwise.
    steps : (m,) array of int
    """

    variables: tuple[str, ...]
    values: Array
    outputs: tuple[str, ...]
    windows: Array
    statistics: dict[str, Array]
    status: list[Status]
    reason: list[str]
    steps: Indices

    def _facts(self) -> tuple[str, dict[str, str]]:
        runs, windows = counted(len(self.values), "run"), counted(len(self.windows), "window")
        failed = sum(one is not Status.OK for one in self.status)
        line = f"{runs}, {windows}, {counted(len(self.outputs), 'output')}; {failed:,} failed"
        rows = {"outputs": ", ".join(self.outputs), "statistics": ", ".join([*self.statistics, "peak"])}
        for name, column in zip(self.variables, self.values.T, strict=True):
            rows[name] = f"{np.nanmin(column):g} to {np.nanmax(column):g}" if len(column) else "no values"
        for one in dict.fromkeys(self.status):
            rows[f"runs: {one.value}"] = f"{self.status.count(one):,}"
        return line, rows

    def __getattr__(self, name: str) -> Array:
        if name not in STATISTICS:
            raise AttributeError(f"a batch has no {name}; it has {', '.join(STATISTICS)}")
        return self.statistics[name]

    @property
    def peak(self) -> Array:
        """Largest magnitude, (m, nw, no)."""
        return np.maximum(np.abs(self.minimum), np.abs(self.maximum))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a pandas DataFrame with a row for each run and window, runs first.

        Its columns are the variables, ``run``, ``start`` and ``end`` of the window [s], every statistic as
        ``OUTPUT.statistic`` (``A.force.peak``), ``status``, ``reason`` and ``steps``.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        runs, windows = len(self.values), len(self.windows)
        row = np.repeat(np.arange(runs), windows)
        columns: dict[str, Any] = {name: self.values[row, k] for k, name in enumerate(self.variables)}
        columns |= {"run": row, "start": np.tile(self.windows[:, 0], runs), "end": np.tile(self.windows[:, 1], runs)}
        for k, output in enumerate(self.outputs):
            for name, table in (self.statistics | {"peak": self.peak}).items():
                columns[f"{output}.{name}"] = table[:, :, k].ravel()
        status = np.array([one.value for one in self.status])
        columns |= {"status": status[row], "reason": np.array(self.reason)[row], "steps": self.steps[row]}
        return needed("pandas", "to_dataframe").DataFrame(columns)

    def to_xarray(self) -> xr.Dataset:
        """Return an xarray Dataset: each statistic over (run, window, output); values and status over the runs.

        Raises
        ------
        InputError
            If xarray is not installed.
        """
        tables = {name: (("run", "window", "output"), table) for name, table in self.statistics.items()}
        coordinates: dict[str, Any] = {name: ("run", self.values[:, k]) for k, name in enumerate(self.variables)}
        coordinates |= {"output": list(self.outputs), "status": ("run", [one.value for one in self.status])}
        spans = {
            "start": ("window", self.windows[:, 0], {"units": "s"}),
            "end": ("window", self.windows[:, 1], {"units": "s"}),
        }
        tables["peak"] = (("run", "window", "output"), self.peak)
        return needed("xarray", "to_xarray").Dataset(tables, coords=coordinates | spans)


def simulate_batch(
    system: System,
    variables: Sequence[str] = (),
    values: Any = None,
    outputs: Sequence[str] | None = None,
    windows: Any = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Batch:
    """Run a system many times with different values, in parallel threads.

    Parameters
    ----------
    system : System
        The nominal one.
    variables : sequence of str
        Dotted paths of the experiment; of the mechanism with ``sdf.`` before them (``sdf.links.rod.mass``).
    values : (m, nv) array_like
        One line for each run; default a single run with the nominal values.
    outputs : sequence of str, optional
        Names of `linkages.outputs.registry`; default the experiment's outputs, forces and eccentricities of the
        contacts, torques of the drives.
    windows : (nw, 2) array_like, optional
        Times between which outputs are summarised [s]; default the whole run.
    threads : int, optional
        Default as many as there are processors. The results do not depend on it.
    progress : callable, optional
        Called now and then with the part of the runs that have ended, 0 to 1.

    Returns
    -------
    Batch
        A run that cannot start or does not reach its end has a status in its row, and NaN for results.

    Raises
    ------
    InputError
        If a path, an output or a window is not valid for the nominal experiment.
    RunError
        If the threads cannot be started.
    MemoryError
        If a run finds no memory: at once, and the other runs are given up.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> variables, outputs = ["joints.A.clearance", "sdf.links.link2.mass"], ["A.force", "slider7.ax"]
    >>> batch = linkages.simulate_batch(system, variables, [[2e-4, 0.2], [3e-4, 0.3]], outputs)
    >>> batch.peak.shape  # runs, windows, outputs
    (2, 1, 2)
    >>> batch.peak[:, 0, 0].round(1).tolist()  # N
    [3.3, 3.6]
    """
    experiment = system.experiment
    table = np.zeros((1, 0)) if values is None else np.array(values, dtype=np.float64, ndmin=2)
    if table.shape[1] != len(variables):
        raise InputError(
            "argument", "values", f"have {table.shape[1]} columns for {len(variables)} variables; give as many"
        )
    names = tuple(outputs) if outputs is not None else default_outputs(system)
    pack(system, names)
    spans = np.array([[0.0, experiment.duration]] if windows is None else windows, dtype=np.float64, ndmin=2)
    if spans.shape[1] != 2 or not np.all((spans[:, 0] >= 0) & (spans[:, 0] < spans[:, 1])):
        raise InputError("argument", "windows", "must be pairs of times, each a start at or after 0 and a later end")
    _check_paths(system, variables, table)
    runs = _Runs(designs_of(system, tuple(variables), names, spans.tobytes()), table)
    runs.make(threads, progress)
    statistics = {name: runs.found[..., k] for k, name in enumerate(STATISTICS)}
    return Batch(tuple(variables), table, names, spans, statistics, runs.status, runs.reason, runs.steps)


def _check_paths(system: System, variables: Sequence[str], table: Array) -> None:
    """See that all paths exist: values out of range are the designs' own failures."""
    for name, column in zip(variables, table.T, strict=True):
        finite = column[np.isfinite(column)]
        system.replaced({name: float(finite[0]) if len(finite) else 1.0})


class _Runs:
    """Runs of a table of designs (m, nv), and their results."""

    def __init__(self, designs: Designs, table: Array) -> None:
        self.designs, self.table, count = designs, table, len(table)
        self.found = np.full((count, len(designs.windows), len(designs.outputs), len(STATISTICS)), np.nan)
        self.status, self.reason = [Status.OK] * count, [""] * count
        self.steps = np.zeros(count, dtype=np.int64)
        self._ended = np.zeros(count, dtype=bool)
        self._stop = np.zeros(1, np.int64)

    def make(self, threads: int | None, progress: Callable[[float], None] | None) -> None:
        """Run all designs, in threads."""
        self.designs.compare(self.table)
        rows = np.arange(len(self.table))
        share = len(rows) // (_PARTS * (threads or os.cpu_count() or 1))  # all threads end at about the same time
        size = min(max(share, 1), _AT_ONCE)
        parts = [rows[first : first + size] for first in range(0, len(rows), size)]
        look = None if progress is None else lambda: progress(float(self._ended.mean()))
        in_threads(lambda k: self._run(parts[k]), len(parts), threads, look, self._end)

    def _end(self) -> None:
        self._stop[0] = 1

    def _run(self, rows: Indices) -> None:
        """Run the designs of some rows."""
        designs, covered = self.designs, self.designs.covers(self.table[rows])
        built: dict[Any, list[tuple[int, Given, Indices]]] = {}
        for row in rows[~covered].tolist():
            try:
                given = designs.given(self.table[row])
            except InputError as problem:
                self._fail(row, Status.BAD_INPUT, str(problem))
            except AssemblyError as problem:
                self._fail(row, problem.status, str(problem))
            else:
                numbers = contents(given)
                built.setdefault(numbers.structure, []).append((row, given, numbers.words))
        for group in built.values():
            with designs.bench(group[0][1]) as bench:
                columns, words = bench.different(np.stack([words for _, _, words in group]))
                self._use(bench, np.array([row for row, _, _ in group]), columns, words)
        if covered.any():
            with designs.bench() as bench:
                self._use(bench, rows[covered], designs.columns, designs.words(self.table[rows[covered]]))

    def _use(self, bench: Bench, rows: Indices, columns: Indices, words: Indices) -> None:
        """Run designs of one structure."""
        found, ended = np.empty((len(rows), *self.found.shape[1:])), np.empty((len(rows), 3))
        bench.run(columns, words, self._stop, found, ended)
        if self._stop[0]:
            return
        self.found[rows], self.steps[rows] = found, ended[:, 2]
        for k in np.flatnonzero(ended[:, 0] != DONE):
            self._fail(int(rows[k]), *self._reason(int(rows[k]), int(ended[k, 0]), float(ended[k, 1])))
        self._ended[rows] = True

    def _reason(self, row: int, code: int, time: float) -> tuple[Status, str]:
        """Status of a run that failed, and why."""
        if code == NO_IDEAL:
            status, what = Status.NO_ASSEMBLY, "the ideal linkage does not close"
        else:
            status = STATUS.get(code, Status.TOO_MANY_STEPS)
            status, time = cause(status, self.designs.replaced(self.table[row]), time)
            what = f"ended at t = {time:.6g} s"
        return status, f"{status.value}: {what}; {status.remedy}"

    def _fail(self, row: int, status: Status, reason: str) -> None:
        self.status[row], self.reason[row], self._ended[row] = status, reason, True
