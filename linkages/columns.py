"""From states to named columns: every quantity of a run that can be reported, plotted or saved.

| name                                   | what it is                                                   | unit    |
|----------------------------------------|--------------------------------------------------------------|---------|
| ``POINT.x, .y, .angle``                | position of a link's or frame's origin, angle of its x axis  | m, rad  |
| ``POINT.vx, .vy, .omega``              | their rates                                                  | m/s     |
| ``POINT.ax, .ay, .alpha``              | their accelerations                                          | m/s2    |
| ``JOINT.fx, .fy, .force``              | force on the joint's child (the journal), and its magnitude  | N       |
| ``JOINT.moment``                       | moment on the child about the joint, drive torque excluded   | N m     |
| ``JOINT.ex, .ey``                      | eccentricity vector, clearance joints                        | m       |
| ``JOINT.eccentricity_ratio``           | its length over the clearance                                | 1       |
| ``JOINT.penetration``                  | length of e less c, joints that can touch                   | m       |
| ``JOINT.closing, .sliding``            | rate of that length, sliding speed of the journal's surface | m/s     |
| ``JOINT.power``                        | power that the force pair delivers, clearance joints         | W       |
| ``JOINT.torque``                       | drive torque (force), driven joints                          | N m (N) |
| ``JOINT.rate``                         | rate of the coordinate, driven joints                        | rad/s   |
| ``kinetic_energy``, ``potential_energy`` | of the whole linkage                                       | J       |
| ``q.COORDINATE``                       | coordinate of the spanning tree: a joint's, or a floating link's | rad, m |

Vectors are in plane axes (see `linkages.mechanism`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.experiment import Experiment
from linkages.planar.dynamics import spread
from linkages.planar.reactions import joint_reactions
from linkages.planar.topology import Tree

Array = NDArray[np.float64]
Columns = dict[str, Array]


def columns_from_states(
    tree: Tree,
    experiment: Experiment,
    times: Array,
    q: Array,
    v: Array,
    a: Array,
    clearance: Array | None = None,
    drive: Array | None = None,
) -> Columns:
    """Compute all columns.

    Parameters
    ----------
    times : (nt,) array
    q, v, a : (nt, n) arrays
        Coordinates of the tree, their rates and accelerations.
    clearance : (nt, nj, WIDTH) array, optional
        `linkages.planar.clearance.CLEARANCE_OUTPUTS` of each clearance joint, from the engine. Without it,
        the tree's clearance joints are taken as ideal, and their reactions computed.
    drive : (nt, nd) array, optional
        Drive torques from the engine; without it they are computed with the reactions.
    """
    nt, nb = len(times), len(tree.bodies)
    pose, vel, acc = np.empty((nt, nb, 5)), np.empty((nt, nb, 3)), np.empty((nt, nb, 3))
    spread(tree.bodies, q, v, a, pose, vel, acc)
    columns: Columns = {"time": times}
    columns |= {f"q.{name}": q[:, i] for i, name in enumerate(tree.coordinates)}
    _points(columns, tree, pose, vel, acc)
    gravity = tree.mechanism.basis[:, :2].T @ np.array(experiment.gravity)
    _energies(columns, tree, pose, vel, gravity)
    torques = {name: experiment.drives[name].torque_history()(times) for name in tree.powered}
    known = {}
    if clearance is not None:
        for k, name in enumerate(tree.play):
            known[name] = (clearance[:, k, 2:4], clearance[:, k, 4])
            _clearance(columns, tree, experiment, name, clearance[:, k], pose, vel)
    force, moment, needed = joint_reactions(tree, pose, vel, acc, gravity, known, torques)
    for name in force:
        columns[f"{name}.fx"], columns[f"{name}.fy"] = force[name].T
        columns[f"{name}.force"] = np.hypot(*force[name].T)
        columns[f"{name}.moment"] = moment[name]
    for k, name in enumerate(tree.driven):
        columns[f"{name}.torque"] = needed[name] if drive is None else drive[:, k]
    for name, torque in torques.items():
        columns[f"{name}.torque"] = torque
    for name in (*tree.driven, *tree.powered):
        columns[f"{name}.rate"] = v[:, tree.coordinates.index(name)]
    return columns


def _points(columns: Columns, tree: Tree, pose: Array, vel: Array, acc: Array) -> None:
    for point in tree.mechanism.point.values():
        body = tree.index[point.link]
        x, y = tree.local(point.link, point.origin)
        c, s = pose[:, body, 3], pose[:, body, 4]
        rx, ry = c * x - s * y, s * x + c * y
        w, al = vel[:, body, 0], acc[:, body, 0]
        columns |= {
            f"{point.name}.x": pose[:, body, 0] + rx,
            f"{point.name}.y": pose[:, body, 1] + ry,
            f"{point.name}.angle": pose[:, body, 2] + point.angle,
            f"{point.name}.vx": vel[:, body, 1] - w * ry,
            f"{point.name}.vy": vel[:, body, 2] + w * rx,
            f"{point.name}.omega": w.copy(),
            f"{point.name}.ax": acc[:, body, 1] - al * ry - w * w * rx,
            f"{point.name}.ay": acc[:, body, 2] + al * rx - w * w * ry,
            f"{point.name}.alpha": al.copy(),
        }


def _energies(columns: Columns, tree: Tree, pose: Array, vel: Array, gravity: Array) -> None:
    bodies = tree.bodies
    c, s = pose[..., 3], pose[..., 4]
    cx, cy = c * bodies["cx"] - s * bodies["cy"], s * bodies["cx"] + c * bodies["cy"]
    vx, vy = vel[..., 1] - vel[..., 0] * cy, vel[..., 2] + vel[..., 0] * cx
    kinetic = 0.5 * (bodies["mass"] * (vx * vx + vy * vy) + bodies["inertia"] * vel[..., 0] ** 2)
    height = gravity[0] * (pose[..., 0] + cx) + gravity[1] * (pose[..., 1] + cy)
    columns["kinetic_energy"] = kinetic.sum(axis=1)
    columns["potential_energy"] = -(bodies["mass"] * height).sum(axis=1)


def _clearance(
    columns: Columns, tree: Tree, experiment: Experiment, name: str, output: Array, pose: Array, vel: Array
) -> None:
    """Columns of one clearance joint; the pair's power is taken where its force acts, at the journal's centre."""
    joint = tree.mechanism.joint[name]
    model = experiment.joints[name]
    ex, ey, fx, fy, couple, closing, sliding, _ = output.T
    columns[f"{name}.ex"], columns[f"{name}.ey"] = ex, ey
    columns[f"{name}.eccentricity_ratio"] = np.hypot(ex, ey) / model.clearance
    if model.can_touch:
        columns[f"{name}.penetration"] = np.hypot(ex, ey) - model.clearance
        columns[f"{name}.closing"], columns[f"{name}.sliding"] = closing, sliding
    rate = []
    at = None
    for link, point in ((joint.child, joint.on_child), (joint.parent, joint.on_parent)):
        body = tree.index[link]
        if at is None:
            x, y = tree.local(link, point)
            c, s = pose[:, body, 3], pose[:, body, 4]
            at = pose[:, body, 0] + c * x - s * y, pose[:, body, 1] + s * x + c * y
        w = vel[:, body, 0]
        rate.append(
            (
                w,
                vel[:, body, 1] - w * (at[1] - pose[:, body, 1]),
                vel[:, body, 2] + w * (at[0] - pose[:, body, 0]),
            )
        )
    (wj, xj, yj), (wb, xb, yb) = rate
    columns[f"{name}.power"] = fx * (xj - xb) + fy * (yj - yb) + couple * (wj - wb)
