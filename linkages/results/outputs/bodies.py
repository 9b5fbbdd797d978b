"""Outputs of bodies: motion of points, coordinates of the tree, internal forces, energies of the whole linkage."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from linkages.elements.flexible.internal_forces import beam_state, deflection, largest_deflection
from linkages.elements.outputs import Quantities
from linkages.input.model.output_names import PIN_QUANTITIES, QUANTITIES
from linkages.mechanics.planar.deformable_dynamics import deformable_energy
from linkages.mechanics.planar.loads import ENERGY
from linkages.mechanics.planar.markers import arm, marker_acceleration, marker_velocity, turned
from linkages.results.outputs.quantity import Declaration, OutputPlace, Owner, Snapshot, formula, quantities
from linkages.system import System


@formula()
def _position(output: np.record, seen: Snapshot) -> float:
    b, pose = output.marker.body, seen.state.pose
    rx, ry = arm(pose, output.marker)
    return (pose[b, 0] + rx, pose[b, 1] + ry, pose[b, 2] + output.constant)[output.column]


@formula()
def _velocity(output: np.record, seen: Snapshot) -> float:
    b, vel = output.marker.body, seen.state.vel
    rx, ry = arm(seen.state.pose, output.marker)
    vx, vy = marker_velocity(vel, b, rx, ry)
    return (vx, vy, vel[b, 0])[output.column]


@formula()
def _acceleration(output: np.record, seen: Snapshot) -> float:
    b, acc = output.marker.body, seen.state.acc
    rx, ry = arm(seen.state.pose, output.marker)
    ax, ay = marker_acceleration(seen.state.vel, acc, b, rx, ry)
    return (ax, ay, acc[b, 0], math.hypot(ax, ay))[output.column]


@formula()
def _coordinate(output: np.record, seen: Snapshot) -> float:
    return seen.state.q[output.at]


def _motion(texts: dict[str, str]) -> dict[str, Declaration]:
    """Make the quantities of a point from their texts."""
    return {
        **quantities(_position, **{name: texts[name] for name in ("x", "y", "angle")}),
        **quantities(_velocity, **{name: texts[name] for name in ("vx", "vy", "omega")}),
        **quantities(_acceleration, **{name: texts[name] for name in ("ax", "ay", "alpha", "acceleration")}),
    }


def _point(system: System, name: str) -> OutputPlace:
    return OutputPlace(marker=system.tree.named_marker(name), constant=system.places[name].angle)


def _joints_asked(system: System) -> Iterable[str]:
    """List the joints whose position the experiment reports."""
    parts = (name.rpartition(".") for name in system.settings.outputs)
    asked = {joint for joint, _, quantity in parts if quantity in PIN_QUANTITIES}
    return (name for name in system.joints if name in asked)


_OF_JOINT = {name: found for name, found in _motion(QUANTITIES | PIN_QUANTITIES).items() if name in PIN_QUANTITIES}
_COORDINATE = "coordinate of the spanning tree: of a joint, a floating link, a mode or a hinge [rad or m]"

#: Links and frames, and joints as points.
POINTS = (
    Owner("POINT", lambda system: system.points, _point, _motion(QUANTITIES)),
    Owner("JOINT", lambda system: system.joints, _point, _OF_JOINT, asked=_joints_asked),
)
#: Coordinates of the tree.
COORDINATES = Owner(
    "q",
    lambda system: system.tree.coordinates,
    lambda system, name: OutputPlace(system.tree.coordinates.index(name)),
    quantities(_coordinate, COORDINATE=_COORDINATE),
)


@formula()
def _frame(output: np.record, seen: Snapshot) -> float:
    pose, marker = seen.state.pose, output.marker
    rx, ry = arm(pose, marker)
    x, y = pose[marker.body, 0] + rx, pose[marker.body, 1] + ry
    return deflection(output.at, output.other, x, y, output.constant, pose)


@formula()
def _deflection(output: np.record, seen: Snapshot) -> float:
    model, w = seen.model, seen.state
    beams = model.beams[output.at : output.other]
    return largest_deflection(beams, model.bodies, model.stations, model.station_modes, w.q, w.pose)[output.column]


@formula("forces")
def _load(output: np.record, seen: Snapshot) -> float:
    model, beams = seen.model, seen.model.beams[output.at : output.other]
    found = beam_state(beams, model.bodies, model.stations, model.station_modes, model.gravity, seen.state)
    return found[output.column]


@formula("loads")
def _energy(output: np.record, seen: Snapshot) -> float:
    bodies, gravity, pose, vel = seen.model.bodies, seen.model.gravity, seen.state.pose, seen.state.vel
    kinetic, potential, strain, lost = 0.0, 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        body = bodies.records[i]
        if body.shapes > 0:
            own = deformable_energy(bodies, i, seen.state, gravity)
            kinetic, potential, strain, lost = kinetic + own[0], potential + own[1], strain + own[2], lost + own[3]
            continue
        cx, cy = turned(pose, i, body.cx, body.cy)
        w = vel[i, 0]
        vx, vy = marker_velocity(vel, i, cx, cy)
        kinetic += 0.5 * (body.mass * (vx * vx + vy * vy) + body.inertia * w * w)
        potential -= body.mass * (gravity[0] * (pose[i, 0] + cx) + gravity[1] * (pose[i, 1] + cy))
    for k in range(len(seen.loads)):
        potential += seen.loads[k, ENERGY]
    return (kinetic, potential + strain, strain, lost)[output.column]


def at_frame(system: System, name: str) -> OutputPlace:
    """Return the numbers of a frame's deflection: sections at the ends of its link's beam, its marker and distance."""
    tree, point = system.tree, system.points[name]
    beam = system.links[point.link].beam
    if beam is None:
        raise AssertionError("a flexible link has a beam")
    first, last = tree.ends_of(point.link)
    (dx, dy), (x, y) = (beam.end - beam.start) / beam.length, point.origin - beam.start
    return OutputPlace(first, last, tree.named_marker(name), float(dx * y - dy * x))


def at_link(system: System, name: str) -> OutputPlace:
    """Return the numbers of a flexible link: its first substructure, and the index after the last one."""
    link = system.tree.deformable[name]
    first = list(system.tree.substructures).index(link[0].name)
    return OutputPlace(first, first + len(link))


def of_frame(outputs: Quantities) -> dict[str, Declaration]:
    """Make the outputs of a frame on a flexible link."""
    return quantities(_frame, **outputs.texts)


def along_link(outputs: Quantities) -> dict[str, Declaration]:
    """Make the outputs along a flexible link: two of its deflection, the others of its internal forces."""
    deflections = ("deflection", "deflection_place")
    loads = {name: text for name, text in outputs.texts.items() if name not in deflections}
    shape = quantities(_deflection, **{name: outputs.texts[name] for name in deflections})
    return shape | quantities(_load, **loads)


_OF_LINKAGE = quantities(
    _energy,
    kinetic_energy="kinetic energy of the whole linkage [J]",
    potential_energy="energy of weight, springs and flexible links [J]",
    strain_energy="energy of flexible links [J]",
    damping_power="power dissipated by the damping of flexible links [W]",
)

#: The whole linkage.
LINKAGE = (Owner("", lambda system: ("",), lambda system, name: OutputPlace(), _OF_LINKAGE),)
