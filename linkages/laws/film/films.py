"""The films by name; see the head of `linkages.laws.film` for their signature.

To add one: its function in `linkages.laws.film.closed_form`, and a line in `FILMS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numba import types

from linkages.base.kernel import Array, address, caller, inlined_kernel
from linkages.laws.film.closed_form import (
    EPS_MAX,
    half_film_long,
    pinkus_sternlicht,
    pinkus_sternlicht_bare,
    short_bearing,
)
from linkages.laws.film.map_table import is_grooved, mapped_film
from linkages.laws.parameters import SHEAR, Parameter, named_record, set_numbers, slots

#: Stands for the address of a film that is given by a map.
MAPPED = 1

_NO_SHEAR, _HALF_SHEAR = SHEAR["none"], SHEAR["half"]
_F = types.float64
_TRIPLE = types.UniTuple(_F, 3)
_SIGNATURE = _TRIPLE(_F, _F, _F, _F)
_call = caller(_TRIPLE)


class Film(NamedTuple):
    """A film: its force, what it is, and what it is good for.

    A film that declares parameters takes the joint's record as its last argument, and reads them by name.
    """

    force: Callable[..., tuple[float, float, float]] | None  # none: a map
    formula: str
    valid: str
    source: str
    bare: Callable[..., tuple[float, float, float]] | None = None  # `force` with an extent of 0, where that is quicker
    parameters: tuple[Parameter, ...] = ()  # at most `SLOTS`

    @property
    def address(self) -> int:
        """Address of the compiled force in this process, or `MAPPED`."""
        if self.force is None:
            return MAPPED
        if not self.parameters:
            return address(self.force, _SIGNATURE)
        return address(self.force, _TRIPLE(_F, _F, _F, _F, named_record("film", self.parameters, ())))

    @property
    def bare_address(self) -> int:
        """The same for joints that do not ask for the extent."""
        return self.address if self.bare is None else address(self.bare, _SIGNATURE)

    def fill(self, record: Any, values: Mapping[str, Any]) -> None:
        """Write the film into a record that holds its ``shear``, from the parameters' values by name."""
        record["film"] = self.address if record["shear"] == _HALF_SHEAR else self.bare_address
        record["film_reads_record"] = bool(self.parameters)
        set_numbers(record, slots("film", self.parameters), values)


#: The films an experiment can name.
FILMS = {
    "long": Film(
        half_film_long, "closed form of the film of extent pi",
        "L/D > 8, half film", "exact integral of Chen 2025 eq. (8) over the pi film",
    ),
    "pinkus-sternlicht": Film(
        pinkus_sternlicht, "rational fit of the film of extent pi",
        "L/D > 8, half film", "Chen 2025 eqs. (9)-(11), sign corrected", pinkus_sternlicht_bare,
    ),
    "short": Film(
        short_bearing, "closed form of the parabolic film where p > 0",
        "L/D < 1/4, half film", "Ocvirk's short bearing",
    ),
    "finite": Film(None, "map of the 2D Reynolds equation", "any L/D", "`linkages.laws.film.film_map`"),
}  # fmt: skip


@inlined_kernel
def film_force(
    joint: np.record, eps: float, deps: float, ew: float, slenderness: float, table: Array, alpha: float = 0.0
) -> tuple[float, float, float]:
    """Evaluate a film without the static part of a supply pressure; eps is clipped to `EPS_MAX`.

    Parameters
    ----------
    joint : record of `linkages.laws.PARAMETERS`
    eps, deps, ew, slenderness : float
        State of the film and L/D, see `linkages.laws.film`.
    table : array of float
        Map of a finite film (`linkages.laws.film.film_map`); others ignore it.
    alpha : float
        Angle from the groove to the eccentricity, for a map with a groove [rad].

    Returns
    -------
    f_n, f_t : float
        Force on the journal in units of mu*L*R^3/c^2.
    extent : float
        Integral of dtheta/h over the film that carries pressure; with a groove, over the whole film, times its content.
        0 for a map where the joint's shear torque does not need it.
    """
    eps = min(eps, EPS_MAX)
    if joint.film == MAPPED:
        sheared = joint.shear == _HALF_SHEAR or (joint.shear != _NO_SHEAR and is_grooved(table))
        return mapped_film(eps, deps, ew, alpha, table, sheared)
    if joint.film_reads_record:
        return _call(joint.film, (eps, deps, ew, slenderness, joint))
    return _call(joint.film, (eps, deps, ew, slenderness))
