"""Two joints with coupled coordinates, exactly or with backlash: what gears, couplings and gearboxes have in common.

Without backlash a coupling is a closure row, whose reaction is the torque (rack: force) on the second joint.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from linkages.base.arrays import Array
from linkages.base.errors import listed_briefly
from linkages.elements.backlash import Backlash, check_backlash, flanks
from linkages.elements.coordinates import Barrier, Coupled
from linkages.elements.element import Checks, Slides, Warned
from linkages.elements.outputs import Quantities, Source
from linkages.elements.pictures import Jointed, Named, Picture, Scene, Traced
from linkages.input.files.toml import Finite, Table, TwoOf

_PULLEYS = 0.3, 6.0  # the larger pulley of a belt: radius over the distance of the axes, or in units if they coincide


class Mesh(Table):
    """Two joints with coupled coordinates: second = ratio * first + offset, or within the backlash from it.

    Joints that share no link, such as a sun's in the housing and a planet's in its carrier, need `carrier` (seen from
    this link, both wheels turn by the ratio) or `mimic` (their own coordinates have the ratio).
    """

    imperfections = ("backlash",)

    if TYPE_CHECKING:

        @property
        def ratio(self) -> float:
            """Return the coordinate of the second joint per coordinate of the first."""

    joints: TwoOf[str] = Field(
        description="two revolute or prismatic joints; their coordinates are zero in the reference configuration"
    )
    offset: Finite = Field(0.0, description="coordinate of the second joint where the first is zero, in SI units")
    carrier: str | None = Field(
        None,
        description="joints that share no link: link on which both wheels have their axes, such as a planet carrier; "
        "the coordinate of a joint that does not join it becomes the angle of the joint's child from this link",
    )
    mimic: bool = Field(
        False, description="joints that share no link: true couples their own coordinates, as a mimic joint of a robot"
    )
    backlash: Backlash | None = Field(None, description="backlash; default: none")

    def _complete(self) -> None:
        if self.joints[0] == self.joints[1]:
            raise ValueError(f'both joints are "{self.joints[0]}"')
        if self.mimic and self.carrier is not None:
            raise ValueError("give either carrier or mimic")


def check(mesh: Mesh, checks: Checks) -> None:
    """Refuse joints that cannot be coupled, and a backlash that does not suit them."""
    for name in mesh.joints:
        joint = checks.joint("joints", name)
        if joint.type == "fixed":
            checks.refuse("joints", f'"{name}" is fixed; name revolute or prismatic joints')
        if checks.has_clearance(name) and joint.type == "prismatic":
            checks.refuse("joints", f'"{name}" has clearance; a rack needs an ideal guide')
    _check_carrier(mesh, checks)
    if mesh.backlash is not None:
        check_backlash(mesh.backlash, mesh.joints[1], checks.within("backlash"))


def _check_carrier(mesh: Mesh, checks: Checks) -> None:
    """Check that a gear says from which link its wheels are seen, and that both can be seen from there."""
    if mesh.carrier is None:
        if not mesh.mimic and not checks.meet(*mesh.joints):
            one, two = (f'"{name}"' for name in mesh.joints)
            apart = f"{one} and {two} share no link, so that their angles are seen from different ones"
            carrier = "give carrier, the link on which both wheels have their axes"
            checks.refuse("joints", f"{apart}: {carrier}, or mimic = true for the joints' own coordinates")
        return
    checks.known_link("carrier", mesh.carrier)
    for joint in (checks.joint("joints", name) for name in mesh.joints):
        if mesh.carrier in (joint.parent, joint.child):
            continue
        if joint.type == "prismatic":
            problem = f'is "{mesh.carrier}", but "{joint.name}" is prismatic'
            checks.refuse("carrier", f"{problem}; name a link that it joins")
        if checks.bends(mesh.carrier):
            problem = f'is "{mesh.carrier}", a flexible link, which has no single angle'
            checks.refuse("carrier", f'{problem}; make it rigid, or let "{joint.name}" join it')


def couples(mesh: Mesh) -> Coupled:
    """Return the coupled joints."""
    first, second = mesh.joints
    pair = Coupled((first, second), mesh.ratio, mesh.offset, mesh.carrier, f"the gear of {first} and {second}")
    if mesh.backlash is None:
        return pair
    return replace(pair, width=mesh.backlash.width, travel="backlash", start=mesh.backlash.start)


def contacts(mesh: Mesh) -> Mapping[str, Barrier]:
    """Return the flanks of the backlash."""
    return {} if mesh.backlash is None else flanks(mesh.backlash, couples(mesh))


# -- outputs and warnings ----------------------------------------------------------------------------------------------

_TRANSMITTED = {"power": "power transmitted to the second joint [W]"}
_ON_SECOND = "on the second joint, along its coordinate"
_CLOSING = "rate of the penetration"
_DELIVERED = {"power": "power that the load delivers to the linkage [W]"}
_LOAD = "load"  # the output of a contact that is its force

#: With backlash: of a revolute second joint, of a prismatic one.
_LOOSE = (
    Quantities(
        "GEAR (backlash)",
        {"torque": f"torque {_ON_SECOND} [N m]"}
        | _TRANSMITTED
        | {"angle": "angle of the second joint from the middle of the play [rad]"},
        Source.BETWEEN,
    ),
    Quantities(
        "RACK (backlash)",
        {"force": f"force {_ON_SECOND} [N]"}
        | _TRANSMITTED
        | {"displacement": "displacement of the second joint from the middle of the play [m]"},
        Source.BETWEEN,
    ),
)
#: Of the flanks: with a torque against an angle, with a force along a length.
_FLANKS = (
    Quantities(
        "FLANK (angle)",
        {
            "torque": "magnitude of the reaction torque [N m]",
            "penetration": "angle beyond the free travel; negative: distance to its end [rad]",
            "closing": f"{_CLOSING} [rad/s]",
        }
        | _DELIVERED,
        Source.CONTACT,
        {"torque": _LOAD},
    ),
    Quantities(
        "FLANK (length)",
        {
            "force": "normal force of the teeth [N]",
            "penetration": "overlap of the teeth, negative: their distance [m]",
            "closing": f"{_CLOSING} [m/s]",
        }
        | _DELIVERED,
        Source.CONTACT,
        {"force": _LOAD},
    ),
)
#: Without backlash, and in the linkage with ideal joints: of a revolute second joint, of a prismatic one.
_CLOSED = (
    Quantities("GEAR (revolute)", {"torque": f"torque {_ON_SECOND} [N m]"} | _TRANSMITTED, Source.REACTION),
    Quantities("GEAR (prismatic)", {"force": f"force {_ON_SECOND} [N]"} | _TRANSMITTED, Source.REACTION),
)
OUTPUTS = (*_LOOSE, *_FLANKS, *_CLOSED)


def sort(mesh: Mesh, slides: Slides) -> Sequence[int]:
    """Return the indices of its outputs; with backlash those of the flanks too, and of the ideal linkage."""
    closed = OUTPUTS.index(_CLOSED[slides(mesh.joints[1])])
    return (closed,) if mesh.backlash is None else (*sort_with_backlash(mesh, slides), closed)


def sort_with_backlash(mesh: Mesh, slides: Slides) -> Sequence[int]:
    """Return the indices of its outputs with backlash, and of the flanks'."""
    rack = slides(mesh.joints[1])
    along = rack or (mesh.backlash is not None and mesh.backlash.normal is not None)
    return OUTPUTS.index(_LOOSE[rack]), OUTPUTS.index(_FLANKS[along])


