"""Outputs of flexible links, and the energies of the whole linkage."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from linkages.input.model.experiment import FRAME_BENDING, LINK_BENDING
from linkages.mechanics.planar.beam_deflection import deflection, largest_deflection
from linkages.mechanics.planar.flexible_dynamics import flexible_energy
from linkages.mechanics.planar.internal_forces import beam_state
from linkages.mechanics.planar.loads import ENERGY
from linkages.mechanics.planar.markers import arm, marker_velocity, turned
from linkages.results.outputs.quantity import Element, Owner, Snapshot, formula, quantities
from linkages.system import System


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
        if body.modes > 0:
            own = flexible_energy(bodies, i, seen.state, gravity)
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


def _frames(system: System) -> Iterable[str]:
    return [frame.name for frame in system.mechanism.frames if frame.link in system.tree.flexible]


def _at_frame(system: System, name: str) -> Element:
    tree, point = system.tree, system.mechanism.point[name]
    beam = system.mechanism.link[point.link].beam
    if beam is None:
        raise AssertionError("a flexible link has a beam")
    first, last = tree.beam_ends(point.link)
    (dx, dy), (x, y) = (beam.end - beam.start) / beam.length, point.origin - beam.start
    return Element(first, last, tree.named_marker(name), float(dx * y - dy * x))


def _at_link(system: System, name: str) -> Element:
    link = system.tree.flexible[name]
    first = list(system.tree.substructures).index(link[0].name)
    return Element(first, first + len(link))


_OF_LINK = {
    **quantities(_deflection, **{name: LINK_BENDING[name] for name in ("deflection", "deflection_place")}),
    **quantities(_load, **{name: LINK_BENDING[name] for name in ("bending", "stress", "stress_place", "compression")}),
}
_OF_LINKAGE = quantities(
    _energy,
    kinetic_energy="kinetic energy of the whole linkage [J]",
    potential_energy="energy of weight, springs and flexible links [J]",
    strain_energy="energy of flexible links [J]",
    damping_power="power dissipated by the damping of flexible links [W]",
)

#: Frames on flexible links, flexible links, the whole linkage.
LINKS = (
    Owner("FRAME (flexible link)", _frames, _at_frame, quantities(_frame, **FRAME_BENDING)),
    Owner("LINK (flexible)", lambda system: system.tree.flexible, _at_link, _OF_LINK),
    Owner("", lambda system: ("",), lambda system, name: Element(), _OF_LINKAGE),
)
