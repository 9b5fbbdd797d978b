"""Axial force and bending moment within links that bend, from equilibrium.

The part of a beam that lies beyond a cut, seen from the frame's origin, moves under the loads on its sections, its
weight and the force at the cut. Its inertia is that of the motion to first order in the modal coordinates, integrated
exactly with the shapes. What follows from the curvature of the modes instead converges slowly with their number, and
does not jump at loads.
"""

from __future__ import annotations

from linkages.kernel import Array, Records, lazy_kernel
from linkages.planar.bodies import POSE, Bodies
from linkages.planar.markers import turned
from linkages.planar.record_types import SECTION

#: What is known of a beam at a state: largest bending moment [N m], largest normal stress [Pa] and its place from the
#: beam's first end [m], largest compressive force [N].
BENDING, STRESS, PLACE, COMPRESSION = 2, 3, 4, 5

#: Columns of a station's line: abscissa; mass, first and second moment of mass beyond it; integrals of a, b, s a, s b
#: beyond it, one of each for every mode; a and b there.
FIXED_COLUMNS = 4


@lazy_kernel
def cut(
    bodies: Bodies, i: int, station: Array, gravity: Array, pose: Array, vel: Array, acc: Array, load: Array
) -> tuple[float, float]:
    """Axial force [N], positive in tension, and bending moment [N m], with the sign of the curvature, at a station.

    Parameters
    ----------
    station : (4 + 6 nm,) array
        Its line, see `FIXED_COLUMNS`.
    load : (nb, 3 + nm) array
        Wrench that each body gets through what carries it; see `linkages.planar.tangent.transmitted`.
    """
    body, nm = bodies.records[i], bodies.shapes.shape[2]
    s, m, along, turning, across = station[0], station[1], station[2], station[3], 0.0
    ux, uy = turned(pose, i, body.ex, body.ey)
    x, y = acc[i, 1] - gravity[0], acc[i, 2] - gravity[1]
    a1, a2, al, w = x * ux + y * uy, y * ux - x * uy, acc[i, 0], vel[i, 0]
    f1, f2, moment, x1, x2 = m * a1, m * a2, 0.0, s, 0.0
    for k in range(body.modes):
        eta, rate, second, first = pose[i, POSE + k], vel[i, 3 + k], acc[i, 3 + k], FIXED_COLUMNS + k
        sa, sb, ca, cb = station[first], station[first + nm], station[first + 2 * nm], station[first + 3 * nm]
        along += sa * eta
        across += sb * eta
        turning += 2.0 * ca * eta
        f1 += sa * second - 2.0 * w * sb * rate
        f2 += sb * second + 2.0 * w * sa * rate
        moment += cb * second + 2.0 * w * ca * rate
        x1 += station[first + 4 * nm] * eta
        x2 += station[first + 5 * nm] * eta
    f1 -= al * across + w * w * along
    f2 += al * along - w * w * across
    moment += along * a2 - across * a1 + turning * al
    for j in range(i + 1, len(bodies.records)):
        section = bodies.records[j]
        if section.type != SECTION or section.mount.body != i:
            break
        place = section.mount.x * body.ex + section.mount.y * body.ey
        if (place > s if s > 0.0 else place < s) and place != 0.0:
            rx, ry = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
            f1 += load[j, 1] * ux + load[j, 2] * uy
            f2 += load[j, 2] * ux - load[j, 1] * uy
            moment += load[j, 0] + rx * load[j, 2] - ry * load[j, 1]
    moment -= x1 * f2 - x2 * f1
    side = -1.0 if s > 0.0 else 1.0
    return side * f1, side * moment


@lazy_kernel
def beam_state(
    what: int,
    beams: Records,
    bodies: Bodies,
    stations: Array,
    gravity: Array,
    pose: Array,
    vel: Array,
    acc: Array,
    load: Array,
) -> float:
    """`BENDING`, `STRESS`, `PLACE` or `COMPRESSION` of a link that bends, from the records of its pieces."""
    bending, stress, place, compression = 0.0, 0.0, 0.0, 0.0
    for j in range(len(beams)):
        beam = beams[j]
        for k in range(beam.first, beam.first + beam.count):
            force, moment = cut(bodies, beam.body, stations[k], gravity, pose, vel, acc, load)
            bending, compression = max(bending, abs(moment)), max(compression, -force)
            normal = abs(force) / beam.area + abs(moment) * beam.leverage
            if normal > stress:
                stress, place = normal, beam.origin + stations[k, 0]
    if what == BENDING:
        return bending
    if what == COMPRESSION:
        return compression
    return stress if what == STRESS else place
