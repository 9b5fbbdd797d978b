"""What modal coordinates add to the kinematics and dynamics of bodies; the beam itself is in `linkages.planar.bodies`.

The modal coordinates of a body are eliminated from its articulated inertia before its joint is. Lines of the work
arrays (nb, ...) hold, for a body with nf of at most nm modes:

| array     | from          | what                                                                                   |
|-----------|---------------|----------------------------------------------------------------------------------------|
| `inertia` | 6             | I_re, coupling of each mode with (turn, x, y) of the frame, three a mode               |
|           | 6 + 3 nm      | I_ee, inertia of the modes with all that hangs on the sections; then its factors       |
| `axis`    | 8             | W = I_ee^-1 I_er, three a mode                                                         |
|           | 8 + 3 nm      | z = I_ee^-1 (forces on the modes), of `linkages.planar.dynamics.respond`               |

So, with a the acceleration of the frame: eta'' = z - W a; what the frame feels is I_rr - I_re W and I_re z.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.kernel import Array, inlined_kernel, lazy_kernel
from linkages.kernel.simd import lane, lanes, lanes_at, put_lanes, with_lane
from linkages.planar.bodies import (
    DAMPING,
    ELASTIC,
    LOCK,
    MATRIX,
    MOTION,
    POINTS,
    POSE,
    REST,
    SHAPE,
    STIFFNESS,
    STRAIGHT,
    Bodies,
)
from linkages.planar.markers import arm, turned
from linkages.planar.record_types import SECTION
from linkages.planar.workspace import Workspace

_SMALL = 0.05  # rad


@lazy_kernel
def bend(bodies: Bodies, i: int, pose: Array) -> None:
    """Fill the line of a section that stands apart from its beam."""
    _place(bodies, i, pose)


@inlined_kernel
def _place(bodies: Bodies, i: int, pose: Array) -> None:
    """Fill the line of a section; its beam's is known."""
    section, shapes, p = bodies.records[i], bodies.shapes[i], bodies.records[i].mount.body
    nb, nm = bodies.records[p].bends, shapes.shape[1]
    ux, uy = turned(pose, p, section.ux, section.uy)
    stretch, deflection, turn = 0.0, 0.0, 0.0
    for k in range(bodies.records[p].modes):
        shape, eta = shapes[SHAPE, k], pose[p, POSE + k]
        psi, b, slope = lane(shape, 0), lane(shape, 1), lane(shape, 2)
        stretch += 0.5 * psi * eta
        for m in range(nb if k < nb else 0):
            psi += lane(shapes[MATRIX + k, m], 0) * pose[p, POSE + m]
        stretch += 0.5 * psi * eta
        deflection += b * eta
        turn += slope * eta
        pose[i, POSE + k] = slope
        pose[i, POSE + nm + k] = psi * ux - b * uy
        pose[i, POSE + 2 * nm + k] = psi * uy + b * ux
    rx, ry = arm(pose, section.mount)
    c, s = _direction(turn)
    pose[i, 0] = pose[p, 0] + rx + (ux * stretch - uy * deflection)
    pose[i, 1] = pose[p, 1] + ry + (uy * stretch + ux * deflection)
    pose[i, 2] = pose[p, 2] + turn
    pose[i, 3] = pose[p, 3] * c - pose[p, 4] * s
    pose[i, 4] = pose[p, 4] * c + pose[p, 3] * s


