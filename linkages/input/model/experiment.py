"""The experiment on a mechanism: drives, joint models, gravity, duration, tolerances; read from TOML.

The comment after a value in the file is its source ("Table 4", "assumed"), shown in reports. Every value can be
replaced by its dotted path, in Python and on the command line: ``joints.A.clearance``, ``drives.O1.speed``; values of
the SDF file have the prefix ``sdf.``, as ``sdf.links.link2.mass``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, create_model

from linkages.base.arrays import Array
from linkages.base.brief import Brief
from linkages.base.errors import ARGUMENT, COMMAND_LINE, InputError, shortened
from linkages.elements.controller import Controller
from linkages.elements.coordinates import Barrier, Coupled, Edge
from linkages.elements.coupling import Coupling
from linkages.elements.drive import Drive
from linkages.elements.flexible_link import LinkModel
from linkages.elements.force import Force
from linkages.elements.friction import JointFriction
from linkages.elements.gear import Gear
from linkages.elements.machine import (
    KINDS,
    NAMED,
    OF_PARTS,
    PUSHING,
    TABLES,
    all_elements_of,
    contacts_by_label,
    couplings_by_name,
    functions_of,
    outputs_of_models,
    quantities_of,
)
from linkages.elements.motor import Motor
from linkages.elements.spring import Spring
from linkages.elements.state import State
from linkages.elements.stop import Stop
from linkages.elements.torque import Torque
from linkages.elements.torsion_spring import TorsionSpring
from linkages.elements.touch import LineContact
from linkages.input.files.beams import MATERIAL, SECTIONS
from linkages.input.files.table_keys import bracketed, table_keys
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, leaves, read_toml, replace_values, validate
from linkages.input.files.unit_conversion import decimal_comma, read
from linkages.input.functions.definitions import Quantity, constant, inputs_of, names_in
from linkages.input.functions.recorded_tables import DataTable, FromFile
from linkages.input.model.experiment_tables import JointModel, RunWindow, SolverTable
from linkages.input.model.output_names import FORCES_OF_JOINTS, PIN_QUANTITIES, QUANTITIES, SHAPE_QUANTITIES
from linkages.input.model.worn import with_worn

_Values = Mapping[str, Any]
_NONE: _Values = MappingProxyType({})

#: The tables of applied loads, in the order in which the loads are packed.
LOADS = PUSHING


#: A number in the SI unit of its own kind.
Value = Annotated[Finite, BeforeValidator(lambda value: read(value, ""))]

_Vector = Annotated[list[Finite], Field(min_length=3, max_length=3)]

#: SI units of a mechanism's values, by the last part of their paths.
_OF_MACHINE = {
    "mass": "kg", "inertia": "kg m2", "roll": "rad", "pitch": "rad", "yaw": "rad",
    **dict.fromkeys(("x", "y", "z", "radius", "length", "height"), "m"),
    **{key: unit for sizes in (*SECTIONS.values(), MATERIAL) for key, unit in sizes.items()},
}  # fmt: skip


class Experiment(Brief, Table):
    """Drives, joint models, loads and settings for a mechanism, in SI units; made by `load_experiment`.

    Its attributes are the keys of the file: docs/experiment.md lists them with meaning, unit, default and range.
    """

    mechanism: str = Field(description="SDFormat file, relative to this file")
    title: str = Field("", description="one line for tables and figures")
    units: str = Field("", description="units of tables and figures, such as mm, deg, r/min; default: SI units")
    duration: Positive = Field(description="simulated time [s]")
    gravity: _Vector = Field([0.0, 0.0, 0.0], description="gravity, world axes [m/s2]")
    start: Literal["centred", "equilibrium"] = Field(
        "centred", description="start of journals: at their offset (default: the centre), or in static equilibrium"
    )
    outputs: list[str] = Field(
        [],
        description=f"reported outputs: LINK_OR_FRAME.{'|'.join((*QUANTITIES, *SHAPE_QUANTITIES))},"
        f" JOINT.{'|'.join(PIN_QUANTITIES)}; all other outputs are recorded, and reported if they are named here",
    )
    joints: Annotated[dict[str, JointModel], AfterValidator(with_worn)] = Field(
        {}, description="joint models by name; joints not named are ideal"
    )
    drives: dict[str, Drive] = Field({}, description="driven joints by name")
    links: dict[str, LinkModel] = Field({}, description="link models by name; links not named are rigid")
    forces: dict[str, Force] = Field({}, description="applied forces by name")
    torques: dict[str, Torque] = Field({}, description="applied torques by name")
    springs: dict[str, Spring] = Field({}, description="springs and dampers between two points, by name")
    torsion_springs: dict[str, TorsionSpring] = Field({}, description="torsion springs and dampers by name")
    frictions: dict[str, JointFriction] = Field({}, description="friction in ideal joints, by name")
    values: dict[str, Value] = Field({}, description="numbers by name, for formulas; in SI units, or with a unit")
    states: dict[str, State] = Field({}, description="additional states by name, for formulas")
    motors: dict[str, Motor] = Field({}, description="motors that turn revolute joints, by name")
    controllers: dict[str, Controller] = Field({}, description="controllers by name; their outputs are for formulas")
    gears: dict[str, Gear] = Field({}, description="gears and belts between joints, by name")
    couplings: dict[str, Coupling] = Field({}, description="couplings of coaxial shafts by name")
    stops: dict[str, Stop] = Field({}, description="stops of joints by name")
    contacts: dict[str, LineContact] = Field({}, description="contacts of points with straight lines, by name")
    data: DataTable | None = Field(None, description="measured curves for comparison with computed ones")
    report: Literal["steady", "whole"] = Field(
        "steady",
        description="part of the run that tables give first: the last period of a periodic motion, otherwise the time "
        "after the start-up of clearance joints; or the whole run",
    )
    report_from: NonNegative | None = Field(None, description="start of the part of a run that tables give instead [s]")
    windows: dict[str, RunWindow] = Field({}, description="further parts of the run with separate results")
    sdf: dict[str, Any] = Field({}, description="replaced values of the SDF file, by dotted path")
    solver: SolverTable = Field(SolverTable.model_validate({}), description="numerical settings")

    _source: Path = PrivateAttr(Path("experiment"))
    _sources: dict[str, str] = PrivateAttr(default_factory=dict)
    _texts: dict[str, Any] = PrivateAttr(default_factory=dict)

    @property
    def driving(self) -> list[str]:
        """Name the drives that act, see `Drive.acts`."""
        return [name for name, drive in self.drives.items() if drive.acts]

    @property
    def actuators(self) -> list[str]:
        """Name what moves the machine: the drives that act, and the motors; each has a torque, or a force."""
        return [*self.driving, *self.motors]

    def _facts(self) -> tuple[str, dict[str, str]]:
        rows = {"experiment": self.source.name, "mechanism": self.mechanism, "duration": f"{self.duration:g} s"}
        rows["drives"] = ", ".join(self.drives) or "none"
        for name, joint in self.joints.items():
            clearance = f", clearance {joint.clearance:g} m" if joint.clearance else ""
            rows[f"model of {name}"] = f"{joint.model}{clearance}"
        named = _in_order("links", "values", *TABLES)
        tables = {name: getattr(self, name) for name in named}
        rows |= {f"table {name}": ", ".join(table) for name, table in tables.items() if table}
        rows["outputs"] = ", ".join(self.outputs) or "none"
        return f"{self.title or self.source.stem}; {self.source.name}, {self.duration:g} s", rows

    @property
    def source(self) -> Path:
        """Return the file of the experiment."""
        return self._source

    @property
    def sources(self) -> dict[str, str]:
        """Return the source of each value, by dotted path: the comment after it, or the origin of its replacement.

        A table that was replaced has one for all its values; a component (``gravity.y``) counts as its list.
        """
        lists = {path for path, value in leaves(self.model_dump(exclude_unset=True)) if isinstance(value, list)}

        def place(path: str) -> str:
            table, _, key = path.rpartition(".")
            column = f"{table}.columns.{key}"  # a column of a file is written at the key of its values
            return table if table in lists else column if column in lists else path

        return {place(path): source for path, source in self._sources.items()}

    @property
    def texts(self) -> dict[str, Any]:
        """Return the texts and lists of the file, by dotted path; values with units are texts."""
        return dict(self._texts)

    @property
    def mechanism_path(self) -> Path:
        """Return the SDFormat file."""
        return self._source.parent / self.mechanism

    @cached_property
    def sdf_overrides(self) -> dict[str, float]:
        """Return the values that override the SDF file, by dotted path without the prefix ``sdf.``."""
        result = {}
        for path, value in leaves(self.sdf):
            source = self.origin(f"sdf.{path}")
            try:
                number = read(value, _OF_MACHINE.get(path.rpartition(".")[2], ""))
            except ValueError as problem:
                raise InputError(source, f"sdf.{path}", str(problem)) from None
            if isinstance(number, bool) or not isinstance(number, int | float):
                comma = decimal_comma(value) if isinstance(value, str) else ""
                what = f"is {shortened(repr(value))}{comma or '; it must be a number'}"
                raise InputError(source, f"sdf.{path}", what)
            result[path] = float(number)
        return result

    def origin(self, path: str) -> str | Path:
        """Return the origin of the value at a dotted path: the file, the command line, or an argument."""
        given = self._sources.get(path)
        return given if given in (ARGUMENT, COMMAND_LINE) else self._source

    @property
    def play(self) -> tuple[str, ...]:
        """Return the names of the clearance joints."""
        return tuple(name for name, joint in self.joints.items() if joint.has_play)

    @property
    def can_touch(self) -> bool:
        """Whether anything can be in contact: in dry or mixed joints, at limits, or of points with lines."""
        return bool(self.touches) or any(self.joints[name].can_touch for name in self.play)

    @property
    def deforming(self) -> dict[str, Any]:
        """Return the models that make links deformable bodies, by link."""
        named = ((kind, *one) for kind in OF_PARTS for one in self.elements[kind.table].items())
        return {name: keys for kind, name, keys in named if kind.deforms(keys)}

    @property
    def imperfect(self) -> bool:
        """Whether the linkage differs from the ideal one: by clearance, backlash or deformation."""
        tables = (getattr(self, kind.table) for kind in KINDS if kind.derived is None)
        return bool(self.play) or any(_is_imperfect(keys) for table in tables for keys in table.values())

    @property
    def loads(self) -> tuple[tuple[str, str], ...]:
        """Return table and name of each applied load beside the elements with kernels: frictions."""
        return tuple((table, name) for table in LOADS for name in getattr(self, table))

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Return the quantities of elements, then values, by the names that formulas have for them."""
        return quantities_of(self.elements) | {name: constant(name, value) for name, value in self.values.items()}

    @property
    def own_states(self) -> dict[str, Quantity]:
        """Return the additional states, in the order of the state vector."""
        return {name: one for name, one in self.quantities.items() if one.is_state}

    def sampling_times(self, end: float) -> Array:
        """Return the times after t = 0 and up to an end at which states are sampled [s]."""
        periods = {one.period for one in self.own_states.values() if one.period > 0.0}
        times = (period * np.arange(1.0, end / period + 0.5) for period in periods)
        return np.unique(np.concatenate([np.zeros(0), *times]))

    @property
    def unread_states(self) -> set[str]:
        """Return the additional states that no formula reads, such as a motor's energy: they change nothing else."""
        found = self.quantities
        read = {name for one in found.values() for name in inputs_of(one.definition, found)}
        return self.own_states.keys() - read - self.functions_read

    @property
    def functions_read(self) -> set[str]:
        """Return the names that functions of elements read: the time, positions, speeds, quantities."""
        return {name for _, _, one in functions_of(self.elements) for name in names_in(one)}

    @property
    def from_files(self) -> dict[str, FromFile]:
        """Return the drives and loads that take their signal from a data file, by dotted path."""
        named = {f"{table}.{name}": one for table, found in self.elements.items() for name, one in found.items()}
        return {path: one for path, one in named.items() if isinstance(one, FromFile) and one.file is not None}

    @cached_property
    def elements(self) -> dict[str, Mapping[str, Table]]:
        """Return the elements of `linkages.elements`, by table and name."""
        return {
            kind.table: getattr(self, kind.table) if kind.derived is None else kind.derived(getattr(self, kind.home))
            for kind in KINDS
        }

    @property
    def named(self) -> tuple[tuple[str, str], ...]:
        """Return table and name of each part that acts on bodies: elements, gears, couplings, stops, contacts."""
        tables = (kind.table for kind in NAMED if kind.acts)
        return tuple((table, name) for table in _in_order(*tables) for name in getattr(self, table))

    @property
    def acting(self) -> tuple[tuple[str, str], ...]:
        """Return the named elements, and those that are derived from other tables."""
        derived = (kind for kind in KINDS if kind.derived is not None)
        return self.named + tuple((kind.table, name) for kind, name, _ in all_elements_of(self.elements, derived))

    @property
    def coupled(self) -> dict[str, Coupled]:
        """Return the joints whose coordinates elements couple, exactly or loosely, by the elements' names."""
        return couplings_by_name(self.elements)

    @property
    def closed(self) -> dict[str, Coupled]:
        """Return the joints with exactly coupled coordinates."""
        return {name: one for name, one in self.coupled.items() if one.width is None}

    @property
    def loose(self) -> dict[str, Coupled]:
        """Return the joints with coordinates that are coupled within a free travel."""
        return {name: one for name, one in self.coupled.items() if one.width is not None}

    @property
    def wheels(self) -> dict[str, float]:
        """Return the moments of inertia of the wheels that drives turn before their joints, by the joint [kg m2]."""
        return {name: drive.wheel for name, drive in self.drives.items() if drive.wheel is not None}

    @property
    def touches(self) -> dict[str, Barrier | Edge]:
        """Return the contacts of elements, by label."""
        return contacts_by_label(self.elements)

    def perfected(self, rigid: bool = True) -> dict[str, Any]:
        """Return tables without the keys that the ideal linkage lacks; only those that change.

        If not `rigid`, links stay deformable.
        """
        kinds = [kind for kind in KINDS if kind.derived is None]
        found: dict[str, dict[str, Table]] = {kind.table: getattr(self, kind.table) for kind in kinds}
        if not rigid:
            found = {
                kind.table: found[kind.table]
                for kind in kinds
                if not any(map(kind.deforms, found[kind.table].values()))
            }
        return {key: _perfect(named) for key, named in found.items() if any(map(_is_imperfect, named.values()))}

    @property
    def couplings_alone(self) -> dict[str, Any]:
        """Return the tables of the elements that couple coordinates, as the linkage with ideal joints has them."""
        tables = {kind.table for kind, _, keys in all_elements_of(self.elements) if kind.couples(keys) is not None}
        return {table: _perfect(getattr(self, table)) for table in TABLES if table in tables}

    def value(self, path: str) -> float:
        """Return the number at a dotted path; InputError if there is none."""
        return self.number_at(path, self._source)

    def replaced(self, overrides: Mapping[str, Any], origin: str = ARGUMENT) -> Experiment:
        """Return the experiment with values from `origin` replaced by dotted path; InputError for a wrong one."""
        # no rule of a table is about another one: only tables with replaced values are checked again
        changed: dict[str, Any] = {}  # names of the tables, or True for the whole value of a key
        for path in overrides:
            key, name, *_ = *path.split("."), ""
            inner = name and isinstance(getattr(self, key, None), dict) and changed.get(key) is not True
            changed[key] = changed.get(key, set()) | {name} if inner else True
        data = self.model_dump(include=changed, exclude_unset=True)
        _replace(data, overrides, origin)
        origins = dict.fromkeys(overrides, origin)
        valid = vars(validate(_part(tuple(changed)), data, self._source, origins, self._source.parent))
        values = {
            key: valid[key] if names is True else getattr(self, key) | valid[key] for key, names in changed.items()
        }
        result = self.model_copy(update=values)
        for key in ("sdf_overrides", "quantities", "elements"):
            result.__dict__.pop(key, None)

        def stays(path: str) -> bool:
            key, _, rest = path.partition(".")
            gone = changed.get(key, set())
            return gone is not True and rest.partition(".")[0] not in gone

        texts = {path: text for path, text in self._texts.items() if stays(path)}
        result._texts, result._sources = texts | _texts(data), _later(self._sources, origins)
        return result

    def ideal(self) -> Experiment:
        """Return the experiment with every joint and element ideal: without clearance, backlash, deformation."""
        perfect = {
            "joints": {name: {"model": "ideal"} for name in self.joints},
            "outputs": [name for name in self.outputs if self._stays(name)],
        }
        data = self.model_dump(exclude_unset=True) | perfect | self.perfected()
        return experiment_of(self._source, data, self._sources)

    def _stays(self, output: str) -> bool:
        """Check whether the linkage with ideal joints and gears and rigid links has an output."""
        owner, _, quantity = output.rpartition(".")
        if quantity in SHAPE_QUANTITIES or owner == "q" or owner.rpartition(".")[0] in self.loose:
            return False
        return owner not in self.play or self.is_of_joint(owner, quantity)

    def is_of_joint(self, joint: str, quantity: str) -> bool:
        """Check whether a joint has an output without clearance."""
        driven = outputs_of_models("joint") if joint in self.drives else ()
        return quantity in (*PIN_QUANTITIES, *FORCES_OF_JOINTS, *driven)


