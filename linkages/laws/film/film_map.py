"""Films as maps: which films there are, and their values at the nodes of a table (`linkages.laws.film.map_table`).

`linkages.laws.film.map_nodes` solves films without groove by the rules of cavitation guembel and reynolds, with grooves
by reynolds and mass-conserving. Maps are kept on disk by `linkages.laws.film.map_cache`.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array
from linkages.laws.film.map_nodes import CELLS, has_angle, is_symmetric, solve_grooved, solve_plain, static_part
from linkages.laws.film.map_table import CHANNELS, MapHead, fit, place, ratios
from linkages.laws.film.surface.grooves import Groove

#: Raised whenever the solver or the layout of the map changes: maps of other versions are not read.
VERSION = 9
#: Largest eccentricity ratio of a map without and with grooves.
EPS_LIMIT, GROOVED_LIMIT = 0.999, 0.99
#: Nodes of a map in x, y and alpha, without and with grooves.
NODES, GROOVED_NODES = (57, 96, 1), (25, 32, 20)

_TURN = 2.0 * math.pi
_MIRRORED = (1.0, -1.0, 1.0, 1.0)  # factors of the quantities of a node in the mirror image


#: The rules of cavitation of a finite film without groove.
CAVITATIONS = ("guembel", "reynolds")
#: The rules of a film with grooves.
GROOVED_CAVITATIONS = ("reynolds", "mass-conserving")


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
        nodes = self.nodes or (GROOVED_NODES if self.grooves else NODES)
        if self.grooves and not has_angle(self.grooves):
            nodes = (*nodes[:2], 1)
        limit = GROOVED_LIMIT if self.grooves else EPS_LIMIT
        key = repr((VERSION, float(self.slenderness), self.cavitation, self.placed, nodes, self.cells, limit))
        identity = float(int.from_bytes(hashlib.sha256(key.encode()).digest()[:6], "big"))
        supplied = any(groove.pressure for groove in self.grooves)
        return MapHead(identity, self.slenderness, float(place(limit)), *nodes, bool(self.grooves), supplied)

    def check(self) -> None:
        """Check the inputs.

        Raises
        ------
        ValueError
            If the rule of cavitation is unknown, or the number of nodes out of range.
        """
        allowed = GROOVED_CAVITATIONS if self.grooves else CAVITATIONS
        if self.cavitation not in allowed:
            raise ValueError(f"cavitation {self.cavitation!r}: must be one of {', '.join(allowed)}")
        if self.nodes is not None and (self.nodes[0] < 5 or self.nodes[1] % 2):
            raise ValueError(f"{self.nodes} nodes: a map needs at least 5 in x, and an even number in y")


def build_map(case: MapCase, progress: Callable[[float], object] | None = None) -> Array:
    """Solve the film on the nodes of a map and fit its splines.

    Parameters
    ----------
    case : MapCase
    progress : callable, optional
        Called with the part that is done.

    Returns
    -------
    table : array of float
        For `linkages.laws.film.map_table.mapped_film`.

    Raises
    ------
    ValueError
        If an input is out of range.
    """
    case.check()
    head = case.head
    nx, ny, na = head.nx, head.ny, head.na
    values = np.empty((nx, ny, na, CHANNELS))
    static = np.empty((nx, na, CHANNELS)) if head.supplied else None
    grooves, mirror = case.placed, -np.arange(ny) % ny
    angles = np.asarray(np.arange(ny) * (_TURN / ny), dtype=np.float64)
    symmetric = is_symmetric(grooves)
    turns = na // 2 + 1 if symmetric else na
    for i, eps in enumerate(ratios(head)):
        for k in range(turns):
            turned = eps, case.slenderness, grooves, k * _TURN / na
            if grooves:
                found = solve_grooved(*turned, case.cavitation, angles, case.cells)
            else:
                found = np.empty((ny, CHANNELS))
                found[: ny // 2 + 1] = solve_plain(eps, case.slenderness, case.cavitation, angles[: ny // 2 + 1])
                found[ny // 2 :] = found[mirror[ny // 2 :]] * _MIRRORED
            if static is not None:
                static[i, k] = static_part(*turned, case.cells)
            if symmetric:
                values[i, :, -k % na] = found[mirror] * _MIRRORED
                if static is not None:
                    static[i, -k % na] = static[i, k] * _MIRRORED
            values[i, :, k] = found
            if progress is not None:
                progress((i * turns + k + 1) / (nx * turns))
    return fit(head, values, static)
