"""Many runs of one experiment that differ in some values: summaries, not trajectories."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.brief import Brief, counted
from linkages.engines.compiled.designs import designs_of
from linkages.engines.compiled.runs import Runs
from linkages.engines.compiled.statistics import STATISTICS
from linkages.errors import InputError, Status
from linkages.files.table_formats import needed
from linkages.kernel import Array, Indices
from linkages.outputs.registry import default_outputs, pack
from linkages.system import System

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


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
        where the run failed before the window's end. Each is an attribute too: ``batch.rms``.
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
        Called now and then with the part that is done, 0 to 1.

    Returns
    -------
    Batch
        A run that cannot start or does not reach its end has a status in its row, and NaN for windows that it did
        not finish.

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
    runs = Runs(designs_of(system, tuple(variables), names, spans.tobytes()), table)
    runs.make(threads, progress)
    statistics = {name: runs.found[..., k] for k, name in enumerate(STATISTICS)}
    return Batch(tuple(variables), table, names, spans, statistics, runs.status, runs.reason, runs.steps)


def _check_paths(system: System, variables: Sequence[str], table: Array) -> None:
    """See that all paths exist: values out of range are the designs' own failures."""
    for name, column in zip(variables, table.T, strict=True):
        finite = column[np.isfinite(column)]
        system.replaced({name: float(finite[0]) if len(finite) else 1.0})