def _in_order(*tables: str) -> list[str]:
    """Return tables in the order of the experiment's keys."""
    return sorted(tables, key=list(Experiment.model_fields).index)


def _is_imperfect(table: Table) -> bool:
    return any(getattr(table, key) != type(table).model_fields[key].default for key in table.imperfections)


def _perfect(named: Mapping[str, Table]) -> dict[str, Any]:
    """Return the values of tables without the keys that the linkage with ideal joints lacks."""
    return {name: one.model_dump(exclude_unset=True, exclude={*one.imperfections}) for name, one in named.items()}


@cache
def _part(keys: tuple[str, ...]) -> type[Table]:
    """Make the table of some keys of an experiment; the experiment itself if one of them is unknown."""
    if not Experiment.model_fields.keys() >= set(keys):
        return Experiment
    known = Experiment.model_fields
    fields: dict[str, Any] = {key: (known[key].annotation, known[key]) for key in keys}
    return create_model("Part", __base__=Table, **fields)


def load_experiment(path: str | Path, overrides: Mapping[str, Any] | None = None, origin: str = ARGUMENT) -> Experiment:
    """Read an experiment from a TOML file.

    To run it, use `linkages.load`, which also reads the mechanism and checks both.

    Parameters
    ----------
    path : str or Path
    overrides : mapping, optional
        Values by dotted path that override the file; strings are read as TOML values.
    origin : str
        Origin of the overrides, named in errors and as the source of their values.

    Raises
    ------
    InputError
        If the input is invalid: one line with file, key and reason.

    Examples
    --------
    >>> import linkages
    >>> experiment = linkages.load_experiment(linkages.find_file("seven_bar.toml"), {"duration": 0.5})
    >>> experiment.duration, experiment.sources["joints.A.clearance"]
    (0.5, 'm, radial, section 3.3')
    """
    path = Path(path)
    return experiment_of(path, *read_toml(path), overrides or {}, origin)


