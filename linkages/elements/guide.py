"""A block in its slot with clearance: a contact of each corner with a wall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from linkages.base.arrays import Array

#: Corners of a block, along and across its slot, relative to half its sides.
CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))


def corners_of(length: float, height: float, along: Array) -> Iterator[tuple[Array, Mapping[str, float]]]:
    """Yield the corners of a block, from its middle [m], and the numbers of their `linkages.elements.wall.RECORD`.

    ``along`` is the direction of the slot, in the axes of its body.
    """
    across = np.array([-along[1], along[0]])
    for x, y in CORNERS:
        corner = 0.5 * (x * length * along + y * height * across)
        yield corner, {"nx": y * across[0], "ny": y * across[1], "place": 0.5 * height}
