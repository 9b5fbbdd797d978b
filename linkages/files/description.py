"""A mechanism described in a few lines of TOML: points, links, sliders, parameters and formulas with units.

The description is part of an experiment file and replaces the name of an SDFormat file; its keys are `Description`'s.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import tomlkit
from pydantic import Discriminator, Field, Tag

from linkages.errors import InputError, nearest
from linkages.files.beams import of_beam
from linkages.files.described_beam import BeamTable, described_beam
from linkages.files.drafting import Array, Body, DraftError, Numbers, body, upright
from linkages.files.raw_model import Bearing, Pose, RawJoint, RawLink, RawModel, Slot
from linkages.files.sdf_text import sdf_text
from linkages.files.shorthand import written_out
from linkages.files.toml import Table, validate
from linkages.files.unit_conversion import is_quantity, si_unit, without_units
from linkages.files.xml import parse_xml

GROUND = "ground"
_UNITS = "units"  # key of a stored description: SI units of parameters whose numbers had one
_Pair = Annotated[list[Any], Field(min_length=2, max_length=2)]


class LinkTable(Table):
    """A link with values that differ from the mechanism's defaults."""

    points: str = Field(description="points of the link, as in its short form")
    section: _Pair | None = Field(None, description="section of its bars, instead of the default [m]")
    density: Any = Field(None, description="density instead of the default [kg/m3]")
    mass: Any = Field(None, description="mass instead of the bars', with the same distribution [kg]")
    inertia: Any = Field(None, description="moment of inertia about the mass centre, instead of the bars' [kg m2]")
    beam: BeamTable | None = Field(None, description="beam of a flexible link, instead of bars")


_Link = Annotated[
    Annotated[str, Tag(" ")] | Annotated[LinkTable, Tag("")],  # tags do not show in a path of `validate`
    Discriminator(lambda value: " " if isinstance(value, str) else ""),
]


class Description(Table):
    """A mechanism in a few lines. Values are numbers (SI), quantities such as "0.1 mm", or formulas of parameters."""

    parameters: dict[str, Any] = Field(
        {}, description="values for formulas by name; they can be replaced, and optimised"
    )
    points: dict[str, list[Any]] = Field(
        description="positions [m]: [x, y]; [point, distance, angle]; [point, distance, point in this direction];"
        " [point, distance, point, distance], to the left of the line from the first point to the second"
    )
    links: dict[str, _Link] = Field(
        description='points of a link, "A B C"; points in parentheses have no joint;'
        ' a slider: "A along LINK", or "A along LINK at ANGLE" from the link\'s first two points (x on the ground);'
        f' the link "{GROUND}" is fixed'
    )
    section: _Pair = Field(description="section of all bars: width in the plane, thickness normal to it [m]")
    density: Any = Field(None, description="density of all bars; required for links without mass [kg/m3]")
    bearing: _Pair | None = Field(
        None, description="radius and length of all pins; default: a quarter of the width, and the thickness [m]"
    )


#: Keys that describe the mechanism; the other keys belong to the experiment.
KEYS = tuple(Description.model_fields)


class Described(NamedTuple):
    """A described mechanism.

    Attributes
    ----------
    model : RawModel
    text : str
        The description in SI units and without repetitions, which `redrawn` reads.
    parameters : dict of str to float
        Parameters by dotted path, in SI units.
    units : dict of str to str
        Their SI units by dotted path, where the description has them.
    """

    model: RawModel
    text: str
    parameters: dict[str, float]
    units: dict[str, str]


def described(path: Path, name: str, data: Mapping[str, Any], stored: bool = False) -> Described:
    """Make a mechanism from its description.

    Parameters
    ----------
    path : Path
        File named in errors.
    name : str
        Name of the mechanism.
    data : mapping
        Values of the keys `KEYS`.
    stored : bool
        Whether the values come from an SDFormat file, whose angles are numbers in rad.

    Raises
    ------
    InputError
        If the description is invalid: file, key and reason.
    """
    try:
        own = {key: value for key, value in data.items() if not (stored and key == _UNITS)}
        given = validate(Description, own, path).model_dump(exclude_unset=True)
        plain = written_out(given, stored)
        quantities = {key: str(value) for key, value in given.get("parameters", {}).items() if is_quantity(str(value))}
        units = data.get(_UNITS, {}) if stored else {key: si_unit(value) for key, value in quantities.items()}
        description = validate(Description, plain, path)
        numbers = Numbers(description.parameters, description.points)
        model = _Drawing(name, description, numbers).model()
        values = {f"parameters.{key}": numbers.named(key, "parameters") for key in description.parameters}
    except DraftError as problem:
        raise InputError(path, *problem.args) from None
    except RecursionError:
        raise InputError(path, "parameters and points", "refer to each other in a chain that is too long") from None
    if not all(isinstance(link, str) for link in plain["links"].values()):  # TOML has tables after texts
        plain["links"] = {key: {"points": v} if isinstance(v, str) else v for key, v in plain["links"].items()}
    text = tomlkit.dumps(plain | ({_UNITS: units} if units else {}))
    return Described(model, text, values, {f"parameters.{key}": unit for key, unit in units.items()})


