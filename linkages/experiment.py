"""What is done with a mechanism: drives, joint models, gravity, duration, tolerances; read from TOML.

The comment that follows a value in the file is kept as its source ("Table 4", "assumed"), and shown in
reports. Every value can be replaced by its dotted path, here and on the command line alike:
``joints.A.clearance``, ``drives.O1.speed``; values of the SDF file are reached as ``sdf.links.link2.mass``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import tomlkit
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationError,
    model_validator,
)
from scipy.interpolate import PPoly
from tomlkit.exceptions import TOMLKitError

from linkages.errors import InputError, nearest
from linkages.laws import CONTACTS, FILMS, FRICTIONS
from linkages.mechanism import Mechanism, load_mechanism
from linkages.planar import motion

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


def _known(registry: Iterable[str]) -> AfterValidator:
    """Validate a law's name against its registry: a law added there can be named in a file."""
    names = sorted(registry)

    def check_name(name: str) -> str:
        if name not in names:
            raise ValueError(f'"{name}" is unknown; {nearest(name, names)}')
        return name

    return AfterValidator(check_name)


FilmName = Annotated[str, _known(FILMS)]
ContactLaw = Annotated[str, _known(CONTACTS)]
FrictionLaw = Annotated[str, _known(set(FRICTIONS) - {"none"})]

_CYLINDERS = ("esdu-78035", "johnson", "dubowsky-freudenstein")

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


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Drive(_Table):
    """A driven joint: a prescribed motion (speed, or a table of angles) or a torque.

    Coordinates are those of the SDF joint: zero in the drawn pose, positive about (along) its axis. For a
    prismatic joint read m for rad and N for N m.
    """

    angle: Finite = Field(0.0, description="joint coordinate at t = 0 [rad]")
    speed: Finite | None = Field(
        None, description="constant speed [rad/s]; of a torque drive, speed at t = 0"
    )
    ramp: NonNegative = Field(0.0, description="time of a smooth start from rest to `speed` [s]")
    times: list[Finite] | None = Field(None, description="times of a table, increasing [s]")
    angles: list[Finite] | None = Field(None, description="joint coordinates at `times` [rad]")
    torque: Finite | None = Field(None, description="constant torque [N m]")
    torques: list[Finite] | None = Field(None, description="torques at `times` [N m]")

    @model_validator(mode="after")
    def _one_kind(self) -> Drive:
        kinds = [k for k in ("angles", "torque", "torques") if getattr(self, k) is not None]
        if len(kinds) > 1:
            raise ValueError(f"give only one of {' and '.join(kinds)}")
        if not kinds and self.speed is None:
            raise ValueError("give speed, or times with angles, or torque")
        if "angles" in kinds and (self.speed is not None or self.ramp or self.angle):
            raise ValueError("angles prescribe the whole motion; remove speed, ramp and angle")
        if self.ramp and kinds:
            raise ValueError("ramp belongs to a constant speed; remove it")
        values = self.angles if self.angles is not None else self.torques
        if (values is None) != (self.times is None):
            raise ValueError("times go with angles or torques")
        if values is not None and self.times is not None:
            if len(values) != len(self.times) or len(values) < 2:
                raise ValueError(
                    f"{len(self.times)} times and {len(values)} values; two or more of each, equally many"
                )
            if any(b <= a for a, b in zip(self.times, self.times[1:], strict=False)):
                raise ValueError("times must increase")
            if self.times[0] > 0.0:
                raise ValueError("times must start at 0 or before")
        return self

    @property
    def prescribed(self) -> bool:
        """Whether the motion is prescribed; otherwise the torque is."""
        return self.torque is None and self.torques is None

    def motion(self) -> PPoly:
        """Coordinate over time of a prescribed drive."""
        if self.angles is not None and self.times is not None:
            return motion.table(self.times, self.angles)
        speed = self.speed or 0.0
        if self.ramp:
            return motion.ramped_rate(self.angle, speed, self.ramp)
        return motion.constant_rate(self.angle, speed)

    def torque_history(self) -> PPoly:
        """Torque over time of a torque drive."""
        if self.torques is not None and self.times is not None:
            return motion.table(self.times, self.torques)
        return motion.constant_rate(self.torque or 0.0, 0.0)


