"""Weight and inertia of a substructure of a flexible link as forces at nodes on its deformed axis."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.flexible import numerics
from linkages.elements.flexible.substructure import Substructure


class Moved(NamedTuple):
    """A motion of a substructure, in axes of its frame."""

    eta: Array  # shape coordinates, (nf,)
    rate: Array
    second: Array
    spin: float  # angular velocity of the frame [rad/s]
    turning: float  # its rate [rad/s2]
    gravity: Array  # gravity less the acceleration of the frame's origin, (2,) [m/s2]


def inertia_at_nodes(part: Substructure, moved: Moved, wanted: Array) -> tuple[Array, Array, Array]:
    """Distribute weight and inertia of a substructure over nodes on its deformed axis.

    The motion of its points is that of `linkages.mechanics.planar.bodies`. The rest, which is the remainder of H and
    the error of the quadrature, is added as the force of a rigid acceleration: the sums are ``wanted`` (3,), moment
    about the frame's origin [N m] and force [N].

    Returns
    -------
    (nn, 2) arrays
        Places of the nodes [m]; forces of gravity and of the centrifugal acceleration, other forces [N].
    """
    spots = sorted({*part.abscissas, *part.ends})
    lines = (np.linspace(a, b, numerics.LINK_LOADS_NODES) for a, b in pairwise(spots))
    places = np.concatenate([line[(k > 0) :] for k, line in enumerate(lines)])
    x, weight = np.polynomial.legendre.leggauss(numerics.LINK_LOADS_POINTS)
    half = 0.5 * np.diff(places)[:, None]
    s, share = (places[:-1, None] + half * (1.0 + x)).ravel(), np.tile(0.5 * (1.0 + x), len(half))
    mass = (part.beam.density * part.beam.area * half * weight).ravel()
    r, rate, second = _motion(part, s, moved)
    of_field = mass[:, None] * (moved.gravity + moved.spin**2 * r)
    others = -mass[:, None] * (moved.turning * _ahead(r) + 2.0 * moved.spin * _ahead(rate) + second)
    nodes, lumped = _motion(part, places, moved)[0], _lumped(mass[:, None], share)[:, 0]
    field, others = _lumped(of_field, share), _lumped(others, share)
    others += _rigid(nodes, lumped, wanted - _sums(nodes, field + others))
    return nodes, field, others


def _motion(part: Substructure, s: Array, moved: Moved) -> tuple[Array, Array, Array]:
    """Places, rates and accelerations (n, 2) of points of the axis relative to the frame, in its axes."""
    eta, rate, second = moved[:3]
    a, b = part.modes.shapes(s)
    h = np.array([part.modes.at(place)[3] for place in s])
    along = s + a @ eta - 0.5 * (h @ eta) @ eta, a @ rate - (h @ eta) @ rate
    bent = a @ second - (h @ rate) @ rate - (h @ eta) @ second
    columns = (along[0], b @ eta), (along[1], b @ rate), (bent, b @ second)
    return tuple(np.column_stack(pair) for pair in columns)  # type: ignore[return-value]


def _ahead(vectors: Array) -> Array:
    """Turn vectors (n, 2) by a quarter counter-clockwise."""
    return np.column_stack([-vectors[:, 1], vectors[:, 0]])


def _lumped(values: Array, share: Array) -> Array:
    """Give values at the points between nodes to the nodes on both sides."""
    found = np.zeros((len(values) // numerics.LINK_LOADS_POINTS + 1, values.shape[1]))
    found[1:] += (values * share[:, None]).reshape(-1, numerics.LINK_LOADS_POINTS, values.shape[1]).sum(axis=1)
    found[:-1] += (values * (1.0 - share)[:, None]).reshape(-1, numerics.LINK_LOADS_POINTS, values.shape[1]).sum(axis=1)
    return found


def _sums(nodes: Array, forces: Array) -> Array:
    """Moment about the origin and sum of forces at nodes."""
    moment = nodes[:, 0] @ forces[:, 1] - nodes[:, 1] @ forces[:, 0]
    return np.array([moment, *forces.sum(axis=0)])


def _rigid(nodes: Array, masses: Array, wanted: Array) -> Array:
    """Compute the forces at nodes of a rigid acceleration with these sums."""
    r = nodes - masses @ nodes / masses.sum()
    turning = masses[:, None] * _ahead(r)
    forces = masses[:, None] * wanted[1:] / masses.sum()
    moment = wanted[0] - _sums(nodes, forces)[0]
    return np.asarray(forces + turning * moment / (masses @ (r * r).sum(axis=1)))
