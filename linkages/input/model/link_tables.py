"""Tables of an experiment's links: flexible or rigid, modes and damping."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from linkages.base.arrays import Array
from linkages.input.files.toml import NonNegative, Table

if TYPE_CHECKING:
    from linkages.mechanics.flexible.beam import Beam
    from linkages.mechanics.flexible.component_modes import ComponentModes

ModeCount = Annotated[int, Field(ge=0, le=60)]

#: Largest number of rigid segments of a link, and of elastic substructures.
MOST_SEGMENTS = 64
MOST_PIECES = 32

#: Default damping ratio of the first bending mode, an assumed value [1].
DAMPING = 0.01


class LinkModel(Table):
    """Model of a link that has a beam in the SDF file."""

    model: Literal["rigid", "flexible"] = Field("rigid", description="link model")
    bending: ModeCount | None = Field(
        None, description="bending modes; default: 2 (n - 1) + 2 for n joints and loads, with substructures 2 (n - 1)"
    )
    axial: ModeCount | None = Field(
        None, description="axial modes, 0: inextensible; default: n - 1 for n joints and loads"
    )
    stiffening: bool = Field(True, description="geometric stiffness: whether axial forces change the bending stiffness")
    damping: NonNegative | None = Field(
        None, description=f"damping ratio of the first bending mode with both ends pinned; default {DAMPING:g} [1]"
    )
    stiffness_damping: NonNegative | None = Field(
        None, description="instead of damping: stress per strain rate, over Young's modulus [s]"
    )
    axial_damping: NonNegative | None = Field(
        None, description="ratio of the first axial mode with one end held; default: as `damping` gives [1]"
    )
    pieces: Annotated[int, Field(ge=1, le=MOST_PIECES)] = Field(
        1, description="number of substructures (equal beams), for large slopes"
    )
    start: Literal["quasi-static", "undeformed"] = Field(
        "quasi-static", description="shape at t = 0: static under the loads of the rigid linkage, or straight"
    )
    segments: Annotated[int, Field(ge=2, le=MOST_SEGMENTS)] = Field(8, description="rigid segments in the Drake engine")

    def _complete(self) -> None:
        if self.bending == 0 and self.axial == 0:
            raise ValueError('has no modes; give bending or axial, or model = "rigid"')
        if self.damping is not None and self.stiffness_damping is not None:
            raise ValueError("give damping or stiffness_damping, not both")

    @property
    def bends(self) -> bool:
        """Check whether the link is flexible."""
        return self.model == "flexible"

    def bending_damping(self, frequency: float) -> float:
        """Compute the damping over stiffness [s] of a beam from its first pinned frequency [rad/s]."""
        if self.stiffness_damping is not None:
            return self.stiffness_damping
        return 2.0 / frequency * (DAMPING if self.damping is None else self.damping)

    def damping_factors(self, modes: ComponentModes, beam: Beam) -> Array:
        """Compute the Kelvin-Voigt damping over stiffness of each mode (nf,) [s] of a beam or its part."""
        bent = self.bending_damping(beam.pinned_frequency)
        stretched = bent if self.axial_damping is None else 2.0 / beam.held_frequency * self.axial_damping
        return np.where(np.arange(len(modes.names)) < modes.bending, bent, stretched)
