"""A named tuple and the contents of its arrays in one block of memory, which one copy restores.

Many runs of one linkage differ in numbers only. `contents` lists the numbers of a named tuple; a `Block` knows where
each of them is in memory, so that compiled code can write other ones there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from linkages.arrays import Array, Indices
from linkages.kernel.by_reference import Packed, lay, packed, reference_to


class Contents(NamedTuple):
    """All numbers of a named tuple, 8 bytes each, (n,); and its structure: types, shapes of arrays, truth values."""

    words: Indices
    structure: tuple[Any, ...]


def contents(value: Any) -> Contents:
    """List the numbers of a named tuple of arrays, numbers, named tuples and packed ones, in this order."""
    parts: list[bytes] = []
    structure: list[Any] = []
    _gather(value, parts, structure)
    return Contents(np.frombuffer(b"".join(parts), np.int64), tuple(structure))


def _gather(value: Any, parts: list[bytes], structure: list[Any]) -> None:
    if isinstance(value, np.ndarray):
        parts.append(value.tobytes())
        structure.append((value.shape, value.itemsize))
    elif isinstance(value, Packed):
        _gather(value.unpacked, parts, structure)
    elif isinstance(value, tuple):
        for item in value:
            _gather(item, parts, structure)
    elif isinstance(value, bool | np.bool_):
        structure.append(bool(value))
    else:
        parts.append(np.array(value, np.float64 if isinstance(value, float) else np.int64).tobytes())
        structure.append(type(value))


class Block(Packed):
    """A copy of a named tuple in one block of memory.

    Parameters
    ----------
    value : named tuple
        Of contiguous arrays of numbers of 8 bytes, numbers, named tuples and packed ones.

    Attributes
    ----------
    memory : (nw,) array of int
        The block of memory.
    initial : (nw,) array of int
        Its first contents: ``memory[:] = initial`` restores them.
    where : (n,) array of int
        Index in the memory of each of the numbers that `contents` lists.
    """

    def __init__(self, value: Any) -> None:
        self.unpacked, self._numba_type_ = value, reference_to(value)
        words, moved, where = bytearray(), list[tuple[int, int]](), list[Indices]()
        _place(value, words, moved, where)
        words.extend(bytes(-len(words) % 8))
        self.where = np.concatenate(where) if where else np.zeros(0, np.int64)
        self.memory = np.frombuffer(words, np.int64).copy()
        self.place = self.memory.ctypes.data
        for address, start in moved:
            self.memory[address // 8] = self.place + start
        self.initial = self.memory.copy()


def _place(value: Any, words: bytearray, moved: list[tuple[int, int]], where: list[Indices]) -> int:
    """Add a value and the contents of its arrays to the words; return where the value begins."""
    words.extend(bytes(-len(words) % 8))
    begin, spots = len(words), list[tuple[int, Any]]()
    lay(value, words, spots)
    for spot, item in spots:
        if isinstance(item, Packed):
            moved.append((spot, _place(item.unpacked, words, moved, where)))
        elif isinstance(item, np.ndarray):
            words.extend(bytes(-len(words) % 8))
            start = len(words)
            words.extend(item.tobytes())
            moved.append((spot, start))
            where.append(np.arange(start // 8, len(words) // 8))
        else:
            where.append(np.array([spot // 8]))
    return begin


class Duplicate:
    """A copy of a named tuple, whose numbers are replaced by their places in `contents`.

    Parameters
    ----------
    value : named tuple
        As for `contents`; its numbers outside arrays stay.

    Attributes
    ----------
    value : named tuple
        The copy.
    initial : (n,) array
        Its first numbers, as floats.
    """

    def __init__(self, value: Any) -> None:
        self.value = _copied(value)
        self.initial = contents(self.value).words.view(np.float64)
        self._words = _views(self.value)
        self._ends = np.cumsum([len(words) for words in self._words])

    def writer(self, places: Indices) -> Callable[[Array], None]:
        """Return a function that writes numbers into these places."""
        owners = np.searchsorted(self._ends, places, side="right")
        found = [(self._words[k], k, owners == k) for k in np.unique(owners).tolist()]
        spots = [(words, places[mine] - self._ends[k] + len(words), mine) for words, k, mine in found]

        def write(numbers: Array) -> None:
            for words, inside, mine in spots:
                words[inside] = numbers[mine]

        return write


def _copied(value: Any) -> Any:
    """Copy a named tuple with its arrays."""
    if isinstance(value, np.ndarray):
        return np.array(value, order="C", subok=True)
    if isinstance(value, Packed):
        return packed(_copied(value.unpacked))
    if isinstance(value, tuple):
        parts = map(_copied, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value


def _views(value: Any) -> list[Array]:
    """List the arrays of a named tuple as floats in the order of `contents`; a number is an array of one entry."""
    if isinstance(value, np.ndarray):
        return [np.asarray(value).reshape(-1).view(np.float64)] if value.size else [np.zeros(0)]
    if isinstance(value, Packed):
        return _views(value.unpacked)
    if isinstance(value, tuple):
        return [part for item in value for part in _views(item)]
    return [] if isinstance(value, bool | np.bool_) else [np.zeros(1)]
