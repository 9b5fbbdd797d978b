"""Backlash of gears, couplings and gearboxes: two contacts bar the second coordinate at the ends of its free travel."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from linkages.elements.contact_tables import ContactTable, FrictionTable, check_states
from linkages.elements.coordinates import Barrier, Coupled
from linkages.elements.element import Checks
from linkages.input.files.toml import Finite, Positive, Table


class Backlash(Table):
    """Backlash: two contacts, at the ends of the second joint's free travel, act instead of the coupling.

    With `play` a contact's penetration is the second joint's angle beyond the play, and its force a torque; with
    `normal` and `radius` both are along the line of action of the teeth. For a prismatic second joint, a rack, read m
    for rad and N for N m. Friction acts between the teeth, which slide by `arm` times the angular velocity of both
    wheels relative to each other (of wheel and rack): the force of the friction law, times the arm, brakes this motion.
    """

    of_any_joint = True

    play: Positive | None = Field(
        None, description="angle through which the second joint turns while the first stands [rad]"
    )
    normal: Positive | None = Field(None, description="instead: normal backlash of the teeth [m]")
    radius: Positive | None = Field(None, description="with normal: base radius of the second joint's wheel [m]")
    start: Finite = Field(0.0, description="angle of the second joint at the start, from the middle of the play [rad]")
    contact: ContactTable = Field(description="contact law, with stiffness [N m/rad^n], with normal [N/m^n]")
    friction: FrictionTable | None = Field(None, description="friction between teeth; default: none")
    arm: Positive | None = Field(
        None, description="with friction: mean distance of the teeth's contact from the pitch point [m]"
    )

    def _complete(self) -> None:
        if (self.play is None) == (self.normal is None) or (self.normal is None) != (self.radius is None):
            raise ValueError("give either play, or normal with radius")
        if (self.friction is None) != (self.arm is None):
            raise ValueError("friction and arm, the distance from the pitch point, belong together")
        check_states(self.contact, self.friction)
        if abs(self.start) > 0.5 * self.width:
            raise ValueError(f"start is {self.start:g}; it must be within half the play, {0.5 * self.width:g}")

    @property
    def lever(self) -> float:
        """Return penetration over the angle beyond the play: 1, or the base radius [m]."""
        return self.radius or 1.0

    @property
    def width(self) -> float:
        """Return the play of the second joint [rad]."""
        return (self.play or self.normal or 0.0) / self.lever


def check_backlash(slack: Backlash, second: str, checks: Checks) -> None:
    """Refuse units, laws and keys that do not suit the second joint."""
    slides = checks.slides(second)
    checks.units(Backlash, slides)
    checks.plain(slack.contact)
    if slides and slack.normal is not None:
        checks.refuse("normal", f'needs a wheel; "{second}" is prismatic: give play [m]')
    if not slides and slack.normal is None and slack.friction is not None:
        checks.refuse("friction", "needs the force of the teeth: give normal and radius instead of play")


def flanks(slack: Backlash, pair: Coupled) -> Mapping[str, Barrier]:
    """Return the contacts at both ends of the free travel."""
    first, second = pair.joints

    def flank(side: float) -> Barrier:
        place = pair.offset + 0.5 * side * slack.width
        seen = slack.lever, pair.ratio, first, pair.carrier
        return Barrier(second, side, place, slack.contact, *seen, slack.friction, slack.arm or 0.0)

    return {".upper": flank(1.0), ".lower": flank(-1.0)}
