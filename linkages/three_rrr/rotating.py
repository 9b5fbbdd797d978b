"""Velocity-dependent terms of the elastic motion: gyroscopic, centrifugal and geometric stiffness.

The elastic displacement in a rod is u = R N R' U, with R the rod's rotation, N the shape functions and U in
plane axes. Its time derivatives at fixed U do not vanish, because axial and transverse shapes differ:

    Rdot-terms:  u_t = omega (S N + N D) R'U,   u_tt = (alpha (S N + N D) + omega^2 (-N + 2 S N D + N D^2))
    R'U

(S turns by 90 degrees, D does the opposite to the nodes' displacements.) This gives M U'' + G U' + (K + K_c
+ K_g) U = F with G = 2 omega int rho A N'(S N + N D). The triangle's shapes are alike along x and y: it has
no such terms. K_g comes from the rods' mean axial forces. The paper has none of these terms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.flexible.elements import Beam, geometric_stiffness
from linkages.three_rrr.kinematics import Motion, turned
from linkages.three_rrr.model import LinkElements, Model
from linkages.three_rrr.turning import angles, element_rotations

Array = NDArray[np.floating]


def element_terms(beam: Beam) -> tuple[Array, Array]:
    """Matrices (6, 6) of an element [kg]: of omega (half of G; alpha's share of K_c), of omega^2."""
    s, weight = beam.quadrature()
    n = beam.shapes(s)[0]
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    d = np.zeros((6, 6))
    for i in (0, 3):
        d[i : i + 2, i : i + 2] = -quarter
    first = quarter @ n + n @ d
    second = -n + 2.0 * quarter @ n @ d + n @ d @ d
    density = beam.line_density
    return (
        density * np.einsum("q,qci,qcj->ij", weight, n, first),
        density * np.einsum("q,qci,qcj->ij", weight, n, second),
    )


def mean_tension(link: LinkElements, full: Array, rotation: Array) -> Array:
    """Mean axial force (N, n) in each element of a link for displacements (N, full) [N]."""
    local = np.einsum("nij,nej->nei", rotation, gather(link, full))
    return link.beam.axial / link.beam.length * (local[..., 3] - local[..., 0])


def gather(link: LinkElements, full: Array) -> Array:
    """Displacements (N, n, 6) of a link's elements in plane axes; zero where the base holds them."""
    return np.where(link.dofs < 0, 0.0, full[:, np.maximum(link.dofs, 0)])


def velocity_terms(model: Model, state: Motion, tension_from: Array | None = None) -> tuple[Array, Array]:
    """Matrices G and K_c + K_g (N, size, size) of the unknowns.

    Parameters
    ----------
    tension_from : (N, size) array, optional
        Displacements whose axial forces give K_g, usually the quasi-static ones; without them K_g is left
        out.
    """
    count = len(state)
    gyro, stiff = np.zeros((2, count, model.full, model.full))
    angle = angles(state)
    speed = np.stack([state.dphi, state.dpsi], axis=-1).reshape(count, 6)
    rate = np.stack([state.ddphi, state.ddpsi], axis=-1).reshape(count, 6)
    full = None if tension_from is None else model.expand(state, tension_from)
    for link in model.links:
        rotation = element_rotations(angle[:, link.angle])
        back = np.swapaxes(rotation, 1, 2)
        once, twice = (back @ matrix @ rotation for matrix in element_terms(link.beam))
        omega, alpha = speed[:, link.angle, None, None], rate[:, link.angle, None, None]
        stretch = back @ geometric_stiffness(link.beam) @ rotation
        tension = None if full is None else mean_tension(link, full, rotation)
        for index, dofs in enumerate(link.dofs):
            held = dofs >= 0
            at = np.ix_(np.arange(count), dofs[held], dofs[held])
            inside = np.ix_(np.arange(count), held, held)
            gyro[at] += (2.0 * omega * once)[inside]
            stiff[at] += (alpha * once + omega**2 * twice)[inside]
            if tension is not None:
                stiff[at] += (tension[:, index, None, None] * stretch)[inside]
    return _reduced(model, state, gyro, stiff)


def _reduced(model: Model, state: Motion, gyro: Array, stiff: Array) -> tuple[Array, Array]:
    """Matrices on the unknowns; the arms of a rigid platform turn with it and add terms of their own."""
    if not model.rigid:
        grid = np.ix_(np.arange(len(state)), model.kept, model.kept)
        return gyro[grid], stiff[grid]
    _, mass = model.full_matrices(state)
    g = model.reduction(state)
    r = model.platform_arms(state)
    once, twice = np.zeros_like(g), np.zeros_like(g)
    for axis in range(2):
        once[:, model.c[:, axis], -3] = -r[..., axis]
        twice[:, model.c[:, axis], -3] = -turned(r)[..., axis]
    omega, alpha = state.dx[:, 0, None, None], state.ddx[:, 0, None, None]
    back = np.swapaxes(g, 1, 2)
    first, second = omega * once, alpha * once + omega**2 * twice
    return back @ (2.0 * mass @ first + gyro @ g), back @ (mass @ second + gyro @ first + stiff @ g)