@inlined_kernel
def _direction(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle that is most often small: by their series, to the last digit."""
    if abs(angle) > _SMALL:
        return math.cos(angle), math.sin(angle)
    x = angle * angle
    both = lanes(1 / 720, 1 / 120, 0.0, 0.0) - lanes(1 / 40320, 1 / 5040, 0.0, 0.0) * x
    both = lanes(1 / 2, 1.0, 0.0, 0.0) - (lanes(1 / 24, 1 / 6, 0.0, 0.0) - both * x) * x
    return 1.0 - lane(both, 0) * x, lane(both, 1) * angle


@inlined_kernel
def modal_motion(bodies: Bodies, i: int, pose: Array, rates: Array) -> tuple[float, float, float]:
    """How fast the modes turn and move a section at rates of its beam's coordinates (nb, 3 + nm): turn, x, y."""
    p = bodies.records[i].mount.body
    turn, x, y, nm = 0.0, 0.0, 0.0, bodies.shapes.shape[2]
    for k in range(bodies.records[p].modes):
        rate = rates[p, 3 + k]
        turn += pose[i, POSE + k] * rate
        x += pose[i, POSE + nm + k] * rate
        y += pose[i, POSE + 2 * nm + k] * rate
    return turn, x, y


@inlined_kernel
def shortening(bodies: Bodies, i: int, rates: Array, others: Array) -> float:
    """Bilinear form rates.H others of a section with two rates of its beam's coordinates, (nb, 3 + nm) each."""
    shapes, p, total = bodies.shapes[i], bodies.records[i].mount.body, 0.0
    nb = bodies.records[p].bends
    for k in range(nb):
        for m in range(nb):
            total -= rates[p, 3 + k] * lane(shapes[MATRIX + k, m], 0) * others[p, 3 + m]
    return total


@inlined_kernel
def add_to_modes(bodies: Bodies, i: int, pose: Array, moment: float, fx: float, fy: float, wrench: Array) -> None:
    """Add what a wrench on section i does to its beam's coordinates to the beam's line of wrenches (nb, 3 + nm)."""
    p, nm = bodies.records[i].mount.body, bodies.shapes.shape[2]
    for k in range(bodies.records[p].modes):
        own = wrench[p, 3 + k] + pose[i, POSE + k] * moment
        wrench[p, 3 + k] = own + (pose[i, POSE + nm + k] * fx + pose[i, POSE + 2 * nm + k] * fy)


@inlined_kernel
def product(bodies: Bodies, i: int, k: int, rates: Array, first: int) -> Any:
    """Row k of body i's matrices, in lanes, times the entries of its line of an array from one on."""
    shapes, total = bodies.shapes[i], 0.0
    for m in range(bodies.records[i].modes):
        total += shapes[MATRIX + k, m] * rates[i, first + m]
    return total


@lazy_kernel
def deform(bodies: Bodies, i: int, pose: Array) -> None:
    """Fill a bending body's line of poses behind its modal coordinates, and those of the sections right behind it."""
    body, shapes, nm = bodies.records[i], bodies.shapes[i], bodies.shapes.shape[2]
    motion, rest = POSE + MOTION * nm, POSE + REST * nm
    points = shapes[STRAIGHT, 0]
    for k in range(body.modes):
        shape, more, eta = shapes[SHAPE, k], product(bodies, i, k, pose, POSE), pose[i, POSE + k]
        own = with_lane(with_lane(shape + more, 1, lane(shape, 1)), 3, lane(shape, 3))
        put_lanes(pose, i, motion + 4 * k, own)
        pose[i, rest + k], pose[i, rest + nm + k] = lane(more, 1), lane(more, 3)
        points += (shape + own) * (0.5 * eta)
    put_lanes(pose, i, POSE + POINTS * nm, points)
    for j in range(i + 1, len(bodies.records)):
        if bodies.records[j].type != SECTION or bodies.records[j].mount.body != i:
            break
        _place(bodies, j, pose)


@inlined_kernel
def two_points(bodies: Bodies, i: int, pose: Array) -> Any:
    """Places of the two points of a bending body's mass along and across it, x0, y0, x1, y1 in lanes."""
    return lanes_at(pose, i, POSE + POINTS * bodies.shapes.shape[2])


@inlined_kernel
def _quarter(x: Any) -> Any:
    """Two vectors in lanes, a quarter turn ahead."""
    return lanes(lane(x, 1), lane(x, 0), lane(x, 3), lane(x, 2)) * lanes(-1.0, 1.0, -1.0, 1.0)


@inlined_kernel
def _sum(x: Any) -> float:
    """Sum of lanes."""
    return (lane(x, 0) + lane(x, 1)) + (lane(x, 2) + lane(x, 3))


@inlined_kernel
def moved_by(bodies: Bodies, i: int, k: int, pose: Array) -> Any:
    """How mode k of a bending body moves its two points, in lanes."""
    return lanes_at(pose, i, POSE + MOTION * bodies.shapes.shape[2] + 4 * k)


@inlined_kernel
def two_rates(bodies: Bodies, i: int, pose: Array, rates: Array) -> Any:
    """How fast those points move in the frame at rates of the coordinates (nb, 3 + nm), in lanes."""
    total = 0.0
    for k in range(bodies.records[i].modes):
        total += moved_by(bodies, i, k, pose) * rates[i, 3 + k]
    return total


@lazy_kernel
def beam_inertia(bodies: Bodies, i: int, work: Workspace) -> None:
    """Put the inertia of a bending body into its line of ``inertia``."""
    pose, inertia = work.pose, work.inertia
    body, shapes, nm = bodies.records[i], bodies.shapes[i], bodies.shapes.shape[2]
    points, (ux, uy) = two_points(bodies, i, pose), turned(pose, i, body.ex, body.ey)
    mass = body.mass
    ahead, turning = _quarter(points) * mass, mass * _sum(points * points)
    along, across = mass * lane(points, 0), mass * lane(points, 1)
    rest = POSE + REST * nm
    for k in range(body.modes):
        moved = moved_by(bodies, i, k, pose)
        psi, b = mass * lane(moved, 0), mass * lane(moved, 1)
        turning += pose[i, rest + k] * pose[i, POSE + k]
        inertia[i, 6 + 3 * k] = _sum(ahead * moved) + pose[i, rest + nm + k]
        inertia[i, 7 + 3 * k] = psi * ux - b * uy
        inertia[i, 8 + 3 * k] = psi * uy + b * ux
        for m in range(k + 1):
            own = mass * _sum(moved * moved_by(bodies, i, m, pose))
            inertia[i, 6 + 3 * nm + k * nm + m] = own + lane(shapes[MATRIX + k, m], 1)
        inertia[i, 6 + 3 * nm + k * nm + k] += lane(shapes[ELASTIC, k], LOCK)
    inertia[i, 0], inertia[i, 1], inertia[i, 2] = turning, -(along * uy + across * ux), along * ux - across * uy
    inertia[i, 3], inertia[i, 4], inertia[i, 5] = mass, 0.0, mass


@lazy_kernel
def hang(bodies: Bodies, i: int, work: Workspace) -> None:
    """Add the inertia that hangs on section i to that of its beam's coordinates."""
    pose, inertia = work.pose, work.inertia
    if inertia[i, 0] == 0.0 and inertia[i, 3] == 0.0 and inertia[i, 5] == 0.0:
        return
    p, nm = bodies.records[i].mount.body, bodies.shapes.shape[2]
    nf = bodies.records[p].modes
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    for k in range(nf):
        s0, s1, s2 = pose[i, POSE + k], pose[i, POSE + nm + k], pose[i, POSE + 2 * nm + k]
        f0 = inertia[i, 0] * s0 + inertia[i, 1] * s1 + inertia[i, 2] * s2
        f1 = inertia[i, 1] * s0 + inertia[i, 3] * s1 + inertia[i, 4] * s2
        f2 = inertia[i, 2] * s0 + inertia[i, 4] * s1 + inertia[i, 5] * s2
        inertia[p, 6 + 3 * k] += f0 + rx * f2 - ry * f1
        inertia[p, 7 + 3 * k] += f1
        inertia[p, 8 + 3 * k] += f2
        for m in range(k + 1):
            other = pose[i, POSE + m] * f0 + pose[i, POSE + nm + m] * f1 + pose[i, POSE + 2 * nm + m] * f2
            inertia[p, 6 + 3 * nm + k * nm + m] += other


@lazy_kernel
def eliminate(bodies: Bodies, i: int, work: Workspace) -> None:
    """Eliminate the modes of body i from its articulated inertia.

    Factorises I_ee = L D L^T in place, L below the diagonal and 1/D on it, and fills W.
    """
    nf, nm, inertia, axis = bodies.records[i].modes, bodies.shapes.shape[2], work.inertia, work.axis
    e, w = 6 + 3 * nm, 8
    i0, i1, i2 = inertia[i, 0], inertia[i, 1], inertia[i, 2]
    i3, i4, i5 = inertia[i, 3], inertia[i, 4], inertia[i, 5]
    for k in range(3 * nf):
        axis[i, w + k] = inertia[i, 6 + k]
    for k in range(nf):
        w0, w1, w2 = axis[i, w + 3 * k], axis[i, w + 3 * k + 1], axis[i, w + 3 * k + 2]
        inverse = 1.0 / inertia[i, e + k * nm + k]
        for j in range(nf - 1, k, -1):
            below = inertia[i, e + j * nm + k] * inverse
            for m in range(k + 1, j + 1):
                inertia[i, e + j * nm + m] -= below * inertia[i, e + m * nm + k]
            inertia[i, e + j * nm + k] = below
            axis[i, w + 3 * j] -= below * w0
            axis[i, w + 3 * j + 1] -= below * w1
            axis[i, w + 3 * j + 2] -= below * w2
        inertia[i, e + k * nm + k] = inverse
        v0, v1, v2 = w0 * inverse, w1 * inverse, w2 * inverse
        axis[i, w + 3 * k], axis[i, w + 3 * k + 1], axis[i, w + 3 * k + 2] = v0, v1, v2
        i0, i1, i2 = i0 - w0 * v0, i1 - w0 * v1, i2 - w0 * v2
        i3, i4, i5 = i3 - w1 * v1, i4 - w1 * v2, i5 - w2 * v2
    inertia[i, 0], inertia[i, 1], inertia[i, 2] = i0, i1, i2
    inertia[i, 3], inertia[i, 4], inertia[i, 5] = i3, i4, i5
    for k in range(nf - 2, -1, -1):
        w0, w1, w2 = axis[i, w + 3 * k], axis[i, w + 3 * k + 1], axis[i, w + 3 * k + 2]
        for m in range(k + 1, nf):
            below = inertia[i, e + m * nm + k]
            w0 -= below * axis[i, w + 3 * m]
            w1 -= below * axis[i, w + 3 * m + 1]
            w2 -= below * axis[i, w + 3 * m + 2]
        axis[i, w + 3 * k], axis[i, w + 3 * k + 1], axis[i, w + 3 * k + 2] = w0, w1, w2


@lazy_kernel
def pushed_modes(bodies: Bodies, i: int, work: Workspace, load: Array, tau: Array) -> None:
    """Find z of a bending body, and add to its load what its frame feels of it."""
    body, nm, still = bodies.records[i], bodies.shapes.shape[2], True
    inertia, axis = work.inertia, work.axis
    z, e = 8 + 3 * nm, 6 + 3 * nm
    for k in range(body.modes):
        push = tau[body.eta + k] - load[i, 3 + k]
        for m in range(k):
            push -= inertia[i, e + k * nm + m] * axis[i, z + m]
        axis[i, z + k] = push
        still = still and push == 0.0
    if still:
        return
    f0, f1, f2 = load[i, 0], load[i, 1], load[i, 2]
    for k in range(body.modes - 1, -1, -1):
        push = axis[i, z + k] * inertia[i, e + k * nm + k]
        for m in range(k + 1, body.modes):
            push -= inertia[i, e + m * nm + k] * axis[i, z + m]
        axis[i, z + k] = push
        f0 += inertia[i, 6 + 3 * k] * push
        f1 += inertia[i, 7 + 3 * k] * push
        f2 += inertia[i, 8 + 3 * k] * push
    load[i, 0], load[i, 1], load[i, 2] = f0, f1, f2


@lazy_kernel
def moved_modes(bodies: Bodies, i: int, work: Workspace, a: Array) -> None:
    """Find the modal accelerations of a bending body from the acceleration of its frame."""
    body, nm, axis, change = bodies.records[i], bodies.shapes.shape[2], work.axis, work.change
    a0, a1, a2 = change[i, 0], change[i, 1], change[i, 2]
    for k in range(body.modes):
        second = axis[i, 8 + 3 * nm + k] - axis[i, 8 + 3 * k] * a0
        second = second - axis[i, 9 + 3 * k] * a1 - axis[i, 10 + 3 * k] * a2
        a[body.eta + k] += second
        change[i, 3 + k] = second


@lazy_kernel
def beam_load(bodies: Bodies, i: int, work: Workspace, gravity: Array, load: Array) -> None:
    """Fill a bending body's line of ``load``: rate of change of momentum less weight, and its elastic forces."""
    body, shapes, nm = bodies.records[i], bodies.shapes[i], bodies.shapes.shape[2]
    pose, vel, acc = work.pose, work.vel, work.acc
    points, (ux, uy) = two_points(bodies, i, pose), turned(pose, i, body.ex, body.ey)
    force = two_accelerations(bodies, i, pose, vel, acc, gravity, load) * body.mass
    fx, fy, al, w = lane(force, 0), lane(force, 1), acc[i, 0], vel[i, 0]
    moment, twice, square, rest = _sum(_quarter(points) * force), 2.0 * w, w * w, POSE + REST * nm
    for k in range(body.modes):
        out, turn, rate, elastic = pose[i, rest + k], pose[i, rest + nm + k], vel[i, 3 + k], shapes[ELASTIC, k]
        eta = pose[i, POSE + k]
        moment += (al * eta + twice * rate) * out + turn * acc[i, 3 + k]
        own = _sum(moved_by(bodies, i, k, pose) * force) + (load[i, 3 + k] + (al * turn - square * out))
        load[i, 3 + k] = own + (lane(elastic, STIFFNESS) * eta + lane(elastic, DAMPING) * rate)
    load[i, 0], load[i, 1], load[i, 2] = moment, fx * ux - fy * uy, fx * uy + fy * ux


@inlined_kernel
def two_accelerations(bodies: Bodies, i: int, pose: Array, vel: Array, acc: Array, gravity: Array, rest: Array) -> Any:
    """Accelerations of the two points of a bending body's mass less gravity, along and across it, in lanes.

    Puts the force on each mode that the motion of modes takes besides into the line of `rest` (nb, 3 + nm).
    """
    points, (ux, uy) = two_points(bodies, i, pose), turned(pose, i, bodies.records[i].ex, bodies.records[i].ey)
    x, y, al, w, shapes = acc[i, 1] - gravity[0], acc[i, 2] - gravity[1], acc[i, 0], vel[i, 0], bodies.shapes[i]
    rates, seconds, curls = 0.0, 0.0, 0.0
    for k in range(bodies.records[i].modes):
        moved, rate, second = moved_by(bodies, i, k, pose), vel[i, 3 + k], acc[i, 3 + k]
        turning, pushed = 0.0, 0.0
        for m in range(bodies.records[i].modes):
            entry = shapes[MATRIX + k, m]
            turning += entry * vel[i, 3 + m]
            pushed += lane(entry, 1) * acc[i, 3 + m]
        rates += moved * rate
        seconds += moved * second
        curls += turning * rate
        rest[i, 3 + k] = pushed + 2.0 * w * lane(turning, 3)
    frame = lanes(x * ux + y * uy, y * ux - x * uy, 0.0, 0.0) - points * (w * w)
    return frame + _quarter(points * al + rates * (2.0 * w)) + (seconds + curls * lanes(1.0, 0.0, 1.0, 0.0))


@lazy_kernel
def beam_energy(bodies: Bodies, i: int, pose: Array, vel: Array, gravity: Array) -> tuple[float, float, float, float]:
    """Kinetic energy of a bending body, its potential energy, and that of strain [J]; power lost to damping [W]."""
    body, shapes, nm = bodies.records[i], bodies.shapes[i], bodies.shapes.shape[2]
    points, (ux, uy) = two_points(bodies, i, pose), turned(pose, i, body.ex, body.ey)
    x, y, w, vx, vy = lane(points, 0), lane(points, 1), vel[i, 0], vel[i, 1], vel[i, 2]
    frame = lanes(vx * ux + vy * uy, vy * ux - vx * uy, 0.0, 0.0)
    rates = frame + two_rates(bodies, i, pose, vel) + _quarter(points) * w
    kinetic, strain, lost = 0.5 * body.mass * _sum(rates * rates), 0.0, 0.0
    px, py = pose[i, 0] + x * ux - y * uy, pose[i, 1] + x * uy + y * ux
    potential, rest = -body.mass * (gravity[0] * px + gravity[1] * py), POSE + REST * nm
    for k in range(body.modes):
        eta, rate = pose[i, POSE + k], vel[i, 3 + k]
        kinetic += (0.5 * w * eta * pose[i, rest + k] + rate * pose[i, rest + nm + k]) * w
        kinetic += 0.5 * rate * lane(product(bodies, i, k, vel, 3), 1)
        strain += 0.5 * lane(shapes[ELASTIC, k], STIFFNESS) * eta * eta
        lost += lane(shapes[ELASTIC, k], DAMPING) * rate * rate
    return kinetic, potential, strain, lost
