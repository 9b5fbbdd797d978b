"""Films as maps: which films there are, how a map is built (`linkages.laws.film.map_table`), and the maps on disk.

`linkages.laws.film.map_nodes` solves films without groove by the rules of cavitation guembel and reynolds, with grooves
by reynolds and mass-conserving.

A map is stored in the user's cache directory, or in the one that the environment variable LINKAGES_CACHE
names, under a name made of its inputs and of `VERSION`, as the numbers of its table with a checksum. It is used only if
the checksum, the inputs in its head and its shape are right and all its numbers finite; otherwise it is built again and
replaced.
"""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkages.base.disk import cache_directory, keep, kept
from linkages.base.kernel import Array
from linkages.laws.film.map_nodes import CELLS, has_angle, is_symmetric, solve_grooved, solve_plain
from linkages.laws.film.map_table import CHANNELS, MapHead, fit, place, ratios
from linkages.laws.film.surface.grooves import Groove

#: Raised whenever the solver or the layout of the map changes: maps of other versions are not read.
VERSION = 10
#: Largest eccentricity ratio of a map without and with grooves.
EPS_LIMIT, GROOVED_LIMIT = 0.999, 0.99
#: Nodes of a map in x, y and alpha, without and with grooves.
NODES, GROOVED_NODES = (57, 96, 1), (25, 32, 20)
#: The rules of cavitation of a finite film without and with grooves.
CAVITATIONS, GROOVED_CAVITATIONS = ("guembel", "reynolds"), ("reynolds", "mass-conserving")

_TURN = 2.0 * math.pi
_MIRRORED = (1.0, -1.0, 1.0, 1.0)  # factors of the quantities of a node in the mirror image
_IDENTITY = b"FILMMAP2"

#: Function that is called with the part of a map that is done.
MapProgress = Callable[[float], object]
_told: list[Callable[[MapCase], MapProgress]] = []


class MapCase(NamedTuple):
    """Inputs of a map.

    Attributes
    ----------
    slenderness : float
        L/D > 0.
    cavitation : str
        A name in `CAVITATIONS`, or in `GROOVED_CAVITATIONS` with grooves.
    grooves : tuple of Groove
        Angles from the first one, whose own angle does not matter. Only the ratios of their pressures count.
    nodes : (int, int, int), optional
        In x, y and alpha, even in the last two; at least 5 in x.
    cells : (int, int)
        Of the mesh around a film with grooves and along its half length.
    """

    slenderness: float
    cavitation: str = "guembel"
    grooves: tuple[Groove, ...] = ()
    nodes: tuple[int, int, int] | None = None
    cells: tuple[int, int] = CELLS

    @property
    def placed(self) -> tuple[Groove, ...]:
        """Grooves with angles from the first one, and pressures in parts of the largest."""
        largest = max((groove.pressure for groove in self.grooves), default=0.0) or 1.0
        return tuple(
            groove._replace(angle=groove.angle - self.grooves[0].angle, pressure=groove.pressure / largest)
            for groove in self.grooves
        )

    @property
    def head(self) -> MapHead:
        """Numbers that the table begins with."""
        nx, ny, na = self.nodes or (GROOVED_NODES if self.grooves else NODES)
        if self.grooves and not has_angle(self.grooves):
            na = 1
        limit = GROOVED_LIMIT if self.grooves else EPS_LIMIT
        key = repr((VERSION, float(self.slenderness), self.cavitation, self.placed, (nx, ny, na), self.cells, limit))
        identity = float(int.from_bytes(hashlib.sha256(key.encode()).digest()[:6], "big"))
        supplied = any(groove.pressure for groove in self.grooves)
        row = (na + 3 if na > 1 else 1) * (ny + 3) + (na + 3 if supplied else 0)
        return MapHead(identity, self.slenderness, float(place(limit)), nx, ny, na, bool(self.grooves), supplied, row)

    def check(self) -> None:
        """Check the inputs: ValueError if the rule of cavitation is unknown, or the number of nodes out of range."""
        allowed = GROOVED_CAVITATIONS if self.grooves else CAVITATIONS
        if self.cavitation not in allowed:
            raise ValueError(f"cavitation {self.cavitation!r}: must be one of {', '.join(allowed)}")
        if self.nodes is not None and (self.nodes[0] < 5 or self.nodes[1] % 2):
            raise ValueError(f"{self.nodes} nodes: a map needs at least 5 in x, and an even number in y")


def build_map(case: MapCase, progress: MapProgress = lambda done: None) -> Array:
    """Solve the film on the nodes of a map and fit its splines, for `linkages.laws.film.map_table.mapped_film`.

    `progress` is called with the part that is done. ValueError if an input is out of range.
    """
    case.check()
    head = case.head
    nx, ny, na = head.nx, head.ny, head.na
    values = np.empty((nx, ny + head.supplied, na, CHANNELS))
    mirror = np.append(-np.arange(ny) % ny, np.arange(ny, values.shape[1]))
    symmetric = is_symmetric(case.placed)
    turns = na // 2 + 1 if symmetric else na
    for i, eps in enumerate(ratios(head)):
        for k in range(turns):
            found = _solve(case, head, eps, k * _TURN / na)
            if symmetric:
                values[i, :, -k % na] = found[mirror] * _MIRRORED
            values[i, :, k] = found
            progress((i * turns + k + 1) / (nx * turns))
    return fit(head, values)


def _solve(case: MapCase, head: MapHead, eps: float, alpha: float) -> Array:
    """Solve the nodes of one place in y, and the static part behind them if there is one."""
    ny = head.ny
    angles = np.asarray(np.arange(ny) * (_TURN / ny), dtype=np.float64)
    if not case.grooves:  # half of them are mirror images
        half = solve_plain(eps, case.slenderness, case.cavitation, angles[: ny // 2 + 1])
        return np.concatenate([half[: ny // 2], half[ny // 2 : 0 : -1] * _MIRRORED])
    return solve_grooved(eps, case.slenderness, case.placed, alpha, case.cavitation, angles, case.cells)


def tell(listener: Callable[[MapCase], MapProgress]) -> None:
    """Call a function before each map that is built in this process; call its result with the part that is done."""
    _told.append(listener)


def map_path(case: MapCase) -> Path:
    """Where the map of these inputs is stored."""
    return cache_directory() / f"film-v{VERSION}-{case.cavitation}-{int(case.head.identity):012x}.map"


def load_map(case: MapCase) -> Array:
    """Map of a film: from the cache if a sound one is there, else built and stored; listeners of `tell` are told.

    A directory that cannot be written to costs a warning and the time to build the map again. ValueError if an input is
    out of range.
    """
    path = map_path(case)
    table = _read(path, case.head)
    if table is None:
        listeners = [listener(case) for listener in _told]
        table = build_map(case, lambda done: [listener(done) for listener in listeners])
        try:
            keep(path, _IDENTITY, table.tobytes())
        except OSError as error:
            warnings.warn(f"film map not stored in {path.parent}: {error.strerror}", stacklevel=2)
    return table


def _read(path: Path, head: MapHead) -> Array | None:
    """Read a stored map; None if there is none or it is not sound."""
    content = kept(path, _IDENTITY)
    if content is None or len(content) != 8 * (len(head) + CHANNELS * (head.nx + 2) * head.row):
        return None
    table = np.frombuffer(content).copy()
    return table if np.isfinite(table).all() and np.array_equal(table[: len(head)], head) else None
