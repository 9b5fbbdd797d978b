"""Runs of many designs in parallel threads, and the statistics of each."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from linkages.base.errors import AssemblyError, InputError, Status
from linkages.base.kernel import Array, Indices
from linkages.base.kernel.precompiled import processors
from linkages.engines.compiled.batch.designs import Bench, Designs
from linkages.engines.compiled.batch.statistics import NO_IDEAL, STATISTICS
from linkages.engines.compiled.derivatives.neighbours import neighbours
from linkages.engines.compiled.run.job import Given
from linkages.engines.compiled.run.runner import STATUS
from linkages.engines.compiled.simulation import simulate
from linkages.engines.numerics import RUNS_AT_ONCE, RUNS_PARTS, RUNS_PATIENCE
from linkages.engines.threads import in_threads
from linkages.mechanics.integrate.driver import DONE
from linkages.results.derivatives import NO_RUN, REFUSED, Direction
from linkages.results.statistic_derivatives import Wanted, differentiate_statistics
from linkages.system.ideal_motion import cause

#: Statistics of a batch with derivatives.
STATISTICS_WITH_RATES = ("minimum", "maximum", "peak", "mean", "rms", "last")


class Runs:
    """Runs of a table of designs (m, nv), and their results.

    Attributes
    ----------
    found : (m, nw, no, ns) array
        `STATISTICS` of the outputs; NaN for windows of which a failed run did not reach the end.
    times : (nt,) array
        Increasing times of samples [s].
    sampled : (m, nt, no) array
        Outputs at these times, NaN where a failed run did not reach them.
    began : (m,) array of bool
        Whether a run was started.
    reached : (m,) array
        Time before which its windows are valid [s]; infinite where it reached its end.
    status : list of Status
    reason : list of str
        Why a run failed, empty otherwise.
    steps : (m,) array of int
    """

    def __init__(self, designs: Designs, table: Array, times: Array) -> None:
        self.designs, self.table, count = designs, table, len(table)
        self.found = np.full((count, len(designs.windows), len(designs.outputs), len(STATISTICS)), np.nan)
        self.times, self.sampled = times, np.full((count, len(times), len(designs.outputs)), np.nan)
        self.status, self.reason = [Status.OK] * count, [""] * count
        self.steps = np.zeros(count, dtype=np.int64)
        self._ended, self.began = np.zeros((2, count), dtype=bool)
        self.reached = np.full(count, np.inf)
        self._under_way: dict[int, tuple[Array, float]] = {}  # what `run_rows` fills, and the end of runs [s], by row
        self._stop = np.zeros(1, np.int64)
        # One thread builds while the others run: threads that build at once only take the interpreter from each other.
        self._building = threading.Lock()

    def make(self, threads: int | None, progress: Callable[[float], None] | None, limits: Array | None = None) -> None:
        """Run all designs, in threads; values of later tables may lie within `limits` (2, nv)."""
        self.designs.compare(self.table, limits)
        rows = np.arange(len(self.table))
        share = len(rows) // (RUNS_PARTS * (threads or processors()))  # all threads end at about the same time
        size = min(max(share, 1), RUNS_AT_ONCE)
        parts = [rows[first : first + size] for first in range(0, len(rows), size)]
        look = None if progress is None else lambda: progress(self._done())
        in_threads(lambda k: self._run(parts[k]), len(parts), threads, look, self._end)

    def give_up(self) -> None:
        """Mark the runs that have not ended as interrupted."""
        for row in np.flatnonzero(~self._ended).tolist():
            self._fail(row, Status.INTERRUPTED, Status.INTERRUPTED.value)

    def _done(self) -> float:
        """Return the part of all runs that is done."""
        parts = sum(float(np.minimum(ended[:, 1] / end, 1.0).sum()) for ended, end in [*self._under_way.values()])
        return float((self._ended.sum() + parts) / len(self._ended))

    def _end(self) -> None:
        self._stop[0] = 1

    def _run(self, rows: Indices) -> None:
        """Run the designs of some rows."""
        designs, known = self.designs, self.designs.covers(self.table[rows])
        if known.any():
            with designs.bench() as bench:
                columns, words, start = designs.numbers(self.table[rows[known]], bench)
                known[known] = start
                self._use(bench, rows[known], columns, words[start])
        with ExitStack() as benches:
            for prepared in self._prepared(rows[~known], benches):
                self._use(*prepared)

    def _prepared(self, rows: Indices, benches: ExitStack) -> list[tuple[Bench, Indices, Indices, Indices]]:
        """Build the designs of some rows; return the arguments of `_use` for the designs of each structure."""
        alone = len(rows) > 0 and self._building.acquire(timeout=RUNS_PATIENCE)
        try:
            result = []
            for group in self._built(rows).values():
                bench = benches.enter_context(self.designs.bench(group[0][1]))
                columns, words = bench.different(np.stack([words for _, _, words in group]))
                result.append((bench, np.array([row for row, _, _ in group]), columns, words))
            return result
        finally:
            if alone:
                self._building.release()

    def _built(self, rows: Indices) -> dict[Any, list[tuple[int, Given, Indices]]]:
        """Build the designs of some rows: row, system and numbers of each, by structure."""
        built: dict[Any, list[tuple[int, Given, Indices]]] = {}
        for row in rows.tolist():
            if self._stop[0]:
                break
            try:
                given, numbers = self.designs.build(self.table[row])
            except InputError as problem:
                self._fail(row, Status.BAD_INPUT, str(problem))
            except AssemblyError as problem:
                self._fail(row, problem.status, str(problem))
            else:
                built.setdefault(numbers.structure, []).append((row, given, numbers.words))
        return built

    def _use(self, bench: Bench, rows: Indices, columns: Indices, words: Indices) -> None:
        """Run designs of one structure, if any."""
        if not len(rows):
            return
        found, ended = np.empty((len(rows), *self.found.shape[1:])), np.zeros((len(rows), 3))
        sampled = np.empty((len(rows), *self.sampled.shape[1:]))
        self._under_way[int(rows[0])] = ended, bench.end
        bench.run(columns, words, self._stop, self.times, found, sampled, ended)
        del self._under_way[int(rows[0])]
        if self._stop[0]:
            return
        self.found[rows], self.sampled[rows], self.steps[rows], self.began[rows] = found, sampled, ended[:, 2], True
        for k in np.flatnonzero(ended[:, 0] != DONE):
            self._fail(int(rows[k]), *self._reason(int(rows[k]), int(ended[k, 0]), float(ended[k, 1])))
        if self.designs.system.has_light_links:
            self._check_light(rows.tolist())
        self._ended[rows] = True

    def _reason(self, row: int, code: int, time: float) -> tuple[Status, str]:
        """Status of a run that failed, and why."""
        if code == NO_IDEAL:
            self.reached[row], status = 0.0, Status.NO_ASSEMBLY
            return status, f"{status.value}: the ideal linkage does not close; {status.remedy}"
        status = STATUS.get(code, Status.TOO_MANY_STEPS)
        status, time = cause(status, self.designs.built(self.table[row])[0], time)
        return status, self._cut(row, status, time)

    def _check_light(self, rows: list[int]) -> None:
        """Run designs again to see that their links without mass never become free of all masses."""
        for row in rows:
            run = simulate(self.designs.built(self.table[row])[0], outputs=())
            if run.status is Status.FREE_OF_MASS:
                self._fail(row, run.status, self._cut(row, run.status, float(run.time[-1])))

    def _cut(self, row: int, status: Status, time: float) -> str:
        """Remove the numbers of a row from a time [s] on, and return the reason of its end."""
        _, windows = self.designs.built(self.table[row])
        self.found[row, windows[:, 1] >= time] = np.nan
        self.sampled[row, self.times >= time] = np.nan
        self.reached[row] = time
        return f"{status.value}: ended at t = {time:.6g} s; {status.remedy}"

    def _fail(self, row: int, status: Status, reason: str) -> None:
        self.status[row], self.reason[row], self._ended[row] = status, reason, True


def differentiate_runs(
    runs: Runs, wrt: Sequence[str | Direction], threads: int | None, progress: Callable[[float], None]
) -> tuple[dict[str, dict[str, Array]], list[str]]:
    """Differentiate the statistics of m finished runs with respect to values, in threads.

    Runs that did not reach their end have no derivatives. Returns (m, nw, no) arrays by path and statistic, NaN where
    there is none, and the status of each run, see `linkages.results.derivatives.MEANING`. `progress` is called now and
    then with the part that is done. InputError if a path of the nominal system has no number or no derivative.
    """
    paths = [one.path for one in neighbours(runs.designs.system, wrt)]
    count, shape = len(runs.table), runs.found.shape[:3]
    table = np.full((len(STATISTICS_WITH_RATES), len(paths), *shape), np.nan)
    status, done = [NO_RUN] * count, np.zeros(count)

    def differentiate(row: int) -> None:
        """Fill a row of the table, unless its run failed."""
        if runs.status[row] is Status.OK:
            system, windows = runs.designs.built(runs.table[row])
            wanted = [
                Wanted(output, name, float(start), float(end))
                for name in STATISTICS_WITH_RATES
                for start, end in windows
                for output in runs.designs.outputs
            ]
            try:
                run = simulate(system, outputs=runs.designs.outputs, wrt=wrt)
            except InputError:
                status[row] = REFUSED
            else:
                each = differentiate_statistics(run, wanted)
                found = np.array([np.where(one.jump, np.nan, one.rates) for one in each])
                table[:, :, row] = np.moveaxis(found.reshape(len(table), *shape[1:], len(paths)), 3, 1)
                status[row] = run.sensitivity.status
        done[row] = 1.0

    in_threads(differentiate, count, threads, lambda: progress(float(done.mean())))
    rates = {path: {name: table[k, p] for k, name in enumerate(STATISTICS_WITH_RATES)} for p, path in enumerate(paths)}
    return rates, status
