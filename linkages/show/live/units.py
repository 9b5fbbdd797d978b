"""Systems of units in which the page shows values: those of drawings, and SI units."""

from __future__ import annotations

import math

from linkages.show.plots.style import typeset

_DRAWINGS = {
    "m": ("mm", 1e3),
    "rad": ("°", 180.0 / math.pi),
    "rad/s": ("r/min", 30.0 / math.pi),
    "Pa s": ("mPa s", 1e3),
    "Pa": ("MPa", 1e-6),
    "kg m2": ("kg mm²", 1e6),
    "m3/s": ("cm³/s", 1e6),
    "N/m": ("N/mm", 1e-3),
    "N s/m": ("N s/mm", 1e-3),
}
#: Systems by name; each has the unit of an SI unit, and how many of it are one SI unit. Other units are SI units.
SYSTEMS: dict[str, dict[str, tuple[str, float]]] = {"mm, r/min, °, mPa s": _DRAWINGS, "SI units": {}}


def unit_of(si: str, system: str) -> tuple[str, float]:
    """Return the unit in which a system shows numbers of an SI unit, and its factor; the first system by default."""
    units = SYSTEMS.get(system, _DRAWINGS)
    return units.get(si, ("" if si == "1" else typeset(si).replace("degC", "°C"), 1.0))
