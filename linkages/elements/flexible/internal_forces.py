"""Internal forces and deflections of flexible links.

Axial force and bending moment follow from equilibrium. The part of a beam beyond a cut, seen from the frame's origin,
moves under the loads on its sections, its weight and the force at the cut. Its inertia is that of the motion to first
order in the modal coordinates, integrated exactly with the shapes. The alternative, internal forces from the curvature
of the modes, converges slowly with the number of modes, and these forces do not jump at loads.

Deflections are distances from the chord between the ends of the beam. ``beams`` (n,) are the substructures of one link,
``stations`` (ns,) are at all beams, ``modes`` (ns, nm) are `STATION_MODE` at these.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, Records, lazy_kernel, record_type
from linkages.mechanics.integrate.peak_search import parabola_top
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.markers import offset, turned
from linkages.mechanics.planar.record_types import NODE
from linkages.mechanics.planar.workspace import Workspace

_ROUNDING = 1e-14  # deflection, in parts of the length, that counts as zero
_SAME = 1e-6  # distance, in parts of the length, below which two stations count as one

#: A flexible link, or a substructure of one, for its internal forces and deflection.
BEAM = record_type(
    body="i8",
    first="i8",  # its first station
    count="i8",  # number of its stations
    area="f8",  # of the section [m2]
    leverage="f8",  # stress at its edges over the bending moment [1/m3]
    origin="f8",  # place of the frame's origin from the first end of the link's beam [m]
    start="i8",  # body of the section at its first end
    first_end="i8",  # bodies of the sections at the ends of the link's beam
    last_end="i8",
)

#: A cross-section of a beam at which internal forces are computed. Integrals extend from it outwards to the beam's end.
STATION = record_type(
    place="f8",  # abscissa from the frame's origin [m]
    mass="f8",  # mass beyond it [kg]
    first="f8",  # first moment of that mass [kg m]
    second="f8",  # second moment [kg m2]
)

#: A mode at a station: integrals over the mass beyond it, of the axial shape a and the bending shape b, and of these
#: times the abscissa; both shapes at the station.
STATION_MODE = record_type(mass_a="f8", mass_b="f8", first_a="f8", first_b="f8", a="f8", b="f8")


@lazy_kernel
def deflection(first: int, last: int, x: float, y: float, undeformed: float, pose: Array) -> float:
    """Distance [m] of a point from the chord of two sections, positive on its left, less the undeformed distance."""
    dx, dy = offset(pose, first, last)
    length = math.hypot(dx, dy)
    distance = (dx * (y - pose[first, 1]) - dy * (x - pose[first, 0])) / length - undeformed
    return distance if abs(distance) > _ROUNDING * length else 0.0


@lazy_kernel
def largest_deflection(
    beams: Records, bodies: Bodies, stations: Records, modes: Records, q: Array, pose: Array
) -> tuple[float, float]:
    """Find the largest magnitude of a flexible link's deflection [m], and its place from the beam's first end [m].

    The deformed axis is integrated from the first end of each substructure: between two stations its length is that of
    the undeformed axis plus the stretch. Between stations the deflection is a parabola through three of them.
    """
    first, last = beams[0].first_end, beams[0].last_end
    dx, dy = offset(pose, first, last)
    length = math.hypot(dx, dy)
    largest, place = 0.0, 0.0
    for j in range(len(beams)):
        beam = beams[j]
        body = bodies.records[beam.body]
        ux, uy = turned(pose, beam.body, body.ex, body.ey)
        x, y, s, along, across = pose[beam.start, 0], pose[beam.start, 1], 0.0, 0.0, 0.0
        s0, s1, d0, d1, count = 0.0, 0.0, 0.0, 0.0, 0
        for k in range(beam.first, beam.first + beam.count):
            at_station = stations[k].place
            if count > 0 and at_station - s < _SAME * length:
                continue
            stretch, rise = at_station, 0.0
            for m in range(body.shapes):
                stretch += modes[k, m].a * q[body.eta + m]
                rise += modes[k, m].b * q[body.eta + m]
            if count > 0:
                dy = rise - across
                dx = math.sqrt(max((stretch - along) ** 2 - dy * dy, 0.0))
                x, y = x + (ux * dx - uy * dy), y + (uy * dx + ux * dy)
            s, along, across, count = at_station, stretch, rise, count + 1
            d = deflection(first, last, x, y, 0.0, pose)
            if abs(d) > largest:
                largest, place = abs(d), beam.origin + s
            if count > 2:
                side = math.copysign(1.0, d1)
                at, top = parabola_top(s0, s1, s, side * d0, side * d1, side * d)
                if s0 < at < s and top > largest:
                    largest, place = top, beam.origin + at
            s0, s1, d0, d1 = s1, s, d1, d
    return largest, place


@lazy_kernel
def cut(
    bodies: Bodies, i: int, station: np.record, modes: Records, gravity: Array, work: Workspace
) -> tuple[float, float]:
    """Axial force [N], positive in tension, and bending moment [N m], with the sign of the curvature, at a station.

    Takes the station's line of ``modes``, and `work`'s q, v, a, pose, vel, acc, and bias with the wrenches of
    `linkages.mechanics.planar.newton_euler.joint_wrenches`.
    """
    body, pose, acc, load = bodies.records[i], work.pose, work.acc, work.bias
    s, m, along, turning, across = station.place, station.mass, station.first, station.second, 0.0
    ux, uy = turned(pose, i, body.ex, body.ey)
    x, y = acc[i, 1] - gravity[0], acc[i, 2] - gravity[1]
    a1, a2, alpha, w = x * ux + y * uy, y * ux - x * uy, acc[i, 0], work.vel[i, 0]
    f1, f2, moment, x1, x2 = m * a1, m * a2, 0.0, s, 0.0
    for k in range(body.shapes):
        mode, place = modes[k], body.eta + k
        eta, rate, second = work.q[place], work.v[place], work.a[place]
        along += mode.mass_a * eta
        across += mode.mass_b * eta
        turning += 2.0 * mode.first_a * eta
        f1 += mode.mass_a * second - 2.0 * w * mode.mass_b * rate
        f2 += mode.mass_b * second + 2.0 * w * mode.mass_a * rate
        moment += mode.first_b * second + 2.0 * w * mode.first_a * rate
        x1 += mode.a * eta
        x2 += mode.b * eta
    f1 -= alpha * across + w * w * along
    f2 += alpha * along - w * w * across
    moment += along * a2 - across * a1 + turning * alpha
    for j in range(i + 1, len(bodies.records)):
        section = bodies.records[j]
        if section.type != NODE or section.mount.body != i:
            break
        at = section.mount.x * body.ex + section.mount.y * body.ey
        if (at > s if s > 0.0 else at < s) and at != 0.0:
            rx, ry = offset(pose, i, j)
            f1 += load[j, 1] * ux + load[j, 2] * uy
            f2 += load[j, 2] * ux - load[j, 1] * uy
            moment += load[j, 0] + rx * load[j, 2] - ry * load[j, 1]
    moment -= x1 * f2 - x2 * f1
    side = -1.0 if s > 0.0 else 1.0
    return side * f1, side * moment


@lazy_kernel
def beam_state(
    beams: Records, bodies: Bodies, stations: Records, modes: Records, gravity: Array, work: Workspace
) -> tuple[float, float, float, float]:
    """Find the largest internal forces of a flexible link; arguments as for `cut`.

    Returns the largest bending moment [N m], the largest normal stress [Pa], its place from the beam's first end [m],
    and the largest compressive force [N].
    """
    bending, stress, place, compression = 0.0, 0.0, 0.0, 0.0
    for j in range(len(beams)):
        beam = beams[j]
        for k in range(beam.first, beam.first + beam.count):
            force, moment = cut(bodies, beam.body, stations[k], modes[k], gravity, work)
            bending, compression = max(bending, abs(moment)), max(compression, -force)
            normal = abs(force) / beam.area + abs(moment) * beam.leverage
            if normal > stress:
                stress, place = normal, beam.origin + stations[k].place
    return bending, stress, place, compression
