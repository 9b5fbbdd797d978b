"""Formulas of all outputs at a state, in compiled code."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.integrate.stepper import copy
from linkages.kernel import Array, Indices, Records, kernel, record_type
from linkages.kernel.by_reference import packed
from linkages.laws.film.tilted_film import tilted_action, tilted_gap
from linkages.laws.journal import end_flow
from linkages.planar.arrays import Arrays
from linkages.planar.beam_deflection import deflection, largest_deflection
from linkages.planar.closure_rows import term_rate
from linkages.planar.contacts import CONTENT, COUPLE, EX, EY, FLOW, FX, FY, PENETRATION, WIDTH, contact_motion
from linkages.planar.flexible_dynamics import flexible_energy
from linkages.planar.internal_forces import BENDING, beam_state
from linkages.planar.kinematics import body_accelerations, body_motions, body_states
from linkages.planar.loads import LOAD_OUTPUTS, load_outputs, load_wrenches
from linkages.planar.markers import arm, marker_acceleration, marker_velocity, turned
from linkages.planar.motion import evaluate_motions
from linkages.planar.newton_euler import inertial_forces
from linkages.planar.reactions import add_known_contacts, joint_forces, row_reactions
from linkages.planar.record_types import HISTORY, MARKER, WORN
from linkages.planar.workspace import Workspace, make_workspace

#: Codes of the kinds of owners.
POINT, CONTACT, GUIDE, JOINT, DRIVE, LOAD, COORDINATE, LINKAGE, BEND, WITHIN, GEAR = range(11)

#: Codes of the kinds that need joint forces.
OF_FORCES = (JOINT, DRIVE, WITHIN, GEAR)

#: Record of one output.
OUTPUT = record_type(
    kind="i8",
    what="i8",  # code of the quantity
    at="i8",  # contact, joint, drive, load, coordinate, or first beam; deflection: section at the beam's first end;
    # gear: index minus the number of gears
    other="i8",  # drive: its coordinate; guide: the block's body; deflection: section at the beam's last end;
    # beams: index after the last one
    jitter="i8",  # 1: minus the ideal linkage's value
    marker=MARKER,  # point: its place; guide: the slot's body and the normal of the slot
    constant="f8",  # point: reference angle; contact: clearance; deflection: undeformed one; gear: sign of second joint
)

_CORNERS = 4
_KNOWN = (0, 1, 2, 3, 4, 5, 8, 9, 10, 11, 15, 17)  # quantities of contacts that follow from the contacts alone


class View(NamedTuple):
    """State, contacts and forces of a linkage at one instant."""

    model: Arrays
    state: Workspace  # of which q, v, a, pose, vel and acc count
    contacts: Array  # `linkages.planar.contacts.CLEARANCE_OUTPUTS`, (nc, WIDTH)
    forces: Array  # on each joint's child, with moment, (nj, 3); see `linkages.planar.reactions.joint_forces`
    efforts: Array  # torque or force of each drive, (nd,)
    loads: Array  # `linkages.planar.loads.LOAD_OUTPUTS`, (nl, 4)


@kernel
def output_value(output: np.record, view: View) -> float:
    """Compute the value of an output at a state, without subtracting the ideal value for jitter."""
    kind, what, at, state = output.kind, output.what, output.at, view.state
    if kind == POINT:
        return point_value(output, state.pose, state.vel, state.acc)
    if kind == CONTACT:
        return _contact_value(what, at, output.constant, view)
    if kind == GUIDE:
        return _guide_value(output, view)
    if kind == JOINT:
        force = view.forces[at]
        return math.hypot(force[0], force[1]) if what == 2 else force[min(what, 2)]
    if kind == DRIVE:
        rate, effort = state.v[output.other], view.efforts[at]
        return effort if what == 0 else (rate if what == 1 else effort * rate)
    if kind == LOAD:
        load = view.loads[at]
        return math.hypot(load[0], load[1]) if what == 3 else load[what]
    if kind == COORDINATE:
        return state.q[at]
    if kind == BEND:
        rx, ry = arm(state.pose, output.marker)
        b = output.marker.body
        x, y = state.pose[b, 0] + rx, state.pose[b, 1] + ry
        return deflection(at, output.other, x, y, output.constant, state.pose)
    if kind == WITHIN:
        return _within_beam(what, at, output.other, view)
    if kind == GEAR:  # index from the end of the rows
        row = view.model.rows[len(view.model.rows) + at]
        reaction = state.reaction[len(view.model.rows) + at]
        return output.constant * reaction if what == 0 else reaction * term_rate(row.term, state.pose, state.vel)
    return _energy(what, view)


@kernel
def _within_beam(what: int, first: int, last: int, view: View) -> float:
    model, w = view.model, view.state
    if what < BENDING:
        found = largest_deflection(
            model.beams[first:last], model.bodies, model.stations, model.station_modes, w.q, w.pose
        )
        return found[0] if what == 0 else found[1]
    return beam_state(
        what, model.beams[first:last], model.bodies, model.stations, model.station_modes, model.gravity, w
    )


@kernel
def point_value(output: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Compute position, velocity or acceleration of a marker, or its body's angle and rates."""
    marker, what = output.marker, output.what
    b = marker.body
    rx, ry = arm(pose, marker)
    if what < 2:
        return pose[b, 0] + rx if what == 0 else pose[b, 1] + ry
    if what == 2:
        return pose[b, 2] + output.constant
    if what < 5:
        vx, vy = marker_velocity(vel, b, rx, ry)
        return vx if what == 3 else vy
    if what == 5:
        return vel[b, 0]
    if what == 8:
        return acc[b, 0]
    ax, ay = marker_acceleration(vel, acc, b, rx, ry)
    return math.hypot(ax, ay) if what == 9 else (ax if what == 6 else ay)


