"""A gear, a belt, a rack or a screw: two joints with coupled coordinates, exactly or with backlash."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import Field

from linkages.elements.analysis import Analysis, Refusal
from linkages.elements.element import Element
from linkages.elements.mesh import Mesh, duties
from linkages.input.files.toml import Finite


class Gear(Mesh):
    """Two joints with coupled coordinates: second = ratio * first + offset.

    For meshing gears with equally directed axes the ratio is negative; for belts and chains it is positive. With a
    prismatic joint the gear is a rack or a screw: the ratio is in m/rad.
    """

    ratio: Finite = Field(description="coordinate of the second joint per coordinate of the first; not 0")

    def _complete(self) -> None:
        super()._complete()
        if self.ratio == 0.0:
            raise ValueError("ratio is 0; the second joint would not move")


#: The wheels of a turning drive have another pose after a revolution.
_FRACTIONAL = Refusal(
    "ratio",
    lambda gear: bool(gear.ratio % 1.0),
    {Analysis.WEAR: "is no whole number: cycles of the drive do not begin in the same pose; drive the other joint"},
    turning=True,
)


def completed(keys: Mapping[str, Any], meet: Callable[[str, str], bool]) -> Mapping[str, Any]:
    """Add to an imported gear the key that joints need which share no link."""
    return keys if meet(*keys["joints"]) else {**keys, "mimic": True}


GEAR: Element[Gear] = Element(table="gears", keys=Gear, unsupported=(_FRACTIONAL,), completed=completed, **duties())
