"""The films by name, and their one dispatcher; see `linkages.laws.film` for the signature."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel import kernel
from linkages.laws.film import EPS_MAX, half_film_long, pinkus_sternlicht, short_bearing
from linkages.laws.film_map import finite_film


class Film(NamedTuple):
    """A film by name: its code in `PARAMETERS`, and what it is good for."""

    code: int
    valid: str
    source: str


#: The films an experiment can name.
FILMS = {
    "long": Film(0, "L/D > 2, half film", "exact integral of Chen 2025 eq. (8) over the pi film"),
    "pinkus-sternlicht": Film(1, "L/D > 2, half film", "Chen 2025 eqs. (9)-(11), sign corrected"),
    "finite": Film(3, "any L/D", "2D Reynolds equation, tabulated (linkages.laws.film_map)"),
    "short": Film(2, "L/D < 1/4, half film", "Ocvirk's short bearing"),
}


@kernel
def film_force(
    code: int, eps: float, deps: float, ew: float, slenderness: float, table: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Evaluate the film with this code; eps is clipped to `EPS_MAX`. See the head of the module.

    `table` is the map of the finite film (`linkages.laws.film_map`); others ignore it.
    """
    eps = min(eps, EPS_MAX)
    if code == 0:
        return half_film_long(eps, deps, ew, slenderness)
    if code == 1:
        return pinkus_sternlicht(eps, deps, ew, slenderness)
    if code == 3:
        return finite_film(eps, deps, ew, table)
    return short_bearing(eps, deps, ew, slenderness)