def warns(named: Mapping[str, Mesh], locked: Sequence[str]) -> Iterator[Warned]:
    """Warn of gears that lock each other, and of joints of geared wheels: gears omit the tooth forces on the pins."""
    if locked:
        stuck = listed_briefly(list(dict.fromkeys(joint for name in locked for joint in named[name].joints)))
        what = f"the gears {listed_briefly(locked)} contradict each other, or the loops: {stuck} cannot move"
        yield Warned("gear", what, "correct a ratio, or remove a gear")
    joints = listed_briefly(list(dict.fromkeys(joint for mesh in named.values() for joint in mesh.joints)))
    what = f"the forces in {joints} exclude the tooth or belt forces of {listed_briefly(list(named))}"
    remedy = (
        "add, in both joints, the torque on the second one over its wheel's pitch radius and, of teeth, over the "
        "cosine of their pressure angle"
    )
    yield Warned("gear", what, remedy)


# -- picture -----------------------------------------------------------------------------------------------------------


def picture(mesh: Mesh, scene: Scene) -> Iterator[Picture]:
    """Draw the pitch circles of meshing wheels or of a rack's pinion; or the pulleys and the belt."""
    first, second = (scene.joint(name) for name in mesh.joints)
    shared = (one for one in (first.parent, first.child) if one in (second.parent, second.child))
    carrier = mesh.carrier or next(shared, None)
    turning = [joint for joint in (first, second) if joint.type == "revolute"]
    apart = second.on_child - first.on_child
    distance = float(np.linalg.norm(apart))
    toothed = mesh.ratio * first.sign * second.sign < 0.0 and carrier is not None
    radii = _radii(abs(mesh.ratio), first, len(turning), distance, toothed, scene.unit) / scene.unit
    for joint, radius in zip(turning, radii, strict=False):
        yield _wheel(joint, carrier, float(radius))
    if distance > 0.0 and not (toothed and len(turning) == 2):
        drawn = radii if len(turning) == 2 else np.zeros(2)
        yield from _belt(first, second, carrier, apart / distance, drawn, distance / scene.unit)
    yield Named((turning[0] if turning else first).name)


