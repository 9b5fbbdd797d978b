"""Backlash of a drive's gearbox: the drive turns a wheel, whose flanks turn the joint.

The wheel is a body before the joint, with a coordinate of its own; the gearbox is a coupling of both with backlash.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from linkages.elements.analysis import Analysis, Refusal
from linkages.elements.backlash import Backlash, check_backlash
from linkages.elements.coordinates import WHEEL
from linkages.elements.coupling import Coupling
from linkages.elements.element import Checks, Element
from linkages.elements.mesh import OUTPUTS, contacts, couples, sort_with_backlash
from linkages.input.files.toml import NonNegative


class GearboxBacklash(Backlash):
    """Backlash of a drive's gearbox: the drive turns the gearbox' output wheel, whose flanks turn the joint.

    The wheel turns about the joint, relative to its parent.
    """

    inertia: NonNegative = Field(
        0.0, description="moment of inertia of the wheel; for a torque and on Drake above 0 [kg m2]"
    )


class Gearbox(Coupling):
    """The output wheel of a drive's gearbox, and the driven joint."""

    backlash: GearboxBacklash


def derived(drives: Mapping[str, Any]) -> dict[str, Gearbox]:
    """Make the gearboxes of the drives with backlash, as ``JOINT.backlash``."""
    return {
        f"{name}.backlash": Gearbox(
            joints=[f"{name}{WHEEL}", name], offset=0.0, carrier=None, mimic=False, backlash=drive.backlash
        )
        for name, drive in drives.items()
        if drive.backlash is not None
    }


def check(gearbox: Gearbox, checks: Checks) -> None:
    """Refuse a gearbox before a prismatic joint, and a backlash that does not suit the joint."""
    joint = gearbox.joints[1]
    if checks.slides(joint):
        checks.refuse("", "needs a revolute joint; before a prismatic one use a gear with backlash")
    check_backlash(gearbox.backlash, joint, checks)


#: Drake's plant has the wheel as a body.
_MASSLESS = Refusal(
    "inertia",
    lambda gearbox: not gearbox.backlash.inertia,
    dict.fromkeys((Analysis.DRAKE, Analysis.DIAGRAM), "is 0, but Drake needs an inertia of the gearbox' wheel"),
)

GEARBOX: Element[Gearbox] = Element(
    table="gearboxes",
    keys=Gearbox,
    derived=derived,
    home="drives",
    check=check,
    couples=couples,
    contacts=contacts,
    outputs=OUTPUTS,
    sort=sort_with_backlash,
    unsupported=(_MASSLESS,),
)
