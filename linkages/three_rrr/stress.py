"""Stress along the links and in the platform.

Within an element the load is known, so internal forces follow from statics: the end forces are k u - f, and
the distributed inertia load of the linear acceleration field is integrated from the first node. This is
exact for quasi-static loads with one element per link; the derivatives of the shape functions alone (the
paper's section 3.3, which also lacks E in the axial part) would give a bending moment that is linear along
the rod.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError
from linkages.three_rrr.kinematics import Motion
from linkages.three_rrr.model import LinkElements, Model
from linkages.three_rrr.response import Response
from linkages.three_rrr.rotating import gather
from linkages.three_rrr.turning import angles, element_rotations

Array = NDArray[np.floating]


@dataclass(frozen=True)
class LinkStress:
    """Internal forces and stress along one link.

    Attributes
    ----------
    s : (P,) array
        Distance from the link's first pivot [m].
    force, moment : (N, P) arrays
        Axial force, positive in tension [N]; bending moment E I v'' [N m].
    axial, bending : (N, P) arrays
        Axial stress; bending stress at the side of +v, positive in tension [Pa].
    """

    name: str
    s: Array
    force: Array
    moment: Array
    axial: Array
    bending: Array

    @property
    def largest(self) -> Array:
        """Largest stress magnitude over the section (N, P) [Pa]."""
        return np.abs(self.axial) + np.abs(self.bending)

    @property
    def fibre(self) -> Array:
        """Stress in the outer fibre at the side of +v (N, P) [Pa]."""
        return self.axial + self.bending


@dataclass(frozen=True)
class PlatformStress:
    """Stress in the triangle, uniform: (N,) arrays [Pa]; x', y' are the platform's axes."""

    x: Array
    y: Array
    shear: Array
    first: Array
    second: Array
    largest_shear: Array


def link_stress(model: Model, response: Response, points: int = 17) -> list[LinkStress]:
    """Stress in all six links, at `points` places in each element."""
    state = response.motion
    displacement = model.expand(state, response.u)
    acceleration = model.rigid_acceleration(state) + model.expand(state, response.a)
    angle = angles(state)
    result = []
    for link in model.links:
        rotation = element_rotations(angle[:, link.angle])
        u = np.einsum("nij,nej->nei", rotation, gather(link, displacement))
        a = np.einsum("nij,nej->nei", rotation, gather(link, acceleration))
        result.append(_along(model, link, u, a, points))
    return result


def _along(model: Model, link: LinkElements, u: Array, a: Array, points: int) -> LinkStress:
    beam, count = link.beam, len(link.dofs)
    length = beam.length
    # loads per length, linear over the element, at its two ends: along, across; and a uniform couple
    ends = -beam.line_density * a.reshape(*a.shape[:2], 2, 3)[..., :2]
    couple = -beam.rotary * 0.5 * (a[..., 2] + a[..., 5])
    s, weight = beam.quadrature()
    shapes, turning, _ = beam.shapes(s)
    linear = np.stack([1.0 - s, s], axis=1)
    consistent = np.einsum("q,qci,qk,nekc->nei", weight, shapes, linear, ends)
    consistent += couple[..., None] * (weight @ turning)
    force_end = np.einsum("ij,nej->nei", beam.stiffness(), u) - consistent
    x = np.linspace(0.0, length, points)
    first, slope = ends[..., 0, :, None], (ends[..., 1, :, None] - ends[..., 0, :, None]) / length
    gathered = first * x + slope * x**2 / 2.0
    lever = first[..., 1, :] * x**2 / 2.0 + slope[..., 1, :] * x**3 / 6.0
    force = -force_end[..., 0, None] - gathered[..., 0, :]
    moment = -force_end[..., 2, None] + force_end[..., 1, None] * x + lever - couple[..., None] * x
    area, inertia = model.robot.rod("crank" if link.name.startswith("crank") else "coupler")
    half = np.sqrt(area / np.pi)
    shape = len(u), count * points
    force, moment = force.reshape(shape), moment.reshape(shape)
    place = (length * np.arange(count)[:, None] + x).ravel()
    return LinkStress(link.name, place, force, moment, force / area, -moment * half / inertia)


def platform_stress(model: Model, response: Response) -> PlatformStress:
    """Stress in the platform, eq. (14) with the right shear modulus.

    Raises
    ------
    InputError
        If the platform is rigid.
    """
    if model.rigid:
        raise InputError(model.robot.source, "model.platform", 'is "rigid" and has no stress; use "triangle"')
    state: Motion = response.motion
    corners = model.expand(state, response.u)[:, model.c.ravel()].reshape(-1, 3, 2)
    c, s = np.cos(state.x[:, 0]), np.sin(state.x[:, 0])
    back = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], axis=1)
    local = np.einsum("nij,nkj->nki", back, corners).reshape(-1, 6)
    x, y, shear = model.triangle.elasticity() @ model.triangle.strain_matrix() @ local.T
    middle, half = 0.5 * (x + y), np.hypot(0.5 * (x - y), shear)
    return PlatformStress(x, y, shear, middle + half, middle - half, half)
