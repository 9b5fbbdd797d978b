"""Film maps on disk: built on demand, checked when read, written atomically.

A map is stored in the user's cache directory, or in the one that the environment variable LINKAGES_CACHE
names, under a name made of its inputs and of `film_map.VERSION`, as an array in NumPy's format with a checksum. It is
used only if the checksum, the inputs in its head and its shape are right and all its numbers finite; otherwise it is
built again and replaced.
"""

from __future__ import annotations

import hashlib
import io
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from linkages.disk import cache_directory, keep, kept
from linkages.kernel import Array
from linkages.laws.film import groove_map
from linkages.laws.film.film_map import CAVITATIONS, EPS_LIMIT, HEAD, NODES, VERSION, build_map, map_head
from linkages.laws.film.surface.grooves import Groove

_IDENTITY = b"FILMMAP1"


def map_path(slenderness: float, cavitation: str = "guembel", nodes: int = NODES) -> Path:
    """Where the map of these inputs is stored."""
    key = f"{float(slenderness).hex()} {cavitation} {nodes} {EPS_LIMIT.hex()}"
    name = hashlib.sha256(key.encode()).hexdigest()[:16]
    return cache_directory() / f"film-v{VERSION}-{cavitation}-{name}.map"


def load_map(
    slenderness: float,
    cavitation: str = "guembel",
    nodes: int = NODES,
    progress: Callable[[float], object] | None = None,
) -> Array:
    """Map of a film: from the cache if a sound one is there, else built and stored.

    Parameters
    ----------
    slenderness, cavitation, nodes, progress
        As for `film_map.build_map`, which is called where the map must be built.

    Returns
    -------
    table : array of float
        For `film_map.finite_film`.

    Raises
    ------
    ValueError
        If an argument is out of range.

    Notes
    -----
    A directory that cannot be written to costs a warning and the time to build the map again.
    """
    path = map_path(slenderness, cavitation, nodes)
    table = read_map(path, slenderness, cavitation, nodes)
    if table is None:
        table = build_map(slenderness, cavitation, nodes, progress)
        _store(path, table)
    return table


def load_groove_map(
    slenderness: float, groove: Groove, rule: str, progress: Callable[[float], object] | None = None
) -> Array:
    """Map of a film with a groove: from the cache if a sound one is there, else built and stored.

    Parameters
    ----------
    slenderness, groove, rule, progress
        As for `groove_map.build_groove_map`, which takes up to half a minute.

    Returns
    -------
    table : array of float
        For `groove_map.grooved_film`.
    """
    head = groove_map.map_head(slenderness, groove, rule)
    key = " ".join(float(number).hex() for number in (*head, *groove_map.CELLS))
    path = cache_directory() / f"film-groove-{rule}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.map"
    table = _read(path)
    if table is None or not np.array_equal(table[: len(head)], head):
        table = groove_map.build_groove_map(slenderness, groove, rule, progress)
        _store(path, table)
    return table


def read_map(path: Path, slenderness: float, cavitation: str, nodes: int) -> Array | None:
    """Read a stored map; None if there is none or it is not sound."""
    if cavitation not in CAVITATIONS:
        return None
    table = _read(path)
    sound = (
        table is not None
        and table.shape == (HEAD + 3 * (nodes + 2) ** 2,)
        and np.array_equal(table[:HEAD], map_head(slenderness, cavitation, nodes))
    )
    return table if sound else None


def _read(path: Path) -> Array | None:
    """Read a flat array of finite numbers; None if there is none or it is not sound."""
    content = kept(path, _IDENTITY)
    if content is None:
        return None
    try:
        table = np.load(io.BytesIO(content), allow_pickle=False)
    except (ValueError, EOFError):
        return None
    sound = table.dtype == np.float64 and table.ndim == 1 and bool(np.isfinite(table).all())
    return table if sound else None


def _store(path: Path, table: Array) -> None:
    """Store a map; a directory that cannot be written to costs a warning."""
    try:
        write_map(path, table)
    except OSError as error:
        warnings.warn(f"film map not stored in {path.parent}: {error.strerror}", stacklevel=3)


def write_map(path: Path, table: Array) -> None:
    """Store a map so that a reader finds either the whole of it or none."""
    buffer = io.BytesIO()
    np.save(buffer, table, allow_pickle=False)
    keep(path, _IDENTITY, buffer.getvalue())
