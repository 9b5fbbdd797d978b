"""The beam of a link in an SDFormat file; the beam determines the link's mass."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from linkages.base.errors import InputError
from linkages.input.files.elements import annotation, parts, sizes
from linkages.input.files.raw_model import LinkBeam, RawLink
from linkages.input.files.xml import label

AnyLink = TypeVar("AnyLink", bound=RawLink)

#: Sizes of each kind of section, and the numbers of a material, with their units.
SECTIONS = {
    "rectangle": {"width": "m", "height": "m"},
    "circle": {"diameter": "m"},
    "tube": {"outer": "m", "inner": "m"},
    "section": {"area": "m2", "second_moment": "m4", "height": "m"},
}
MATERIAL = {"youngs_modulus": "Pa", "density": "kg/m3", "poisson": "1"}
#: Poisson's ratio of metals; the Euler-Bernoulli beam does not depend on it.
POISSON = 0.3
FOLLOWS = "follows from the link's beam; replace its section, its density or the positions of its ends instead"

_AGREES = 0.01  # largest relative difference of <inertial> from the beam


def written_beam(path: Path, link: ET.Element) -> LinkBeam | None:
    """Read the beam of a link, if it has one; its end positions are not yet set."""
    element, where = annotation(link, "beam"), f"{label(link)}/<linkages:beam>"
    if element is None:
        return None
    found = parts(path, element, where, ("from", "to", *SECTIONS, "material"))
    for key in ("from", "to", "material"):
        if key not in found:
            raise InputError(path, where, f"has no <linkages:{key}>")
    kinds = [key for key in found if key in SECTIONS]
    if len(kinds) != 1:
        choice = ", ".join(f"<linkages:{kind}>" for kind in SECTIONS)
        raise InputError(path, where, f"has {len(kinds)} sections; give one of {choice}")
    (kind,), inner = kinds, f"{where}/<linkages:{kinds[0]}>"
    section = sizes(path, found[kind], inner, SECTIONS[kind])
    if kind == "tube" and section["inner"] >= section["outer"]:
        outer = f"it must be smaller than the outer one of {section['outer']:g} m"
        raise InputError(path, f"{inner}/<linkages:inner>", f"is {section['inner']:g} m; {outer}")
    spot = f"{where}/<linkages:material>"
    material = sizes(path, found["material"], spot, MATERIAL, poisson=POISSON)
    if material["poisson"] >= 0.5:
        problem = f"is {material['poisson']:g}; it must be below 0.5"
        raise InputError(path, f"{spot}/<linkages:poisson>", problem)
    start, end = ((found[key].text or "").strip() for key in ("from", "to"))
    return LinkBeam((start, end), np.zeros(3), np.zeros(3), kind, section, **material)


def beam_text(beam: LinkBeam) -> Iterator[str]:
    """Yield the lines of an element ``<linkages:beam>``."""
    section = "".join(_element(key, repr(value)) for key, value in beam.sizes.items())
    material = "".join(_element(key, repr(getattr(beam, key))) for key in MATERIAL)
    yield "<linkages:beam>"
    yield f"  {''.join(map(_element, ('from', 'to'), beam.frames))}"
    yield f"  {_element(beam.section, section)}"
    yield f"  {_element('material', material)}"
    yield "</linkages:beam>"


def of_beam(link: AnyLink, beam: LinkBeam) -> AnyLink:
    """Return a link with the mass, mass centre and inertia of a beam: a thin rod between its ends."""
    middle = link.rotation.T @ (0.5 * (beam.start + beam.end) - link.translation)
    axis = link.rotation.T @ (beam.end - beam.start) / beam.length
    tensor = beam.inertia * (np.eye(3) - np.outer(axis, axis))
    return replace(link, mass=beam.mass, com_local=middle, inertia_local=tensor, beam=beam)


def check_inertial(path: Path, written: RawLink, link: RawLink) -> None:
    """Reject an <inertial> that describes another body than the beam, as other readers would use it.

    `written` has the values of <inertial>, `link` the values of the beam (`of_beam`). The closer one of the moments
    about both axes normal to the beam counts.
    """
    assert link.beam is not None
    length, inertia = link.beam.length, link.beam.inertia
    _, axes = np.linalg.eigh(link.inertia_local)  # the beam's axis, with zero moment, comes first
    moments = np.linalg.eigvalsh(axes[:, 1:].T @ written.inertia_local @ axes[:, 1:])
    moment = float(moments[np.argmin(np.abs(moments - inertia))])
    off = float(np.linalg.norm(written.com_local - link.com_local))
    problem = ""
    if abs(written.mass - link.mass) > _AGREES * link.mass:
        problem = f"<mass> is {written.mass:g} kg, but the mass of its <linkages:beam> is {link.mass:g} kg"
    elif off > _AGREES * length:
        place = " ".join(f"{round(x, 9) + 0.0:g}" for x in link.com_local)
        problem = f"the mass centre is {off:g} m from the middle of its <linkages:beam>, which is at {place}"
    elif abs(moment - inertia) > _AGREES * inertia:
        problem = f"<inertia> is {moment:g} kg m2 about the normal, but the <linkages:beam> has {inertia:g} kg m2"
    if problem:
        rule = "write the beam's value, and put further mass into another link that is fixed to this one"
        raise InputError(path, f'<link name="{link.name}">/<inertial>', f"{problem}; {rule}")


def _element(key: str, text: str) -> str:
    return f"<linkages:{key}>{text}</linkages:{key}>"
