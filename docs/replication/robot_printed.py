"""Equations of Lu et al. (2010) as printed, to be compared with ours; section and equation numbers are the paper's.

Arrays over poses have the pose as their first axis; N poses, three legs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.mechanics.flexible.rotation import TRIANGLE, rotations
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import RobotMotion, pivots, turned
from linkages.three_rrr.response import Response
from linkages.three_rrr.robot import KINDS

Array = NDArray[np.floating]


def line(a: float, b: float, l1: float, theta: float, first: float, other: float) -> tuple[float, float, float]:
    """Coefficients a_j, b_j, c_j of a_j x + b_j y + c_j = 0, section 1.1, for the crank angles phi_1 and phi_j [rad].

    `a`, `b` and `l1` are the sides of base and platform and the crank's length [m].
    """
    along = 2 * b * np.cos(theta) - 2 * a - 2 * l1 * np.cos(other) + 2 * l1 * np.cos(first)
    across = 2 * b * np.sin(theta) - 2 * l1 * np.sin(other) + 2 * l1 * np.sin(first)
    rest = b**2 - 2 * a * b * np.cos(theta) - 2 * b * l1 * np.cos(other - theta) + a**2 + 2 * a * l1 * np.cos(other)
    return float(along), float(across), float(rest)


def leg_influence(geometry: Geometry, state: RobotMotion) -> tuple[Array, Array]:
    """First- and second-order influence coefficients of the legs, eqs. (3) and (5).

    Returns
    -------
    (N, 3, 3, 3), (N, 3, 3, 3, 3) arrays
        G[n, leg]: platform's rates (theta, x, y) per relative joint rate; H[n, leg, i, j]: the vector (theta, x, y) that goes with
        the product of the joint rates i and j.
    """
    b, c = pivots(geometry, state.phi, state.x)
    joints = np.stack([np.broadcast_to(geometry.base, b.shape), b, c], axis=2)
    arm = state.x[:, None, None, 1:] - joints
    ones, nones = np.ones((*arm.shape[:-1], 1)), np.zeros((*arm.shape[:-1], 1))
    first = np.swapaxes(np.concatenate([ones, turned(arm)], axis=-1), 2, 3)
    outer = np.maximum.outer(np.arange(3), np.arange(3))  # of both joints the one nearer to the platform
    return first, np.concatenate([nones, -arm], axis=-1)[:, :, outer]


def joint_rates(state: RobotMotion) -> Array:
    """Relative rates (N, 3, 3) of the joints A, B, C of each leg [rad/s]."""
    return np.stack([state.dphi, state.dpsi - state.dphi, state.dx[:, :1] - state.dpsi], axis=-1)


def accelerations(geometry: Geometry, state: RobotMotion) -> Array:
    """Platform's accelerations (N, 3) by eqs. (5)-(6), with the first row of G on the right too."""
    first, second = leg_influence(geometry, state)
    rates = joint_rates(state)
    quadratic = np.einsum("nli,nlj,nlijk->nlk", rates, rates, second)
    row = np.linalg.inv(first)[:, :, 0]
    return np.linalg.solve(row, (state.ddphi + np.einsum("nlk,nlk->nl", row, quadratic))[..., None])[..., 0]


def load(model: FiniteElementModel, state: RobotMotion) -> Array:
    """Generalised forces (N, full), section 2.2: the inertia with the other sign, the platform's translation left out.

    The moment M of the platform's load, which the virtual work lacks, is left out too.
    """
    robot = model.robot
    outside = model.full_load(state) - _inertia(model, state)
    if robot.load.moment:
        r = model.platform_arms(state)
        couple = robot.load.moment * turned(r) / np.sum(r**2, axis=(1, 2))[:, None, None]
        outside[:, model.c] -= couple
    printed = outside - _inertia(model, state)
    printed[:, model.c] -= model.triangle.total_mass / 3.0 * state.ddx[:, None, 1:]
    return printed


def _inertia(model: FiniteElementModel, state: RobotMotion) -> Array:
    """Inertia load -M a (N, full) of the rigid motion."""
    _, mass = model.full_matrices(state)
    return -np.einsum("nij,nj->ni", mass, model.rigid_acceleration(state))


def rod_stress(model: FiniteElementModel, response: Response) -> tuple[Array, Array]:
    """Axial stress and largest bending stress at each rod's ends (N, 6), section 3.3: the axial one lacks E, it is a strain.

    Both are derivatives of the shape functions, magnitudes.
    """
    state = response.motion
    displacement = model.expand(state, response.u)
    axial, bending = np.zeros((2, len(state), len(model.links)))
    for link in model.links:
        u = link.gather(displacement, rotations(state.angles[:, link.angle]))[:, 0]
        area, _ = model.robot.rod(KINDS[link.angle % 2])
        curvature = u @ link.beam.shapes(np.array([0.0, 1.0]))[2].T
        axial[:, link.angle] = np.abs(u[:, 3] - u[:, 0]) / link.beam.length
        bending[:, link.angle] = (
            model.robot.material.youngs_modulus * np.sqrt(area / np.pi) * np.abs(curvature).max(axis=1)
        )
    return axial, bending


def platform_stress(model: FiniteElementModel, response: Response) -> tuple[Array, Array, Array]:
    """First and second principal stress and largest shear (N,) of the platform, eq. (14) [Pa]: shear by E/(1 + nu^2)."""
    state, m = response.motion, model.robot.material
    corners = model.expand(state, response.u)[:, model.c.ravel()]
    local = np.einsum("nij,nj->in", rotations(state.x[:, 0], TRIANGLE), corners)
    elasticity = model.triangle.elasticity()
    elasticity[2, 2] = m.youngs_modulus / (1.0 + m.poisson**2)
    x, y, shear = elasticity @ model.triangle.strain_matrix() @ local
    middle, half = 0.5 * (x + y), np.hypot(0.5 * (x - y), shear)
    return middle + half, middle - half, half
