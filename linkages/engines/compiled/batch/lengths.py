"""Designs with other lengths: their numbers without a system for each, to the last bit.

Places are multiples of a power of two (`Mechanism.grid`). So their coordinates are exact sums of such multiples, each
of which follows from one length; tolerances follow from the linkage's size; the state at t = 0 is assembled by compiled
code.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.engines.compiled.run.job import Job
from linkages.engines.compiled.run.model import clearances, error_scale
from linkages.engines.numerics import LENGTHS_NEAR
from linkages.input.files.raw_model import TURN, on_grid
from linkages.mechanics.planar.closure import approach, close, closure_quality, consistent_rates
from linkages.system import System
from linkages.system.assembly import SINGULAR, continuation
from linkages.system.tree import extent_of, joint_ends


class Example(NamedTuple):
    """A design that was built."""

    values: Array  # (nv,)
    words: Indices  # its numbers
    ends: Array  # of its joints in the reference configuration, (np, 2) [m]
    clearances: Array  # `linkages.engines.compiled.run.model.clearances`, (nj,) [m]


def example_of(system: System, values: Array, words: Indices) -> Example:
    """Return a design that was built of values (nv,), with its numbers."""
    return Example(values, words, joint_ends(system.joints.values()), clearances(system))


class Start(NamedTuple):
    """What the state at t = 0 follows from, besides the linkage."""

    places: Array  # of the drives, (nd,) [rad, m]
    speeds: Array
    steps: int  # in which the drives move to their places
    offset: Array  # of the closure rows, (nr,) [m, rad]


def start_of(system: System) -> Start | None:
    """Return what the start follows from; None unless it is the loops and the motions of drives."""
    tree = system.tree
    if not system.starts_unloaded or tree.powered:
        return None
    if not tree.driven or math.isnan(system.assembly.quality):
        return None
    places, speeds = system.motions.start
    return Start(places, speeds, continuation(places), system.start_offsets)


class Lengths:
    """The numbers of designs as functions of their values, and the examples that these follow from.

    Parameters
    ----------
    system : System
        The nominal one.
    examples : sequence of Example
        The nominal one, then two for each variable that differ in this variable alone, then others.
    start : Start

    Attributes
    ----------
    start : Start
    columns : (2 nf + k,) array
        Indices in `contents` of the numbers that differ: those of the start of nf free coordinates, which come first,
        then others.
    """

    def __init__(self, system: System, examples: Sequence[Example], start: Start) -> None:
        words, values = np.stack([each.words for each in examples]), np.stack([each.values for each in examples])
        self._system, self._grid, states = system, system.mechanism.grid, 2 * len(system.tree.free_dofs)
        differ = (words != words[0]).any(axis=0)
        differ[:states] = True
        self.start, self.columns = start, np.flatnonzero(differ)
        self._known = words[:, self.columns]
        numbers = self._known[:, states:].view(np.float64)
        ends = np.stack([example.ends for example in examples])
        play = np.stack([example.clearances for example in examples])
        given = (play[:, :, None] == values[:, None, :]).all(axis=0)  # clearances that are values
        self._play, self._is_given, self._given = play[0], given.any(axis=1), given.argmax(axis=1)
        same = (numbers[:, :, None] == self._others(values, ends)[:, None, :]).all(axis=0)
        self._is_other, self._other = same.any(axis=1), same.argmax(axis=1)
        self._slopes = np.zeros((values.shape[1], numbers.shape[1] + ends[0].size))
        places = np.hstack([numbers, ends.reshape(len(ends), -1)])
        turns = [np.eye(3), *(link.rotation for link in system.links.values())]
        known = np.unique(on_grid(np.abs(turns), TURN))
        for k, slopes in enumerate(self._slopes):
            (low, high), step = places[1 + 2 * k : 3 + 2 * k], values[2 + 2 * k, k] - values[1 + 2 * k, k]
            if step > 0.0:
                slopes[:] = _nearest(known, (high - low) / step, LENGTHS_NEAR * self._grid / step)
        self._base = np.zeros(places.shape[1])
        self._base = places[0] - self._places(values[:1])[0]
        largest = np.abs(np.where(self._is_other, 0.0, numbers)).max(initial=np.abs(ends).max())
        self._exact = largest < 2.0**53 * self._grid  # of two examples, and so of designs between them

    def fits(self, found: Indices) -> bool:
        """Check whether the examples have the numbers (m, 2 nf + k) that are computed."""
        return bool(self._exact) and np.array_equal(found, self._known)

    def numbers(self, table: Array) -> Array:
        """Compute the numbers of designs (m, nv) other than those of the start, (m, k)."""
        places, k = self._places(table), len(self._other)
        others = self._others(table, places[:, k:].reshape(len(table), -1, 2))
        return np.where(self._is_other, others[:, self._other], places[:, :k])

    def _places(self, table: Array) -> Array:
        """Compute numbers that are coordinates of places, then the ends of joints."""
        both = np.tile(self._base, (len(table), 1))
        for values, slopes in zip(table.T, self._slopes, strict=True):
            both += on_grid(values[:, None] * slopes, self._grid)
        return both

    def _others(self, table: Array, ends: Array) -> Array:
        """Compute numbers that are no places, from values (m, nv) and the ends of joints (m, np, 2)."""
        size, accuracy = extent_of(ends), self._system.settings.accuracy
        play = np.where(self._is_given, table[:, self._given], self._play)
        return np.hstack([table, size[:, None], accuracy * error_scale(self._system, size, play)])


def _nearest(known: Array, found: Array, error: float) -> Array:
    """Return the only known magnitude within an error of each of the numbers (k,) found, with its sign; else NaN."""
    near = np.abs(np.abs(found)[:, None] - known) <= error
    return np.where(near.sum(axis=1) == 1, np.copysign(known[near.argmax(axis=1)], found), np.nan)


@kernel(makes_arrays=True)
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


@kernel(makes_arrays=True)
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
