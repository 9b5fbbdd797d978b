"""General tolerances of ISO 2768-1:1989, Tables 1 and 3, for dimensions without a tolerance of their own."""

from __future__ import annotations

import math
from bisect import bisect_left

from linkages.base.errors import InputError, nearest

#: Largest sizes of the ranges, and deviations of the classes fine, medium, coarse, very coarse [mm]; 0: none is given.
_SIZES = (3, 6, 30, 120, 400, 1000, 2000, 4000)
_LENGTHS = {
    "f": (0.05, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.0),
    "m": (0.1, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0),
    "c": (0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.0),
    "v": (0.0, 0.5, 1.0, 1.5, 2.5, 4.0, 6.0, 8.0),
}
_SMALLEST = 0.5  # [mm]
#: Largest lengths of the shorter side of an angle [mm], and deviations [arc minutes].
_SIDES = (10, 50, 120, 400, math.inf)
_FINE = (60, 30, 20, 10, 5)
_ANGLES = {"f": _FINE, "m": _FINE, "c": (90, 60, 30, 15, 10), "v": (180, 120, 60, 30, 20)}


def general_tolerance(name: str, size: float, angle: bool = False) -> float:
    """Return the permissible deviation, upwards and downwards, of a dimension.

    Parameters
    ----------
    name : str
        Tolerance class: "f", "m", "c" or "v".
    size : float
        Length, or shorter side of the angle [m].
    angle : bool
        Whether the dimension is an angle.

    Returns
    -------
    float
        Deviation [m], of an angle [rad].

    Raises
    ------
    InputError
        If the standard does not define it.

    Examples
    --------
    >>> import linkages
    >>> linkages.general_tolerance("m", 0.12), round(linkages.general_tolerance("m", 0.12, angle=True), 6)
    (0.0003, 0.005818)
    """
    if name not in _LENGTHS:
        raise InputError("argument", "name", f'is "{name}"; {nearest(name, _LENGTHS)}')
    millimetres = round(1e3 * size, 9)  # 0.03 m is 30 mm
    if angle and millimetres > 0.0:
        return math.radians(_ANGLES[name][bisect_left(_SIDES, millimetres)] / 60.0)
    inside = not angle and _SMALLEST <= millimetres <= _SIZES[-1]
    if inside and (deviation := _LENGTHS[name][bisect_left(_SIZES, millimetres)]):
        return 1e-3 * deviation
    raise InputError("argument", "size", f"is {size:g} m, for which class {name} has no general tolerance")
