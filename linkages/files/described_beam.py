"""The beam of a described link: its ends among the link's points, its section, its material."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from pydantic import Field

from linkages.files.beams import MATERIAL, POISSON, SECTIONS
from linkages.files.drafting import Array, DraftError
from linkages.files.raw_model import LinkBeam
from linkages.files.toml import Table

_BESIDE = 1e-6  # distance of a point over the beam's length below which the point lies on the beam

#: Units of a beam's quantities by key; sections have a separate table.
UNITS = {key: unit for kind in (*SECTIONS.values(), MATERIAL) for key, unit in kind.items() if unit != "1"}


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


def described_beam(
    table: BeamTable,
    where: str,
    places: Mapping[str, Array],
    pins: Sequence[str],
    frames: Mapping[str, str],
    bar: tuple[float, float],
    density: Any,
    positive: Callable[[Any, str], float],
) -> LinkBeam:
    """Return the beam that a link's table describes.

    Parameters
    ----------
    table : BeamTable
    where : str
        Key named in errors.
    places : mapping of str to (2,) array
        Positions of the link's points [m].
    pins : sequence of str
        Points with joints.
    frames : mapping of str to str
        Name of the frame at each point.
    bar : (float, float)
        Section of the link's bars: width in the plane, thickness normal to it [m].
    density : float, str or None
        Density of the link [kg/m3].
    positive : callable
        Function that evaluates the value of a key and rejects numbers that are not positive.

    Raises
    ------
    DraftError
        If the beam is invalid: key and reason.
    """
    first, last = _ends(table, where, places)
    start, end = places[first], places[last]
    length = float(np.linalg.norm(end - start))
    if not length:
        raise DraftError(where, f"has no length; {first} and {last} coincide")
    for point in pins:
        along = (places[point] - start) @ (end - start) / length**2
        off = float(np.linalg.norm(places[point] - start - np.clip(along, 0.0, 1.0) * (end - start)))
        if off > _BESIDE * length:
            problem = f"{point} lies {off:g} m off the beam from {first} to {last}"
            raise DraftError(where, f"{problem}; a flexible link is straight: put {point} on another link")
    kinds = [kind for kind in SECTIONS if getattr(table, kind) is not None]
    if len(kinds) > 1:
        raise DraftError(where, f"has {len(kinds)} sections, {' and '.join(kinds)}; give one of them")
    kind, (height, width) = kinds[0] if kinds else "rectangle", bar
    given = getattr(table, kind) if kinds else {"width": width, "height": height}
    inner = f"{where}.{kind}"
    if set(given) != set(SECTIONS[kind]):
        raise DraftError(inner, f"has the keys {', '.join(given) or 'none'}; it needs {', '.join(SECTIONS[kind])}")
    sizes = {key: positive(given[key], f"{inner}.{key}") for key in SECTIONS[kind]}
    if kind == "tube" and sizes["inner"] >= sizes["outer"]:
        problem = f"is {sizes['inner']:g} m; it must be smaller than the outer one of {sizes['outer']:g} m"
        raise DraftError(f"{inner}.inner", problem)
    weight = density if table.density is None else table.density
    if weight is None:
        raise DraftError(where, "has no mass; give density")
    poisson = POISSON if table.poisson is None else positive(table.poisson, f"{where}.poisson")
    if poisson >= 0.5:
        raise DraftError(f"{where}.poisson", f"is {poisson:g}; it must be below 0.5")
    modulus = positive(table.youngs_modulus, f"{where}.youngs_modulus")
    ends = np.append(start, 0.0), np.append(end, 0.0)
    return LinkBeam(
        (frames[first], frames[last]), *ends, kind, sizes, modulus, positive(weight, f"{where}.density"), poisson
    )


def _ends(table: BeamTable, where: str, places: Mapping[str, Array]) -> tuple[str, str]:
    """Name the points at a beam's ends."""
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
