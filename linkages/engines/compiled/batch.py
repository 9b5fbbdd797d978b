"""Many runs of one experiment that differ in some values: summaries, not trajectories."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.brief import Brief, counted
from linkages.engines.budget import most
from linkages.engines.compiled.runner import STATUS, Runner, join
from linkages.engines.compiled.statistics import STATISTICS
from linkages.engines.threads import in_threads
from linkages.errors import AssemblyError, InputError, Status
from linkages.files.table_formats import needed
from linkages.kernel import Array, Indices
from linkages.outputs.registry import default_outputs, pack
from linkages.planar.ideal import make_ideal
from linkages.system import System
from linkages.system.ideal_motion import cause

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
    shape = (len(table), len(spans), len(names), len(STATISTICS))
    found = np.full(shape, np.nan)
    status = [Status.OK] * len(table)
    reason = [""] * len(table)
    steps = np.zeros(len(table), dtype=np.int64)
    ended = np.zeros(len(table), dtype=bool)

    def one(i: int) -> None:
        values = dict(zip(variables, map(float, table[i]), strict=True))
        status[i], reason[i], steps[i] = _run(system, values, names, spans, found[i])
        ended[i] = True

    look = None if progress is None else lambda: progress(float(ended.mean()))
    in_threads(one, len(table), threads, look)
    statistics = {name: found[..., k] for k, name in enumerate(STATISTICS)}
    return Batch(tuple(variables), table, names, spans, statistics, status, reason, steps)


def _check_paths(system: System, variables: Sequence[str], table: Array) -> None:
    """See that all paths exist: values out of range are the designs' own failures."""
    for name, column in zip(variables, table.T, strict=True):
        finite = column[np.isfinite(column)]
        system.replaced({name: float(finite[0]) if len(finite) else 1.0})


def _run(
    nominal: System, values: dict[str, float], names: tuple[str, ...], windows: Array, out: Array
) -> tuple[Status, str, int]:
    """Run one design; fills the statistics (nw, no, ns)."""
    try:
        system = nominal.replaced(values)
        duration = system.experiment.duration
        if np.any(windows[:, 1] > duration * (1.0 + 1e-12)):
            return Status.BAD_INPUT, "a window ends after the run", 0
        outputs = pack(system, names)
        runner = Runner(system, outputs)
    except InputError as problem:
        return Status.BAD_INPUT, str(problem), 0
    except AssemblyError as problem:
        return problem.status, str(problem), 0
    record = runner.run(0.0, runner.start, 0.0, most(system))
    status, end = cause(STATUS.get(record.status, Status.TOO_MANY_STEPS), system, float(record.times[-1]))
    if status is not Status.OK:
        where = f"ended at t = {end:.6g} s"
        return status, f"{status.value}: {where}; {status.remedy}", record.steps
    tree = system.tree
    ideal = make_ideal(tree.closure_rows, tree.closing_dofs, tree.bodies, tree.size)
    if not runner.summarise(ideal, outputs, join([record]), np.minimum(windows, duration), out):
        out[...] = np.nan
        status = Status.NO_ASSEMBLY
        return status, f"{status.value}: the ideal linkage does not close; {status.remedy}", record.steps
    return status, "", record.steps
