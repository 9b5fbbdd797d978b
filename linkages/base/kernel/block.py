"""A named tuple and the contents of its arrays in one block of memory, which one copy restores.

Many runs of one linkage differ in numbers only. `contents` lists the numbers of a named tuple; a `Block` knows where
each of them is in memory, so that compiled code can write other ones there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Indices
from linkages.base.kernel.by_reference import Packed, lay, packed, reference_to


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


def starts(value: Any, name: str = "") -> dict[str, int]:
    """Return the place of the first number of each array among the `contents` of a named tuple, by its name.

    The name of an array in a named tuple within another is, for example, "bodies.records".
    """
    found: dict[str, int] = {}
    _find(value, name, 0, found)
    return found


def _find(value: Any, name: str, start: int, found: dict[str, int]) -> int:
    """Add the places of a value's arrays; return the place after its numbers."""
    if isinstance(value, Packed):
        return _find(value.unpacked, name, start, found)
    if isinstance(value, tuple):
        names = getattr(value, "_fields", map(str, range(len(value))))
        for part, item in zip(names, value, strict=True):
            start = _find(item, f"{name}.{part}" if name else part, start, found)
        return start
    found[name] = start
    if isinstance(value, np.ndarray):
        return start + value.nbytes // 8
    return start if isinstance(value, bool | np.bool_) else start + 1


def are_floats(value: Any) -> NDArray[np.bool_]:
    """Tell which of the numbers that `contents` lists are floats; the others are integers."""
    return np.concatenate([np.zeros(0, bool), *_kinds(value)])


def _kinds(value: Any) -> Iterator[NDArray[np.bool_]]:
    if isinstance(value, Packed):
        yield from _kinds(value.unpacked)
    elif isinstance(value, tuple):
        for item in value:
            yield from _kinds(item)
    elif isinstance(value, np.ndarray):
        yield np.tile(_kinds_of(value.dtype), value.size)
    elif not isinstance(value, bool | np.bool_):
        yield np.array([isinstance(value, float)])


@cache
def _kinds_of(dtype: np.dtype[Any]) -> NDArray[np.bool_]:
    """Tell which numbers of an entry of an array are floats."""
    if dtype.names is None:
        return np.full(int(np.prod(dtype.shape, dtype=int)), dtype.base.kind == "f")
    return np.concatenate([_kinds_of(dtype[name]) for name in dtype.names])


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
        _place(value, words, moved, where, {})
        words.extend(bytes(-len(words) % 8))
        self.where = np.concatenate(where) if where else np.zeros(0, np.int64)
        self.memory = np.frombuffer(words, np.int64).copy()
        self.place = self.memory.ctypes.data
        for address, start in moved:
            self.memory[address // 8] = self.place + start
        self.initial = self.memory.copy()


def _place(
    value: Any, words: bytearray, moved: list[tuple[int, int]], where: list[Indices], known: dict[int, int]
) -> int:
    """Add a value and the contents of its arrays to the words; return where the value begins.

    An array that occurs twice is placed once; ``known`` has the places by the arrays' identities.
    """
    words.extend(bytes(-len(words) % 8))
    begin, spots = len(words), list[tuple[int, Any]]()
    lay(value, words, spots)
    for spot, item in spots:
        if isinstance(item, Packed):
            moved.append((spot, _place(item.unpacked, words, moved, where, known)))
        elif isinstance(item, np.ndarray):
            if id(item) not in known:
                words.extend(bytes(-len(words) % 8))
                known[id(item)] = len(words)
                words.extend(item.tobytes())
            start = known[id(item)]
            moved.append((spot, start))
            where.append(np.arange(start // 8, (start + item.nbytes) // 8))
        else:
            where.append(np.array([spot // 8]))
    return begin


def rebuilt(value: Any, array_of: Callable[[Any, slice], Any], start: int) -> tuple[Any, int]:
    """Return the copy of a value with other arrays, and the place after its numbers in the order of `contents`.

    Parameters
    ----------
    value : named tuple
    array_of : callable
        ``array_of(array, part)``: the array in the place of another one, whose numbers are a part of all.
    start : int
        Place of the value's first number.
    """
    if isinstance(value, np.ndarray):
        end = start + value.nbytes // 8
        return array_of(value, slice(start, end)), end
    if isinstance(value, Packed):
        copy, end = rebuilt(value.unpacked, array_of, start)
        return packed(copy), end
    if isinstance(value, tuple):
        parts = []
        for item in value:
            part, start = rebuilt(item, array_of, start)
            parts.append(part)
        return (type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)), start
    return value, start if isinstance(value, bool | np.bool_) else start + 1
