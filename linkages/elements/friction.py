"""Friction in an ideal joint: a torque, or force, against the rate of its coordinate.

It is a push along the joint's coordinate: a formula of the rate, and a share of the force in the joint.
"""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field

from linkages.elements.coordinates import Push
from linkages.elements.element import Checks, Element
from linkages.elements.outputs import Quantities
from linkages.elements.pictures import Named, Picture, Ring, Scene
from linkages.input.files.formula import parse
from linkages.input.files.toml import NonNegative, Positive, Table
from linkages.input.functions.definitions import Definition


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
        return self._law(f"-{self._falling('constant')}*tanh(v/speed) - viscous*v")

    @property
    def share(self) -> Definition:
        """Return the friction along the coordinate over the joint force as a formula of its rate [m or 1]."""
        return self._law(f"-{self._falling('coefficient')}*radius*tanh(v/speed)")

    def _falling(self, key: str) -> str:
        """Return the formula of a number that falls from rest by Stribeck's law, if it has a static value."""
        if getattr(self, f"static_{key}") is None:
            return key
        return f"({key} + (static_{key} - {key})*exp(-(v/stribeck_speed)**2))"

    def _law(self, text: str) -> Definition:
        """Return a formula of the rate v and the own numbers."""
        formula = parse(text)
        own = {name: getattr(self, name) for name in formula.names - {"v"}}
        return Definition(formula, {**own, "radius": self.radius or 1.0, "v": f"{self.joint}.rate"})


def check(friction: JointFriction, checks: Checks) -> None:
    """Refuse joints without a coordinate of their own, and keys that do not suit the joint."""
    checks.moving(friction.joint)
    if checks.has_clearance(friction.joint):
        own = f"[joints.{friction.joint}.friction]"
        checks.refuse("joint", f'"{friction.joint}" has clearance; give it a table {own}')
    slides = checks.slides(friction.joint)
    if friction.depends_on_force and not slides and friction.radius is None:
        checks.refuse("radius", "is missing: a coefficient needs the radius of the pin")
    for key, fits in (("radius", not slides), ("length", slides)):
        if getattr(friction, key) is not None and not fits:
            checks.refuse(key, f'has no effect: "{friction.joint}" is {"prismatic" if slides else "revolute"}')
    checks.units(JointFriction, slides)


def push(friction: JointFriction) -> Push:
    """Return the push along the joint's coordinate."""
    if not friction.depends_on_force:
        return Push(friction.joint, friction.law)
    leverage = 2.0 / friction.length if friction.length is not None else 0.0
    return Push(friction.joint, friction.law, friction.share, leverage)


def picture(friction: JointFriction, scene: Scene) -> Iterator[Picture]:
    """Draw a ring around the joint."""
    yield Ring(friction.joint)
    yield Named(friction.joint)


_ALONG = "friction in an ideal joint, along its coordinate"

FRICTION = Element(
    table="frictions",
    keys=JointFriction,
    check=check,
    push=push,
    outputs=(
        Quantities("FRICTION (revolute)", {"torque": f"{_ALONG} [N m]"}),
        Quantities("FRICTION (prismatic)", {"force": f"{_ALONG} [N]"}),
    ),
    sort=lambda friction, slides: int(slides(friction.joint)),
    picture=picture,
    linear=False,
)
