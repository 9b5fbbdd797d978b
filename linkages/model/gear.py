"""The table of an experiment's gears and belts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from linkages.files.toml import Finite, Table


class Gear(Table):
    """Two joints whose coordinates go together: second = ratio * first + offset.

    Meshing gears turn against each other, a ratio below zero if both axes point the same way; belts and chains turn
    alike. With a joint that slides it is a rack, or a screw: the ratio is in m/rad.
    """

    joints: Annotated[list[str], Field(min_length=2, max_length=2)] = Field(
        description="two revolute or prismatic joints; their coordinates are zero in the reference configuration"
    )
    ratio: Finite = Field(description="coordinate of the second joint per coordinate of the first; not 0")
    offset: Finite = Field(0.0, description="coordinate of the second joint where the first is zero, in SI units")

    @model_validator(mode="after")
    def _couples(self) -> Gear:
        if self.ratio == 0.0:
            raise ValueError("ratio is 0; the second joint would stand still")
        if self.joints[0] == self.joints[1]:
            raise ValueError(f'joints are one and the same, "{self.joints[0]}"')
        return self