def redrawn(
    path: Path, model: ET.Element, text: str, overrides: Mapping[str, float]
) -> tuple[ET.Element, dict[str, float], dict[str, str]]:
    """Make a described mechanism again with other parameters.

    Parameters
    ----------
    path : Path
        File named in errors.
    model : Element
        Model of the file; it must agree with its description.
    text : str
        Description of the mechanism.
    overrides : mapping of str to float
        Parameters by the paths ``parameters.NAME``.

    Returns
    -------
    (Element, dict of str to float, dict of str to str)
        The model, all parameters by path, and their SI units where they are known.

    Raises
    ------
    InputError
        If a parameter is unknown, gives no valid mechanism, or the model was edited after it was written.
    """
    name, data = model.get("name", ""), tomlkit.parse(text).unwrap()
    drawn = described(path, name, data, stored=True)
    for key in overrides:
        if key not in drawn.parameters:
            raise InputError(path, f"sdf.{key}", f"there is no such parameter; {nearest(key, drawn.parameters)}")
    if not overrides:
        return model, drawn.parameters, drawn.units
    if _content(_element(path, drawn)) != _content(model):
        problem = "the model no longer agrees with its description; write it again with `linkages new --from`"
        raise InputError(path, "<linkages:description>", f"{problem}, or replace values of its links instead")
    own = {key.partition(".")[2]: value for key, value in overrides.items()}
    other = described(path, name, data | {"parameters": data.get("parameters", {}) | own}, stored=True)
    return _element(path, other), other.parameters, drawn.units


def _element(path: Path, drawn: Described) -> ET.Element:
    return parse_xml(path, sdf_text(drawn.model, (), drawn.text).encode())[0]


def _content(element: ET.Element) -> tuple[Any, ...]:
    """Return the content of an element without its formatting."""
    return element.tag, element.attrib, (element.text or "").split(), [_content(part) for part in element]


# -- the drawing -------------------------------------------------------------------------------------------------------


class _Points(NamedTuple):
    """Parsed short form of a link: points with pins, other points, the link that it slides along, angle."""

    pins: list[str]
    others: list[str]
    rail: str
    turn: str

    @classmethod
    def of(cls, text: str, where: str, names: set[str]) -> _Points:
        points, along, rest = text.partition(" along ")
        rail, _, turn = rest.partition(" at ")
        words = points.split()
        if not words or (along and not rail.strip()):
            raise DraftError(where, f'is "{text}"; write points "A B C", or "A along LINK at ANGLE"')
        others = [word[1:-1] for word in words if word.startswith("(") and word.endswith(")")]
        try:
            angle = without_units(turn.strip() or "0", names)
        except ValueError as problem:
            raise DraftError(where, str(problem)) from None
        return cls([word for word in words if not word.startswith("(")], others, rail.strip(), angle)

    @property
    def points(self) -> list[str]:
        return [*self.pins, *self.others]


