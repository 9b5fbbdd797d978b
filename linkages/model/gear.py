"""The table of an experiment's gears and belts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from linkages.files.toml import Finite, Table


class Gear(Table):
    """Two joints with coupled coordinates: second = ratio * first + offset.

    For meshing gears with equally directed axes the ratio is negative; for belts and chains it is positive. With a
    prismatic joint the gear is a rack or a screw: the ratio is in m/rad.
    """

    joints: Annotated[list[str], Field(min_length=2, max_length=2)] = Field(
        description="two revolute or prismatic joints; their coordinates are zero in the reference configuration"
    )
    ratio: Finite = Field(description="coordinate of the second joint per coordinate of the first; not 0")
    offset: Finite = Field(0.0, description="coordinate of the second joint where the first is zero, in SI units")

    @model_validator(mode="after")
    def _couples(self) -> Gear:
        if self.ratio == 0.0:
            raise ValueError("ratio is 0; the second joint would not move")
        if self.joints[0] == self.joints[1]:
            raise ValueError(f'both joints are "{self.joints[0]}"')
        return self
