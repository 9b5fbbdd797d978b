"""Tables of a mechanism's description, and the mechanism that it defines: links, joints, beams, frames in the world."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Discriminator, Field, Tag

from linkages.base.arrays import Array
from linkages.base.errors import nearest
from linkages.input.files.beams import POISSON, SECTIONS, of_beam
from linkages.input.files.drafting import DraftError, Numbers, body, upright
from linkages.input.files.raw_model import BearingSize, LinkBeam, RawJoint, RawLink, RawModel, Slot
from linkages.input.files.toml import Table, TwoOf
from linkages.input.files.unit_conversion import without_units

_BESIDE = 1e-6  # distance of a point over the beam's length below which the point lies on the beam

GROUND = "ground"


class BeamTable(Table):
    """The beam of a link: the link is flexible, straight and uniform, and has the beam's mass and inertia."""

    points: str = Field("", description="first and last end; default: the points of the link that are farthest apart")
    rectangle: dict[str, Any] | None = Field(
        None, description="width normal to the plane, height in the plane [m]; default: the section of the link's bars"
    )
    circle: dict[str, Any] | None = Field(None, description="diameter [m]")
    tube: dict[str, Any] | None = Field(None, description="outer and inner diameter [m]")
    section: dict[str, Any] | None = Field(
        None, description="area [m2], second_moment [m4], height in the plane [m], of any other section"
    )
    youngs_modulus: Any = Field(description="Young's modulus [Pa]")
    density: Any = Field(None, description="density instead of the link's [kg/m3]")
    poisson: Any = Field(None, description=f"Poisson's ratio; default {POISSON:g} [1]")


class LinkTable(Table):
    """A link with values that differ from the mechanism's defaults."""

    points: str = Field(description="points of the link, as in its short form")
    section: TwoOf[Any] | None = Field(None, description="section of its bars, instead of the default [m]")
    density: Any = Field(None, description="density instead of the default [kg/m3]")
    mass: Any = Field(None, description="mass instead of the bars', with the same distribution [kg]")
    inertia: Any = Field(None, description="moment of inertia about the mass centre, instead of the bars' [kg m2]")
    com: Any = Field(None, description="mass centre instead of the bars': a point, or coordinates [x, y] [m]")
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
    section: TwoOf[Any] = Field(description="section of all bars: width in the plane, thickness normal to it [m]")
    density: Any = Field(None, description="density of all bars; required for links without mass [kg/m3]")
    bearing: TwoOf[Any] | None = Field(
        None, description="radius and length of all pins; default: a quarter of the width, and the thickness [m]"
    )


#: Keys that describe the mechanism; the other keys belong to the experiment.
KEYS = tuple(Description.model_fields)


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


