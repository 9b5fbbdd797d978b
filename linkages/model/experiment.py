"""What is done with a mechanism: drives, joint models, gravity, duration, tolerances; read from TOML.

The comment that follows a value in the file is kept as its source ("Table 4", "assumed"), and shown in
reports. Every value can be replaced by its dotted path, here and on the command line alike:
``joints.A.clearance``, ``drives.O1.speed``; values of the SDF file are reached as ``sdf.links.link2.mass``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, PrivateAttr

from linkages.errors import InputError, nearest
from linkages.files import toml as toml_tables
from linkages.files.toml import Finite, Positive, Table
from linkages.model.load_tables import Force, Spring, Torque, TorsionSpring
from linkages.model.mechanism import Mechanism, load_mechanism
from linkages.model.tables import Drive, JointModel, Solver
from linkages.system.loads import check_loads

_CYLINDERS = ("esdu-78035", "johnson", "dubowsky-freudenstein")

#: Where a replaced value came from, as its source and in errors: Python, or the command line.
ARGUMENT, COMMAND_LINE = "argument", "command line"

#: What an output can measure of a link or frame, in plane axes; units m, rad and s.
QUANTITIES = {
    "x": "position of the frame's origin along x_P [m]",
    "y": "position along y_P [m]",
    "angle": "angle of the frame's x axis [rad]",
    "vx": "velocity along x_P [m/s]",
    "vy": "velocity along y_P [m/s]",
    "omega": "angular velocity [rad/s]",
    "ax": "acceleration along x_P [m/s2]",
    "ay": "acceleration along y_P [m/s2]",
    "alpha": "angular acceleration [rad/s2]",
}


class Experiment(Table):
    """Everything that is done with a mechanism. SI units."""

    mechanism: str = Field(description="SDFormat file, relative to this file")
    title: str = Field("", description="one line for tables and figures")
    duration: Positive = Field(description="simulated time [s]")
    gravity: Annotated[list[Finite], Field(min_length=3, max_length=3)] = Field(
        [0.0, 0.0, 0.0], description="gravity, world axes [m/s2]"
    )
    outputs: list[str] = Field([], description="what to report: LINK_OR_FRAME." + "|".join(QUANTITIES))
    drives: dict[str, Drive] = Field({}, description="driven joints by name")
    joints: dict[str, JointModel] = Field({}, description="joint models by name; joints not named are ideal")
    forces: dict[str, Force] = Field({}, description="applied forces, each with a name of its own")
    torques: dict[str, Torque] = Field({}, description="applied torques, each with a name of its own")
    springs: dict[str, Spring] = Field({}, description="springs and dampers between two points, each named")
    torsion_springs: dict[str, TorsionSpring] = Field(
        {}, description="torsion springs and dampers, each with a name of its own"
    )
    sdf: dict[str, Any] = Field({}, description="values that replace those of the SDF file, by dotted path")
    solver: Solver = Field(
        default_factory=lambda: Solver.model_validate({}), description="numerical settings"
    )

    _source: Path = PrivateAttr(Path("experiment"))
    _sources: dict[str, str] = PrivateAttr(default_factory=dict)

    @property
    def source(self) -> Path:
        """The file the experiment came from."""
        return self._source

    @property
    def sources(self) -> dict[str, str]:
        """The comment beside each value, by dotted path: where the value comes from."""
        return dict(self._sources)

    @property
    def mechanism_path(self) -> Path:
        """The SDFormat file."""
        return self._source.parent / self.mechanism

    @cached_property
    def sdf_overrides(self) -> dict[str, float]:
        """Values that replace those of the SDF file, by dotted path without the leading ``sdf.``."""
        result = {}
        for path, value in toml_tables.leaves(self.sdf):
            if isinstance(value, bool) or not isinstance(value, int | float):
                given = self._sources.get(f"sdf.{path}")
                source = given if given in (ARGUMENT, COMMAND_LINE) else self._source
                raise InputError(source, f"sdf.{path}", "must be a number")
            result[path] = float(value)
        return result

    @property
    def integrator(self) -> str:
        """Drake's integration scheme: implicit for films, explicit for dry contact, which is not stiff."""
        if self.solver.integrator is not None:
            return self.solver.integrator
        stiff = any(joint.has_film for joint in self.joints.values()) or not self.play
        return "radau3" if stiff else "runge_kutta5"

    @property
    def max_step(self) -> float:
        """Largest step [s]: short enough not to miss a contact, which lasts some 50 microseconds."""
        if self.solver.max_step is not None:
            return self.solver.max_step
        return 2e-5 if any(joint.can_touch for joint in self.joints.values()) else 2e-3

    @property
    def play(self) -> tuple[str, ...]:
        """Joints with clearance."""
        return tuple(name for name, joint in self.joints.items() if joint.has_play)

    def replaced(self, overrides: Mapping[str, Any], origin: str = ARGUMENT) -> Experiment:
        """Return the same experiment with values replaced by dotted path, which come from `origin`.

        Raises
        ------
        InputError
            If a path or value is not valid.
        """
        data = self.model_dump(exclude_unset=True)
        return _build(self._source, data, self._sources, overrides, origin)

    def ideal(self) -> Experiment:
        """Return the same experiment with every joint ideal."""
        joints = {name: {"model": "ideal"} for name in self.joints}
        data = self.model_dump(exclude_unset=True) | {"joints": joints}
        return _build(self._source, data, self._sources, {}, ARGUMENT)


