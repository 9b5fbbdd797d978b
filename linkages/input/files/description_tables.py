"""Tables of a mechanism's description: points, links, beams, parameters."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from linkages.input.files.beams import POISSON
from linkages.input.files.toml import Table, TwoOf

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
