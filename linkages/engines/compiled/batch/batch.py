"""Many runs of one experiment that differ in some values: summaries, not trajectories."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from linkages.base.arguments import Count, Lines, Names, Vector, fitting, validated
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, Status
from linkages.base.kernel import Array, Indices
from linkages.base.packages import needed
from linkages.elements.analysis import Analysis
from linkages.engines.compiled.batch.designs import designs_of
from linkages.engines.compiled.batch.runs import STATISTICS_WITH_RATES, Runs, differentiate_runs
from linkages.engines.compiled.batch.statistics import STATISTICS
from linkages.engines.compiled.effects import check_differentiated, check_varied
from linkages.engines.numerics import BATCH_OF_RUNS
from linkages.results.derivatives import Wrt
from linkages.results.outputs.registry import default_outputs, pack
from linkages.system import System

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@dataclass(frozen=True, repr=False)
class Batch(Brief):
    """Summaries of m runs in nw windows; the number of outputs is ``no``.

    Attributes
    ----------
    variables : tuple of str
        Dotted paths that differ between the runs.
    values : (m, nv) array
    outputs : tuple of str
        See `linkages.results.outputs.registry`.
    windows : (nw, 2) array
        Times [s].
    statistics : dict of (m, nw, no) arrays
        By the names of `linkages.engines.compiled.batch.statistics.STATISTICS`, over continuous time within each
        window; NaN where the run failed before the window's end. Each is an attribute too: ``batch.rms``.
    status : list of Status
    reason : list of str
        Why a run failed, empty otherwise.
    steps : (m,) array of int
    times : (nt,) array
        Times of the samples [s].
    samples : (m, nt, no) array
        Outputs at these times; NaN where a run ended before.
    sensitivity : dict of dict of (m, nw, no) arrays
        Derivatives of minimum, maximum, peak, mean, rms and last by path and statistic, in units of the output per unit
        of the value: ``batch.sensitivity[PATH]["peak"]``; NaN where there is none, as beyond the horizon of
        predictability, or where an extreme is at a jump of its output. Empty unless requested.
    sensitivity_status : list of str
        Why the derivatives of a run end, see `linkages.results.derivatives.MEANING`; empty unless requested.
    """

    variables: tuple[str, ...]
    values: Array
    outputs: tuple[str, ...]
    windows: Array
    statistics: dict[str, Array]
    status: list[Status]
    reason: list[str]
    steps: Indices
    times: Array = field(default_factory=lambda: np.zeros(0))
    samples: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    sensitivity: dict[str, dict[str, Array]] = field(default_factory=dict)
    sensitivity_status: list[str] = field(default_factory=list)

    def _facts(self) -> tuple[str, dict[str, str]]:
        runs, windows = counted(len(self.values), "run"), counted(len(self.windows), "window")
        failed = sum(one is not Status.OK for one in self.status)
        line = f"{runs}, {windows}, {counted(len(self.outputs), 'output')}; {failed:,} failed"
        rows = {"outputs": ", ".join(self.outputs), "statistics": ", ".join([*self.statistics, "peak"])}
        for name, column in zip(self.variables, self.values.T, strict=True):
            known = column[~np.isnan(column)]
            rows[name] = f"{known.min():g} to {known.max():g}" if len(known) else "no values"
        for one in dict.fromkeys(self.status):
            rows[f"runs: {one.value}"] = f"{self.status.count(one):,}"
        if self.sensitivity:
            rows["derivatives"] = ", ".join(self.sensitivity)
        for state in dict.fromkeys(self.sensitivity_status):
            rows[f"derivatives: {state}"] = f"{self.sensitivity_status.count(state):,}"
        return line, rows

    def __getattr__(self, name: str) -> Array:
        if name not in STATISTICS:
            raise AttributeError(f"a batch has no {name}; it has {', '.join(STATISTICS)}")
        return self.statistics[name]

    @property
    def peak(self) -> Array:
        """Largest magnitude, (m, nw, no)."""
        return np.maximum(np.abs(self.minimum), np.abs(self.maximum))

    @property
    def fluctuation(self) -> Array:
        """Range over the magnitude of the mean, (m, nw, no): of a rate the coefficient of speed fluctuation [1]."""
        return np.asarray((self.maximum - self.minimum) / np.abs(self.mean))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a pandas DataFrame with a row for each run and window, runs first.

        Its columns are the variables, ``run``, ``start`` and ``end`` of the window [s], every statistic as
        ``OUTPUT.statistic`` (``A.force.peak``), derivatives as ``OUTPUT.statistic wrt PATH``, ``status``, ``reason``
        and ``steps``; with derivatives ``sensitivity_status``.

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
            for path, tables in self.sensitivity.items():
                columns |= {f"{output}.{name} wrt {path}": table[:, :, k].ravel() for name, table in tables.items()}
        status = np.array([one.value for one in self.status])
        columns |= {"status": status[row], "reason": np.array(self.reason)[row], "steps": self.steps[row]}
        if self.sensitivity:
            columns["sensitivity_status"] = np.array(self.sensitivity_status)[row]
        return needed("pandas", "to_dataframe").DataFrame(columns)

    def to_xarray(self) -> xr.Dataset:
        """Return an xarray Dataset: each statistic over (run, window, output); values and status over the runs.

        Derivatives are ``peak_rate`` and others over (wrt, run, window, output).

        Raises
        ------
        InputError
            If xarray is not installed.
        """
        tables: dict[str, Any] = {name: (("run", "window", "output"), table) for name, table in self.statistics.items()}
        coordinates: dict[str, Any] = {name: ("run", self.values[:, k]) for k, name in enumerate(self.variables)}
        coordinates |= {"output": list(self.outputs), "status": ("run", [one.value for one in self.status])}
        spans = {
            "start": ("window", self.windows[:, 0], {"units": "s"}),
            "end": ("window", self.windows[:, 1], {"units": "s"}),
        }
        tables["peak"] = (("run", "window", "output"), self.peak)
        if len(self.times):
            tables["samples"] = (("run", "time", "output"), self.samples)
            coordinates["time"] = ("time", self.times, {"units": "s"})
        if self.sensitivity:
            coordinates |= {"wrt": list(self.sensitivity), "sensitivity_status": ("run", self.sensitivity_status)}
            for name in STATISTICS_WITH_RATES:
                rates = np.stack([one[name] for one in self.sensitivity.values()])
                tables[f"{name}_rate"] = (("wrt", "run", "window", "output"), rates)
        return needed("xarray", "to_xarray").Dataset(tables, coords=coordinates | spans)


@validated
def simulate_batch(
    system: System,
    variables: Names = (),
    values: Lines | None = None,
    outputs: Names | None = None,
    windows: Lines | None = None,
    threads: Count | None = None,
    progress: Callable[[float], None] | None = None,
    wrt: Wrt = (),
    limits: Lines | None = None,
    samples: Vector | None = None,
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
        Names of `linkages.results.outputs.registry`; default the experiment's outputs, forces and eccentricities of the
        contacts, torques of the drives.
    windows : (nw, 2) array_like, optional
        Times between which outputs are summarised [s]; default the whole run.
    threads : int, optional
        Default as many as there are processors. The results do not depend on it.
    progress : callable, optional
        Called now and then with the part that is done, 0 to 1; default: on a terminal a bar, after two seconds.
    wrt : sequence of str or Direction, optional
        Dotted paths of values, or values that several paths follow; `Batch.sensitivity` has the derivatives of the
        statistics of each run with respect to them, as `linkages.sensitivities` for one run. They take several
        times as long as the runs.
    limits : (2, nv) array_like, optional
        Ends of the ranges of the values of this batch and later ones with the same system, variables, outputs and
        windows, for instance the bounds of an optimisation. Later batches then start sooner; the results are the same.
    samples : (nt,) array_like, optional
        Increasing times [s] at which `Batch.samples` has the outputs.

    Returns
    -------
    Batch
        A run that cannot start or does not reach its end has a status in its row, and NaN for windows that it did
        not finish.

    Raises
    ------
    InputError
        If a path, an output, a window or a time is not valid for the nominal experiment, values of a path change no
        number of the model, a path of `wrt` has no derivative, or `wrt` is given and a model has no derivatives.
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
    [6.8, 7.6]
    >>> path = "sdf.frames.link6_D.pose.x"
    >>> batch = linkages.simulate_batch(system, variables, [[3e-4, 0.3]], ["slider7.x"], wrt=[path])
    >>> batch.sensitivity[path]["mean"].round(3).tolist()  # m/m: runs, windows, outputs
    [[[1.001]]]
    """
    return run_batch(
        system, variables, values, outputs, windows, threads, progress, wrt, limits, samples, must_act=True
    )


