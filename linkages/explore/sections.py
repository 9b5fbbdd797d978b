"""Poincare sections of runs: once per revolution, or where a signal crosses a level."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from linkages.base.arguments import Count, Names, Whole, validated
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import RunError, Status
from linkages.engines.compiled.batch.designs import Systems
from linkages.engines.compiled.batch.runs import Runs
from linkages.engines.compiled.batch.statistics import STATISTICS
from linkages.explore.compare import looser
from linkages.explore.flow import Flow, lasting, period_of
from linkages.explore.numerics import SECTIONS_AT_ONCE, SECTIONS_HALVINGS, SECTIONS_LOOKS
from linkages.results.divergence import PARTED, configuration, dense
from linkages.results.extremes import extremes
from linkages.results.outputs.columns import Columns
from linkages.results.outputs.registry import pack
from linkages.results.trajectory import Trajectory
from linkages.system import System


@dataclass(frozen=True, repr=False)
class Section(Brief):
    """Values in each of nr revolutions; made by `stroboscopic`. Unfinished revolutions are omitted.

    Attributes
    ----------
    period : float
        Period of a revolution [s].
    times : (nr,) array
        Ends of the revolutions [s].
    strobe : dict of (nr,) arrays
        Value at the end of each revolution, by column name.
    low, high : dict of (nr,) arrays
        Extremes within each revolution over continuous time, by column name.
    status : Status
        End of the run.
    """

    period: float
    times: Array
    strobe: dict[str, Array]
    low: dict[str, Array]
    high: dict[str, Array]
    status: Status

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{counted(len(self.times), 'revolution')} of {self.period:g} s, {self.status.value}"
        rows = {}
        for name in self.strobe if len(self.times) else ():
            rows[name] = f"{self.low[name].min():.5g} to {self.high[name].max():.5g}"
        return line, rows

    def peaks(self, name: str) -> Array:
        """Return the largest magnitude in each revolution (nr,)."""
        return np.maximum(np.abs(self.low[name]), np.abs(self.high[name]))

    def values(self, name: str, kind: str) -> Array:
        """Return the values at the ends of revolutions ("strobe"), or the largest magnitudes ("peaks"), (nr,)."""
        return self.strobe[name] if kind == "strobe" else self.peaks(name)


@validated
def stroboscopic(
    system: System,
    names: Names,
    revolutions: Count,
    transient: Whole = 0,
    drive: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> Section:
    """Compute a Poincaré section once per revolution, with the extremes of each revolution.

    Parameters
    ----------
    system : System
    names : sequence of str
        Outputs (see `linkages.results.outputs.registry`).
    revolutions, transient : int
        Recorded revolutions, and discarded ones before them.
    drive : str, optional
        Drive that defines a revolution; default: see `linkages.explore.flow.period_of`.
    progress : callable, optional
        Called with the finished fraction, 0 to 1.

    Returns
    -------
    Section
        End of each revolution [s], with each output's value there and extremes within.

    Raises
    ------
    InputError, AssemblyError
        See `linkages.engines.assessment.simulate`; also if a column or drive does not exist.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> section = linkages.stroboscopic(system, ["B.ey", "B.force"], revolutions=3, transient=1)
    >>> (section.times / section.period).round(6).tolist()
    [2.0, 3.0, 4.0]
    >>> section.strobe["B.ey"].shape, section.peaks("B.force").shape
    ((3,), (3,))
    """
    (case,) = checked([system], names, revolutions, transient, drive)
    _ = case[0].assembly
    (section,), interrupted = sections([case], names, revolutions, transient, progress=progress)
    if interrupted:
        raise KeyboardInterrupt
    if isinstance(section, Status):
        raise RunError(f"{section.value}; {section.remedy}")
    return section


def checked(
    systems: Sequence[System], names: Sequence[str], revolutions: int, transient: int, drive: str | None
) -> list[tuple[System, float]]:
    """Return each system with the duration of its revolutions, and its period [s]; InputError for an unknown name."""
    for system in systems:
        pack(system, names)
    return [(lasting(system, transient + revolutions, drive), period_of(system, drive)) for system in systems]


def sections(
    cases: Sequence[tuple[System, float]],
    names: Sequence[str],
    revolutions: int,
    transient: int,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[list[Section | Status], bool]:
    """Compute the section of each case of `checked`, in threads; the status instead if a run could not begin.

    Returns them and whether Ctrl-C ended the runs: the cases that are not finished have the status ``INTERRUPTED``. If
    none is finished, `KeyboardInterrupt` is raised.
    """
    periods = np.array([period for _, period in cases])
    ends = periods[:, None] * (transient + 1.0 + np.arange(revolutions))
    windows = np.stack([ends - periods[:, None], ends], axis=-1)
    designs = Systems([case for case, _ in cases], tuple(names), windows)
    runs = Runs(designs, np.arange(float(len(cases)))[:, None], np.zeros(0))
    interrupted = False
    try:
        runs.make(threads, progress)
    except KeyboardInterrupt:
        if not runs.began.any():
            raise
        runs.give_up()
        interrupted = True
    result: list[Section | Status] = []
    for k, status in enumerate(runs.status):
        if not runs.began[k]:
            result.append(status)
            continue
        count = np.count_nonzero(ends[k] < runs.reached[k])  # revolutions that are finished
        columns = [runs.found[k, :count, :, STATISTICS.index(what)] for what in ("last", "minimum", "maximum")]
        strobe, low, high = (dict(zip(names, table.T, strict=True)) for table in columns)
        result.append(Section(float(periods[k]), ends[k, :count], strobe, low, high, status))
    return result, interrupted


def recorded(flow: Flow, start: float, period: float, names: Sequence[str], revolutions: int) -> Section:
    """Continue a run that has reached a start over revolutions of a period, both [s], and record a section."""
    times: list[float] = []
    found: dict[str, list[tuple[float, float, float]]] = {name: [] for name in names}
    while len(times) < revolutions and flow.status is Status.OK:
        piece = flow.advance(start + (len(times) + 1) * period)
        if flow.status is not Status.OK:
            break
        run = flow.sampled(piece, names)
        times.append(flow.t)
        for name, extreme in extremes(run, names).items():
            found[name].append((float(run[name][-1]), extreme.min, extreme.max))
    table = {name: np.array(rows).reshape(-1, 3).T for name, rows in found.items()}
    strobe, low, high = ({name: rows[k] for name, rows in table.items()} for k in range(3))
    return Section(period, np.array(times), strobe, low, high, flow.status)


@validated
def crossings(run: Trajectory, name: str, level: float = 0.0, rising: bool = True, start: float = 0.0) -> Columns:
    """Compute a Poincaré section at a level of a column: all columns at the crossings.

    For sections once per revolution use `stroboscopic`. Two crossings within one integrator step are not detected.

    Parameters
    ----------
    run : Trajectory
        Run with dense output.
    name : str
        Name of the column.
    level : float
        Level in the column's unit.
    rising : bool
        Whether to take upward crossings; otherwise downward ones.
    start : float
        Start of the evaluated time range [s].

    Returns
    -------
    dict of (n,) arrays
        All outputs at the n crossings, and the crossing times as "time" [s].

    Raises
    ------
    InputError
        If the run was loaded from a file.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> run = linkages.simulate(system, "compiled")
    >>> touching = linkages.crossings(run, "B.penetration")
    >>> touching["time"][:2].round(6).tolist()  # s: the first two contacts
    [0.000227, 0.000677]
    """
    evaluate = dense(run)
    sign = 1.0 if rising else -1.0
    above = sign * (run[name] - level) > 0.0
    steps = np.flatnonzero(~above[:-1] & above[1:] & (run.time[:-1] >= start))
    left, right = run.time[steps].copy(), run.time[steps + 1].copy()
    for _ in range(SECTIONS_HALVINGS):
        middle = 0.5 * (left + right)
        if not np.any((left < middle) & (middle < right)):
            break
        beyond = sign * (evaluate(middle)[name] - level) > 0.0
        right, left = np.where(beyond, middle, right), np.where(beyond, left, middle)
    return evaluate(right)


@validated
def horizon(system: System, most: float, drive: str | None = None) -> float:
    """Count the revolutions for which runs at the experiment's and at a ten times looser accuracy agree.

    Two runs agree as long as no entry of their configurations (`linkages.results.divergence`) differs by more than
    `linkages.results.divergence.PARTED`: eccentricities over clearances, and free coordinates. They are compared at 200
    times in each revolution. Both are runs of `linkages.simulate`, so the horizon does not depend on `most`.

    Parameters
    ----------
    system : System
    most : float
        Largest number of compared revolutions, returned if the runs still agree.

    Returns
    -------
    float
        Horizon [revolutions], a multiple of 1/200; `most` if the runs agree up to there.

    Raises
    ------
    InputError, AssemblyError
        See `stroboscopic`.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> linkages.horizon(system, most=1) < 1.0  # without friction
    True
    """
    period = period_of(system, drive)
    fine = lasting(system, most, drive)
    flows = Flow(fine), Flow(looser(fine))
    names = [f"{label}.{axis}" for _, label in system.tree.contacts for axis in ("ex", "ey")]
    names += [] if system.determinate else [f"q.{name}" for name in system.tree.coordinates]
    last = int(most * SECTIONS_LOOKS)
    for first in range(0, last, SECTIONS_AT_ONCE):
        looks = np.arange(first, min(first + SECTIONS_AT_ONCE, last)) + 1
        times = looks * period / SECTIONS_LOOKS
        one, other = (configuration(system, {"time": times, **flow.follow(times, names)}) for flow in flows)
        together = np.all(np.abs(one - other) <= PARTED, axis=1)
        if not together.all():
            return float(looks[np.argmin(together)] - 1) / SECTIONS_LOOKS
    return float(most)
