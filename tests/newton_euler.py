"""Reactions of all joints by Newton-Euler on free bodies, in absolute coordinates.

Independent of the package's recursion over its tree: for every body, mass times acceleration = applied wrench +
reactions. The equations are linear in the reactions and drive forces; redundant reactions (of a linkage with more
constraints than it needs) come out with the smallest norm.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from linkages import System
from linkages.elements.machine import add_elements
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS
from linkages.mechanics.planar.kinematics import body_accelerations, body_states
from linkages.mechanics.planar.loads import load_wrenches
from linkages.system.tree import Tree

Array = NDArray[np.float64]
Forces = tuple[dict[str, Array], dict[str, Array], dict[str, Array]]


def free_bodies(system: System, times: Array, q: Array, v: Array, a: Array, contacts: Array | None = None) -> Forces:
    """Forces, moments and drive forces of `joint_reactions` at states of a system.

    Parameters
    ----------
    q, v, a : (nt, n) arrays
        Coordinates of the system's tree, their rates and accelerations.
    contacts : (nt, nc, WIDTH) array, optional
        `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS`; without it clearance joints count as ideal.
    """
    tree, (nt, nb) = system.tree, (len(times), len(system.tree.bodies.records))
    pose, vel, acc, applied = (np.zeros((nt, nb, width)) for width in (5, 3, 3, 3))
    for i, t in enumerate(times):
        body_states(tree.bodies, q[i], v[i], pose[i], vel[i])
        body_accelerations(tree.bodies, pose[i], vel[i], v[i], a[i], acc[i])
        load_wrenches(system.loads, t, np.zeros(0), pose[i], vel[i], applied[i])
        add_elements(system.elements, system.loads[1:], t, np.zeros(0), pose[i], vel[i], applied[i])
    known = {} if contacts is None else {name: _of_contacts(tree, name, pose, contacts) for name in tree.play}
    torques = dict(zip(tree.powered, system.torques(times)[0].T, strict=True))
    return joint_reactions(tree, pose, vel, acc, system.gravity, known, torques, applied)


def _of_contacts(tree: Tree, name: str, pose: Array, contacts: Array) -> tuple[Array, Array]:
    """Force (nt, 2) and moment (nt,) of a clearance joint on its child, at the joint on the child."""
    fx, fy, couple = (CLEARANCE_OUTPUTS.index(what) for what in ("fx", "fy", "couple"))
    joint = tree.mechanism.joint[name]
    child, *at = tree.marker(joint.child, joint.on_child)
    force, moment = np.zeros((len(pose), 2)), np.zeros(len(pose))
    for k, (owner, _) in enumerate(tree.contacts):
        if owner == name:
            corner = tree.ends[k]["journal"]
            arm = _turned(pose[:, child], np.array([corner["x"], corner["y"]]) - at)
            f = contacts[:, k, [fx, fy]]
            force += f
            moment += contacts[:, k, couple] + arm[:, 0] * f[:, 1] - arm[:, 1] * f[:, 0]
    return force, moment


def joint_reactions(
    tree: Tree,
    pose: Array,
    vel: Array,
    acc: Array,
    gravity: Array,
    known: Mapping[str, tuple[Array, Array]],
    torques: Mapping[str, Array],
    applied: Array,
) -> Forces:
    """Solve for the reactions of every joint whose force is not known.

    Parameters
    ----------
    pose, vel, acc : (nt, nb, 5), (nt, nb, 3), (nt, nb, 3) arrays
        Body poses, velocities and accelerations.
    gravity : (2,) array
    known : mapping
        Joint name to force (nt, 2) and couple (nt,) on its child at the joint on the child: clearance joints.
    torques : mapping
        Applied drive torque or force (nt,) of each powered joint. Those of the tree's driven joints are solved for.
    applied : (nt, nb, 3) array
        Wrenches of all other loads on the bodies.

    Returns
    -------
    force : dict of (nt, 2) arrays
        Force on each joint's child, plane axes [N].
    moment : dict of (nt,) arrays
        Moment on each joint's child about the joint on the child, drives not included [N m].
    drive : dict of (nt,) arrays
        Drive force [N] or torque [N m] along each driven joint's coordinate.
    """
    nt, nb = pose.shape[:2]
    rhs = _inertial_wrench(tree, pose, vel, acc, gravity) - applied
    columns: list[Array] = []
    owners: list[tuple[str, str, Array]] = []

    def add(kind: str, name: str, moment: float, force: Array) -> None:
        """One unknown: a unit moment and a force field (nt, 2) on the child at the joint, opposite on the parent."""
        columns.append(_pair_wrench(tree, name, pose, force, np.full(nt, moment)))
        owners.append((kind, name, force))

    for joint in tree.mechanism.joints:
        parent = pose[:, tree.index[joint.parent]]
        if joint.name in known:
            force, couple = known[joint.name]
            rhs = rhs - _pair_wrench(tree, joint.name, pose, force, couple)
        along = _turned(parent, joint.direction) if joint.type == "prismatic" else np.tile([1.0, 0.0], (nt, 1))
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        if joint.name not in known:
            add("force", joint.name, 0.0, across)
        if joint.type != "prismatic" and joint.name not in known:
            add("force", joint.name, 0.0, along)
        if joint.type != "revolute" and joint.name not in known:
            add("moment", joint.name, 1.0, np.zeros((nt, 2)))
        moment, push = (joint.sign, 0.0 * along) if joint.type == "revolute" else (0.0, along)
        if joint.name in tree.driven:
            add("drive", joint.name, moment, push)
        if joint.name in torques:
            torque = torques[joint.name]
            rhs = rhs - _pair_wrench(tree, joint.name, pose, push * torque[:, None], moment * torque)
    force_out = {j.name: np.zeros((nt, 2)) for j in tree.mechanism.joints}
    moment_out = {j.name: np.zeros(nt) for j in tree.mechanism.joints}
    drive_out = {name: np.zeros(nt) for name in tree.driven}
    for name, (force, couple) in known.items():
        force_out[name], moment_out[name] = force, couple
    if not columns:  # every force is known already
        return force_out, moment_out, drive_out
    real = [i for i in range(1, nb) if tree.bodies.records[i]["mass"] > 0.0]
    matrix = np.stack(columns, axis=-1)[:, real].reshape(nt, 3 * len(real), len(columns))
    sizes = _solve(matrix, rhs[:, real].reshape(nt, -1))
    for column, (kind, name, force) in enumerate(owners):
        size = sizes[:, column]
        if kind == "force":
            force_out[name] += size[:, None] * force
        elif kind == "moment":
            moment_out[name] += size
        else:
            drive_out[name] = size
    return force_out, moment_out, drive_out


def _solve(matrix: Array, rhs: Array) -> Array:
    """Smallest-norm solutions (nt, nu) of a stack of linear systems."""
    rows, unknowns = matrix.shape[1:]
    if rows == unknowns:
        scale = np.abs(matrix).max(axis=(1, 2), keepdims=True)
        condition = np.linalg.cond(matrix[:1] / scale[:1])
        if np.all(condition < 1e10):
            try:
                return np.asarray(np.linalg.solve(matrix, rhs[..., None])[..., 0], dtype=np.float64)
            except np.linalg.LinAlgError:
                pass
    return np.einsum("tij,tj->ti", np.linalg.pinv(matrix, rcond=1e-12), rhs)


def _turned(pose: Array, vector: Array) -> Array:
    """Turn a vector given in a body's frame into plane axes (nt, 2)."""
    c, s = pose[:, 3], pose[:, 4]
    return np.stack([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]], axis=1)


