"""The flexible robot: SDFormat dimensions and a TOML file of sections, material, drives and options."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, check_history, read_toml, validate
from linkages.input.model.mechanism import load_mechanism
from linkages.mechanics.planar import motion
from linkages.mechanics.planar.motion import Motions
from linkages.three_rrr.geometry import LEGS, Geometry, from_mechanism
from linkages.three_rrr.kinematics import CrankMotion

Kind = Literal["crank", "coupler"]
KINDS: tuple[Kind, ...] = ("crank", "coupler")
PlanePair = Annotated[list[Finite], Field(min_length=2, max_length=2)]
Three = Annotated[list[Finite], Field(min_length=3, max_length=3)]


class CrankDrives(Table):
    """Motion of the cranks, and how their roots are held against elastic rotation.

    Either constant speeds from start angles, reached from rest if there is a ramp, or a table of angles over time.
    """

    phi0: Three | None = Field(None, description="crank angles at t = 0 [deg], absolute")
    phidot: Three | None = Field(None, description="crank speeds [rad/s]")
    ramp: NonNegative = Field(0.0, description="time of a smooth start from rest to `phidot` [s]")
    times: list[Finite] | None = Field(None, description="times of a table, increasing [s]")
    angles: list[Three] | None = Field(None, description="crank angles at each of `times` [deg]; a spline joins them")
    roots: Literal["locked", "free", "servo"] = Field("locked", description="elastic rotation of the crank roots")
    servo_stiffness: Positive | None = Field(None, description="of each drive, if roots are servo [N m/rad]")

    @model_validator(mode="after")
    def _one_motion(self) -> CrankDrives:
        if self.angles is not None and (self.phi0 is not None or self.phidot is not None or self.ramp):
            raise ValueError("angles prescribe the whole motion; remove phi0, phidot and ramp")
        if self.angles is None and (self.phi0 is None or self.phidot is None):
            raise ValueError("give phi0 and phidot, or times with angles")
        if self.roots == "servo" and self.servo_stiffness is None:
            raise ValueError('give servo_stiffness [N m/rad]; roots = "servo" needs it')
        check_history(self.times, self.angles, "angles")
        return self

    def motion(self) -> Motions:
        """Crank angles over time, with their rates and accelerations."""
        if self.angles is not None and self.times is not None:
            return Motions([motion.table(self.times, crank) for crank in np.deg2rad(self.angles).T.tolist()])
        start, speeds = np.deg2rad(self.phi0 or ()).tolist(), self.phidot or ()
        if self.ramp:
            return Motions([motion.ramped_rate(*values, self.ramp) for values in zip(start, speeds, strict=True)])
        return Motions([motion.constant_rate(*values) for values in zip(start, speeds, strict=True)])


class Material(Table):
    """Linear elastic material of all parts."""

    name: str = Field("", description="for tables")
    youngs_modulus: Positive = Field(description="[Pa]")
    density: Positive = Field(description="[kg/m3]")
    poisson: Annotated[float, Field(gt=-1.0, lt=0.5)] = Field(description="Poisson's ratio [1]")


class Sections(Table):
    """Round rods and a plate."""

    crank_diameter: Positive = Field(description="[m]")
    coupler_diameter: Positive = Field(description="[m]")
    platform_thickness: Positive = Field(description="[m]")


class Masses(Table):
    """Point masses at the pivots."""

    B: NonNegative = Field(0.0, description="at each B_r [kg]")
    C: NonNegative = Field(0.0, description="at each C_r [kg]")


class ModelOptions(Table):
    """Finite-element options."""

    elements: Annotated[int, Field(ge=1, le=512)] = Field(1, description="beam elements in each link")
    beam: Literal["euler-bernoulli", "timoshenko"] = Field("euler-bernoulli", description="beam theory")
    platform: Literal["triangle", "rigid"] = Field("triangle", description="one constant-strain triangle, or rigid")


class Damping(Table):
    """Rayleigh damping C = mass M + stiffness K."""

    mass: NonNegative = Field(0.0, description="coefficient of M [1/s]")
    stiffness: NonNegative = Field(0.0, description="coefficient of K [s]")


class Load(Table):
    """Constant load on the platform, plane axes."""

    force: PlanePair = Field([0.0, 0.0], description="[N]")
    at: PlanePair | None = Field(None, description="where the force acts, in platform axes [m]; without, at the centre")
    moment: Finite = Field(0.0, description="[N m]")


class Robot(Table):
    """A flexible 3-RRR robot and its motion. SI units, except for the angles of `drives`."""

    mechanism: str = Field(description="SDFormat file, relative to this file")
    title: str = Field("", description="one line for tables and figures")
    duration: Positive = Field(description="[s]")
    branch: Finite | None = Field(None, description="platform angle at t = 0 of the assembly to follow [deg]")
    drives: CrankDrives = Field(description="crank motion")
    material: Material = Field(description="of rods and platform")
    sections: Sections = Field(description="rods and plate")
    joint_masses: Masses = Field(Masses.model_validate({}), description="point masses at the pivots")
    model: ModelOptions = Field(ModelOptions.model_validate({}), description="finite-element options")
    damping: Damping = Field(Damping.model_validate({}), description="Rayleigh damping")
    load: Load = Field(Load.model_validate({}), description="constant load on the platform")

    _source: Path = PrivateAttr(Path("robot"))
    _geometry: Geometry | None = PrivateAttr(None)

    @property
    def source(self) -> Path:
        """The file the robot came from."""
        return self._source

    @property
    def mechanism_path(self) -> Path:
        """The SDFormat file."""
        return self._source.parent / self.mechanism

    @cached_property
    def geometry(self) -> Geometry:
        """Return the dimensions: given ones, otherwise the SDFormat file's."""
        return self._geometry if self._geometry is not None else from_mechanism(load_mechanism(self.mechanism_path))

    @cached_property
    def cranks(self) -> CrankMotion:
        """Motion of the cranks, see `linkages.three_rrr.kinematics.CrankMotion`."""
        return self.drives.motion()

    @property
    def phi0(self) -> Array:
        """Crank angles (3,) at t = 0 [rad]."""
        return self.cranks(np.zeros(1))[0][0]

    def rod(self, kind: Kind) -> tuple[float, float]:
        """Area [m2] and second moment of area [m4] of a crank or coupler."""
        d = self.sections.crank_diameter if kind == "crank" else self.sections.coupler_diameter
        return np.pi * d**2 / 4.0, np.pi * d**4 / 64.0

    def rigid_properties(self) -> dict[str, float]:
        """Masses, centres and inertias of thin rods and a lamina of this material, as SDFormat overrides.

        A pivot's point mass is counted with the coupler (B) and the platform (C).
        """
        g, rho = self.geometry, self.material.density
        result: dict[str, float] = {}
        for kind, lengths, extra in zip(KINDS, (g.crank, g.coupler), (0.0, self.joint_masses.B), strict=True):
            for leg, length in zip(LEGS, lengths, strict=True):
                rod = rho * self.rod(kind)[0] * length
                mass = rod + extra
                centre = 0.5 * length * rod / mass
                inertia = rod * length**2 / 3.0 - mass * centre**2
                result |= {
                    f"links.{kind}{leg}.mass": float(mass),
                    f"links.{kind}{leg}.com.x": float(centre),
                    f"links.{kind}{leg}.inertia": float(inertia),
                }
        corners = g.platform
        centre = corners.mean(0)
        plate = rho * self.sections.platform_thickness * abs(g.platform_area)
        spread = float(np.sum((corners - centre) ** 2))
        mass = plate + 3.0 * self.joint_masses.C
        result |= {
            "links.platform.mass": mass,
            "links.platform.com.x": float(centre[0]),
            "links.platform.com.y": float(centre[1]),
            "links.platform.inertia": plate * spread / 12.0 + self.joint_masses.C * spread,
        }
        return result


def load_robot(path: str | Path) -> Robot:
    """Read a robot from TOML, and the dimensions from its SDFormat file; InputError names file, key and reason."""
    data, _ = read_toml(Path(path))
    return make_robot(data, path)


def make_robot(data: Mapping[str, Any], source: str | Path = "robot", geometry: Geometry | None = None) -> Robot:
    """Build a robot from the tables of its TOML file; `geometry` replaces the SDFormat file's dimensions."""
    path = Path(source)
    robot = validate(Robot, data, path)
    robot._source = path
    robot._geometry = geometry
    times = robot.drives.times
    if times is not None and robot.duration > times[-1]:
        problem = f"end at {times[-1]:g} s; they must reach the duration, {robot.duration:g} s"
        raise InputError(path, "drives.times", problem)
    _ = robot.geometry  # so that errors of the SDFormat file come here
    return robot


def changed(robot: Robot, **tables: Mapping[str, Any] | float | None) -> Robot:
    """Return a robot with some values replaced: ``changed(robot, model={"elements": 4}, duration=1.0)``."""
    data = robot.model_dump()
    for name, value in tables.items():
        data[name] = data[name] | dict(value) if isinstance(value, Mapping) else value
    return make_robot(data, robot.source, robot.geometry)