@validated
def run_batch(
    system: System,
    variables: Names = (),
    values: Lines | None = None,
    outputs: Names | None = None,
    windows: Lines | None = None,
    threads: Count | None = None,
    progress: Callable[[float], None] | None = None,
    wrt: Wrt = (),
    limits: Lines | None = None,
    samples: Vector | None = None,
    must_act: bool = False,
) -> Batch:
    """Run a batch as `simulate_batch`; values without an effect are refused only if they `must_act`."""
    for name in variables:
        if variables.count(name) > 1:
            raise InputError("argument", "variables", f'has "{name}" twice; give each once')
    table = fitting(np.zeros((1, 0)) if values is None else values, len(variables), "values", "variables")
    spans = _spans_of(windows, variables, system.settings.duration)
    chosen = default_outputs(system) if outputs is None else tuple(outputs)
    designs = designs_of(system, tuple(variables), chosen, spans.tobytes())
    if not designs.checked:  # a search makes many batches of the same designs
        pack(system, chosen)
        _check_paths(system, variables, table)
        if must_act:
            _check_effects(system, variables, table, chosen)
        designs.checked = True
    if wrt:
        system.check_analysis(Analysis.DERIVATIVES)
        if must_act:
            check_differentiated(system, wrt, chosen)
    times = np.zeros(0) if samples is None else samples
    if np.any(np.diff(times) <= 0.0) or np.any((times < 0.0) | (times > system.settings.duration)):
        raise InputError("argument", "samples", "must be increasing times within the run")
    runs = Runs(designs, table, times)
    share = BATCH_OF_RUNS if wrt else 1.0
    bounds = None if limits is None else fitting(limits, len(variables), "limits", "variables")
    if bounds is not None and (len(bounds) != 2 or not np.isfinite(bounds).all()):
        raise InputError("argument", "limits", "must have two lines, the ends of the ranges, of finite numbers")
    with _shown(progress) as show:
        runs.make(threads, lambda part: show(share * part), bounds)
        statistics = {name: runs.found[..., k] for k, name in enumerate(STATISTICS)}
        batch = Batch(
            tuple(variables),
            table,
            chosen,
            spans,
            statistics,
            runs.status,
            runs.reason,
            runs.steps,
            times,
            runs.sampled,
        )
        if not wrt:
            return batch
        rates, status = differentiate_runs(runs, wrt, threads, lambda part: show(share + (1.0 - share) * part))
    return replace(batch, sensitivity=rates, sensitivity_status=status)


