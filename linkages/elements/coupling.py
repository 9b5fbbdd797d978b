"""A coupling of two coaxial shafts, exact or with backlash."""

from __future__ import annotations

from linkages.elements.element import Element
from linkages.elements.mesh import Mesh, duties


class Coupling(Mesh):
    """Two coaxial shafts that turn together: the coordinates of their joints differ by the offset."""

    @property
    def ratio(self) -> float:
        """Return 1."""
        return 1.0


COUPLING: Element[Coupling] = Element(table="couplings", keys=Coupling, **duties())