def _pair_wrench(tree: Tree, name: str, pose: Array, force: Array, couple: Array) -> Array:
    """Wrenches (nt, nb, 3) of a force at the joint on the child and a couple, opposite on the parent."""
    joint = tree.mechanism.joint[name]
    child, parent = tree.index[joint.child], tree.index[joint.parent]
    wrench = np.zeros((*pose.shape[:2], 3))
    at = pose[:, child, :2] + _turned(pose[:, child], np.array(tree.marker(joint.child, joint.on_child)[1:]))
    for body, sign in ((child, 1.0), (parent, -1.0)):
        arm = at - pose[:, body, :2]
        wrench[:, body, 0] += sign * (couple + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])
        wrench[:, body, 1:] += sign * force
    return wrench


def _inertial_wrench(tree: Tree, pose: Array, vel: Array, acc: Array, gravity: Array) -> Array:
    """Rate of change of momentum less weight, as wrenches (nt, nb, 3) about the body frames' origins."""
    mass, inertia = tree.bodies.records["mass"], tree.bodies.records["inertia"]
    c, s = pose[..., 3], pose[..., 4]
    cx = c * tree.bodies.records["cx"] - s * tree.bodies.records["cy"]
    cy = s * tree.bodies.records["cx"] + c * tree.bodies.records["cy"]
    w, al = vel[..., 0], acc[..., 0]
    fx = mass * (acc[..., 1] - al * cy - w * w * cx - gravity[0])
    fy = mass * (acc[..., 2] + al * cx - w * w * cy - gravity[1])
    return np.stack([inertia * al + cx * fy - cy * fx, fx, fy], axis=-1)
