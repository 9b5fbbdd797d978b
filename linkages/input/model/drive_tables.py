"""Tables of drives, and of backlash: of a drive's gearbox, of gears and couplings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydantic import Field

from linkages.input.files.toml import Finite, NonNegative, Positive, Table, check_history
from linkages.input.functions.definitions import TIME, formula, over_time, program
from linkages.input.functions.recorded_tables import FromFile
from linkages.input.model.experiment_tables import ContactTable, FrictionTable, check_states
from linkages.mechanics.planar import motion
from linkages.mechanics.planar.motion import Pieces, Program

_LOOKS = 2000  # number of times at which the rate of a formula is sampled


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


class GearboxBacklash(Backlash):
    """Backlash of a drive's gearbox: the drive turns the gearbox' output wheel, whose flanks turn the joint.

    The wheel turns about the joint, relative to its parent.
    """

    inertia: NonNegative = Field(
        0.0, description="moment of inertia of the wheel; for a torque and on Drake above 0 [kg m2]"
    )


class Drive(FromFile):
    """A driven joint: a prescribed motion (speed, table, formula, file), a torque, or (prismatic) a force.

    The coordinate is the SDF joint's: zero in the reference configuration, positive about (along) its axis. For a
    prismatic joint read m for rad.
    """

    of_any_joint = True
    column_keys = ("angle", "speed", "torque", "force")

    angle: Finite = Field(0.0, description="joint coordinate at t = 0 [rad]")
    speed: Finite | None = Field(None, description="constant speed [rad/s]; with a torque, the speed at t = 0")
    ramp: NonNegative = Field(0.0, description="time of a smooth start from rest to `speed` [s]")
    times: list[Finite] | None = Field(None, description="times of a table, increasing [s]")
    angles: list[Finite] | None = Field(None, description="joint coordinates at `times` [rad]")
    formula: str | None = Field(
        None, description="joint coordinate as a formula of the time t and of values, [rad] in SI units"
    )
    torque: Finite | None = Field(None, description="constant torque of a revolute joint [N m]")
    torques: list[Finite] | None = Field(None, description="torques at `times` [N m]")
    force: Finite | None = Field(None, description="constant force of a prismatic joint along its axis [N]")
    forces: list[Finite] | None = Field(None, description="forces at `times` [N]")
    backlash: GearboxBacklash | None = Field(
        None, description="backlash of the drive's gearbox, before a revolute joint; default: none"
    )

    def _complete(self) -> None:
        super()._complete()
        known = ("angles", "formula", "torque", "torques", "force", "forces", "file")
        kinds = [key for key in known if getattr(self, key) is not None]
        if len(kinds) > 1:
            raise ValueError(f"give only one of {' and '.join(kinds)}")
        if not kinds and self.speed is None:
            raise ValueError("give speed, or times with angles, or formula, or torque (for a prismatic joint: force)")
        verb = "prescribe" if kinds == ["angles"] else "prescribes"
        if self.backlash is not None and not self.prescribed and not self.backlash.inertia:
            raise ValueError("a torque turns the gearbox' output wheel: give backlash its inertia [kg m2]")
        column = self._check_columns()
        whole = kinds in (["angles"], ["formula"]) or column == "angle" or (column == "speed" and self.ramp)
        if whole and (self.speed is not None or self.ramp or self.angle):
            raise ValueError(f"the {kinds[0]} {verb} the complete motion; remove speed, ramp and angle")
        if self.formula is not None:
            formula(self.formula, of_state=False)
        if self.ramp and kinds:
            raise ValueError("ramp belongs to a constant speed; remove it")
        values = next((v for v in (self.angles, self.torques, self.forces) if v is not None), None)
        check_history(self.times, values, "angles, torques or forces")
        if column is not None:
            self._fit(column, kind=column if self.prescribed else "value")

    @property
    def acts(self) -> bool:
        """Check whether the drive acts; a constant torque or force of zero gives the start of a free joint alone."""
        return self.prescribed or self.varies or bool(self.torque or self.force)

    @property
    def prescribed(self) -> bool:
        """Check whether the drive prescribes the motion; otherwise it prescribes the torque or force."""
        given = (
            self.torque,
            self.torques,
            self.force,
            self.forces,
            self.columns.get("torque", self.columns.get("force")),
        )
        return all(value is None for value in given)

    @property
    def varies(self) -> bool:
        """Check whether the drive follows a table, a formula or a file."""
        return self.times is not None or self.formula is not None or self.file is not None

    def start(self, values: Mapping[str, float]) -> float:
        """Return the joint coordinate at t = 0, with the values that formulas read."""
        return float(motion.Motions([self.motion(values)])(np.zeros(1))[0][0, 0]) if self.prescribed else self.angle

    def motion(self, values: Mapping[str, float]) -> Pieces | Program:
        """Return the coordinate of a prescribed drive over time, with the values that formulas read."""
        if self.fitted:
            return self.fitted[0].function
        if self.formula is not None:
            return program(over_time(self.formula, values), {TIME: 0})
        if self.angles is not None and self.times is not None:
            return motion.table(self.times, self.angles)
        if self.ramp:
            return motion.ramped_rate(self.angle, self.speed or 0.0, self.ramp)
        return motion.constant_rate(self.angle, self.speed or 0.0)

    def largest_rate(self, end: float, values: Mapping[str, float]) -> float:
        """Return the largest rate of a prescribed motion [rad/s], with the values that formulas read.

        A formula is sampled up to the time `end` [s], at random times to avoid aliasing.
        """
        if not self.varies:
            return abs(float(self.speed or 0.0))
        times = (end if self.times is None else self.times[-1]) * np.random.default_rng(0).random(_LOOKS)
        return float(np.abs(motion.Motions([self.motion(values)])(times)[1]).max())

    def torque_history(self) -> Pieces | Program:
        """Return the torque (or force of a prismatic joint) over time of a drive without prescribed motion."""
        if self.fitted:
            return self.fitted[0].function
        values = self.torques if self.forces is None else self.forces
        if values is not None and self.times is not None:
            return motion.table(self.times, values)
        return motion.constant_rate(self.torque or self.force or 0.0, 0.0)
