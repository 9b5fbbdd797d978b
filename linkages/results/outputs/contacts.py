"""Outputs of contacts: clearance joints, guides, and any contact of an element."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from linkages.base.kernel import inlined_kernel
from linkages.input.model.experiment_tables import JointModel
from linkages.laws import FILMS
from linkages.laws.film.tilted_film import tilted_action, tilted_gap
from linkages.laws.journal import end_flow
from linkages.laws.journal_motion import polar
from linkages.mechanics.planar import contacts
from linkages.mechanics.planar.contacts import COUPLE, EX, EY, FX, FY, PENETRATION, contact_motion
from linkages.mechanics.planar.markers import turned
from linkages.mechanics.planar.record_types import REMEMBERING, WORN
from linkages.results.outputs.quantity import Declaration, OutputPlace, Owner, Snapshot, formula, quantities, quantity
from linkages.system import System

_CORNERS = 4


@formula()
def _entry(output: np.record, seen: Snapshot) -> float:
    return seen.contacts[output.at, output.column]


@formula()
def _force(output: np.record, seen: Snapshot) -> float:
    return math.hypot(seen.contacts[output.at, FX], seen.contacts[output.at, FY])


@formula()
def _ratio(output: np.record, seen: Snapshot) -> float:
    return _ratio_at(seen, output.at)


@inlined_kernel
def _ratio_at(seen: Snapshot, k: int) -> float:
    contact, clearance = seen.contacts[k], seen.model.laws[k].clearance
    if seen.model.ends[k].kind == WORN:
        return math.hypot(contact[EX], contact[EY]) / clearance
    return 1.0 + contact[PENETRATION] / clearance


@formula()
def _power(output: np.record, seen: Snapshot) -> float:
    return _power_at(seen, output.at)


@inlined_kernel
def _power_at(seen: Snapshot, k: int) -> float:
    contact = seen.contacts[k]  # both forces act at the journal's marker, as a point of either body
    motion, _ = contact_motion(seen.model.ends[k], seen.state.pose, seen.state.vel)
    ex, ey, vx, vy, wb, wj, _, _ = motion
    return contact[FX] * (vx + wb * ey) + contact[FY] * (vy - wb * ex) + contact[COUPLE] * (wj - wb)


@formula()
def _thickness(output: np.record, seen: Snapshot) -> float:
    law = seen.model.laws[output.at]
    if law.tilt == 0.0:
        return -seen.contacts[output.at, PENETRATION]
    motion, _ = contact_motion(seen.model.ends[output.at], seen.state.pose, seen.state.vel)
    ex, ey, _, _, _, _, angle, _ = motion
    return tilted_gap(law, math.hypot(ex, ey), math.atan2(ey, ex) - angle)


@formula()
def _moment(output: np.record, seen: Snapshot) -> float:
    motion, _ = contact_motion(seen.model.ends[output.at], seen.state.pose, seen.state.vel)
    ex, ey, vx, vy, wb, wj, angle, _ = motion
    e, nx, ny, v_n, v_t = polar(ex, ey, vx, vy)
    _, _, _, m_n, m_t, _ = tilted_action(seen.model.laws[output.at], e, v_n, v_t, wb, wj, math.atan2(ny, nx) - angle)
    return (m_n * nx - m_t * ny, m_n * ny + m_t * nx, math.hypot(m_n, m_t))[output.column]


@formula()
def _flow(output: np.record, seen: Snapshot) -> float:
    k, model = output.at, seen.model
    if model.ends[k].kind == REMEMBERING:
        return seen.contacts[k, contacts.FLOW]
    motion, _ = contact_motion(model.ends[k], seen.state.pose, seen.state.vel)
    ex, ey, vx, vy, wb, wj, angle, _ = motion
    return end_flow(model.laws[k], model.tables[k], ex, ey, vx, vy, wb, wj, angle)


@formula()
def _guide(output: np.record, seen: Snapshot) -> float:
    slot, pose, largest, power, offset = output.marker, seen.state.pose, -np.inf, 0.0, 0.0
    nx, ny = turned(pose, slot.body, slot.x, slot.y)
    for k in range(output.at, output.at + _CORNERS):
        largest = max(largest, _ratio_at(seen, k))
        power += _power_at(seen, k)
        offset += (seen.contacts[k, EX] * nx + seen.contacts[k, EY] * ny) / _CORNERS
    return (largest, power, offset, pose[output.other, 2] - pose[slot.body, 2])[output.column]


def _entries(**columns: str) -> dict[str, Declaration]:
    """Make quantities that are entries of `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS` with their names."""
    return {name: quantity(text, _entry, getattr(contacts, name.upper())) for name, text in columns.items()}


def contact_quantity(name: str, text: str) -> Declaration:
    """Make an output of any contact: an entry by its name, the magnitude "force", or the "power" of its force pair."""
    whole = {"force": _force, "power": _power}.get(name)
    return quantity(text, _entry, getattr(contacts, name.upper())) if whole is None else quantity(text, whole)


_FORCE = {"force": quantity("magnitude of the force [N]", _force)}
_OF_JOURNAL = {
    **_entries(
        ex="eccentricity vector, from the bearing's centre to the journal's, along x_P [m]",
        ey="eccentricity vector along y_P [m]",
        fx="force on the journal along x_P [N]",
        fy="force on the journal along y_P [N]",
    ),
    **_FORCE,
    "eccentricity_ratio": quantity("length of the eccentricity vector over the radial clearance [1]", _ratio),
    "power": quantity("power that the force pair delivers [W]", _power),
    "friction_torque": quantity("friction torque on the journal, counter-clockwise [N m]", _entry, COUPLE),
}
_OF_TOUCH = _entries(
    penetration="largest overlap of journal and bearing, negative: their smallest gap [m]",
    closing="rate of the penetration [m/s]",
    sliding="sliding speed of the journal's surface [m/s]",
    load="normal load of the contact, without the film force [N]",
)
_OF_TILT = quantities(
    _moment,
    mx="moment of the film on the tilted journal about the bearing's middle, about x_P [N m]",
    my="moment of the film on the tilted journal about the bearing's middle, about y_P [N m]",
    tilting_moment="magnitude of this moment [N m]",
)
_OF_GUIDE = quantities(
    _guide,
    eccentricity_ratio="largest of its corners' [1]",
    power="power that its force pairs deliver [W]",
    offset="position of the block across its slot [m]",
    tilt="angle of the block in its slot [rad]",
)


def _play(kinds: str, suits: Callable[[JointModel], bool], found: dict[str, Declaration]) -> Owner:
    """Make the owner for the contacts of clearance joints with suitable models."""

    def labels(system: System) -> Iterable[str]:
        pairs = zip(system.tree.contacts, system.models, strict=False)
        return [label for (_, label), model in pairs if suits(model)]

    return Owner(f"JOINT ({kinds})", labels, at_contact, found, real=True)


def at_contact(system: System, name: str) -> OutputPlace:
    """Return the numbers of a contact."""
    k = [label for _, label in system.contacts].index(name)
    return OutputPlace(k)


def _guides(system: System) -> Iterable[str]:
    return [name for name in system.tree.play if system.joints[name].slot is not None]


def _at_guide(system: System, name: str) -> OutputPlace:
    tree, joint = system.tree, system.joints[name]
    k = [owner for owner, _ in tree.contacts].index(name)
    across = (tree.marker(joint.parent, joint.on_parent)[0], float(-joint.direction[1]), float(joint.direction[0]))
    return OutputPlace(k, tree.marker(joint.child, joint.on_child)[0], across)


def _by_drive(owner: Owner) -> tuple[Owner, Owner]:
    """Split an owner: in joints with a drive ``power`` is the drive's, and ``contact_power`` the force pairs'."""
    power = owner.quantities["power"]._replace(meaning="power that the force pairs deliver in a joint with a drive")
    others = {name: one for name, one in owner.quantities.items() if name != "power"}

    def names(driven: bool) -> Callable[[System], Iterable[str]]:
        return lambda system: [name for name in owner.names(system) if (name in system.drives) is driven]

    return replace(owner, names=names(False)), replace(
        owner, names=names(True), quantities=others | {"contact_power": power}
    )


#: Clearance joints, guides.
PLAY = (
    *_by_drive(_play("film, dry, mixed", lambda model: True, _OF_JOURNAL)),
    _play(
        "film, mixed", lambda model: model.has_film,
        {"film_thickness": quantity("smallest thickness of the film [m]", _thickness)},
    ),
    _play("dry, mixed", lambda model: model.can_touch, _OF_TOUCH),
    _play("tilted", lambda model: model.is_tilted, _OF_TILT),
    _play(
        "finite film", lambda model: model.has_film and FILMS[model.film].force is None,
        {"flow": quantity("volume flow out of the ends of the film [m3/s]", _flow)},
    ),
    _play(
        "film with history", lambda model: model.has_history,
        {"film_content": quantity("share of the gap that is filled with oil [1]", _entry, contacts.CONTENT)},
    ),
    *_by_drive(Owner("GUIDE", _guides, _at_guide, _OF_GUIDE, real=True)),
)  # fmt: skip