def experiment_of(
    source: Path, data: dict[str, Any], sources: Mapping[str, str], overrides: _Values = _NONE, origin: str = ARGUMENT
) -> Experiment:
    """Return the experiment of nested tables, in which overrides replace values; see `load_experiment`."""
    _replace(data, overrides, origin)
    replaced = dict.fromkeys(overrides, origin)
    experiment = validate(Experiment, data, source, replaced, source.parent)
    experiment._source = source
    experiment._texts, experiment._sources = _texts(data), _later(sources, replaced)
    return experiment


def nothing_done(path: Path, overrides: _Values = _NONE, origin: str = ARGUMENT) -> Experiment:
    """Return an experiment at rest on the mechanism of a file, ideal and without loads; see `load_experiment`."""
    return experiment_of(path, {"mechanism": path.name, "duration": 1.0}, {}, overrides, origin)


def value_unit(path: str) -> str:
    """Return the SI unit of the value at a dotted path (for a revolute joint); empty if unknown.

    Paths in the mechanism have the prefix ``sdf.``.

    Examples
    --------
    >>> from linkages.input.model.experiment import value_unit
    >>> value_unit("joints.A.clearance"), value_unit("sdf.links.rod.mass"), value_unit("drives.O.speed")
    ('m', 'kg', 'rad/s')
    """
    parts = path.split(".")
    if parts[0] == "sdf":
        return _OF_MACHINE.get(parts[-1], "")
    named = ".".join(["NAME" if k == 1 and len(parts) > 2 else part for k, part in enumerate(parts)])
    known = dict(table_keys(Experiment))
    meaning = known.get(path, known.get(named, known.get(named.rpartition(".")[0], "")))
    return bracketed(meaning)


def _later(sources: Mapping[str, str], others: Mapping[str, str]) -> dict[str, str]:
    """Return sources by path with later ones; values of replaced tables have no other source."""
    below = tuple(f"{path}." for path in others)
    return {path: source for path, source in sources.items() if not path.startswith(below)} | dict(others)


def _replace(data: dict[str, Any], overrides: Mapping[str, Any], origin: str) -> None:
    """Replace values by dotted path, in place."""
    if any(path.startswith("gravity.") for path in overrides):
        data.setdefault("gravity", [0.0, 0.0, 0.0])
    replace_values(data, overrides, origin)


def _texts(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the texts and lists of nested tables, by dotted path."""
    return {path: value for path, value in leaves(data) if isinstance(value, str | list)}
