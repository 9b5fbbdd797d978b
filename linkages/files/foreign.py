"""Elements of other programs that change the motion: converted to joints or entries, or rejected."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from linkages.errors import InputError, nearest
from linkages.files.elements import number
from linkages.files.xml import label

_MIMICS = ("mimic", "drake:mimic")

#: Elements between links, converted by `linkages.files.constraints` to joints and frames.
CONSTRAINTS = ("drake:weld_constraint", "drake:ball_constraint", "drake:linear_spring_damper")

#: Elements of Drake without influence on the motion of a linkage without contact outside joints.
_HARMLESS = ("drake:collision_filter_group", "drake:controller_gains", "drake:gear_ratio", "drake:visual")

_REFUSED = {
    "drake:linear_bushing_rpy": "is a soft joint; write a revolute joint, or springs in the experiment",
    "drake:tendon_constraint": "is not supported; write a gear, or springs in the experiment",
    "drake:joint": "is of a type that no planar linkage has; a planar linkage has revolute, prismatic and fixed joints",
    "world/joint": "joins models, which is not supported; write it into the model",
}


class Entry(NamedTuple):
    """An entry of an experiment for an element that the mechanism's file cannot contain.

    Attributes
    ----------
    element : str
        Name of the element in messages.
    table, name : str
        Table and name of the entry, such as "gears" and "A_mimic".
    values : dict of str to (str, float or tuple of str)
        Values by key, in SI units; joint coordinates are zero in the reference configuration.
    """

    element: str
    table: str
    name: str
    values: dict[str, Any]

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the joints of the entry."""
        found = self.values.get("joints", self.values.get("joint", ()))
        return found if isinstance(found, tuple) else (str(found),)

    def redrawn(self, at: Mapping[str, float]) -> Entry:
        """Return the entry for a new reference configuration at these old joint coordinates."""
        values, here = dict(self.values), [at[name] for name in self.joints]
        if self.table == "gears":
            values["offset"] += values["ratio"] * here[0] - here[1]
        if self.table == "torsion_springs":
            values["free_angle"] -= here[0]
        return self._replace(values=values)

    @property
    def note(self) -> str:
        """Return a line for users."""
        shown = ", ".join(f"{key} = {_toml(value)}" for key, value in self.values.items())
        return f'{self.element} left out; write it into the experiment as {self.table}."{self.name}" = {{{shown}}}'


@dataclass
class Foreign:
    """Elements of an imported model other than links, joints and frames.

    Attributes
    ----------
    constraints : list of Element
        Constraints and springs between links.
    entries : list of Entry
        Entries of the experiment.
    notes : list of str
        One line per constraint that became a joint.
    """

    path: Path
    constraints: list[ET.Element] = field(default_factory=list)
    entries: list[Entry] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def take_foreign(path: Path, model: ET.Element) -> Foreign:
    """Remove from a model all elements that change the motion and have another form in this package.

    Raises
    ------
    InputError
        If an element changes the motion and has no counterpart.
    """
    found = Foreign(path)
    for element in list(model):
        if element.tag in CONSTRAINTS:
            found.constraints.append(element)
            model.remove(element)
        else:
            _refuse(path, element, label(model))
    for link in model.findall("link"):
        _check_link(path, link)
    for joint in model.findall("joint"):
        for holder in (joint, *joint.findall("axis")):
            for element in list(holder):
                if element.tag in _MIMICS:
                    found.entries.append(_gear(path, model, joint, element))
                    holder.remove(element)
                elif element.tag == "dynamics":
                    found.entries += _dynamics(path, joint, element)
                    holder.remove(element)
                else:
                    _refuse(path, element, label(joint))
    return found


def _refuse(path: Path, element: ET.Element, where: str) -> None:
    problem = _REFUSED.get(element.tag)
    if problem is None and element.tag.removeprefix("world/").startswith("drake:") and element.tag not in _HARMLESS:
        problem = "may change the motion and is not supported; remove it"
    inertia = next(element.iter("drake:rotor_inertia"), None)
    if inertia is not None:
        at = f"{where}/<{inertia.tag}>"
        value = inertia.text if inertia.get("value") is None else inertia.get("value")
        if _is_zero(value):
            return
        where, problem = at, "adds the rotor's inertia to the joint; remove it, and add it to the driven link"
    elif problem is not None:
        where = f"{where}/<{element.tag}>"
    if problem is not None:
        raise InputError(path, where, problem)


def _check_link(path: Path, link: ET.Element) -> None:
    """Reject a link with forces other than weight and joint forces."""
    for key, usual in (("gravity", ("true", "1")), ("kinematic", ("false", "0"))):
        value = (link.findtext(key) or usual[0]).strip()
        if value not in usual:
            raise InputError(path, f"{label(link)}/<{key}>", f"is {value}, which is not supported; remove it")
    for place in ("velocity_decay", "inertial/fluid_added_mass"):
        if any(not _is_zero(part.text) for part in link.iterfind(f"{place}/*")):
            raise InputError(path, f"{label(link)}/<{place}>", "is not supported; remove it")
    for element in link:
        _refuse(path, element, label(link))


def _is_zero(text: str | None) -> bool:
    try:
        return float(text or "0") == 0.0
    except ValueError:
        return False


# -- entries of the experiment -----------------------------------------------------------------------------------------


def _gear(path: Path, model: ET.Element, joint: ET.Element, element: ET.Element) -> Entry:
    """Convert a joint that mimics another to a gear: multiplier (q - reference) + offset."""
    name, where = joint.get("name", ""), f"{label(joint)}/<{element.tag}>"
    leader = element.get("joint", "")
    names = [other.get("name", "") for other in model.findall("joint") if other is not joint]
    if leader not in names:
        raise InputError(path, where, f'follows joint "{leader}"; {nearest(leader, names)}')
    given = {}
    for key, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0)):
        if (text := element.get(key)) is not None:
            ET.SubElement(element, key).text = text
        given[key] = number(path, element, key, where, default)
    if given["multiplier"] == 0.0:
        raise InputError(path, where, "has the multiplier 0; make the joint fixed")
    offset = given["offset"] - given["multiplier"] * given["reference"]
    values = {"joints": (leader, name), "ratio": given["multiplier"], "offset": offset}
    return Entry(f"<{element.tag}> of joint {name}", "gears", f"{name}_mimic", values)


def _dynamics(path: Path, joint: ET.Element, element: ET.Element) -> Iterator[Entry]:
    """Convert the <dynamics> of a joint to friction and a spring."""
    name, where = joint.get("name", ""), f"{label(joint)}/<axis>/<dynamics>"
    keys = ("damping", "friction", "spring_stiffness", "spring_reference")
    damping, friction, stiffness, free = (number(path, element, key, where, 0.0) for key in keys)
    turns = joint.get("type") in ("revolute", "continuous")
    said = f"<dynamics> of joint {name}"
    springs = stiffness != 0.0 or (turns and damping != 0.0)
    if springs:
        spring = {"joint": name, "stiffness": stiffness, "free_angle": free, "damping": damping}
        yield Entry(said, "torsion_springs", f"{name}_spring", spring)
    losses = {"constant": friction, "viscous": 0.0 if springs else damping}
    if any(losses.values()):
        given = {key: value for key, value in losses.items() if value}
        yield Entry(said, "frictions", f"{name}_friction", {"joint": name, **given})


def _toml(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else f"{value!r}"
