"""Tables of friction, gears, couplings, limit stops, and contacts of points with straight lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from pydantic import Field

from linkages.input.files.formula import parse
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, TwoOf
from linkages.input.functions.definitions import Definition
from linkages.input.model.drive_tables import Backlash
from linkages.input.model.experiment_tables import ContactTable, FrictionTable, check_states


class JointFriction(Table):
    """Friction in an ideal joint: a torque (prismatic: force) against the rate v of the joint's coordinate.

    The law is (C + mu * radius * N) * tanh(v/speed) + viscous * v: regularised Coulomb friction, as in the law
    "coulomb" of dry joints, and viscous friction. N is the force in the joint. C is the constant, and mu the
    coefficient, or by Stribeck's law constant + (static_constant - constant) * exp(-(v/stribeck_speed)^2), and mu the
    same of coefficient and static_coefficient. In a prismatic joint the radius is 1 and N the normal force or, if that
    is larger, 2/length times the moment that the guide carries: the sum of the forces at both ends of the slider, whose
    middle is the joint's place on the child.
    """

    of_any_joint = True

    joint: str = Field(description="the ideal joint")
    constant: NonNegative = Field(0.0, description="Coulomb part, independent of the joint force [N m]")
    viscous: NonNegative = Field(0.0, description="viscous part [N m s/rad]")
    speed: Positive = Field(
        1e-2, description="speed at which 76 % of the Coulomb part act (96 % at twice this speed) [rad/s]"
    )

    coefficient: NonNegative | None = Field(
        None, description="coefficient of friction of the joint force; default: no such part [1]"
    )
    radius: Positive | None = Field(None, description="revolute joint with a coefficient: radius of the pin [m]")
    length: Positive | None = Field(
        None,
        description="prismatic joint with a coefficient: length of the slider; default: no effect of the moment [m]",
    )
    static_constant: NonNegative | None = Field(
        None, description="Coulomb part at rest, from which it falls by Stribeck's law; default: the constant [N m]"
    )
    static_coefficient: NonNegative | None = Field(
        None, description="coefficient at rest, from which it falls by Stribeck's law; default: the coefficient [1]"
    )
    stribeck_speed: Positive | None = Field(
        None, description="Stribeck's law: speed at which 63 % of the fall from rest are done [rad/s]"
    )

    def _complete(self) -> None:
        if not self.constant and not self.viscous and self.coefficient is None and not self.static_constant:
            raise ValueError("give constant, viscous, or coefficient")
        at_rest, lone = (self.static_constant, self.static_coefficient), self.coefficient is None
        if (self.stribeck_speed is None) != (at_rest == (None, None)) or (lone and self.static_coefficient is not None):
            asked = "give static_coefficient and stribeck_speed, with coefficient, or neither"
            raise ValueError(f"{asked}; or static_constant and stribeck_speed")

    @property
    def depends_on_force(self) -> bool:
        """Check whether the friction depends on the joint force."""
        return self.coefficient is not None

    @property
    def law(self) -> Definition:
        """Return the part without the joint force along the coordinate as a formula of its rate [N m or N]."""
        return self._definition(f"-{self._falling('constant')}*tanh(v/speed) - viscous*v")

    @property
    def share(self) -> Definition:
        """Return the friction along the coordinate over the joint force as a formula of its rate [m or 1]."""
        return self._definition(f"-{self._falling('coefficient')}*radius*tanh(v/speed)")

    def _falling(self, key: str) -> str:
        """Return the formula of a number that falls from rest by Stribeck's law, if it has a static value."""
        if getattr(self, f"static_{key}") is None:
            return key
        return f"({key} + (static_{key} - {key})*exp(-(v/stribeck_speed)**2))"

    def _definition(self, text: str) -> Definition:
        """Return a formula of the rate v and the own numbers."""
        formula = parse(text)
        own = {name: getattr(self, name) for name in formula.names - {"v"}}
        return Definition(formula, {**own, "radius": self.radius or 1.0, "v": f"{self.joint}.rate"})


#: End of the name of the output wheel of a drive's gearbox, after the joint's.
WHEEL = ".wheel"


class Limit(NamedTuple):
    """A contact at the limit of a joint's coordinate less `ratio` times another's: a stop, or a gear's flank."""

    joint: str
    side: float  # 1: upper limit, -1: lower limit
    place: float  # [rad or m]
    contact: ContactTable
    lever: float = 1.0  # penetration per coordinate beyond the limit
    ratio: float = 0.0
    other: str | None = None
    carrier: str | None = None
    friction: FrictionTable | None = None
    arm: float = 0.0  # sliding speed over the angular velocity of both joints' children relative to each other [m]


class Mesh(Table):
    """Two joints with coupled coordinates: second = ratio * first + offset, or within the backlash from it.

    Joints that share no link, such as a sun's in the housing and a planet's in its carrier, need `carrier` (seen from
    this link, both wheels turn by the ratio) or `mimic` (their own coordinates have the ratio).
    """

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

    @property
    def flanks(self) -> dict[str, Limit]:
        """Return the contacts of the backlash by side; none without backlash."""
        if (slack := self.backlash) is None:
            return {}
        first, second = self.joints
        pair, teeth = (slack.lever, self.ratio, first, self.carrier), (slack.friction, slack.arm or 0.0)
        return {
            name: Limit(second, side, self.offset + 0.5 * side * slack.width, slack.contact, *pair, *teeth)
            for name, side in (("upper", 1.0), ("lower", -1.0))
        }


class Coupling(Mesh):
    """Two coaxial shafts that turn together: the coordinates of their joints differ by the offset."""

    @property
    def ratio(self) -> float:
        """Return 1."""
        return 1.0


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


class Stop(Table):
    """A limit stop that a joint's coordinate meets from one side, with a contact law.

    At a revolute joint the law's penetration is an angle and its force a torque; at a prismatic joint read m for rad.
    """

    of_any_joint = True

    joint: str = Field(description="ideal joint whose range the stop limits")
    side: Literal["upper", "lower"] = Field(description="upper or lower limit of the coordinate")
    limit: Finite = Field(description="coordinate of the stop, zero in the reference configuration [rad]")
    contact: ContactTable = Field(description="contact law, with stiffness [N m/rad^n]")

    @property
    def as_limit(self) -> Limit:
        """Return the contact."""
        return Limit(self.joint, 1.0 if self.side == "upper" else -1.0, self.limit, self.contact)


class LineContact(Table):
    """Contact of a point of a link with a straight line, on the ground or on another link: a foot, a probe, a buffer.

    The line is infinite; its free side is to the left of its direction: along y if the line is along x.
    """

    point: str = Field(description="origin of this link or frame")
    line: str | None = Field(None, description="frame whose x axis is the line; its y axis points to the free side")
    anchor: TwoOf[Finite] | None = Field(None, description="instead: a point of a fixed line, plane axes [m]")
    angle: Finite = Field(0.0, description="direction of the fixed line, from x_P counter-clockwise [rad]")
    contact: ContactTable = Field(description="normal contact law, with stiffness [N/m^n]")
    friction: FrictionTable | None = Field(None, description="friction; default: none")

    def _complete(self) -> None:
        if (self.line is None) == (self.anchor is None):
            raise ValueError("give either line, a frame, or anchor, a fixed point (with angle)")
        if self.line is not None and self.angle:
            raise ValueError("angle belongs to anchor; the line's frame has its own direction")
        check_states(self.contact, self.friction)
