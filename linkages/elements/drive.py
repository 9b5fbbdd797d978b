"""A drive of a joint: a prescribed motion, a torque, or the force of a prismatic joint; perhaps through a gearbox."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import Field

from linkages.elements.element import Checks, Element, Quantities, Slides
from linkages.elements.gearbox import GearboxBacklash
from linkages.elements.outputs import Source
from linkages.input.files.table_keys import bracketed
from linkages.input.files.toml import Finite, NonNegative, check_history
from linkages.input.files.unit_conversion import SLIDING
from linkages.input.functions.definitions import TIME, formula, over_time, program
from linkages.input.functions.recorded_tables import FromFile
from linkages.mechanics.planar import motion
from linkages.mechanics.planar.motion import Pieces, Program

_LOOKS = 2000  # number of times at which the rate of a formula is sampled


class Drive(FromFile):
    """A driven joint: a prescribed motion (speed, table, formula, file), a torque, or (prismatic) a force.

    The coordinate is the SDF joint's: zero in the reference configuration, positive about (along) its axis. For a
    prismatic joint read m for rad.
    """

    of_any_joint = True
    imperfections = ("backlash",)
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
    def wheel(self) -> float | None:
        """Return the moment of inertia of the wheel that it turns before the joint [kg m2]; None without one."""
        return None if self.backlash is None else self.backlash.inertia

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


def check(drive: Drive, checks: Checks) -> None:
    """Refuse a drive of a fixed joint, a force on a revolute one, units and tables that do not suit."""
    joint = checks.joint("", checks.name)
    if joint.type == "fixed":
        checks.refuse("", "a fixed joint cannot be driven")
    pushes = (drive.force, drive.forces) != (None, None) or bool(drive.columns.get("force"))
    if pushes and joint.type == "revolute":
        checks.refuse("force", "belongs to a prismatic joint; this one is revolute: give a torque")
    slides = joint.type == "prismatic"
    checks.units(Drive, slides)
    for key, unit in drive.units.items():
        known = bracketed(Drive.model_fields[key].description) if key != "time" else "s"
        checks.same_kind(f"units.{key}", unit, SLIDING.get(known, known) if slides else known)
    checks.covers(drive.times, drive.fitted)
    checks.over_time("formula", drive.formula)


def force(drive: Drive, _: Slides, extent: float) -> float:
    """Return the largest force of the drive; its largest torque over the machine's extent [N]."""
    torque, own = (max(map(_magnitude, pair)) for pair in ((drive.torque, drive.torques), (drive.force, drive.forces)))
    return max(torque / extent, own)


def _magnitude(values: Any) -> float:
    """Return the largest magnitude of a number or list; zero for None."""
    return 0.0 if values is None else float(np.abs(values).max())


_POWER = "power delivered by the drive [W]"
_EFFORTS = Quantities(
    "DRIVE",
    {
        "torque": "torque (prismatic joint: force) of the drive along the joint's coordinate; JOINT.force excludes it"
        " [N m or N]",
        "rate": "rate of the joint's coordinate [rad/s or m/s]",
        "power": _POWER,
    },
    Source.EFFORT,
    peaks=("torque",),
)
_EFFORTS_OF_WHEEL = Quantities(
    "DRIVE (backlash)",
    {
        "torque": "torque of the drive on the output wheel of its gearbox, along the joint's coordinate [N m]",
        "rate": "rate of the joint's coordinate; the wheel has another one [rad/s]",
        "power": _POWER,
    },
    Source.EFFORT_OF_WHEEL,
    peaks=("torque",),
)

DRIVE = Element(
    table="drives",
    part="joint",
    keys=Drive,
    check=check,
    outputs=(_EFFORTS, _EFFORTS_OF_WHEEL),
    sort=lambda drive, slides: 0 if drive.backlash is None else 1,
    absent=lambda name: f'needs a drive, and "{name}" has none; name a driven joint, or the angles of its links',
    force=force,
    controls=("speed", "torque", "force"),
)
