"""Deflections of links that bend: distances from the line between the beam's ends."""

from __future__ import annotations

import math

from linkages.integrate.parabola import parabola_top
from linkages.kernel import Array, Records, lazy_kernel
from linkages.planar.bodies import POSE, Bodies
from linkages.planar.internal_forces import FIXED_COLUMNS
from linkages.planar.markers import turned

_ROUNDING = 1e-14  # deflection over length below which it is zero
_SAME = 1e-6  # distance over length below which two stations are one


@lazy_kernel
def deflection(first: int, last: int, x: float, y: float, unbent: float, pose: Array) -> float:
    """Distance [m] of a point from the line through two sections' origins, positive on its left, less that unbent."""
    dx, dy = pose[last, 0] - pose[first, 0], pose[last, 1] - pose[first, 1]
    length = math.hypot(dx, dy)
    distance = (dx * (y - pose[first, 1]) - dy * (x - pose[first, 0])) / length - unbent
    return distance if abs(distance) > _ROUNDING * length else 0.0


@lazy_kernel
def largest_deflection(beams: Records, bodies: Bodies, stations: Array, pose: Array) -> tuple[float, float]:
    """Largest deflection [m] of a link along its beam, its magnitude, and its place from the beam's first end [m].

    The beam's axis is followed from each piece's first end: from station to station it is as long as it is stretched.
    Between stations the deflection is a parabola through three of them.

    Parameters
    ----------
    beams : (n,) records of `linkages.planar.record_types.BEAM`
        The link's pieces.
    stations : (ns, 4 + 6 nm) array
        Lines of all beams, see `linkages.planar.internal_forces.FIXED_COLUMNS`.
    """
    first, last, nm = beams[0].first_end, beams[0].last_end, bodies.shapes.shape[2]
    length = math.hypot(pose[last, 0] - pose[first, 0], pose[last, 1] - pose[first, 1])
    largest, place = 0.0, 0.0
    for j in range(len(beams)):
        beam = beams[j]
        body = bodies.records[beam.body]
        ux, uy = turned(pose, beam.body, body.ex, body.ey)
        x, y, s, along, across = pose[beam.start, 0], pose[beam.start, 1], 0.0, 0.0, 0.0
        s0, s1, d0, d1, count = 0.0, 0.0, 0.0, 0.0, 0
        for k in range(beam.first, beam.first + beam.count):
            station = stations[k]
            if count > 0 and station[0] - s < _SAME * length:
                continue
            stretch, rise = station[0], 0.0
            for m in range(body.modes):
                eta, column = pose[beam.body, POSE + m], FIXED_COLUMNS + 4 * nm + m
                stretch += station[column] * eta
                rise += station[column + nm] * eta
            if count > 0:
                dy = rise - across
                dx = math.sqrt(max((stretch - along) ** 2 - dy * dy, 0.0))
                x, y = x + (ux * dx - uy * dy), y + (uy * dx + ux * dy)
            s, along, across, count = station[0], stretch, rise, count + 1
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