def load_experiment(
    path: str | Path, overrides: Mapping[str, Any] | None = None, origin: str = ARGUMENT
) -> Experiment:
    """Read an experiment from a TOML file.

    Parameters
    ----------
    path : str or Path
    overrides : mapping, optional
        Values by dotted path that replace those of the file; strings are read as TOML values.
    origin : str
        Where the overrides come from, for errors and as the source of their values.

    Raises
    ------
    InputError
        One line with file, key and reason.
    """
    path = Path(path)
    data, sources = toml_tables.read_toml(path)
    return _build(path, data, sources, overrides or {}, origin)


def load(
    path: str | Path, overrides: Mapping[str, Any] | None = None, origin: str = ARGUMENT
) -> tuple[Mechanism, Experiment]:
    """Read an experiment and its mechanism, and check that they fit each other.

    Parameters
    ----------
    path : str or Path
        The TOML file.
    overrides : mapping, optional
        Values by dotted path that replace those of the files.
    origin : str
        Where the overrides come from, for errors and as the source of their values.

    Raises
    ------
    InputError
        One line with file, element or key, and reason.
    """
    experiment = load_experiment(path, overrides, origin)
    mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
    check(mechanism, experiment)
    return mechanism, experiment


def check(mechanism: Mechanism, experiment: Experiment) -> None:
    """Check that every name in the experiment exists in the mechanism and that the values suit it.

    Raises
    ------
    InputError
        One line with key and reason.
    """
    source = experiment.source
    for kind in ("drives", "joints"):
        for name in getattr(experiment, kind):
            if name not in mechanism.joint:
                raise InputError(
                    source,
                    f"{kind}.{name}",
                    f"{mechanism.source.name} has no such joint; {nearest(name, mechanism.joint)}",
                )
    for name, drive in experiment.drives.items():
        where = f"drives.{name}"
        if mechanism.joint[name].type == "fixed":
            raise InputError(source, where, "a fixed joint cannot be driven")
        if name in experiment.play:
            raise InputError(source, where, "a joint with clearance cannot be driven; make it ideal")
        if drive.times is not None and drive.times[-1] < experiment.duration:
            raise InputError(
                source,
                f"{where}.times",
                f"end at {drive.times[-1]:g} s, before the duration of {experiment.duration:g} s",
            )
    for name, joint in experiment.joints.items():
        if not joint.has_play:
            continue
        _check_joint(mechanism, experiment, name, joint)
    check_loads(mechanism, experiment)
    for output in experiment.outputs:
        point, _, quantity = output.rpartition(".")
        if point not in mechanism.point:
            raise InputError(
                source,
                f'outputs: "{output}"',
                f'{mechanism.source.name} has no link or frame "{point}"; {nearest(point, mechanism.point)}',
            )
        if quantity not in QUANTITIES:
            raise InputError(
                source, f'outputs: "{output}"', f'"{quantity}" is unknown; {nearest(quantity, QUANTITIES)}'
            )


def _check_joint(mechanism: Mechanism, experiment: Experiment, name: str, model: JointModel) -> None:
    """Check a joint with play against the machine's bearing or slot."""
    source, joint, clearance = experiment.source, mechanism.joint[name], model.clearance or 0.0
    needs = {"revolute": "bearing", "prismatic": "slot"}.get(joint.type)
    if needs is None:
        raise InputError(source, f"joints.{name}", "a fixed joint cannot have play")
    if (joint.bearing or joint.slot) is None:
        raise InputError(
            source,
            f"joints.{name}.model",
            f'"{model.model}" needs a <linkages:{needs}> in <joint name="{name}"> of {mechanism.source.name}',
        )
    if joint.bearing is not None:
        if clearance >= joint.bearing.radius:
            raise InputError(
                source,
                f"joints.{name}.clearance",
                f"is {clearance:g} m; it must be smaller than the bearing's radius of {joint.bearing.radius:g} m",
            )
        if sum(x * x for x in model.offset) >= clearance**2:
            raise InputError(source, f"joints.{name}.offset", "must lie inside the clearance circle")
        return
    if model.model != "dry":
        raise InputError(source, f"joints.{name}.model", f'is "{model.model}"; a guide with play is "dry"')
    if model.contact is not None and (model.contact.stiffness is None or model.contact.law in _CYLINDERS):
        raise InputError(
            source, f"joints.{name}.contact", "a corner at a wall needs a power law and its stiffness [N/m^n]"
        )


def keys() -> Iterator[tuple[str, str]]:
    """Every key of an experiment file with its meaning and unit."""
    return toml_tables.keys(Experiment)


def _build(
    source: Path,
    data: dict[str, Any],
    sources: Mapping[str, str],
    overrides: Mapping[str, Any],
    origin: str,
) -> Experiment:
    toml_tables.replace_values(data, overrides, origin)
    replaced = dict.fromkeys(overrides, origin)
    experiment = toml_tables.validate(Experiment, data, source, replaced)
    experiment._source = source
    experiment._sources = dict(sources) | replaced
    return experiment
