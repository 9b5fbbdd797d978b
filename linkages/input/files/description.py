"""A mechanism described in a few lines of TOML: points, links, sliders, parameters and formulas with units.

The description is part of an experiment file and replaces the name of an SDFormat file; its keys are `Description`'s.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit

from linkages.base.errors import InputError, nearest
from linkages.input.files.described_model import Description, Drawing
from linkages.input.files.drafting import DraftError, Numbers
from linkages.input.files.raw_model import RawModel
from linkages.input.files.sdf_text import sdf_text
from linkages.input.files.shorthand import written_out
from linkages.input.files.toml import validate
from linkages.input.files.unit_conversion import is_quantity, si_unit
from linkages.input.files.xml import parse_xml

_UNITS = "units"  # key of a stored description: SI units of parameters whose numbers had one


class Described(NamedTuple):
    """A described mechanism; the description in SI units without repetitions; parameters and their units, by path."""

    model: RawModel
    text: str
    parameters: dict[str, float]
    units: dict[str, str]


def described(path: Path, name: str, data: Mapping[str, Any], stored: bool = False) -> Described:
    """Make a mechanism from the values of the keys `KEYS`; errors name the file `path`, the key and the reason.

    The values are `stored` if they come from an SDFormat file, whose angles are numbers in rad.
    """
    try:
        own = {key: value for key, value in data.items() if not (stored and key == _UNITS)}
        given = validate(Description, own, path).model_dump(exclude_unset=True)
        plain = written_out(given, stored)
        quantities = {key: str(value) for key, value in given.get("parameters", {}).items() if is_quantity(str(value))}
        units = data.get(_UNITS, {}) if stored else {key: si_unit(value) for key, value in quantities.items()}
        description = validate(Description, plain, path)
        numbers = Numbers(description.parameters, description.points)
        model = Drawing(name, description, numbers).model()
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
    """Make a described mechanism again, the `model` of a file, from its text with other parameters.

    `overrides` has the parameters by the paths ``parameters.NAME``. The result is the model, all parameters by path,
    and their SI units where they are known. InputError if a parameter is unknown or gives no valid mechanism, or if the
    model no longer agrees with its description.
    """
    name, data = model.get("name", ""), tomlkit.parse(text).unwrap()
    drawn = described(path, name, data, stored=True)
    for key in overrides:
        if key not in drawn.parameters:
            raise InputError(path, f"sdf.{key}", f"there is no such parameter; {nearest(key, drawn.parameters)}")
    if not overrides:
        return model, drawn.parameters, drawn.units
    layouts = [
        at_frames for at_frames in (True, False) if _content(_element(path, drawn, at_frames)) == _content(model)
    ]
    if not layouts:
        problem = "the model no longer agrees with its description; write it again with `linkages new --from`"
        raise InputError(path, "<linkages:description>", f"{problem}, or replace values of its links instead")
    own = {key.partition(".")[2]: value for key, value in overrides.items()}
    other = described(path, name, data | {"parameters": data.get("parameters", {}) | own}, stored=True)
    return _element(path, other, layouts[0]), other.parameters, drawn.units


def _element(path: Path, drawn: Described, at_frames: bool) -> ET.Element:
    return parse_xml(path, sdf_text(drawn.model, (), drawn.text, at_frames).encode())[0]


def _content(element: ET.Element) -> tuple[Any, ...]:
    """Return the content of an element without its formatting."""
    return element.tag, element.attrib, (element.text or "").split(), [_content(part) for part in element]
