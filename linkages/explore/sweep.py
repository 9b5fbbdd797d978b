"""Sections over the values of one variable: bifurcation diagrams."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

from linkages.base.arguments import Count, Names, Whole, validated, vector
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import ARGUMENT, InputError, Status
from linkages.engines.compiled.effects import check_varied
from linkages.engines.threads import in_threads
from linkages.explore.sections import Section, checked, horizon, sections
from linkages.system import System


@dataclass(frozen=True)
class SweepPoint:
    """One value of the variable.

    Attributes
    ----------
    value : float
    section : Section or None
        None if the linkage could not be assembled.
    status : Status
    horizon : float or None
        Number of revolutions from the start for which two tolerances agree (`linkages.explore.sections.horizon`); None
        without contacts, or if not requested.
    """

    value: float
    section: Section | None
    status: Status
    horizon: float | None = None

    def mean_peak(self, name: str) -> float:
        """Return the mean of the revolutions' peaks of an output; NaN without a finished revolution."""
        if self.section is None or not len(self.section.times):
            return float("nan")
        return float(self.section.peaks(name).mean())


@dataclass(frozen=True, repr=False)
class Sweep(Brief):
    """Sections of outputs at every value of a variable; made by `sweep`.

    Attributes
    ----------
    path : str
        Dotted path of the variable.
    names : tuple of str
        Names of the outputs.
    transient : int
        Revolutions that were discarded before each section.
    points : tuple of SweepPoint
        In the order of the values.
    status : Status
        INTERRUPTED if the sweep was: some values then have no section or no horizon.
    unit : str
        SI unit of the variable; empty for a pure number.
    """

    path: str
    names: tuple[str, ...]
    transient: int
    points: tuple[SweepPoint, ...]
    status: Status = Status.OK
    unit: str = ""

    def _facts(self) -> tuple[str, dict[str, str]]:
        values = [point.value for point in self.points]
        span = f" from {min(values):g} to {max(values):g}" if values else ""
        failed = sum(point.status is not Status.OK for point in self.points)
        line = f"{self.path}, {counted(len(values), 'value')}{span}; {failed:,} failed"
        return line, {"outputs": ", ".join(self.names), "transient": counted(self.transient, "revolution")}


@validated
def sweep(
    system: System,
    path: str,
    values: Annotated[Sequence[float] | Array, vector],
    names: Names,
    revolutions: Count,
    transient: Whole = 0,
    drive: str | None = None,
    horizons: bool = False,
    threads: Count | None = None,
    progress: Callable[[float], None] | None = None,
    origin: str = ARGUMENT,
) -> Sweep:
    """Take a stroboscopic section at every value of a variable, in threads; their number has no effect.

    Use `simulate_batch` for statistics without sections. Every run starts from the experiment's initial state.

    Parameters
    ----------
    system : System
    path : str
        Dotted path of the variable, of the experiment or, with ``sdf.``, of the machine.
    values : sequence of float
    names : sequence of str
        Recorded outputs; see `linkages.results.outputs.registry`.
    revolutions, transient : int
        Recorded revolutions, and discarded ones before them.
    drive : str, optional
        Drive that defines a revolution; default: see `linkages.explore.flow.period_of`.
    horizons : bool
        Whether to compute the horizon of each value (joints with contact only).
    threads : int, optional
        Number of threads; default: number of processors.
    progress : callable, optional
        Called with the finished fraction, 0 to 1.
    origin : str
        Origin of the values, named in errors.

    Returns
    -------
    Sweep
        A section for each value, in their order. Ctrl-C ends the sweep, not the call: values that are not finished have
        the status ``INTERRUPTED``, and `Sweep.status` tells it.

    Raises
    ------
    InputError
        If path, a value or a name is not valid; raised before any run.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> over = linkages.sweep(system, "joints.B.clearance", [1e-4, 2e-4], ["B.force"], revolutions=2)
    >>> [float(point.section.peaks("B.force").max().round(-2)) for point in over.points]  # N
    [26300.0, 33300.0]
    """
    if len(values) == 0:
        raise InputError("argument", path, "has no values")
    systems = [system.replaced({path: float(value)}, origin) for value in values]
    check_varied(system, path, [min(values), max(values)], origin, names)
    wanted = [k for k, case in enumerate(systems) if horizons and case.can_touch]
    share = 0.5 if wanted else 1.0  # a horizon takes about the same time again
    look = None if progress is None else lambda done: progress(share * done)
    points, interrupted = points_of(systems, values, names, revolutions, transient, drive, threads, look)
    known: dict[int, float] = {}
    if not interrupted and (wanted := [k for k in wanted if points[k].section is not None]):
        watch = None if progress is None else lambda: progress(1.0 - share * (1.0 - len(known) / len(wanted)))

        def turns(k: int) -> None:
            known[wanted[k]] = horizon(systems[wanted[k]], transient + revolutions, drive)

        try:
            in_threads(turns, len(wanted), threads, watch)
        except KeyboardInterrupt:
            interrupted = True
    status = Status.INTERRUPTED if interrupted else Status.OK
    found = (replace(point, horizon=known.get(k)) for k, point in enumerate(points))
    return Sweep(path, tuple(names), transient, tuple(found), status, system.value_unit(path))


def points_of(
    systems: Sequence[System],
    values: Sequence[float] | Array,
    names: Sequence[str],
    revolutions: int,
    transient: int,
    drive: str | None,
    threads: int | None,
    progress: Callable[[float], None] | None,
) -> tuple[list[SweepPoint], bool]:
    """Return a point for the system of each value, without horizon, and whether Ctrl-C ended the runs."""
    cases = checked(systems, names, revolutions, transient, drive)
    found, interrupted = sections(cases, names, revolutions, transient, threads, progress)
    points = []
    for value, section in zip(map(float, values), found, strict=True):
        if isinstance(section, Status):
            points.append(SweepPoint(value, None, section))
        else:
            points.append(SweepPoint(value, section, section.status))
    return points, interrupted
