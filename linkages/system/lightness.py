"""Links without mass or moment of inertia: allowed where they cannot move alone, because then others' masses tell how.

The equations of the tree need a mass of each link. Such links get a negligible one, in parts of the lightest link, so
that the accelerations are those of the linkage without it. Where they can move alone, the results would depend on it.
"""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, listed
from linkages.input.model.mechanism import Link, Mechanism
from linkages.mechanics.planar.closure import jacobian_at
from linkages.mechanics.planar.kinematics import state_tables
from linkages.system.tree import Tree, extent_of, joint_ends, without

_NEGLIGIBLE = 1e-10  # mass or inertia of a link without, over the smallest one of the others
_ALONE = 1e-4  # kinetic energy over the one if all links were as heavy as the lightest: below it links move alone
_INVOLVED = 1e-3  # part of the largest rate from which a coordinate belongs to a motion
_INDEPENDENT = 1e-9  # relative to the largest singular value


def negligible_inertials(mechanism: Mechanism) -> dict[str, float]:
    """Return a negligible mass and inertia of each link without, by path [kg, kg m2]."""
    light = _light(mechanism)
    masses = [link.mass for link in mechanism.links if link.mass > 0.0]
    if not light or not masses:
        return {}
    inertias = [link.inertia for link in mechanism.links if link.inertia > 0.0]
    least = min(inertias, default=min(masses) * _size(mechanism) ** 2)
    found = {f"links.{link.name}.inertia": _NEGLIGIBLE * least for link in light if link.inertia == 0.0}
    return found | {f"links.{link.name}.mass": _NEGLIGIBLE * min(masses) for link in light if link.mass == 0.0}


def check_lightness(tree: Tree, mechanism: Mechanism, q: Array) -> None:
    """Refuse a link without mass or moment of inertia that can move alone at q (n,): its acceleration has no value."""
    motion = _motion_alone(tree, mechanism, q)
    if motion is None:
        return
    way = np.abs(motion)
    moving = listed(name for name, rate in zip(tree.coordinates, way, strict=True) if rate > _INVOLVED * way.max())
    link = _moved(tree, q, _light(mechanism), motion)
    lacks = "mass" if link.mass == 0.0 else "moment of inertia about the plane's normal"
    problem = f"has no {lacks}, and can move while all masses rest ({moving})"
    raise InputError(mechanism.source, f'<link name="{link.name}">', f"{problem}; give its mass and inertia")


def first_alone(tree: Tree, mechanism: Mechanism, q: Array) -> int | None:
    """Return the first of the coordinates (nt, n) at which a link without mass or inertia can move alone, if any."""
    if not _light(mechanism):
        return None
    return next((k for k, one in enumerate(q) if _motion_alone(tree, mechanism, one) is not None), None)


def _motion_alone(tree: Tree, mechanism: Mechanism, q: Array) -> Array | None:
    """Return the motion (n,) in which nearly no mass moves at coordinates (n,), None if there is none."""
    if not (light := _light(mechanism)):
        return None
    ways = _open_ways(tree, q)
    masses = [link.mass for link in mechanism.links if link.mass > 0.0]
    if not len(ways):
        return None
    unit = min(masses, default=1.0)
    reference = np.full(len(tree.bodies.records), unit)
    real, alike = (
        _energy(tree, q, ways, *weights)
        for weights in (_real(tree, light), (reference, reference * _size(mechanism) ** 2))
    )
    values, axes = np.linalg.eigh(alike)
    scaled = axes / np.sqrt(np.maximum(values, _INDEPENDENT * values[-1]))
    shares, ends = np.linalg.eigh(scaled.T @ real @ scaled)
    return None if shares[0] > _ALONE else np.asarray(scaled @ ends[:, 0] @ ways)


def _light(mechanism: Mechanism) -> list[Link]:
    return [link for link in mechanism.links if link.mass == 0.0 or link.inertia == 0.0]


def _size(mechanism: Mechanism) -> float:
    return float(extent_of(joint_ends(mechanism.joints))) or 1.0


def _open_ways(tree: Tree, q: Array) -> Array:
    """Return independent motions (k, n) that drives and ideal joints leave open."""
    free = without(tree.joint_dofs, tree.driven_dofs)
    ways = np.zeros((len(free), tree.size))
    if not len(free):
        return ways
    closing = jacobian_at(tree.bodies, tree.loop_rows, q)[:, free]
    values, right = np.linalg.svd(closing)[1:] if len(closing) else (np.zeros(0), np.eye(len(free)))
    rank = int(np.count_nonzero(values > _INDEPENDENT * values.max(initial=0.0)))
    ways[:, free] = right
    return ways[rank:]


def _real(tree: Tree, light: list[Link]) -> tuple[Array, Array]:
    """Return mass and moment of inertia (nb,) of each body, without the negligible ones."""
    masses, inertias = tree.bodies.records["mass"].copy(), tree.bodies.records["inertia"].copy()
    for link in light:
        masses[tree.index[link.name]] *= link.mass > 0.0
        inertias[tree.index[link.name]] *= link.inertia > 0.0
    return masses, inertias


def _energy(tree: Tree, q: Array, ways: Array, masses: Array, inertias: Array) -> Array:
    """Compute the matrix (k, k) of the kinetic energy of motions (k, n) at coordinates q (n,)."""
    turns, speeds = _velocities(tree, q, ways)
    return np.einsum("iax,jax,a->ij", speeds, speeds, masses) + np.einsum("ia,ja,a->ij", turns, turns, inertias)


def _velocities(tree: Tree, q: Array, ways: Array) -> tuple[Array, Array]:
    """Return angular velocities (k, nb), and velocities of the mass centres (k, nb, 2), in motions (k, n)."""
    pose, vel = state_tables(tree.bodies, np.repeat(q[None], len(ways), axis=0), ways)
    x, y = tree.bodies.records["cx"], tree.bodies.records["cy"]
    c, s = pose[0, :, 3], pose[0, :, 4]
    arms, turns = np.column_stack([-(s * x + c * y), c * x - s * y]), vel[:, :, 0]
    return turns, vel[:, :, 1:3] + turns[:, :, None] * arms


def _moved(tree: Tree, q: Array, light: list[Link], way: Array) -> Link:
    """Return the link without mass or inertia that moves most."""
    turns, speeds = _velocities(tree, q, way[None])
    extent = max(tree.extent, 1e-300)
    return max(
        light,
        key=lambda link: float(
            np.hypot(*speeds[0, tree.index[link.name]]) + extent * abs(turns[0, tree.index[link.name]])
        ),
    )