class Drawing:
    """The links, pins and guides of a description; `model` makes the mechanism of them."""

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
        """Return the mechanism in world coordinates."""
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
        where, link, given = f"links.{name}", self.links[name], self.description.links[name]
        table = LinkTable.model_validate({"points": given}) if isinstance(given, str) else given
        density, angle = self.description.density if table.density is None else table.density, self._angle(name)
        points = np.array([self._place(point, where) for point in link.points])
        pose = upright(angle, points[0])
        if table.beam is not None:
            for key in ("mass", "inertia", "com"):
                if getattr(table, key) is not None:
                    raise DraftError(f"{where}.{key}", "cannot be given with a beam, which determines it; remove it")
            none = RawLink(name, 0.0, pose.rotation, pose.translation, np.zeros(3), np.zeros((3, 3)), (), None)
            return of_beam(none, self._beam(name, table.beam, density))
        if density is None and table.mass is None:
            raise DraftError(where, "has no mass; give density, or mass")
        weight = self._positive(1.0 if density is None else density, "density")
        own, centre, inertia = body(points, angle, self._section(name), weight)
        if not own:
            raise DraftError(where, "has no length; its points coincide")
        mass = own if table.mass is None else self._positive(table.mass, f"{where}.mass")
        inertia = inertia * (mass / own)
        if table.inertia is not None:
            inertia = inertia * (self._positive(table.inertia, f"{where}.inertia") / inertia[2, 2])
        if table.com is not None:
            centre = self._centre(table.com, f"{where}.com")
        turn = pose.rotation
        local = turn.T @ (np.array([*centre, 0.0]) - pose.translation), turn.T @ inertia @ turn
        return RawLink(name, mass, turn, pose.translation, *local, (), None)

    def _centre(self, given: Any, where: str) -> Array:
        """Return the place of a point, or coordinates [m]."""
        match given:
            case str(point):
                return self._place(point, where)
            case [x, y]:
                return np.array([self.numbers.number(value, where) for value in (x, y)])
            case _:
                raise DraftError(where, f'is {given!r}; give a point, such as "O", or [x, y]')

    def _beam(self, name: str, table: BeamTable, density: Any) -> LinkBeam:
        where = f"links.{name}.beam"
        places = {point: self._place(point, f"links.{name}") for point in self.links[name].points}
        first, last = _ends(table, where, places)
        start, end = places[first], places[last]
        length = float(np.linalg.norm(end - start))
        if not length:
            raise DraftError(where, f"has no length; {first} and {last} coincide")
        for point in self.links[name].pins:
            along = (places[point] - start) @ (end - start) / length**2
            off = float(np.linalg.norm(places[point] - start - np.clip(along, 0.0, 1.0) * (end - start)))
            if off > _BESIDE * length:
                problem = f"{point} lies {off:g} m off the beam from {first} to {last}"
                raise DraftError(where, f"{problem}; a flexible link is straight: put {point} on another link")
        kinds = [kind for kind in SECTIONS if getattr(table, kind) is not None]
        if len(kinds) > 1:
            raise DraftError(where, f"has {len(kinds)} sections, {' and '.join(kinds)}; give one of them")
        kind, (height, width) = kinds[0] if kinds else "rectangle", self._section(name)
        given = getattr(table, kind) if kinds else {"width": width, "height": height}
        inner = f"{where}.{kind}"
        if set(given) != set(SECTIONS[kind]):
            raise DraftError(inner, f"has the keys {', '.join(given) or 'none'}; it needs {', '.join(SECTIONS[kind])}")
        sizes = {key: self._positive(given[key], f"{inner}.{key}") for key in SECTIONS[kind]}
        if kind == "tube" and sizes["inner"] >= sizes["outer"]:
            problem = f"is {sizes['inner']:g} m; it must be smaller than the outer one of {sizes['outer']:g} m"
            raise DraftError(f"{inner}.inner", problem)
        weight = density if table.density is None else table.density
        if weight is None:
            raise DraftError(where, "has no mass; give density")
        poisson = POISSON if table.poisson is None else self._positive(table.poisson, f"{where}.poisson")
        if poisson >= 0.5:
            raise DraftError(f"{where}.poisson", f"is {poisson:g}; it must be below 0.5")
        modulus = self._positive(table.youngs_modulus, f"{where}.youngs_modulus")
        ends = np.append(start, 0.0), np.append(end, 0.0)
        material = modulus, self._positive(weight, f"{where}.density"), poisson
        return LinkBeam((self._frame(name, first), self._frame(name, last)), *ends, kind, sizes, *material)

    def _pins(self) -> Iterator[RawJoint]:
        """Join all links that share a point to the first of them; the ground comes first."""
        order = sorted(self.links, key=lambda name: name != GROUND)
        used = {point for link in self.links.values() for point in link.points}
        centres = (given.com for given in self.description.links.values() if isinstance(given, LinkTable))
        used |= {centre for centre in centres if isinstance(centre, str)}
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
                yield RawJoint(name, "revolute", parent, other, axis, place, place, BearingSize(radius, length), None)
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


def _ends(table: BeamTable, where: str, places: Mapping[str, Array]) -> tuple[str, str]:
    names = list(places)
    if table.points:
        ends = table.points.split()
        if len(ends) != 2 or ends[0] == ends[1] or not set(ends) <= set(names):
            problem = f'is "{table.points}"; give two points of the link, of {", ".join(names)}'
            raise DraftError(f"{where}.points", problem)
        return ends[0], ends[1]
    apart = {(a, b): float(np.linalg.norm(places[b] - places[a])) for k, a in enumerate(names) for b in names[k + 1 :]}
    if not apart:
        raise DraftError(where, "belongs to a link with one point; a beam needs two")
    first, last = max(apart, key=lambda pair: apart[pair])
    along = (places[last] - places[first]) / (apart[first, last] or 1.0)
    for point, place in places.items():
        off = place - places[first]
        if abs(along[0] * off[1] - along[1] * off[0]) > _BESIDE * apart[first, last]:
            problem = f"{point} is not on the line from {first} to {last}"
            raise DraftError(where, f'{problem}; name the ends of the beam, as points = "{first} {last}"')
    return first, last