@kernel
def _contact_value(what: int, at: int, clearance: float, view: View) -> float:
    contact = view.contacts[at]
    if what < 4:
        return contact[what]
    if what == 4:
        return math.hypot(contact[FX], contact[FY])
    if what == 5 and view.model.ends[at].kind == WORN:
        return math.hypot(contact[EX], contact[EY]) / clearance
    if what == 5:
        return 1.0 + contact[PENETRATION] / clearance
    if what == 6:  # both forces act at the journal's marker, as a point of either body
        motion, _ = contact_motion(view.model.ends[at], view.state.pose, view.state.vel)
        ex, ey, vx, vy, wb, wj, _, _ = motion
        return contact[FX] * (vx + wb * ey) + contact[FY] * (vy - wb * ex) + contact[COUPLE] * (wj - wb)
    if what == 7 and view.model.laws[at].tilt == 0.0:
        return -contact[PENETRATION]
    if what in (7, 12, 13, 14):
        return _tilted_value(what, at, view)
    if what == 15:
        return contact[COUPLE]
    if what == 17 or (what == 16 and view.model.ends[at].kind == HISTORY):
        return contact[CONTENT] if what == 17 else contact[FLOW]
    if what == 16:
        motion, _ = contact_motion(view.model.ends[at], view.state.pose, view.state.vel)
        ex, ey, vx, vy, wb, wj, angle, _ = motion
        return end_flow(view.model.laws[at], view.model.tables[at], ex, ey, vx, vy, wb, wj, angle)
    return contact[what - 3]


@kernel
def _tilted_value(what: int, at: int, view: View) -> float:
    """Compute the smallest film (7) of a tilted journal, or its moment: about x_P (12), y_P (13), its magnitude."""
    law = view.model.laws[at]
    motion, _ = contact_motion(view.model.ends[at], view.state.pose, view.state.vel)
    ex, ey, vx, vy, wb, wj, angle, _ = motion
    e = math.hypot(ex, ey)
    nx, ny = (ex / e, ey / e) if e > 0.0 else (1.0, 0.0)
    alpha = math.atan2(ny, nx) - angle
    if what == 7:
        return tilted_gap(law, e, alpha)
    _, _, _, m_n, m_t, _ = tilted_action(law, e, vx * nx + vy * ny, vy * nx - vx * ny, wb, wj, alpha)
    if what == 14:
        return math.hypot(m_n, m_t)
    return m_n * nx - m_t * ny if what == 12 else m_n * ny + m_t * nx


@kernel
def _guide_value(output: np.record, view: View) -> float:
    what, first, slot, pose = output.what, output.at, output.marker, view.state.pose
    if what == 3:
        return pose[output.other, 2] - pose[slot.body, 2]
    total, largest = 0.0, -np.inf
    nx, ny = turned(pose, slot.body, slot.x, slot.y)
    for k in range(first, first + _CORNERS):
        if what == 0:
            largest = max(largest, _contact_value(5, k, output.constant, view))
        elif what == 1:
            total += _contact_value(6, k, output.constant, view)
        else:
            total += (view.contacts[k, EX] * nx + view.contacts[k, EY] * ny) / _CORNERS
    return largest if what == 0 else total


@kernel
def _energy(what: int, view: View) -> float:
    bodies, gravity, pose, vel = view.model.bodies, view.model.gravity, view.state.pose, view.state.vel
    kinetic, potential, strain, lost = 0.0, 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        body = bodies.records[i]
        if body.modes > 0:
            own = flexible_energy(bodies, i, view.state, gravity)
            kinetic, potential, strain, lost = kinetic + own[0], potential + own[1], strain + own[2], lost + own[3]
            continue
        cx, cy = turned(pose, i, body.cx, body.cy)
        w = vel[i, 0]
        vx, vy = marker_velocity(vel, i, cx, cy)
        kinetic += 0.5 * (body.mass * (vx * vx + vy * vy) + body.inertia * w * w)
        potential -= body.mass * (gravity[0] * (pose[i, 0] + cx) + gravity[1] * (pose[i, 1] + cy))
    for k in range(len(view.loads)):
        potential += view.loads[k, 3]
    return (kinetic, potential + strain, strain, lost)[what]