class SmallEccentricity(_Table):
    """The paper's correction of the film near the centre, seed eqs. (12)-(13): force times eps^power below ratio.

    It is not needed (the film is regular there) and leaves the centred journal nearly unsupported; it is here to
    replicate the paper.
    """

    ratio: Annotated[float, Field(gt=0, lt=1)] = Field(
        description="eps_0, below which the correction acts [1]"
    )
    power: NonNegative = Field(description="m, 0 to 5 [1]")


class Contact(_Table):
    """Contact of journal and bearing, for dry and mixed joints."""

    law: ContactLaw = Field(description="normal contact law")
    restitution: Annotated[float, Field(gt=0, le=1)] = Field(
        description="nominal coefficient of restitution [1]"
    )
    youngs_modulus: Positive | None = Field(None, description="Young's modulus of both bodies [Pa]")
    poissons_ratio: Annotated[float, Field(ge=0, lt=0.5)] = Field(
        0.3, description="Poisson's ratio of both [1]"
    )
    stiffness: Positive | None = Field(
        None, description="stiffness instead of the law's from material and radii [N/m^n; N/m for cylinders]"
    )
    exponent: Annotated[float, Field(ge=1, le=3)] = Field(1.5, description="exponent n of power laws [1]")
    damping: NonNegative = Field(0.0, description="damping of kelvin-voigt [N s/m]")
    clip: bool = Field(True, description="whether the damping's speed ratio is clipped to [-1, 1]")

    @model_validator(mode="after")
    def _complete(self) -> Contact:
        if self.youngs_modulus is None and self.stiffness is None:
            raise ValueError("give youngs_modulus or stiffness")
        if self.law == "kelvin-voigt" and self.stiffness is None:
            raise ValueError("kelvin-voigt needs its stiffness [N/m]")
        return self


class Friction(_Table):
    """Friction between journal and bearing, for dry and mixed joints."""

    law: FrictionLaw = Field(description="friction law")
    coefficient: Positive = Field(description="dynamic coefficient [1]")
    static: Positive | None = Field(None, description="static coefficient; default: the dynamic one [1]")
    v_0: NonNegative = Field(1e-4, description="first speed of the law [m/s]")
    v_1: Positive = Field(1e-3, description="second speed of the law, above v_0 [m/s]")
    bristle_stiffness: Positive = Field(1e5, description="LuGre: sigma_0 per unit of load [1/m]")
    bristle_damping: NonNegative = Field(0.0, description="LuGre: sigma_1 per unit of load [s/m]")

    @model_validator(mode="after")
    def _ordered(self) -> Friction:
        if self.v_1 <= self.v_0:
            raise ValueError("v_1 must be above v_0")
        if self.static is not None and self.static < self.coefficient:
            raise ValueError("static must not be below coefficient")
        if self.law == "cubic" and self.v_0 == 0.0:
            raise ValueError("cubic needs v_0 above 0")
        return self


class Mixed(_Table):
    """Between film and contact, for mixed joints."""

    law: Literal["blend", "greenwood-tripp"] = Field(description="blend of seed eq. (15), or asperities")
    transition: Positive | None = Field(
        None, description="blend: penetration E_0 where only contact is left [m]"
    )
    film_limit: Annotated[float, Field(gt=0, lt=1)] = Field(
        0.99, description="largest eccentricity ratio at which the film is evaluated [1]"
    )
    roughness: Positive | None = Field(
        None, description="asperities: standard deviation of either surface [m]"
    )
    density: Positive | None = Field(None, description="asperities: summits per area [1/m2]")
    tip_radius: Positive | None = Field(None, description="asperities: radius of the summits [m]")

    @model_validator(mode="after")
    def _complete(self) -> Mixed:
        needed = ("transition",) if self.law == "blend" else ("roughness", "density", "tip_radius")
        missing = [key for key in needed if getattr(self, key) is None]
        if missing:
            raise ValueError(f"{self.law} needs {' and '.join(missing)}")
        return self


class Oil(_Table):
    """A mineral oil by its ISO VG grade, at a temperature: gives the viscosity."""

    grade: Annotated[int, Field(gt=1)] = Field(
        description="ISO VG grade: kinematic viscosity at 40 C [mm2/s]"
    )
    temperature: Annotated[float, Field(ge=-50, le=250)] = Field(description="[degC]")
    density: Positive = Field(870.0, description="density at 15 C [kg/m3]")


