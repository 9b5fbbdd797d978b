"""Designs with other lengths: their numbers without a system for each.

The numbers of a run are affine in lengths, or proportional to a power of the linkage's size (`Tree.extent`). The state
at t = 0 is neither: compiled code assembles it. Both agree with systems to about 1e-13, relative to the largest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.engines.compiled.run.job import Job
from linkages.mechanics.planar.closure import approach, close, closure_quality, consistent_rates
from linkages.system import System
from linkages.system.assembly import SINGULAR, continuation, start_offsets
from linkages.system.tree import extent_of

_SAME, _ERROR = 1e-13, 1e-12  # largest errors: of proportional numbers; of all, in parts of the largest of the examples
_INTEGER = 1e-290  # an integer, read as a float, is smaller


class Example(NamedTuple):
    """A design that was built."""

    values: Array  # (nv,)
    words: Indices  # its numbers
    ends: Array  # of the joints, (np, 2) [m]


class Start(NamedTuple):
    """What the state at t = 0 follows from, besides the linkage."""

    places: Array  # of the drives, (nd,) [rad, m]
    speeds: Array
    steps: int  # in which the drives move to their places
    offset: Array  # of the closure rows, (nr,) [m, rad]


def start_of(system: System) -> Start | None:
    """Return what the start follows from; None unless it is the loops and the motions of drives.

    None if contacts can touch, too: impacts magnify errors.
    """
    tree, experiment = system.tree, system.experiment
    if experiment.start != "centred" or tree.flexible or tree.powered or system.touching.any():
        return None
    if not tree.driven or math.isnan(system.assembly.quality):
        return None
    places, speeds = system.motions.start
    return Start(places, speeds, continuation(places), start_offsets(tree, experiment))


class Lengths:
    """The numbers of designs as functions of their values, and the examples that these follow from.

    Parameters
    ----------
    examples : sequence of Example
        The nominal one, then two for each variable that differ in this variable alone, then others.
    start : Start
    free : int
        Number nf of free coordinates.

    Attributes
    ----------
    start : Start
    columns : (2 nf + k,) array
        Indices in `contents` of the numbers that differ: those of the start, which come first, then others.
    """

    def __init__(self, examples: Sequence[Example], start: Start, free: int) -> None:
        words, values, ends = map(np.stack, zip(*((x.words, x.values, x.ends) for x in examples), strict=True))
        differ = (words != words[0]).any(axis=0)
        differ[: 2 * free] = True
        self.start, self.columns = start, np.flatnonzero(differ)
        self._known, self._free = words[:, self.columns].view(np.float64), free
        numbers, size = self._known[:, 2 * free :], extent_of(ends)[:, None]
        self._power = np.zeros(numbers.shape[1])
        for power in (-1.0, 1.0):
            rest = np.abs(numbers / size**power)
            self._power[np.ptp(rest, axis=0) <= _SAME * rest[0]] = power
        both = np.hstack([numbers / size**self._power, ends.reshape(len(ends), -1)])
        n = values.shape[1]
        low, high = slice(1, 1 + 2 * n, 2), slice(2, 2 + 2 * n, 2)
        steps, changes = np.diag(values[high] - values[low])[:, None], both[high] - both[low]
        self._slopes = np.divide(changes, steps, out=np.zeros_like(changes), where=steps != 0.0)
        self._base = both[0] - values[0] @ self._slopes

    def fits(self, found: Array) -> bool:
        """Check whether the examples have the numbers (m, 2 nf + k) that are computed."""
        known, free = np.abs(self._known), self._free
        scale = known.max(axis=0)
        scale[:free], scale[free : 2 * free] = scale[:free].max(initial=0.0), scale[free : 2 * free].max(initial=0.0)
        whole = (known < _INTEGER) & (known != 0.0)
        return not whole.any() and bool(np.all(np.abs(found - self._known) <= _ERROR * scale))

    def affine(self, table: Array) -> Array:
        """Compute the numbers of designs (m, nv) other than those of the start, (m, k)."""
        both, k = np.tile(self._base, (len(table), 1)), len(self._power)
        for values, slopes in zip(table.T, self._slopes, strict=True):  # a product of matrices would depend on m
            both += values[:, None] * slopes
        return np.asarray(both[:, :k] * extent_of(both[:, k:].reshape(len(table), -1, 2))[:, None] ** self._power)


@kernel
def fill_starts(
    job: Job,
    memory: Indices,
    columns: Indices,
    words: Indices,
    places: Array,
    speeds: Array,
    steps: int,
    offset: Array,
    starts: Array,
) -> None:
    """Assemble the designs of m rows: ``starts`` (m, 2 nf) gets the positions and rates of the free coordinates.

    Rows without a regular position at the start get NaN. For the arguments see `Start` and
    `linkages.engines.compiled.batch.statistics.run_rows`.
    """
    q, v, a = np.empty((3, len(job.equations.work.dynamics.q)))
    for i in range(len(words)):
        for k in range(len(columns)):
            memory[columns[k]] = words[i, k]
        q[:], v[:], a[:] = 0.0, 0.0, 0.0
        starts[i] = math.nan
        if _is_placed(job, places, steps, offset, q):
            _set_start(job, speeds, q, v, a, starts[i])


@kernel
def _is_placed(job: Job, places: Array, steps: int, offset: Array, q: Array) -> bool:
    """Move the linkage from the reference configuration, where q is zero, to the start, as `assemble` does."""
    model, rows, closing = job.equations.model, job.rows, job.closing
    if not close(model.bodies, rows, np.zeros(len(rows)), closing, model.size, q):
        return False
    if closure_quality(model.bodies, rows, closing, q) < SINGULAR:
        return False
    if not approach(model.bodies, rows, closing, model.size, model.driven, places, steps, q):
        return False
    if not close(model.bodies, rows, offset, closing, model.size, q):
        return False
    return closure_quality(model.bodies, rows, closing, q) >= SINGULAR


@kernel
def _set_start(job: Job, speeds: Array, q: Array, v: Array, a: Array, start: Array) -> None:
    """Compute the rates v at coordinates q, and set the start (2 nf,); a is scratch."""
    model, count = job.equations.model, len(job.equations.model.free)
    for k in range(len(speeds)):
        v[model.driven[k]] = speeds[k]
    consistent_rates(model.bodies, job.rows, job.closing, q, v, a)
    for k in range(count):
        start[k], start[count + k] = q[model.free[k]], v[model.free[k]]
