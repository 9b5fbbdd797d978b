"""Velocity-dependent terms of the elastic motion: gyroscopic, centrifugal and geometric stiffness.

They make the equations M U'' + G U' + (K + K_c + K_g) U = F. G and K_c come from the rotation of the rods (see
`linkages.mechanics.flexible.beam.Beam.velocity_terms`), K_g from their mean axial forces. The triangle's shapes are
alike along x and y, so that it has no such terms. The paper has none of them.
"""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.mechanics.flexible.rotation import rotations
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion, legwise, turned


def velocity_terms(
    model: FiniteElementModel, state: RobotMotion, tension_from: Array | None = None
) -> tuple[Array, Array]:
    """Matrices G and K_c + K_g (N, size, size) of the unknowns.

    K_g follows from the axial forces of displacements (N, size), usually the quasi-static ones; without them it is left
    out.
    """
    count = len(state)
    gyro, stiff = np.zeros((2, count, model.full, model.full))
    speed, rate = legwise(state.dphi, state.dpsi), legwise(state.ddphi, state.ddpsi)
    full = None if tension_from is None else model.expand(state, tension_from)
    for link in model.links:
        rotation = rotations(state.angles[:, link.angle])
        back = np.swapaxes(rotation, 1, 2)
        once, twice = (back @ matrix @ rotation for matrix in link.beam.velocity_terms())
        omega, alpha = speed[:, link.angle, None, None], rate[:, link.angle, None, None]
        stretch = back @ link.beam.geometric_stiffness() @ rotation
        u = None if full is None else link.gather(full, rotation)
        for index, dofs in enumerate(link.dofs):
            held = dofs >= 0
            at = np.ix_(np.arange(count), dofs[held], dofs[held])
            inside = np.ix_(np.arange(count), held, held)
            gyro[at] += (2.0 * omega * once)[inside]
            stiff[at] += (alpha * once + omega**2 * twice)[inside]
            if u is not None:
                tension = link.beam.axial / link.beam.length * (u[:, index, 3] - u[:, index, 0])
                stiff[at] += (tension[:, None, None] * stretch)[inside]
    return _reduced(model, state, gyro, stiff)


def _reduced(model: FiniteElementModel, state: RobotMotion, gyro: Array, stiff: Array) -> tuple[Array, Array]:
    """Assemble the matrices of the unknowns; the arms of a rigid platform rotate with it and add terms."""
    if not model.rigid:
        grid = np.ix_(np.arange(len(state)), model.kept, model.kept)
        return gyro[grid], stiff[grid]
    _, mass = model.full_matrices(state)
    g = model.reduction(state)
    r = model.platform_arms(state)
    once, twice = np.zeros_like(g), np.zeros_like(g)
    once[:, model.c, -3] = -r
    twice[:, model.c, -3] = -turned(r)
    omega, alpha = state.dx[:, 0, None, None], state.ddx[:, 0, None, None]
    back = np.swapaxes(g, 1, 2)
    first, second = omega * once, alpha * once + omega**2 * twice
    return back @ (2.0 * mass @ first + gyro @ g), back @ (mass @ second + gyro @ first + stiff @ g)