class JointModel(_Table):
    """How a joint that has a bearing or a slot in the SDF file is modelled."""

    model: Literal["ideal", "dry", "lubricated", "mixed"] = Field(description="what the joint is")
    clearance: Positive | None = Field(None, description="radial clearance c [m]")
    film: FilmName = Field("long", description="film law")
    cavitation: Literal["guembel", "reynolds"] = Field("guembel", description="rule of the finite film")
    viscosity: Positive | None = Field(None, description="dynamic viscosity [Pa s]")
    oil: Oil | None = Field(None, description="instead of viscosity")
    contact: Contact | None = Field(None, description="dry and mixed: normal contact")
    friction: Friction | None = Field(None, description="dry and mixed: friction; none without it")
    mixed: Mixed | None = Field(None, description="mixed: between film and contact")
    shear_torque: bool = Field(True, description="whether the film's shear torque acts")
    shear_film: Literal["full", "half"] = Field("full", description="extent of the film that shears")
    small_eccentricity: SmallEccentricity | None = Field(
        None, description="the paper's correction near the centre"
    )
    offset: Annotated[list[Finite], Field(min_length=2, max_length=2)] = Field(
        [0.0, 0.0],
        description="journal's centre from the bearing's at t = 0, plane axes [m]; guide: offset [m], tilt [rad]",
    )

    @model_validator(mode="after")
    def _complete(self) -> JointModel:
        given = {key for key in ("clearance", "contact", "mixed") if getattr(self, key) is not None}
        if self.viscosity is not None and self.oil is not None:
            raise ValueError("give viscosity or oil, not both")
        if self.viscosity is not None or self.oil is not None:
            given.add("viscosity")
        needed = {
            "ideal": (),
            "lubricated": ("clearance", "viscosity"),
            "dry": ("clearance", "contact"),
            "mixed": ("clearance", "viscosity", "contact", "mixed"),
        }[self.model]
        missing = [key for key in needed if key not in given]
        if missing:
            raise ValueError(f'model "{self.model}" needs {" and ".join(missing)}')
        asperities = self.mixed is not None and self.mixed.law == "greenwood-tripp"
        if self.model == "mixed" and asperities and self.contact and self.contact.youngs_modulus is None:
            raise ValueError("greenwood-tripp needs the contact's youngs_modulus")
        return self

    @property
    def can_touch(self) -> bool:
        """Whether journal and bearing can be in contact."""
        return self.model in ("dry", "mixed")

    @property
    def has_film(self) -> bool:
        """Whether there is oil between journal and bearing."""
        return self.model in ("lubricated", "mixed")

    @property
    def has_play(self) -> bool:
        """Whether journal and bearing can move apart."""
        return self.model != "ideal"


class Solver(_Table):
    """Numerical settings; the defaults suit lubricated joints."""

    integrator: (
        Literal["radau3", "radau1", "implicit_euler", "runge_kutta5", "runge_kutta3", "bogacki_shampine3"]
        | None
    ) = Field(
        None, description="Drake's integration scheme; default radau3, with dry joints alone runge_kutta5"
    )
    accuracy: Annotated[float, Field(gt=0, le=0.1)] = Field(1e-7, description="relative accuracy [1]")
    max_step: Positive | None = Field(
        None, description="largest step; default 2e-3, where contact is possible 2e-5 [s]"
    )
    stabilisation: NonNegative = Field(50.0, description="decay rate of drive and loop errors [1/s]")


class Experiment(_Table):
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
        for path, value in _leaves(self.sdf):
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(self._source, f"sdf.{path}", "must be a number")
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

    def replaced(self, overrides: Mapping[str, Any]) -> Experiment:
        """Return the same experiment with values replaced by dotted path.

        Raises
        ------
        InputError
            If a path or value is not valid.
        """
        data = self.model_dump(exclude_unset=True)
        return _build(self._source, data, self._sources, overrides, "argument")

    def ideal(self) -> Experiment:
        """Return the same experiment with every joint ideal."""
        joints = {name: {"model": "ideal"} for name in self.joints}
        data = self.model_dump(exclude_unset=True) | {"joints": joints}
        return _build(self._source, data, self._sources, {}, "argument")


