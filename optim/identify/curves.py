"""Outputs of a run and their derivatives at the times of samples."""

from __future__ import annotations

import math

import numpy as np

from linkages import InputError, RunError, Status, System
from linkages.base.arrays import Array
from linkages.elements.analysis import Analysis
from linkages.engines.assessment import differentiated
from linkages.engines.compiled.batch.batch import run_batch
from linkages.results.outputs.columns import Columns

_STEP = 1e-3  # step of differences with respect to time, relative to the interval of samples
_DIFFERENCE = 1e-5  # step of differences of runs, for models without derivatives, in the unknown's own scale


def step_in_time(times: Array, end: float) -> float:
    """Return the step of differences with respect to time [s], for samples of a run that ends at a time."""
    return _STEP * float(np.diff(times).mean()) if len(times) > 1 else _STEP * end


class Curves:
    """Outputs of a run and their derivatives at any times; beyond the run's ends they continue in straight lines.

    `until` is the time up to which derivatives are known [s]. RunError if the run does not reach its end.
    """

    def __init__(
        self, system: System, paths: list[str], values: Array, outputs: list[str], derivatives: bool = True
    ) -> None:
        self.system, self.paths, self.numbers = system, paths if derivatives else [], values
        self.outputs = list(dict.fromkeys(outputs))
        try:
            system.check_analysis(Analysis.DERIVATIVES)
            self._exact = True
        except InputError:
            self._exact = False
        self._run = differentiated(system, self.outputs, self.paths if self._exact else ())
        self._computed: dict[bytes, Columns] = {}
        self._known: dict[bytes, dict[str, Columns]] = {}
        self.end = float(self._run.time[-1])
        if self._run.status is not Status.OK:
            raise RunError(f"the run ended at t = {self.end:.6g} s: {self._run.status.value}")
        self.until = self._run.sensitivity.until if self._exact and self.paths else math.inf

    def __call__(self, output: str, times: Array, moved: bool) -> tuple[Array, Array, Array]:
        """Return an output (nt,), its derivatives with respect to the values (nt, np), and to time (nt,)."""
        inside = np.clip(times, 0.0, self.end)
        step = step_in_time(times, self.end)
        computed, rate = self._at(output, inside), np.zeros(len(times))
        if moved or np.any(times != inside):
            after, before = np.minimum(inside + step, self.end), np.maximum(inside - step, 0.0)
            rate = (self._at(output, after) - self._at(output, before)) / (after - before)
        return computed + rate * (times - inside), self._rates(output, inside), rate

    def _at(self, output: str, times: Array) -> Array:
        assert self._run.evaluate is not None
        key = times.tobytes()
        if key not in self._computed:  # columns of a file have the same times
            self._computed[key] = self._run.evaluate(times)
        return np.asarray(self._computed[key][output], np.float64)

    def _rates(self, output: str, times: Array) -> Array:
        if not self.paths:
            return np.zeros((len(times), 0))
        if self._exact:
            key = times.tobytes()
            if key not in self._known:
                self._known[key] = self._run.sensitivity.evaluate(times)
            found = self._known[key]
            return np.column_stack([found[path][output] for path in self.paths])
        return self._differences(output, times)

    def _differences(self, output: str, times: Array) -> Array:
        """Central differences of runs, for models without derivatives."""
        steps = _DIFFERENCE * np.maximum(np.abs(self.numbers), 1e-9)
        table = np.concatenate([self.numbers + sign * np.diag(steps) for sign in (1.0, -1.0)])
        grid, places = np.unique(times, return_inverse=True)
        batch = run_batch(self.system, self.paths, table, [output], samples=grid, progress=lambda part: None)
        plus, minus = np.split(batch.samples[:, :, 0], 2)
        return np.asarray(((plus - minus) / (2.0 * steps[:, None])).T[places], np.float64)
