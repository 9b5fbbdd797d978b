"""A copy of a named tuple whose numbers are duals: results computed from it have derivatives along their changes.

A word of 8 bytes becomes `DIRECTIONS` + 1 words, so that all records have the same layout: an integer of a record
keeps its place, and no slopes belong to it. Arrays of integers are shared.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import from_dtype, types
from numba.extending import typeof_impl

from linkages.base.arrays import Array
from linkages.base.kernel.block import contents, rebuilt
from linkages.base.kernel.dual import DIRECTIONS, LANES, DualArray, dual_record
from linkages.base.kernel.simd import LaneArray

_WORDS = 1 + DIRECTIONS


class DualLanes(DualArray):
    """An array of duals side by side, the last two axes; compiled code sees the axes before them."""

    axes = 2


class DualRecords(np.ndarray[Any, Any]):
    """An array of records whose numbers are duals."""


@typeof_impl.register(DualLanes)
def _type_of_lanes(value: DualLanes, context: Any) -> Any:
    return types.Array(LANES, value.ndim - 2, "C", aligned=False)


@typeof_impl.register(DualRecords)
def _type_of_records(value: DualRecords, context: Any) -> Any:
    return types.Array(dual_record(from_dtype(value.dtype)), value.ndim, "C", aligned=False)


class DualCopy:
    """A copy of a named tuple whose numbers are duals.

    Parameters
    ----------
    value : named tuple
        As for `linkages.base.kernel.block.contents`; numbers outside its arrays are copied without slopes.

    Attributes
    ----------
    value : named tuple
        The copy.
    memory : (n, 1 + DIRECTIONS) array
        Its numbers in the order of `contents`, and their slopes: zero.
    """

    def __init__(self, value: Any) -> None:
        words = contents(value).words
        self.memory = np.zeros((len(words), _WORDS))
        self.memory.view(np.int64)[:, 0] = words
        self.value, _ = rebuilt(value, lambda array, part: _array_of(self.memory[part], array), 0)


def _array_of(memory: Array, value: Any) -> Any:
    """Return the duals in a part of the memory as an array like another; one of integers itself."""
    if value.dtype.names:
        return memory.reshape(-1).view(_spread(value.dtype)).reshape(value.shape).view(DualRecords)
    if value.dtype != np.float64:
        return value
    return memory.reshape(*value.shape, _WORDS).view(DualLanes if isinstance(value, LaneArray) else DualArray)


@cache
def _spread(kind: np.dtype[Any]) -> np.dtype[Any]:
    """Return the type of records with words `_WORDS` times as far apart."""
    fields: Any = kind.fields
    if not fields:
        return kind
    places = [fields[name] for name in kind.names or ()]
    layout: Any = {
        "names": kind.names,
        "formats": [_spread(place[0]) for place in places],
        "offsets": [_WORDS * place[1] for place in places],
        "itemsize": _WORDS * kind.itemsize,
    }
    return np.dtype((np.record, layout))
