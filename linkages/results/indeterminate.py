"""Statically indeterminate forces and torques: reactions of redundant loops and gears."""

from __future__ import annotations

import math

import numpy as np

from linkages.arrays import Array
from linkages.planar.arrays import Arrays
from linkages.planar.closure import jacobian_at
from linkages.planar.contacts import WIDTH
from linkages.planar.kinematics import body_positions
from linkages.planar.reactions import joint_forces
from linkages.planar.workspace import make_workspace
from linkages.results.characteristics import effort_of
from linkages.results.trajectory import Trajectory
from linkages.system import System

_POSITIONS = 5  # number of examined positions of the motion
_NOTHING = 1e-6  # relative threshold of a quantity in self-balanced reactions


def indeterminate(system: System, arrays: Arrays, motion: Trajectory) -> tuple[str, ...]:
    """Name the columns whose values are statically indeterminate.

    If there are more closure rows than independent ones, some reactions balance each other without any load: the null
    space of the rows' transposed Jacobian. A quantity with a part in such reactions depends on assembly tolerances and
    on elasticity.

    Parameters
    ----------
    system : System
    arrays : Arrays
        `System.arrays`, or `System.ideal_arrays` for the motion with ideal joints.
    motion : Trajectory
        Motion with columns ``q.COORDINATE``.

    Returns
    -------
    tuple of str
        Columns of joints (``P.force``, ``P.fx``, ``P.fy``, ``P.moment``), drives and gears (``mesh.torque``,
        ``mesh.power``); empty for loops that are not redundant.
    """
    if arrays.rank == len(arrays.rows):
        return ()
    q = np.stack([motion[f"q.{name}"] for name in system.tree.coordinates], axis=1)
    found: dict[str, bool] = {}
    for line in q[np.linspace(0, len(q) - 1, _POSITIONS).astype(int)]:
        for reaction in _self_balanced(arrays, line):
            sizes = _sizes(system, arrays, line, reaction)
            largest = max(sizes.values())
            for column, size in sizes.items():
                found[column] = found.get(column, False) or size > _NOTHING * largest
    return tuple(column for column, part in found.items() if part)


def _self_balanced(arrays: Arrays, q: Array) -> Array:
    """Compute the self-balanced reactions of the rows, which load no free coordinate, as lines."""
    jacobian = jacobian_at(arrays.bodies, arrays.rows, q)[:, arrays.free]
    return np.linalg.svd(jacobian)[0].T[arrays.rank :]


def _sizes(system: System, arrays: Arrays, q: Array, reaction: Array) -> dict[str, float]:
    """Compute each column's magnitude under reactions alone [N]; moments over the linkage's length."""
    mechanism, gears = system.mechanism, system.experiment.gears
    work = make_workspace(len(arrays.bodies.records), len(q), len(arrays.rows), arrays.bodies.shapes.shape[2])
    body_positions(arrays.bodies, q, work.pose)
    work.reaction[:] = reaction
    forces, efforts = np.zeros((len(arrays.joints), 3)), np.zeros(len(arrays.driven) + len(arrays.powered))
    joint_forces(arrays, work, np.zeros((len(arrays.ends), WIDTH)), forces, efforts)
    sizes: dict[str, float] = {}
    for joint, (fx, fy, moment) in zip(mechanism.joints, np.abs(forces).tolist(), strict=True):
        each = {"fx": fx, "fy": fy, "force": math.hypot(fx, fy), "moment": moment / arrays.size}
        sizes |= {f"{joint.name}.{what}": size for what, size in each.items()}
    for name, effort in zip(system.tree.driven, np.abs(efforts).tolist(), strict=False):
        size = effort / arrays.size if mechanism.joint[name].type == "revolute" else effort
        sizes |= {f"{name}.torque": size, f"{name}.power": size}
    for name, effort in zip(gears, np.abs(reaction[len(reaction) - len(gears) :]).tolist(), strict=True):
        what = effort_of(system, "gears", name)
        size = effort / arrays.size if what == "torque" else effort
        sizes |= {f"{name}.{what}": size, f"{name}.power": size}
    return sizes
