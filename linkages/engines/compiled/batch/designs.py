"""Designs of a batch as numbers: everything that a run reads, for each row of values.

The system of a design, built as for a single run, has its numbers. Many values are themselves
such numbers, for example masses and viscosities: they are written in their places, and no system is built for them.
`Designs` finds these places by comparison with systems that are built.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache, partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from linkages.base.errors import AssemblyError, InputError
from linkages.base.kernel import Array, Indices
from linkages.base.kernel.block import Block, Contents, contents
from linkages.engines.budget import most
from linkages.engines.compiled.batch.lengths import Lengths, Start, example_of, fill_starts, start_of
from linkages.engines.compiled.batch.statistics import run_rows
from linkages.engines.compiled.run.job import END, Given, Job, make_given, make_job
from linkages.results.outputs.registry import pack, packer
from linkages.system import System
from linkages.system.replacing import keeps_start

_PART, _BEGIN = 0.618, 0.01  # of the way from the least to the greatest value


class Designs:
    """The designs of a batch.

    `columns` (k,) are the indices in `contents` of the numbers that values replace; `checked` tells whether the paths
    of the variables are known to exist.
    """

    def __init__(self, system: System, variables: tuple[str, ...], outputs: tuple[str, ...], windows: Array) -> None:
        self.system, self.variables, self.outputs, self.windows = system, variables, outputs, windows
        self.columns, self._source = np.zeros((2, 0), np.int64)
        self.checked = False
        self._low, self._high = np.full((2, len(variables)), np.nan)
        self._compared = False  # whether it is known which values are numbers, within the limits at least
        self._limited = False  # whether designs at limits have been compared
        self._numbers = np.zeros(len(variables), bool)  # variables whose values are
        self._lengths: Lengths | None = None  # designs within the limits whose values are not all numbers
        self._records = packer(system, outputs)  # all designs have the same elements
        self._most: int | None = most(system)
        self._nominal: Given | None = None
        self._structure: tuple[Any, ...] = ()  # of the nominal design
        self._latest: tuple[bytes, Given] | None = None  # the system built last: its values
        self._benches: dict[Any, list[Bench]] = {}  # that no thread uses, by structure

    def built(self, values: Array, left: Any = False) -> tuple[System, Array]:
        """Return the system with the values (nv,) of a design, some of them `left` as they are, and its windows."""
        new = zip(self.variables, map(float, values), np.broadcast_to(left, values.shape), strict=True)
        return self.system.replaced({path: value for path, value, stays in new if not stays}), self.windows

    def given(self, values: Array, left: Any = False) -> Given:
        """Build the system of a design (nv,), and collect its numbers.

        InputError if a value is not valid, AssemblyError if the linkage cannot be assembled.
        """
        return self._given(*self.built(values, left))

    def _given(self, system: System, windows: Array) -> Given:
        if np.any(windows[:, 1] > system.settings.duration * (1.0 + 1e-12)):
            raise InputError("", "", "a window ends after the run")
        return make_given(system, self._records(system), windows, self._most)

    def build(self, values: Array) -> tuple[Given, Contents]:
        """Build a system for a design (nv,), with other values where these are numbers; return it, and all numbers.

        Errors as for `given`.
        """
        if self._numbers.any() and self._inside(values):
            with suppress(InputError, AssemblyError):  # the message may depend on all values
                key, latest = values[~self._numbers].tobytes(), self._latest
                if latest is None or latest[0] != key:
                    self._latest = latest = key, self.given(values, self._numbers)
                found = contents(latest[1])
                if found.structure == self._structure:
                    return latest[1], found._replace(words=self._written(found.words, values))
        given = self.given(values)
        return given, contents(given)

    def _inside(self, table: Array) -> Any:
        """Tell which designs (..., nv) are within the limits that are compared."""
        return np.all((self._low <= table) & (table <= self._high), axis=-1)

    def covers(self, table: Array) -> NDArray[np.bool_]:
        """Tell which designs (m, nv) need not be built: all their values are numbers."""
        known = self._nominal is not None and (self._numbers.all() or self._lengths is not None)
        return known & self._inside(table)

    def words(self, table: Array) -> Indices:
        """Return the values of designs (m, nv) in the order of `columns`, as the bits of numbers, (m, k)."""
        return np.ascontiguousarray(table[:, self._source]).view(np.int64)

    def numbers(self, table: Array, bench: Bench) -> tuple[Indices, Indices, NDArray[np.bool_]]:
        """Compute the numbers that differ in designs (m, nv) which `covers` names: indices (k,), values (m, k).

        The last result tells which designs start, (m,): the others must be built, to know why they do not.
        """
        if self._lengths is None:
            return self.columns, self.words(table), np.ones(len(table), bool)
        return self._lengths.columns, *bench.started(self._lengths, table)

    def _written(self, words: Indices, values: Array) -> Indices:
        """Write the values (nv,) of a design that are numbers into a copy of its numbers."""
        result = words.copy()
        result[self.columns] = self.words(values[None])[0]
        return result

    def compare(self, table: Array, limits: Array | None = None) -> None:
        """Build designs at the limits of a table, and find out which values are numbers within these limits.

        The designs have each variable alone at its limits, and each pair of variables at all corners of their limits: a
        condition that a larger or smaller value breaks, alone or with another one, holds between the corners if it
        holds there. If all designs at the `limits` (2, nv) of later tables can be built too, they are compared with.
        """
        if limits is not None and not self._limited:
            self._limited = True
            if not all(map(keeps_start, self.variables)):
                self._compare(limits)
        few = len(_corners(*np.zeros((3, len(self.variables)))))
        useless = self._compared and not self._numbers.any() and self._lengths is None
        if useless or np.sum(~self._inside(table)) <= few:
            return
        if limits is None or not self._compare(np.vstack([table, limits])):
            self._compare(table)

    def _compare(self, table: Array) -> bool:
        """Compare designs at the limits of a table; False if one of them cannot be built."""
        n = len(self.variables)
        low = np.fmin(np.fmin.reduce(table, axis=0), self._low)
        high = np.fmax(np.fmax.reduce(table, axis=0), self._high)
        try:
            usual = np.array([self.system.value(path) for path in self.variables])
            nominal, corners = self.given(usual), _corners(low, high, usual)
            alone = [contents(self.given(corner)) for corner in corners[: 2 * n]]
            numbers, columns, source = _places(contents(nominal), corners, alone)
            start = None if numbers.all() else self._start()
            between = low + np.array([np.mod(_PART * np.arange(1, n + 1), 1.0), [_BEGIN] * n]) * (high - low)
            # with the last bit set, a length and its multiple of the grid differ
            between = np.where(high > low, (between.view(np.int64) | 1).view(np.float64), low)
            lengths = self._lengths_of([usual, *corners, *between], start) if start else None
            numbers &= lengths is None
            corners = corners[2 * n :] if numbers.any() else corners[:0]
            whole = [contents(self.given(corner)) for corner in corners]
            others = [contents(nominal if numbers.all() else self.given(corner, numbers)) for corner in corners]
        except (InputError, AssemblyError):
            return False
        self._nominal, self.columns, self._source, self._latest = nominal, columns, source, None
        self._compared, self._structure, self._low, self._high = True, contents(nominal).structure, low, high
        self._lengths = lengths
        self._numbers = numbers & all(
            one.structure == two.structure == self._structure
            and np.array_equal(one.words, self._written(two.words, corner))
            for one, two, corner in zip(whole, others, corners, strict=True)
        )
        return True

    def _start(self) -> Start | None:
        """Return what the start of designs follows from, see `start_of`."""
        with suppress(InputError, AssemblyError):
            return start_of(self.system)
        return None

    def _lengths_of(self, table: Sequence[Array], start: Start) -> Lengths | None:
        """Return designs as functions of their values; None if the designs (m, nv) of a table are not as these say."""
        examples, nominal = [], self.given(table[0])
        for values in table:
            system, windows = self.built(values)
            words, structure = contents(self._given(system, windows))
            if structure != contents(nominal).structure:
                return None
            examples.append(example_of(system, values, words))
        lengths = Lengths(self.system, examples, start)
        found, _ = Bench(nominal).started(lengths, np.array(table))
        return lengths if lengths.fits(found) else None

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
        self._systems, self._own, self._compared = systems, windows, True
        self._records, self._most = partial(pack, wanted=outputs), None

    def built(self, values: Array, left: Any = False) -> tuple[System, Array]:
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

    def started(self, lengths: Lengths, table: Array) -> tuple[Indices, NDArray[np.bool_]]:
        """Compute the numbers of designs (m, nv) in the order of `Lengths.columns`; and tell which of them start."""
        block, numbers = self._block, lengths.numbers(table)
        starts = np.empty((len(table), len(lengths.columns) - numbers.shape[1]))
        where = block.where[lengths.columns[starts.shape[1] :]]
        fill_starts(cast(Job, block), block.memory, where, numbers.view(np.int64), *lengths.start, starts)
        return np.hstack([starts, numbers]).view(np.int64), np.asarray(np.isfinite(starts).all(axis=1))

    def run(
        self, columns: Indices, words: Indices, stop: Indices, times: Array, found: Array, sampled: Array, ended: Array
    ) -> None:
        """Run designs (m,); see `linkages.engines.compiled.batch.statistics.run_rows`."""
        block = self._block
        run_rows(
            cast(Job, block),
            block.memory,
            block.initial,
            block.where[columns],
            words,
            stop,
            times,
            found,
            sampled,
            ended,
        )


def _places(nominal: Contents, corners: Array, alone: list[Contents]) -> tuple[Any, Indices, Indices]:
    """Find which variables have values that are numbers of a run, with each alone at its limits.

    Returns which they are, (nv,), the indices of these numbers, (k,), and the variable of each.
    """
    numbers, source = np.zeros(corners.shape[1], bool), np.full(len(nominal.words), -1)
    for k in range(len(numbers)):
        pair = alone[2 * k : 2 * k + 2]
        if any(each.structure != nominal.structure for each in pair):
            continue
        words, values = np.stack([each.words for each in pair]), corners[2 * k : 2 * k + 2, k].copy().view(np.int64)
        places = np.flatnonzero((words != nominal.words).any(axis=0))
        numbers[k] = (words[:, places] == values[:, None]).all()
        if numbers[k]:
            source[places] = k
    columns = np.flatnonzero(source >= 0)
    return numbers, columns, source[columns]


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
