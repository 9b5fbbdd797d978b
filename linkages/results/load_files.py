"""Balanced loads of links for finite elements: ``loads.csv``, and ``LINK.inp`` for CalculiX and Abaqus."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.raw_model import LinkBeam
from linkages.input.files.writing import file_name, whole
from linkages.results import numerics
from linkages.results.link_loads import Field, LinkLoads, Load

_HEADS = "case", "time [s]", "link", "load", "x [m]", "y [m]", "fx [N]", "fy [N]", "moment [N m]"
_OF_FIELD = "weight", "inertia", "node"


class Case(NamedTuple):
    """Loads of links at a time [s]; ``name`` is the word of the option."""

    name: str
    time: float
    links: dict[str, LinkLoads]


def write_loads(folder: Path, cases: Sequence[Case]) -> list[str]:
    """Write ``loads.csv`` and for each link and case ``LINK.inp``, ``LINK_2.inp``, ...; return the names."""
    with whole(folder / "loads.csv") as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_HEADS)
        for case in cases:
            for link, of_link in case.links.items():
                for load in of_link.loads:
                    numbers = load.x, load.y, load.fx, load.fy, load.moment
                    writer.writerow([case.name, case.time, link, load.name, *numbers])
    names = ["loads.csv"]
    for k, case in enumerate(cases):
        for link, of_link in case.links.items():
            names.append(f"{file_name(link)}{f'_{k + 1}' if k else ''}.inp")
            text = _rigid(of_link, case) if of_link.beam is None else _beam(of_link, of_link.beam, case)
            with whole(folder / names[-1]) as partial:
                partial.write_text(text, encoding="utf-8")
    return names


def _rigid(of_link: LinkLoads, case: Case) -> str:
    """Write the step of a link whose mesh the reader has."""
    name = _set(of_link.link)
    inertia = next(one for one in of_link.loads if one.name == "inertia")
    outer = [one for one in of_link.loads if one.name not in _OF_FIELD]
    lines = [
        f"** {of_link.link}, {case.name}, t = {case.time:.9g} s. Axes of the link's frame; m, kg, s, N.",
        f"** Include this file after a mesh with the element set {name} (with its density), supports, and node sets at",
        *(f"**   {_set(one.name):20} {_number(one.x)}, {_number(one.y)}" for one in outer),
        f"**   {name + '_CENTRE':20} {_number(inertia.x)}, {_number(inertia.y)}  mass centre: a coupled node",
        "*STEP",
        "*STATIC",
        "*CLOAD",
        *(line for one in outer for line in _forces(_set(one.name), one)),
        f"{name}_CENTRE, 6, {_number(inertia.moment)}",
        "*DLOAD",
        *_field(name, of_link.field),
        "*END STEP",
    ]
    return "\n".join(lines) + "\n"


def _beam(of_link: LinkLoads, beam: LinkBeam, case: Case) -> str:
    """Write a model of a flexible link: its deformed axis as beam elements, supports, one step."""
    parts = of_link.parts
    nodes, places = _distinct(np.concatenate([part.nodes for part in parts]), numerics.ROUNDED * beam.length)
    first, last = _ends(nodes)
    lies = abs(nodes[last, 0] - nodes[first, 0]) >= abs(nodes[last, 1] - nodes[first, 1])
    across, twist = (2, 4) if lies else (1, 5)
    # a rectangle with the area and the second moment of the section
    height = float(np.sqrt(12.0 * beam.second_moment / beam.area))
    lines = [
        f"** {of_link.link}, {case.name}, t = {case.time:.9g} s. Axes of the link's frame; m, kg, s, N.",
        "*NODE, NSET=ALL",
        *(f"{k + 1}, {_number(x)}, {_number(y)}, 0" for k, (x, y) in enumerate(nodes.tolist())),
    ]
    element, at = 0, 0
    for k, part in enumerate(parts):
        lines.append(f"*ELEMENT, TYPE=B32, ELSET=PART{k + 1}")
        own = places[at : at + len(part.nodes)] + 1
        at += len(own)
        for i in range(0, len(own) - 2, 2):
            element += 1
            lines.append(f"{element}, {own[i]}, {own[i + 1]}, {own[i + 2]}")
    outer = [one for one in of_link.loads if one.name not in _OF_FIELD]
    for name in dict.fromkeys(one.name for one in outer):
        load = next(one for one in outer if one.name == name)
        nearest = int(np.argmin(np.hypot(*(nodes - (load.x, load.y)).T))) + 1
        lines += [f"*NSET, NSET={_set(name)}", f"{nearest}"]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{_number(beam.youngs_modulus)}, {_number(beam.poisson)}"]
    lines += ["*DENSITY", f"{_number(beam.density)}"]
    for k in range(len(parts)):
        lines += [f"*BEAM SECTION, ELSET=PART{k + 1}, MATERIAL=M, SECTION=RECT"]
        lines += [f"{_number(beam.area / height)}, {_number(height)}", "0, 0, 1"]
    lines += ["** Three supports in the plane; the others keep the beam in it.", "*BOUNDARY"]
    lines += [f"{first + 1}, 1, 3", f"{first + 1}, {twist}", f"{last + 1}, {across}", f"{last + 1}, 3"]
    lines += ["*STEP", "*STATIC", "*CLOAD", *(line for one in outer for line in _forces(_set(one.name), one))]
    others = np.zeros_like(nodes)
    for place, force in zip(places.tolist(), np.concatenate([part.others for part in parts]), strict=True):
        others[place] += force
    lines += [
        f"{k + 1}, {i + 1}, {_number(size)}" for k, force in enumerate(others.tolist()) for i, size in enumerate(force)
    ]
    lines += ["*DLOAD", *(line for k, part in enumerate(parts) for line in _field(f"PART{k + 1}", part.field))]
    lines.append("*END STEP")
    return "\n".join(lines) + "\n"


def _distinct(nodes: Array, near: float) -> tuple[Array, Array]:
    """Return nodes without repetition, and the place of each given one among them."""
    kept: list[Array] = []
    places = []
    for node in nodes:
        same = [k for k, other in enumerate(kept) if np.hypot(*(node - other)) <= near]
        places.append(same[0] if same else len(kept))
        kept += [] if same else [node]
    return np.array(kept), np.array(places)


def _ends(nodes: Array) -> tuple[int, int]:
    """Return the two ends of a beam."""
    first = int(np.argmax(np.hypot(*(nodes - nodes.mean(axis=0)).T)))
    return first, int(np.argmax(np.hypot(*(nodes - nodes[first]).T)))


def _forces(name: str, load: Load) -> list[str]:
    sizes = (1, load.fx), (2, load.fy), (6, load.moment)
    return [f"{name}, {direction}, {_number(size)}" for direction, size in sizes if size != 0.0]


def _field(name: str, field: Field) -> list[str]:
    """Write gravity less the acceleration of the axis, and the centrifugal load."""
    size = float(np.hypot(field.gx, field.gy))
    way = (field.gx / size, field.gy / size) if size else (1.0, 0.0)
    lines = [f"{name}, GRAV, {_number(size)}, {_number(way[0])}, {_number(way[1])}, 0"]
    return [
        *lines,
        f"{name}, CENTRIF, {_number(float(field.square))}, {_number(field.x)}, {_number(field.y)}, 0, 0, 0, 1",
    ]


def _number(value: float) -> str:
    """Write a number in at most 20 characters: CalculiX reads no more."""
    return f"{value:.12e}"


def _set(name: str) -> str:
    """Return the name of a set: letters, digits and underscores, a letter first."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    return plain if plain[:1].isalpha() else f"X{plain}"
