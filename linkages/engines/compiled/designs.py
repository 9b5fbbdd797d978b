"""Designs of a batch as numbers: everything that a run reads, for each row of values.

The system of a design, built as for a single run, has its numbers. Many values are themselves
such numbers, for example masses and viscosities: they are written in their places, and no system is built. `Designs`
finds these places by comparison with systems that are built.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from linkages.engines.compiled.job import END, Given, Job, make_given, make_job
from linkages.engines.compiled.rows import run_rows
from linkages.errors import AssemblyError, InputError
from linkages.kernel import Array, Indices
from linkages.kernel.block import Block, contents
from linkages.outputs.registry import pack
from linkages.system import System


class Designs:
    """The designs of a batch.

    Attributes
    ----------
    columns : (k,) array of int
        Indices in `contents` of the numbers that are replaced by values.
    """

    def __init__(self, system: System, variables: tuple[str, ...], outputs: tuple[str, ...], windows: Array) -> None:
        self.system, self.variables, self.outputs, self.windows = system, variables, outputs, windows
        self.columns, self._source = np.zeros((2, 0), np.int64)
        self._low, self._high = np.full((2, len(variables)), np.nan)
        self._replace = True  # whether values replace numbers, as far as known
        self._nominal: Given | None = None
        self._benches: dict[Any, list[Bench]] = {}  # that no thread uses, by structure

    def built(self, values: Array) -> tuple[System, Array]:
        """Return the system with the values (nv,) of a design, and its windows."""
        return self.system.replaced(dict(zip(self.variables, map(float, values), strict=True))), self.windows

    def given(self, values: Array) -> Given:
        """Build the system of a design (nv,), and collect its numbers.

        Raises
        ------
        InputError, AssemblyError
            If a value is not valid, or the linkage cannot be assembled.
        """
        system, windows = self.built(values)
        if np.any(windows[:, 1] > system.experiment.duration * (1.0 + 1e-12)):
            raise InputError("", "", "a window ends after the run")
        return make_given(system, pack(system, self.outputs), windows)

    def covers(self, table: Array) -> NDArray[np.bool_]:
        """Tell which designs (m, nv) need not be built: their values replace numbers."""
        known = self._nominal is not None
        return known & np.all((self._low <= table) & (table <= self._high), axis=1)

    def words(self, table: Array) -> Indices:
        """Return the values of designs (m, nv) in the order of `columns`, as the bits of numbers, (m, k)."""
        return np.ascontiguousarray(table[:, self._source]).view(np.int64)

    def compare(self, table: Array) -> None:
        """Build designs at the limits of a table; if they have the values as numbers, `covers` has these limits.

        The designs have each variable alone at its limits, and each pair of variables at all corners of their limits: a
        condition that a larger or smaller value breaks, alone or with another one, holds between the corners if it
        holds there.
        """
        n = len(self.variables)
        if not self._replace or np.count_nonzero(~self.covers(table)) <= len(_corners(*np.zeros((3, n)))):
            return
        low, high = np.fmin.reduce(table, axis=0), np.fmax.reduce(table, axis=0)
        if np.all((self._low <= low) & (high <= self._high)):
            return
        try:
            usual = np.array([self.system.value(path) for path in self.variables])
            self._nominal = self.given(usual)
            low, high = np.fmin(low, self._low), np.fmax(high, self._high)
            corners = _corners(low, high, usual)
            found = [contents(self.given(corner)) for corner in corners]
        except (InputError, AssemblyError):
            return
        nominal = contents(self._nominal)
        self._replace = all(each.structure == nominal.structure for each in found)
        if not self._replace:
            return
        words = np.stack([each.words for each in found])
        source = np.full(len(nominal.words), -1)
        for k in range(len(usual)):
            alone = words[2 * k : 2 * k + 2]
            source[(alone != nominal.words).any(axis=0)] = k
        self.columns = np.flatnonzero(source >= 0)
        self._source = source[self.columns]
        expected = np.tile(nominal.words, (len(words), 1))
        expected[:, self.columns] = self.words(corners)
        self._replace = bool(np.array_equal(words, expected))
        if self._replace:
            self._low, self._high = low, high

    @contextmanager
    def bench(self, given: Given | None = None) -> Iterator[Bench]:
        """Lend memory for designs with the structure of `given`, default of the nominal one."""
        found = given or self._nominal
        assert found is not None  # as soon as it covers designs
        free = self._benches.setdefault(contents(found).structure, [])
        try:
            bench = free.pop()
        except IndexError:
            bench = Bench(found)
        yield bench
        free.append(bench)


class Systems(Designs):
    """Systems as the designs of a batch, each with its own windows (m, nw, 2); a table has indices, (m, 1)."""

    def __init__(self, systems: Sequence[System], outputs: tuple[str, ...], windows: Array) -> None:
        super().__init__(systems[0], (), outputs, windows[0])
        self._systems, self._own, self._replace = systems, windows, False

    def built(self, values: Array) -> tuple[System, Array]:
        """Return the system of an index (1,), and its windows."""
        return self._systems[int(values[0])], self._own[int(values[0])]


class Bench:
    """Memory in which designs of one structure run, one after the other."""

    def __init__(self, given: Given) -> None:
        self._words, self.end = contents(given).words, float(given.limits[END])
        self._block = Block(make_job(given))

    def different(self, words: Indices) -> tuple[Indices, Indices]:
        """Find which numbers of designs (m, n) differ from the bench's own: their indices (k,), and they, (m, k)."""
        columns = np.flatnonzero((words != self._words).any(axis=0))
        return columns, words[:, columns]

    def run(self, columns: Indices, words: Indices, stop: Indices, found: Array, ended: Array) -> None:
        """Run designs (m,); see `linkages.engines.compiled.rows.run_rows`."""
        block = self._block
        run_rows(cast(Job, block), block.memory, block.initial, block.where[columns], words, stop, found, ended)


def _corners(low: Array, high: Array, usual: Array) -> Array:
    """Designs at limits (nv,): for each variable two with it alone, then with all, each pair in all combinations."""
    n = len(usual)
    alone = np.tile(usual, (2 * n, 1))
    alone[2 * np.arange(n), np.arange(n)], alone[2 * np.arange(n) + 1, np.arange(n)] = low, high
    bits = [np.zeros(n, bool), *(np.arange(n) >> bit & 1 == 1 for bit in range(max(n - 1, 0).bit_length()))]
    sides = np.array([*bits, *(~side for side in bits)])
    return np.concatenate([alone, np.where(sides, high, low)])


@lru_cache(maxsize=8)
def designs_of(system: System, variables: tuple[str, ...], outputs: tuple[str, ...], windows: bytes) -> Designs:
    """Return the designs of a batch; the same arguments give the same object, with the limits that it has compared."""
    return Designs(system, variables, outputs, np.frombuffer(windows).reshape(-1, 2))
