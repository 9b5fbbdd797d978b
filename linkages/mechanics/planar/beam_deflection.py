"""Deflections of flexible links: distances from the chord between the ends of the beam."""

from __future__ import annotations

import math

from linkages.base.kernel import Array, Records, lazy_kernel
from linkages.mechanics.integrate.parabola import parabola_top
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.markers import offset, turned

_ROUNDING = 1e-14  # deflection, in parts of the length, that counts as zero
_SAME = 1e-6  # distance, in parts of the length, below which two stations count as one


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

    Parameters
    ----------
    beams : (n,) records of `linkages.mechanics.planar.record_types.BEAM`
        The link's substructures.
    stations : (ns,) records of `linkages.mechanics.planar.record_types.STATION`
        Of all beams.
    modes : (ns, nm) records of `linkages.mechanics.planar.record_types.STATION_MODE`
    q : (n,) array
    pose : (nb, ...) array
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
            for m in range(body.modes):
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
