"""Outputs of a run and their derivatives at the times of samples."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from linkages import InputError, RunError, Status, System
from linkages.base.arrays import Array
from linkages.elements.analysis import Analysis
from linkages.engines.assessment import differentiated
from linkages.engines.compiled.batch.batch import run_batch
from optim.identify.nodes import between_nodes
from optim.identify.numerics import CURVES_DIFFERENCE, CURVES_STEP


def step_in_time(times: Array, end: float) -> float:
    """Return the step of differences with respect to time [s], for samples of a run that ends at a time."""
    return CURVES_STEP * float(np.diff(times).mean()) if len(times) > 1 else CURVES_STEP * end


class Curves:
    """Outputs of a run and their derivatives at the times of samples; beyond the run's ends they continue straight.

    `until` is the time up to which derivatives are known [s]. RunError if the run does not reach its end.

    Parameters
    ----------
    system : System
    paths : list of str
        Of np values.
    values : (np,) array
    wanted : list of (str, (nt,) array)
        Outputs, and the times at which each is compared [s].
    moved : bool
        Whether the derivatives to time are wanted.
    derivatives : bool
        Whether the derivatives with respect to the values are wanted.
    """

    def __init__(
        self, system: System, paths: list[str], values: Array, wanted: list[tuple[str, Array]], moved: bool,
        derivatives: bool = True,
    ) -> None:  # fmt: skip
        self.system, self.paths, self.numbers = system, paths if derivatives else [], values
        self.outputs = list(dict.fromkeys(output for output, _ in wanted))
        try:
            system.check_analysis(Analysis.DERIVATIVES)
            self._exact = True
        except InputError:
            self._exact = False
        self._run = differentiated(system, self.outputs, self.paths if self._exact else ())
        self.end = float(self._run.time[-1])
        if self._run.status is not Status.OK:
            raise RunError(f"the run ended at t = {self.end:.6g} s: {self._run.status.value}")
        self.until = self._run.sensitivity.until if self._exact and self.paths else math.inf
        self._moved, self._known = moved, dict[bytes, Array]()
        distinct = {times.tobytes(): times for _, times in wanted}.values()  # columns of a file have the same times
        self._times = np.unique(np.clip(np.concatenate(list(distinct)), 0.0, self.end))
        self._values, self._slopes = self._at_samples()

    def __call__(self, output: str, times: Array) -> tuple[Array, Array, Array]:
        """Return an output (nt,), its derivatives with respect to the values (nt, np), and to time (nt,)."""
        inside = np.clip(times, 0.0, self.end)
        places, k = np.searchsorted(self._times, inside), self.outputs.index(output)
        computed, rate = self._values[k, places], np.zeros(len(times))
        if self._moved or np.any(times != inside):
            rate = self._rates(times, inside)[k]
        slopes = self._slopes[:, k, places].T if self._exact else self._differences(output, inside)
        return computed + rate * (times - inside), slopes, rate

    def _at_samples(self) -> tuple[Array, Array]:
        """Return the outputs (no, nt) at all samples, and their derivatives (np, no, nt) from the same steps."""
        count = len(self.paths) if self._exact else 0
        found = self._between(self._times, self._with_slopes if count else self._alone)
        table = found.reshape(1 + count, len(self.outputs), len(self._times))
        return table[0], table[1:]

    def _between(self, times: Array, evaluate: Callable[[Array], Array]) -> Array:
        return between_nodes(self._run.time, times, evaluate, self.system.settings.accuracy)

    def _alone(self, times: Array) -> Array:
        assert self._run.evaluate is not None
        found = self._run.evaluate(times)
        return np.array([found[name] for name in self.outputs])

    def _with_slopes(self, times: Array) -> Array:
        values, slopes = self._run.sensitivity.with_values(times)
        return np.array([own[name] for own in (values, *slopes.values()) for name in self.outputs])

    def _rates(self, times: Array, inside: Array) -> Array:
        """Return the derivatives of the outputs to time (no, nt), once for columns with the same times."""
        key = times.tobytes()
        if key not in self._known:
            step = step_in_time(times, self.end)
            after, before = np.minimum(inside + step, self.end), np.maximum(inside - step, 0.0)
            ends = (self._between(at, self._alone) for at in (after, before))
            self._known[key] = np.subtract(*ends) / (after - before)
        return self._known[key]

    def _differences(self, output: str, times: Array) -> Array:
        """Central differences of runs, for models without derivatives."""
        if not self.paths:
            return np.zeros((len(times), 0))
        steps = CURVES_DIFFERENCE * np.maximum(np.abs(self.numbers), 1e-9)
        table = np.concatenate([self.numbers + sign * np.diag(steps) for sign in (1.0, -1.0)])
        grid, places = np.unique(times, return_inverse=True)
        batch = run_batch(self.system, self.paths, table, [output], samples=grid, progress=lambda part: None)
        plus, minus = np.split(batch.samples[:, :, 0], 2)
        return np.asarray(((plus - minus) / (2.0 * steps[:, None])).T[places], np.float64)