@contextmanager
def _shown(progress: Callable[[float], None] | None) -> Iterator[Callable[[float], None]]:
    """Provide the caller's function for the finished fraction, or a bar on a terminal."""
    if progress is not None:
        yield progress
        return
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f}% |{bar}| [{elapsed}<{remaining}]"
    with tqdm(desc="runs", total=1.0, delay=2.0, disable=None, leave=False, bar_format=form) as bar:
        yield lambda part: cast(None, bar.update(part - bar.n))


def _spans_of(windows: Array | None, variables: Sequence[str], duration: float) -> Array:
    """Return the times of the windows, (nw, 2); the whole run by default."""
    spans = np.array([[0.0, duration]]) if windows is None else windows
    if spans.shape[1] != 2 or not np.all((spans[:, 0] >= 0) & (spans[:, 0] < spans[:, 1])):
        raise InputError("argument", "windows", "must be pairs of times, each a start at or after 0 and a later end")
    if "duration" not in variables and spans.max(initial=0.0) > duration * (1.0 + 1e-12):
        problem = f"end at {spans.max():g} s, after the duration of {duration:g} s; give a longer duration"
        raise InputError("argument", "windows", problem)
    return spans


def _check_effects(system: System, variables: Sequence[str], table: Array, outputs: Sequence[str]) -> None:
    """Refuse values that change no number of the model."""
    for name, column in zip(variables, table.T, strict=True):
        if len(finite := column[np.isfinite(column)]):
            check_varied(system, name, [float(finite.min()), float(finite.max())], "argument", outputs)


def _check_paths(system: System, variables: Sequence[str], table: Array) -> None:
    """See that all paths exist: values out of range are the designs' own failures.

    A path exists if the system takes its own value there; if it has none, the first, least or largest one given, or 1.
    """
    for name, column in zip(variables, table.T, strict=True):
        first: InputError | None = None
        finite = column[np.isfinite(column)]
        tried = [*finite[:1], *([finite.min(), finite.max()] if len(finite) else []), 1.0]
        with suppress(InputError):
            tried = [system.value(name), *tried]
        for value in tried:
            try:
                system.replaced({name: float(value)})
                break
            except InputError as problem:
                first = first or problem
        else:
            raise cast(InputError, first)
