"""Stress along the links and in the platform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.mechanics.flexible.rotation import TRIANGLE, rotations
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.response import Response
from linkages.three_rrr.robot import KINDS


@dataclass(frozen=True)
class LinkStress:
    """Internal forces and stress along one link; tension is positive.

    Attributes
    ----------
    name : str
    s : (P,) array
        Distance from the link's first pivot [m].
    force : (N, P) array
        Axial force [N].
    moment : (N, P) array
        Bending moment E I v'' [N m].
    axial : (N, P) array
        Axial stress [Pa].
    bending : (N, P) array
        Bending stress at the side of +v [Pa].
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
    """Uniform stress in the triangle, (N,) arrays [Pa]: normal along the platform's axes, shear, principal."""

    x: Array
    y: Array
    shear: Array
    first: Array
    second: Array
    largest_shear: Array


def link_stress(model: FiniteElementModel, response: Response, points: int = 17) -> list[LinkStress]:
    """Stress in all six links, at `points` places in each element.

    Internal forces follow from equilibrium within each element, see
    `linkages.mechanics.flexible.beam.Beam.internal_forces`. They are exact for quasi-static loads with one element in
    each link. The paper's section 3.3 takes the shape functions' derivatives alone, and lacks E in the axial part.
    Rayleigh's damping takes part in the equilibrium: its part of the stiffness as stress, its part of the mass as load.
    """
    state, damping = response.motion, model.robot.damping
    displacement = _strained(model, response)
    loaded = response.a + damping.mass * response.v
    acceleration = model.rigid_acceleration(state) + model.expand(state, loaded)
    result = []
    for link in model.links:
        beam, count = link.beam, len(link.dofs)
        rotation = rotations(state.angles[:, link.angle])
        x = np.linspace(0.0, beam.length, points)
        force, moment = beam.internal_forces(
            link.gather(displacement, rotation), link.gather(acceleration, rotation), x
        )
        shape = len(state), count * points
        force, moment = force.reshape(shape), moment.reshape(shape)
        area, inertia = model.robot.rod(KINDS[link.angle % 2])
        half = np.sqrt(area / np.pi)
        place = (beam.length * np.arange(count)[:, None] + x).ravel()
        result.append(LinkStress(link.name, place, force, moment, force / area, -moment * half / inertia))
    return result


def _strained(model: FiniteElementModel, response: Response) -> Array:
    """Displacements (N, full) under which the undamped material has the stress of the damped one, u + beta u'."""
    return model.expand(response.motion, response.u + model.robot.damping.stiffness * response.v)


def platform_stress(model: FiniteElementModel, response: Response) -> PlatformStress:
    """Stress in the platform, eq. (14) with the shear modulus E/(2 (1 + nu)), which is misprinted there.

    InputError if the platform is rigid.
    """
    if model.rigid:
        raise InputError(model.robot.source, "model.platform", 'is "rigid" and has no stress; use "triangle"')
    state = response.motion
    corners = _strained(model, response)[:, model.c.ravel()]
    local = np.einsum("nij,nj->in", rotations(state.x[:, 0], TRIANGLE), corners)
    x, y, shear = model.triangle.elasticity() @ model.triangle.strain_matrix() @ local
    middle, half = 0.5 * (x + y), np.hypot(0.5 * (x - y), shear)
    return PlatformStress(x, y, shear, middle + half, middle - half, half)
