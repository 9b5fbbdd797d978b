"""Archard's law at held loads: a history of loads, repeated many times, wears the profiles that carry it.

The input is a list of *samples* from a run: position of the journal, overlap of journal and bearing, and the sample's
part of the integral of N |v_t| dt. While the profiles change, each sample keeps its load: the depth of contact is
adjusted until the moment of the overlap I = integral of delta_+ g dtheta has its old value (for Hertz's law, as for any
elastic foundation, the load depends on I alone). A pocket that becomes conforming thus spreads its load, and the many
small steps for this need no simulation.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, kernel
from linkages.laws.wear.overlap import Place, overlap
from linkages.laws.wear.profile import depth_of

#: Columns of a sample: angles of bearing and journal [rad], eccentricity vector [m], overlap's moment [m], all in plane
#: axes; its part of the integral of N |v_t| dt [N m].
SAMPLE = ("bearing_angle", "journal_angle", "ex", "ey", "ix", "iy", "work")

#: Largest part of an overlap that one deposit removes.
FRACTION = 0.2

_NEWTON = 30
_CLOSE, _FAR = 1e-6, 1e-3  # relative errors of a moment: found, not found
_MOST = 200  # deposits of one sample in a sweep


@kernel(makes_arrays=True)
def wear_away(
    samples: Array,
    clearance: float,
    radii: tuple[float, float],
    length: float,
    coefficients: tuple[float, float],
    sweeps: int,
    removed: Array,
) -> float:
    """Wear both profiles by samples at held loads.

    Parameters
    ----------
    samples : (m, 7) array
        Samples (`SAMPLE`); the journal positions are updated.
    clearance : float
        At which load is carried, before wear [m].
    radii : tuple of two floats
        Of bearing and journal, before wear [m].
    length : float
        L [m].
    coefficients : tuple of two floats
        k of bearing and journal, times the number of repetitions [m2/N].
    sweeps : int
        Number of passes over the history, alternately forwards and backwards, with proportionally less wear each.
    removed : (2, n) array
        Area per angle over the part's radius that has been removed from bearing and journal [m]; added to.

    Returns
    -------
    float
        Fraction of the work without a found journal position.
    """
    n = removed.shape[1]
    signed = radii[0], -radii[1]  # see `depth_of`
    depths, spread = np.empty((2, n)), np.zeros((2, n))
    for side in range(2):
        depths[side] = depth_of(removed[side], signed[side])
    whole = coefficients[0] / radii[0] + coefficients[1] / radii[1]
    missed, total = 0.0, 0.0
    for sweep in range(sweeps):
        for count in range(len(samples)):
            sample = samples[count if sweep % 2 == 0 else len(samples) - 1 - count]
            work = sample[6] / sweeps
            while work > 0.0:
                place, error = _sink(sample, clearance, radii[1], depths)
                for i in range(n):
                    spread[0, i] = 0.0
                    spread[1, i] = 0.0
                overlap(place, spread[0], spread[1])
                area = 0.0
                for i in range(n):
                    area += spread[0, i]
                if area <= 0.0:  # cannot be: its moment is not zero
                    return 1.0
                most = FRACTION * area * length / whole
                now = min(work, max(most, sample[6] / (sweeps * _MOST)))
                work = work - now if now < work else 0.0
                total += now
                missed += now if error > _FAR else 0.0
                for side in range(2):
                    if coefficients[side] == 0.0:
                        continue
                    other = 0.0
                    for i in range(n):
                        other += spread[side, i]
                    part = coefficients[side] * now / (radii[side] * length * other * 2.0 * math.pi / n)
                    for i in range(n):
                        if spread[side, i] > 0.0:
                            removed[side, i] += part * spread[side, i]
                            s = removed[side, i]
                            depths[side, i] = 2.0 * s / (1.0 + math.sqrt(1.0 + 2.0 * s / signed[side]))
    return missed / total if total > 0.0 else 0.0


@kernel
def fill_moments(samples: Array, clearance: float, journal_radius: float, depths: Array) -> None:
    """Fill in the moments of samples, from where the journal was.

    Parameters
    ----------
    samples : (m, 7) array
    clearance, journal_radius : float
        At which load is carried, and before wear [m].
    depths : (2, n) array
        Control depths of bearing and journal [m].
    """
    for k in range(len(samples)):
        s = samples[k]
        place = Place(s[2], s[3], s[0], s[1], clearance, journal_radius, depths[0], depths[1])
        found = overlap(place, place.bearing[:0], place.journal[:0])
        s[4], s[5] = found.ix, found.iy


@kernel
def _sink(sample: Array, clearance: float, journal_radius: float, depths: Array) -> tuple[Place, float]:
    """Find where the overlap has a sample's moment, from its last place; U is convex, so Newton's method finds it."""
    ix, iy = sample[4], sample[5]
    goal = math.hypot(ix, iy)
    scale = (0.75 * goal * math.sqrt(0.5 * clearance)) ** (2.0 / 3.0)  # penetration of the round joint
    place = Place(sample[2], sample[3], sample[0], sample[1], clearance, journal_radius, depths[0], depths[1])
    error = 1.0
    for _ in range(_NEWTON):
        found = overlap(place, place.bearing[:0], place.journal[:0])
        rx, ry = ix - found.ix, iy - found.iy
        error = math.hypot(rx, ry) / goal
        if error < _CLOSE:
            error = 0.0
            break
        determinant = found.hxx * found.hyy - found.hxy * found.hxy
        if found.energy > 0.0 and determinant > 0.0:
            dx = (found.hyy * rx - found.hxy * ry) / determinant
            dy = (found.hxx * ry - found.hxy * rx) / determinant
            step, most = (
                math.hypot(dx, dy),
                2.0 * max(found.peak, scale) / max(0.1, math.hypot(found.peak_x, found.peak_y)),
            )
            if step > 10.0 * most:
                dx, dy = dx * 10.0 * most / step, dy * 10.0 * most / step
        else:  # it hovers: on along the load
            move = (scale - found.peak) / goal
            dx, dy = move * ix, move * iy
        place = Place(
            place.ex + dx, place.ey + dy, sample[0], sample[1], clearance, journal_radius, depths[0], depths[1]
        )
    sample[2], sample[3] = place.ex, place.ey
    return place, error
