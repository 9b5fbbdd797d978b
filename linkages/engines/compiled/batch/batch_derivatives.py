"""Derivatives of the statistics of a batch: each run as a single run, with the same code and the same numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from linkages.base.errors import InputError, Status
from linkages.base.kernel import Array
from linkages.engines.compiled.batch.runs import Runs
from linkages.engines.compiled.derivatives.neighbours import neighbours
from linkages.engines.compiled.simulation import simulate
from linkages.engines.threads import in_threads
from linkages.results.derivatives import NO_RUN, REFUSED, Direction
from linkages.results.statistic_derivatives import Wanted, differentiate_statistics

#: Statistics of a batch with derivatives.
STATISTICS_WITH_RATES = ("minimum", "maximum", "peak", "mean", "rms", "last")


def differentiate_runs(
    runs: Runs,
    wrt: Sequence[str | Direction],
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[dict[str, dict[str, Array]], list[str]]:
    """Differentiate the statistics of m finished runs with respect to values, in threads.

    Parameters
    ----------
    runs : Runs
        Those that did not reach their end have no derivatives.
    wrt : sequence of str or Direction
        Dotted paths of np values, or values that several paths follow.
    threads : int, optional
    progress : callable, optional
        Called now and then with the part that is done, 0 to 1.

    Returns
    -------
    rates : dict of dict of (m, nw, no) arrays
        By path and statistic; NaN where there is none.
    status : list of str
        See `linkages.results.derivatives.MEANING`.

    Raises
    ------
    InputError
        If a path of the nominal system has no number or no derivative.
    """
    paths = [one.path for one in neighbours(runs.designs.system, wrt)]
    count, shape = len(runs.table), runs.found.shape[:3]
    table = np.full((len(STATISTICS_WITH_RATES), len(paths), *shape), np.nan)
    status, done = [NO_RUN] * count, np.zeros(count)

    def differentiate(row: int) -> None:
        """Fill a row of the table, unless its run failed."""
        if runs.status[row] is Status.OK:
            table[:, :, row], status[row] = _of_row(runs, row, wrt)
        done[row] = 1.0

    look = None if progress is None else lambda: progress(float(done.mean()))
    in_threads(differentiate, count, threads, look)
    rates = {path: {name: table[k, p] for k, name in enumerate(STATISTICS_WITH_RATES)} for p, path in enumerate(paths)}
    return rates, status


def _of_row(runs: Runs, row: int, wrt: Sequence[str | Direction]) -> tuple[Array, str]:
    """Return the derivatives of a run's statistics, (ns, np, nw, no), and their status."""
    system, windows = runs.designs.built(runs.table[row])
    outputs = runs.designs.outputs
    shape = len(STATISTICS_WITH_RATES), len(windows), len(outputs), len(wrt)
    try:
        run = simulate(system, outputs=outputs, wrt=wrt)
    except InputError:
        return np.full((shape[0], shape[3], *shape[1:3]), np.nan), REFUSED
    wanted = [
        Wanted(output, name, float(start), float(end))
        for name in STATISTICS_WITH_RATES
        for start, end in windows
        for output in outputs
    ]
    found = np.array([one.rates for one in differentiate_statistics(run, wanted)]).reshape(shape)
    return np.moveaxis(found, 3, 1), run.sensitivity.status