class _Drawing:
    """The links, pins and guides of a description."""

    def __init__(self, name: str, description: Description, numbers: Numbers) -> None:
        self.name, self.description, self.numbers = name, description, numbers
        names = set(description.parameters)
        self.links = {
            key: _Points.of(link if isinstance(link, str) else link.points, f"links.{key}", names)
            for key, link in description.links.items()
        }
        if GROUND not in self.links and not any(link.rail == GROUND for link in self.links.values()):
            raise DraftError("links", f'has no "{GROUND}"; name the fixed points')
        ground = description.links.get(GROUND, "")
        if not isinstance(ground, str) and ground.beam is not None:
            raise DraftError(f"links.{GROUND}.beam", "is fixed; give the beam to a moving link")
        self.turning: list[str] = []

    def model(self) -> RawModel:
        links = tuple(self._link(name) for name in self.links if name != GROUND)
        return RawModel(self.name, links, (*self._pins(), *self._guides()), dict(self._frames()), {})

    def _place(self, point: str, where: str) -> Array:
        return np.array(self.numbers.place(point, where))

    def _angle(self, name: str) -> float:
        """Return the angle of a link's x axis: from its first to its second point; for a slider its direction [rad]."""
        if name == GROUND and name not in self.links:
            return 0.0
        where = f"links.{name}"
        if name not in self.links:
            raise DraftError(f"links.{self.turning[-1]}", f'there is no link "{name}"; {nearest(name, self.links)}')
        if name in self.turning:
            raise DraftError(where, "slides along itself; break the circle")
        link = self.links[name]
        self.turning.append(name)
        angle = 0.0
        if link.rail:
            angle = self._angle(link.rail) + self.numbers.number(link.turn, where)
        elif len(link.points) > 1 and name != GROUND:
            way = self._place(link.points[1], where) - self._place(link.points[0], where)
            angle = math.atan2(way[1], way[0])
        self.turning.pop()
        return angle

    def _section(self, name: str) -> tuple[float, float]:
        own = self.description.links.get(name, "")
        section = self.description.section if isinstance(own, str) or own.section is None else own.section
        width, thickness = (self._positive(value, "section") for value in section)
        return width, thickness

    def _positive(self, value: Any, where: str) -> float:
        number = self.numbers.number(value, where)
        if not number > 0.0:
            raise DraftError(where, f"is {number:g}; it must be positive")
        return number

    def _link(self, name: str) -> RawLink:
        where, link, own = f"links.{name}", self.links[name], self.description.links[name]
        table = LinkTable.model_validate({"points": own}) if isinstance(own, str) else own
        density, angle = self.description.density if table.density is None else table.density, self._angle(name)
        points = np.array([self._place(point, where) for point in link.points])
        if table.beam is not None:
            return self._flexible(name, table, upright(angle, points[0]), density)
        if density is None and table.mass is None:
            raise DraftError(where, "has no mass; give density, or mass")
        weighed = body(
            points, angle, self._section(name), self._positive(1.0 if density is None else density, "density")
        )
        if not weighed.mass:
            raise DraftError(where, "has no length; its points coincide")
        weighed = self._given(weighed, table, where)
        pose = upright(angle, points[0])
        turn, centre = pose.rotation, np.array([*weighed.centre, 0.0])
        local = turn.T @ (centre - pose.translation), turn.T @ weighed.inertia @ turn
        return RawLink(name, weighed.mass, turn, pose.translation, *local, (), None)

    def _flexible(self, name: str, table: LinkTable, pose: Pose, density: Any) -> RawLink:
        """Return a link with a beam, which determines its mass and inertia."""
        where, link = f"links.{name}", self.links[name]
        assert table.beam is not None
        for key in ("mass", "inertia"):
            if getattr(table, key) is not None:
                raise DraftError(f"{where}.{key}", "cannot be given with a beam, which determines it; remove it")
        places = {point: self._place(point, where) for point in link.points}
        frames = {point: self._frame(name, point) for point in link.points}
        shape = places, link.pins, frames, self._section(name)
        beam = described_beam(table.beam, f"{where}.beam", *shape, density, self._positive)
        none = np.zeros(3)
        return of_beam(RawLink(name, 0.0, pose.rotation, pose.translation, none, np.zeros((3, 3)), (), None), beam)

    def _given(self, weighed: Body, table: LinkTable, where: str) -> Body:
        """Return a body with the mass and the moment of inertia given in the table."""
        mass, inertia = weighed.mass, weighed.inertia
        if table.mass is not None:
            mass = self._positive(table.mass, f"{where}.mass")
            inertia = inertia * (mass / weighed.mass)
        if table.inertia is not None:
            inertia = inertia * (self._positive(table.inertia, f"{where}.inertia") / inertia[2, 2])
        return Body(mass, weighed.centre, inertia)

    def _pins(self) -> Iterator[RawJoint]:
        """Join all links that share a point to the first of them; the ground comes first."""
        order = sorted(self.links, key=lambda name: name != GROUND)
        used = {point for link in self.links.values() for point in link.points}
        for point in self.description.points:
            on = [name for name in order if point in self.links[name].pins]
            for count, other in enumerate(on[1:]):
                name = point if not count else f"{point}_{other}"
                width, thickness = self._section(on[0])
                given = self.description.bearing or [width / 4.0, thickness]
                radius, length = (self._positive(value, "bearing") for value in given)
                place = np.array([*self._place(point, f"links.{other}"), 0.0])
                parent = "world" if on[0] == GROUND else on[0]
                axis = np.array([0.0, 0.0, 1.0])
                yield RawJoint(name, "revolute", parent, other, axis, place, place, Bearing(radius, length), None)
        for point in self.description.points:
            named = {name.partition(".")[0] for name in self.numbers.found}
            if point not in used and point not in named:
                raise DraftError(f"points.{point}", "is on no link; name it in [links], or remove it")

    def _guides(self) -> Iterator[RawJoint]:
        for name, link in self.links.items():
            if not link.rail:
                continue
            angle, (width, _) = self._angle(name), self._section(name)
            place = np.array([*self._place(link.points[0], f"links.{name}"), 0.0])
            rail = "world" if link.rail == GROUND else link.rail
            axis = np.array([math.cos(angle), math.sin(angle), 0.0])
            slot = Slot(2.0 * width, width)
            yield RawJoint(f"{name}_guide", "prismatic", rail, name, axis, place, place, None, slot)

    def _frames(self) -> Iterator[tuple[str, tuple[str, Any]]]:
        """Name the points of links: LINK_POINT, or POINT if no other link has it."""
        for name, link in self.links.items():
            for point in link.points if name != GROUND else ():
                if (frame := self._frame(name, point)) != name:
                    place = self._place(point, f"links.{name}")
                    yield frame, (name, upright(self._angle(name), place.tolist()))

    def _frame(self, name: str, point: str) -> str:
        """Name the frame at a point of a link: POINT if no other link has it; else LINK_POINT, LINK if it is first."""
        if sum(point in other.points for other in self.links.values()) == 1:
            return point
        return name if point == self.links[name].points[0] else f"{name}_{point}"
