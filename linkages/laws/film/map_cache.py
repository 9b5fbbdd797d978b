"""Film maps on disk: built on demand, checked when read, written atomically.

A map is stored in the user's cache directory, or in the one that the environment variable LINKAGES_CACHE
names, under a name made of its inputs and of `film_map.VERSION`, as the numbers of its table with a checksum. It is
used only if the checksum, the inputs in its head and its shape are right and all its numbers finite; otherwise it is
built again and replaced.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from linkages.base.disk import cache_directory, keep, kept
from linkages.base.kernel import Array
from linkages.laws.film.film_map import VERSION, MapCase, build_map
from linkages.laws.film.map_table import CHANNELS

_IDENTITY = b"FILMMAP2"
#: Function that is called with the part of a map that is done.
MapProgress = Callable[[float], object]
_told: list[Callable[[MapCase], MapProgress]] = []


def tell(listener: Callable[[MapCase], MapProgress]) -> None:
    """Call a function before each map that is built in this process; call its result with the part that is done."""
    _told.append(listener)


def map_path(case: MapCase) -> Path:
    """Where the map of these inputs is stored."""
    return cache_directory() / f"film-v{VERSION}-{case.cavitation}-{int(case.head.identity):012x}.map"


def load_map(case: MapCase) -> Array:
    """Map of a film: from the cache if a sound one is there, else built and stored; listeners of `tell` are told.

    Returns
    -------
    table : array of float
        For `linkages.laws.film.map_table.mapped_film`.

    Raises
    ------
    ValueError
        If an input is out of range.

    Notes
    -----
    A directory that cannot be written to costs a warning and the time to build the map again.
    """
    case.check()
    path = map_path(case)
    table = read_map(path, case)
    if table is None:
        listeners = [listener(case) for listener in _told]
        table = build_map(case, lambda done: [listener(done) for listener in listeners])
        try:
            keep(path, _IDENTITY, table.tobytes())
        except OSError as error:
            warnings.warn(f"film map not stored in {path.parent}: {error.strerror}", stacklevel=2)
    return table


def read_map(path: Path, case: MapCase) -> Array | None:
    """Read a stored map; None if there is none or it is not sound."""
    content, head = kept(path, _IDENTITY), case.head
    turns = head.na + 3 if head.na > 1 else 1
    size = len(head) + CHANNELS * (head.nx + 2) * turns * (head.ny + 3 + head.supplied)
    if content is None or len(content) != 8 * size:
        return None
    table = np.frombuffer(content).copy()
    return table if np.isfinite(table).all() and np.array_equal(table[: len(head)], head) else None
