"""A flexible link: a link with a beam, whose deformation is a sum of component modes; a link is rigid without it.

What a user sees of it is here: keys, checks, outputs, and what other programs make of it. `linkages.elements.flexible`
has its substructures, the forces in its sections and the limits of its model; mechanics knows bodies with shape
coordinates, whatever their shapes are.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from linkages.base.arrays import Array
from linkages.base.errors import listed_briefly
from linkages.elements.analysis import Analysis, Refusal
from linkages.elements.element import Checks, Element, Quantities, Substitute, Warned
from linkages.elements.flexible.choice import CHOICE
from linkages.elements.flexible.rules import RULES
from linkages.elements.outputs import Source
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

    imperfections = ("model",)

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


def check(link: LinkModel, checks: Checks) -> None:
    """Refuse a flexible link without a beam, or with too few modes for its interfaces."""
    if not link.bends:
        return
    if not checks.has_beam(checks.name):
        checks.refuse("model", f'"flexible" needs a <linkages:beam> in {checks.in_file("link")}')
    others = checks.interfaces(checks.name) - 1
    what = "joints and loads" if link.pieces == 1 else "joints, loads and ends of a substructure"
    for key, least in (("bending", 2 * others), ("axial", others)):
        if (count := getattr(link, key)) and count < least:
            checks.refuse(key, f"is {count}; its {others + 1} {what} need {least} modes or more, or 0")


_OF_LINK = Quantities(
    "LINK (flexible)",
    {
        "deflection": "largest magnitude of the distance from the chord between the beam's ends [m]",
        "deflection_place": "its position from the beam's first end [m]",
        "bending": "largest magnitude of the bending moment [N m]",
        "stress": "largest magnitude of the normal stress [Pa]",
        "stress_place": "its position from the beam's first end [m]",
        "compression": "largest compressive force, zero in tension [N]",
    },
    Source.ALONG,
    peaks=("deflection", "bending", "stress"),
)
_OF_FRAME = Quantities(
    "FRAME (flexible link)",
    {"deflection": "distance of a frame from the beam's chord, positive to its left, less the undeformed one [m]"},
    Source.FRAME,
)


def idle(link: LinkModel | None, name: str) -> str:
    """Say that a link is rigid; empty for a flexible one."""
    flexible = link is not None and link.bends
    return "" if flexible else f'link {name} is rigid; give links.{name}.model = "flexible"'


def refined(link: LinkModel) -> dict[str, float]:
    """Return twice the number of rigid segments."""
    return {"segments": min(2 * link.segments, MOST_SEGMENTS)}


def warns_of_substitutes(named: Mapping[str, LinkModel]) -> Iterable[Warned]:
    """Warn of links whose axial deformation rigid segments omit without the setting axial = 0."""
    if names := [name for name, link in named.items() if link.bends and link.axial != 0]:
        what = f"the rigid segments of {listed_briefly(names)} are inextensible: axial modes are omitted"
        yield Warned("segments", what, "use the compiled engine, or set axial = 0")


def compared(named: Mapping[str, LinkModel]) -> list[str]:
    """Explain a comparison with rigid segments."""
    stretched = [name for name, link in named.items() if link.bends and link.axial]
    return [
        "both engines run the machine with rigid segments, as Drake has no flexible links; the last column is the",
        "difference of segments and flexible links in the compiled engine, relative to the peak; more segments"
        " (links.NAME.segments) reduce it",
        *(f"segments do not stretch; links.{name}.axial = 0 removes this part of it" for name in stretched),
    ]


_STIFFENING = Refusal(
    "stiffening",
    lambda link: link.bends and not link.stiffening,
    {Analysis.DRAKE: "is false, but Drake's rigid segments always stiffen; remove it, or use the compiled engine"},
)

FLEXIBLE_LINK = Element(
    table="links",
    part="link",
    keys=LinkModel,
    check=check,
    from_reference=lambda link: link.bends,
    deforms=lambda link: link.bends,
    idle=idle,
    outputs=(_OF_LINK, _OF_FRAME),
    sort=lambda link, slides: (0, 1) if link.bends else (),
    absent=lambda name: f'needs a flexible link, and "{name}" is rigid; set links.{name}.model, or remove the output',
    choice=CHOICE,
    rules=RULES,
    unsupported=(_STIFFENING,),
    substitute=Substitute("segments", refined, warns_of_substitutes, compared),
)
