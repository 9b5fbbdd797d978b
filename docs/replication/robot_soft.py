"""Strain energy of the robot's bodies in its modes, and how far the platform moves in them."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np

from linkages.mechanics.flexible.rotation import TRIANGLE, rotations
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion
from linkages.three_rrr.modes import modes
from linkages.three_rrr.robot import changed
from replication.robot_runs import Array, results, robot

#: Lowest modes that are looked at, and every how many poses of the revolution.
COUNT, _EVERY = 12, 10


class Shares(NamedTuple):
    """Shares of cranks, couplers and platform in the strain energy of each mode, means over the revolution.

    `platform_moves` is the largest displacement of the platform's corners over that of the crank pins, a median.
    """

    crank: list[float]
    coupler: list[float]
    platform: list[float]
    platform_moves: list[float]


@cache
def held() -> Shares:
    """Look at the modes with held crank roots."""
    return _shares(results().model, 0)


@cache
def free() -> Shares:
    """Look at the elastic modes of the paper's 24 numbers, crank roots free."""
    return _shares(FiniteElementModel(changed(robot(), drives={"roots": "free"})), 3)


def energies(model: FiniteElementModel, state: RobotMotion, full: Array) -> Array:
    """Strain energies (N, 3) of all cranks, all couplers and the platform, of displacements (N, full) [J]."""
    found = np.zeros((len(state), 3))
    for link in model.links:
        u = link.gather(full, rotations(state.angles[:, link.angle]))
        found[:, link.angle % 2] += 0.5 * np.einsum("nei,ij,nej->n", u, link.beam.stiffness(), u)
    local = np.einsum("nij,nj->ni", rotations(state.x[:, 0], TRIANGLE), full[:, model.c.ravel()])
    found[:, 2] = 0.5 * np.einsum("ni,ij,nj->n", local, model.triangle.stiffness(), local)
    return found


def _shares(model: FiniteElementModel, zero: int) -> Shares:
    state = results().motion.part(slice(None, None, _EVERY))
    _, shapes = modes(model, state, COUNT)
    parts, ratios = [], []
    for k in range(zero, COUNT):
        full = model.expand(state, shapes[:, :, k])
        energy = energies(model, state, full)
        parts.append((energy / energy.sum(axis=1, keepdims=True)).mean(axis=0))
        corners, pins = (np.linalg.norm(full[:, dofs], axis=2).max(axis=1) for dofs in (model.c, model.b))
        ratios.append(float(np.median(corners / pins)))
    return Shares(*(column.tolist() for column in np.array(parts).T), ratios)


def listed(shares: Iterable[float]) -> str:
    """Write shares as per cents."""
    return ", ".join(f"{100.0 * share:.0f}" for share in shares) + " %"


def ratios(values: Iterable[float]) -> str:
    """Write ratios."""
    return ", ".join(f"{value:.2f}" for value in values)