def _radii(ratio: float, first: Jointed, turning: int, distance: float, toothed: bool, unit: float) -> Array:
    """Return the radii of the wheels that turn [m]."""
    if turning < 2:
        return np.array([ratio if first.type == "revolute" else 1.0 / ratio])
    sizes = np.array([ratio, 1.0])
    wide, alone = _PULLEYS
    if distance == 0.0:
        return alone * unit * sizes / sizes.max()
    return distance * sizes / sizes.sum() if toothed else wide * distance * sizes / sizes.max()


def _wheel(joint: Jointed, carrier: str | None, radius: float) -> Traced:
    """Draw a circle [units] with a spoke on the link that rotates on the carrier."""
    link, at = (joint.parent, joint.on_parent) if joint.child == carrier else (joint.child, joint.on_child)
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    rim = np.column_stack([np.cos(turn), np.sin(turn)]) * radius
    return Traced([(link, at, way) for way in (np.zeros(2), *rim)])


def _belt(
    first: Jointed, second: Jointed, carrier: str | None, along: Array, radii: Array, distance: float
) -> Iterator[Traced]:
    """Draw the tangents of two wheels on a carrier; a line between the joints if there are none.

    Radii and distance of the wheels are in units.
    """
    if carrier is None or not radii.any():
        yield Traced([(joint.child, joint.on_child, np.zeros(2)) for joint in (first, second)])
        return
    sine = (radii[0] - radii[1]) / distance
    for side in (1.0, -1.0):
        normal = sine * along + side * np.sqrt(1.0 - sine**2) * np.array([-along[1], along[0]])
        ends = zip((first, second), radii, strict=True)
        yield Traced([(carrier, joint.on_child, radius * normal) for joint, radius in ends])


def duties() -> dict[str, Any]:
    """Return the duties that gears and couplings have in common."""
    own = {"check": check, "couples": couples, "contacts": contacts, "outputs": OUTPUTS, "sort": sort}
    return own | {"warns": warns, "picture": picture, "from_reference": lambda mesh: True}