def load_experiment(path: str | Path, overrides: Mapping[str, Any] | None = None) -> Experiment:
    """Read an experiment from a TOML file.

    Parameters
    ----------
    path : str or Path
    overrides : mapping, optional
        Values by dotted path that replace those of the file; strings are read as TOML values.

    Raises
    ------
    InputError
        One line with file, key and reason.
    """
    path = Path(path)
    try:
        document = tomlkit.parse(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise InputError(path, "", f"cannot be read ({problem.strerror})") from None
    except (TOMLKitError, UnicodeDecodeError) as problem:
        raise InputError(path, "", f"is not valid TOML: {problem}") from None
    sources = dict(_comments(document))
    return _build(path, document.unwrap(), sources, overrides or {}, "--set")


def load(path: str | Path, overrides: Mapping[str, Any] | None = None) -> tuple[Mechanism, Experiment]:
    """Read an experiment and its mechanism, and check that they fit each other.

    Parameters
    ----------
    path : str or Path
        The TOML file.
    overrides : mapping, optional
        Values by dotted path that replace those of the files.

    Raises
    ------
    InputError
        One line with file, element or key, and reason.
    """
    experiment = load_experiment(path, overrides)
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

    def walk(model: type[BaseModel], prefix: str) -> Iterator[tuple[str, str]]:
        for name, info in model.model_fields.items():
            inner = next((t for t in [info.annotation, *get_args(info.annotation)] if _is_table(t)), None)
            named = str(info.annotation).startswith("dict") and inner is not None
            path = f"{prefix}{name}" + (".NAME" if named else "")
            yield path, info.description or ""
            if inner is not None:
                yield from walk(inner, path + ".")

    return walk(Experiment, "")


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _leaves(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in data.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _comments(table: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Find the comment beside each value of a TOML document."""
    for key in table:
        # indexing would unwrap booleans, and lose their comment; tables written in several places have no item()
        item = table.item(key) if hasattr(table, "item") else table[key]
        path = f"{prefix}{key}"
        if isinstance(item, Mapping):
            yield from _comments(getattr(item, "value", item), path + ".")
        elif hasattr(item, "trivia") and item.trivia.comment:
            yield path, item.trivia.comment.lstrip("# ").strip()


def parse_value(text: str) -> Any:
    """Read one value as TOML would; what is not TOML is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _build(
    source: Path,
    data: dict[str, Any],
    sources: Mapping[str, str],
    overrides: Mapping[str, Any],
    override_name: str,
) -> Experiment:
    sources = dict(sources)
    for path, value in overrides.items():
        parts = path.split(".")
        table = data
        for part in parts[:-1]:
            table = table.setdefault(part, {})
            if not isinstance(table, dict):
                raise InputError(override_name, path, f'"{part}" is a value, not a table')
        table[parts[-1]] = parse_value(value) if isinstance(value, str) else value
        sources[path] = override_name
    try:
        experiment = Experiment.model_validate(data)
    except ValidationError as problem:
        # a misspelt key often leaves another one missing: name the misspelt one
        first = min(problem.errors(), key=lambda error: error["type"] != "extra_forbidden")
        where = ".".join(str(part) for part in first["loc"])
        origin = override_name if where in overrides else source
        raise InputError(origin, where, _explain(first)) from None
    experiment._source = source
    experiment._sources = sources
    return experiment


def _explain(error: Any) -> str:
    """One sentence for a validation error."""
    loc, kind, value = error["loc"], error["type"], error["input"]
    if kind == "extra_forbidden":
        return f"unknown key; {nearest(str(loc[-1]), _model_at(loc[:-1]).model_fields)}"
    field = _model_at(loc[:-1]).model_fields.get(str(loc[-1])) if loc else None
    meaning = f" ({field.description})" if field is not None and field.description else ""
    if kind == "missing":
        return f"is missing{meaning}"
    if kind == "value_error":
        return str(error["ctx"]["error"])
    message = error["msg"].replace("Input should", "it should", 1)
    return f"is {value!r}; {message}{meaning}"


def _model_at(loc: tuple[Any, ...]) -> type[BaseModel]:
    """Find the table class that a validation error's location lies in."""
    model: type[BaseModel] = Experiment
    for part in loc:
        info = model.model_fields.get(str(part))
        if info is None:
            continue  # a name in a table of names
        inner = next((t for t in [info.annotation, *get_args(info.annotation)] if _is_table(t)), None)
        if inner is not None:
            model = inner
    return model
