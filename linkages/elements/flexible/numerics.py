"""Numbers that tune what is computed of flexible links, with unit and effect; `tests/constants.py` tries others."""

from __future__ import annotations

# substructure: stations of internal forces
STATIONS = 17  # [1] between neighbouring sections: a largest stress between two is missed
STATION_POINTS = 8  # [1] Gauss points between stations: integrals of mass and shapes

# inertia: loads for finite elements
LINK_LOADS_NODES = 17  # [1] of each part of a beam between neighbouring sections
LINK_LOADS_POINTS = 3  # [1] Gauss points between neighbouring nodes

# rules
VALIDITY_SAMPLES = 101  # [1] places along a beam

# choice
SLENDERNESS = 40.0  # [1] length over width of the bar that a link without mass gets