@kernel
def tabulate(
    outputs: Records,
    with_forces: bool,
    view: View,
    times: Array,
    q: Array,
    v: Array,
    a: Array,
    contacts: Array,
    out: Array,
) -> None:
    """Fill ``out`` (no, nt) with outputs over time, from coordinates, rates, accelerations (nt, n) and contacts.

    Parameters
    ----------
    with_forces : bool
        Whether any output needs the forces in joints or the efforts of drives.
    view : View
        View of the model with work arrays; see `make_view`.
    """
    w, powered = view.state, np.zeros((3, len(view.model.powered_bodies)))
    for i in range(len(times)):
        copy(q[i], w.q)
        copy(v[i], w.v)
        copy(a[i], w.a)
        for k in range(contacts.shape[1]):
            copy(contacts[i, k], view.contacts[k])
        body_states(view.model.bodies, w.q, w.v, w.pose, w.vel)
        body_accelerations(view.model.bodies, w.pose, w.vel, w.v, w.a, w.acc)
        _complete(view, with_forces, times[i], powered)
        for k in range(len(outputs)):
            out[k, i] = output_value(outputs[k], view)


@kernel
def add_moved(
    outputs: Records, with_forces: bool, needed: Indices, view: View, times: Array, q: Array, v: Array, a: Array,
    contacts: Array, dq: Array, dv: Array, da: Array, dcontacts: Array, h: float, weight: float, out: Array,
) -> None:  # fmt: skip
    """Add the outputs of `tabulate`, at h times a change of coordinates and contacts, times a weight, to ``out``.

    ``needed``: see `bodies_needed`.
    """
    w, powered = view.state, np.zeros((3, len(view.model.powered_bodies)))
    for i in range(len(times)):
        for k in range(len(w.q)):
            w.q[k], w.v[k], w.a[k] = q[i, k] + h * dq[i, k], v[i, k] + h * dv[i, k], a[i, k] + h * da[i, k]
        for k in range(contacts.shape[1]):
            for j in range(WIDTH):
                view.contacts[k, j] = contacts[i, k, j] + h * dcontacts[i, k, j]
        body_motions(view.model.bodies, needed, w.q, w.v, w.a, w.pose, w.vel, w.acc)
        _complete(view, with_forces, times[i], powered)
        for k in range(len(outputs)):
            out[k, i] += weight * output_value(outputs[k], view)


@kernel
def _complete(view: View, with_forces: bool, t: float, powered: Array) -> None:
    """Fill loads and forces of a view whose bodies and contacts are set; ``powered`` (3, np) is to work in."""
    model, w = view.model, view.state
    bodies = model.bodies
    loads = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
    if len(loads[0]):
        load_outputs(loads, t, w.pose, w.vel, view.loads)
    if with_forces:
        w.wrench[:] = 0.0
        add_known_contacts(model.ends, view.contacts, w.pose, w.wrench)
        if len(loads[0]):
            load_wrenches(loads, t, w.pose, w.vel, w.wrench)
        evaluate_motions((model.torque, model.torque_c, model.torque_n), t, powered[0], powered[1], powered[2])
        for k in range(powered.shape[1]):
            w.tau[bodies.records[model.powered_bodies[k]].dof] = powered[0, k]
        inertial_forces(bodies, w, model.gravity, w.bias, w.modal_bias)
        if len(model.rows):
            row_reactions(model, w)
        joint_forces(model, w, view.contacts, view.forces, view.efforts)


def bodies_needed(model: Arrays, outputs: Records) -> Indices:
    """Return 1 for each body whose motion outputs need, else 0, (nb,): a point needs its body and all parents."""
    kind, parents = outputs["kind"], model.bodies.records["mount"]["body"]
    points, known = kind == POINT, (kind == CONTACT) & np.isin(outputs["what"], _KNOWN)
    if len(model.loads) or not np.all(points | known | (kind == COORDINATE)):
        return np.ones(len(parents), np.int64)
    needed = np.zeros(len(parents), np.int64)
    for body in outputs["marker"]["body"][points]:
        while body > 0:
            needed[body], body = 1, parents[body]
    return needed


def make_view(model: Arrays, n: int) -> View:
    """Make the arrays of a view of a linkage with n coordinates, for `tabulate`."""
    work = make_workspace(len(model.bodies.records), n, len(model.rows), model.bodies.shapes.shape[2])
    forces, efforts = np.zeros((len(model.joints), 3)), np.zeros(len(model.driven) + len(model.powered))
    parts = np.zeros((len(model.ends), WIDTH)), forces, efforts, np.zeros((len(model.loads), len(LOAD_OUTPUTS)))
    return packed(View(packed(model), packed(work), *parts))
