"""Axial force and bending moment within flexible bodies, from equilibrium.

The part of a beam beyond a cut, seen from the frame's origin, moves under the loads on its sections, its weight and the
force at the cut. Its inertia is that of the motion to first order in the modal coordinates, integrated exactly with the
shapes. The alternative, internal forces from the curvature of the modes, converges slowly with the number of modes, and
these forces do not jump at loads.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Records, lazy_kernel
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.markers import offset, turned
from linkages.mechanics.planar.record_types import SECTION
from linkages.mechanics.planar.workspace import Workspace


@lazy_kernel
def cut(
    bodies: Bodies, i: int, station: np.record, modes: Records, gravity: Array, work: Workspace
) -> tuple[float, float]:
    """Axial force [N], positive in tension, and bending moment [N m], with the sign of the curvature, at a station.

    Parameters
    ----------
    station : record of `linkages.mechanics.planar.record_types.STATION`
    modes : (nm,) records of `linkages.mechanics.planar.record_types.STATION_MODE`
    gravity : (2,) array
        In plane axes [m/s2].
    work : Workspace
        Its q, v, a, pose, vel, acc, and bias with the wrenches of
        `linkages.mechanics.planar.newton_euler.joint_wrenches`.
    """
    body, pose, acc, load = bodies.records[i], work.pose, work.acc, work.bias
    s, m, along, turning, across = station.place, station.mass, station.first, station.second, 0.0
    ux, uy = turned(pose, i, body.ex, body.ey)
    x, y = acc[i, 1] - gravity[0], acc[i, 2] - gravity[1]
    a1, a2, alpha, w = x * ux + y * uy, y * ux - x * uy, acc[i, 0], work.vel[i, 0]
    f1, f2, moment, x1, x2 = m * a1, m * a2, 0.0, s, 0.0
    for k in range(body.modes):
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
        if section.type != SECTION or section.mount.body != i:
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
    """Find the largest internal forces of a flexible link, from the records of its substructures.

    Parameters
    ----------
    beams : (n,) records of `linkages.mechanics.planar.record_types.BEAM`
    stations : (ns,) records of `linkages.mechanics.planar.record_types.STATION`
        Of all beams.
    modes : (ns, nm) records of `linkages.mechanics.planar.record_types.STATION_MODE`
    gravity, work
        As for `cut`.

    Returns
    -------
    tuple
        Largest bending moment [N m], largest normal stress [Pa], its place from the beam's first end [m], largest
        compressive force [N].
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
