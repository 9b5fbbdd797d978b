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
| ``GUIDE.offset, .tilt``                | of a block with play in its slot: across the slot, turned    | m, rad  |
| ``JOINT.power``                        | power that the force pair delivers, clearance joints         | W       |
| ``JOINT.torque``                       | drive torque (force), driven joints                          | N m (N) |
| ``JOINT.rate``                         | rate of the coordinate, driven joints                        | rad/s   |
| ``kinetic_energy``, ``potential_energy`` | of the whole linkage; weight and springs                   | J       |
| ``LOAD.fx, .fy, .force``               | applied force, plane axes, and its magnitude                 | N       |
| ``LOAD.torque``                        | applied torque; of a torsion spring, against its angle       | N m     |
| ``LOAD.force, .length``                | tension and length of a spring                               | N, m    |
| ``LOAD.angle``                         | angle of a torsion spring                                    | rad     |
| ``LOAD.power``                         | power that the load delivers to the linkage                  | W       |
| ``q.COORDINATE``                       | coordinate of the spanning tree: a joint's, or a floating link's | rad, m |

For a guide with play ``GUIDE.corner1`` to ``GUIDE.corner4`` have the columns of a contact each.
Vectors are in plane axes (see `linkages.model.mechanism`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.model.experiment import Experiment
from linkages.outputs.reactions import joint_reactions
from linkages.planar.kinematics import spread
from linkages.planar.loads import LOAD_OUTPUTS, load_history
from linkages.planar.motion import Motions
from linkages.system.loads import load_names, pack_loads
from linkages.system.tree import Tree

Array = NDArray[np.float64]
Columns = dict[str, Array]

#: Columns of the first two `LOAD_OUTPUTS` of each kind of load.
_LOAD_COLUMNS = {
    "forces": ("fx", "fy"),
    "torques": ("torque",),
    "springs": ("force", "length"),
    "torsion_springs": ("torque", "angle"),
}


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
    clearance : (nt, nc, WIDTH) array, optional
        `linkages.planar.contacts.CLEARANCE_OUTPUTS` of each contact, from the engine. Without it,
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
    applied = _loads(columns, tree, experiment, times, pose, vel)
    applied_torques = Motions([experiment.drives[name].torque_history() for name in tree.powered])(times)[0]
    torques = {name: applied_torques[:, i] for i, name in enumerate(tree.powered)}
    known = {}
    if clearance is not None:
        for k, (name, label) in enumerate(tree.contacts):
            _contact(columns, tree, experiment, k, clearance[:, k], pose, vel)
            if name == label:
                known[name] = (clearance[:, k, 2:4], clearance[:, k, 4])
        for name in tree.play:
            rows = [k for k, (owner, label) in enumerate(tree.contacts) if owner == name != label]
            if rows:
                known[name] = _guide(columns, tree, name, clearance[:, rows], pose)
    force, moment, needed = joint_reactions(tree, pose, vel, acc, gravity, known, torques, applied)
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
    for name in tree.mechanism.point:
        columns |= point_columns(tree, name, pose, vel, acc)


def point_columns(tree: Tree, name: str, pose: Array, vel: Array, acc: Array) -> Columns:
    """Columns of one link or frame, from what `linkages.planar.kinematics.spread` gives."""
    point = tree.mechanism.point[name]
    body = tree.index[point.link]
    x, y = tree.local(point.link, point.origin)
    c, s = pose[:, body, 3], pose[:, body, 4]
    rx, ry = c * x - s * y, s * x + c * y
    w, al = vel[:, body, 0], acc[:, body, 0]
    return {
        f"{name}.x": pose[:, body, 0] + rx,
        f"{name}.y": pose[:, body, 1] + ry,
        f"{name}.angle": pose[:, body, 2] + point.angle,
        f"{name}.vx": vel[:, body, 1] - w * ry,
        f"{name}.vy": vel[:, body, 2] + w * rx,
        f"{name}.omega": w.copy(),
        f"{name}.ax": acc[:, body, 1] - al * ry - w * w * rx,
        f"{name}.ay": acc[:, body, 2] + al * rx - w * w * ry,
        f"{name}.alpha": al.copy(),
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


def _loads(
    columns: Columns, tree: Tree, experiment: Experiment, times: Array, pose: Array, vel: Array
) -> Array:
    """Columns of the applied loads, what springs store, and their wrenches on the bodies (nt, nb, 3)."""
    names = load_names(experiment)
    wrench = np.zeros_like(vel)
    if not names:
        return wrench
    outputs = np.empty((len(times), len(names), len(LOAD_OUTPUTS)))
    load_history(pack_loads(tree, experiment), times, pose, vel, wrench, outputs)
    for (table, name), (value, second, power, energy) in zip(names, outputs.transpose(1, 2, 0), strict=True):
        for quantity, column in zip(_LOAD_COLUMNS[table], (value, second), strict=False):
            columns[f"{name}.{quantity}"] = column
        if table == "forces":
            columns[f"{name}.force"] = np.hypot(value, second)
        columns[f"{name}.power"] = power
        columns["potential_energy"] = columns["potential_energy"] + energy
    return wrench


def _contact(
    columns: Columns, tree: Tree, experiment: Experiment, k: int, output: Array, pose: Array, vel: Array
) -> None:
    """Columns of contact k; the pair's power is taken where its force acts, at the point on the inner body."""
    name, label = tree.contacts[k]
    model = experiment.joints[name]
    ex, ey, fx, fy, couple, penetration, closing, sliding, _ = output.T
    columns[f"{label}.ex"], columns[f"{label}.ey"] = ex, ey
    columns[f"{label}.eccentricity_ratio"] = 1.0 + penetration / model.clearance
    columns[f"{label}.force"] = np.hypot(fx, fy)
    if model.can_touch:
        columns[f"{label}.penetration"] = penetration
        columns[f"{label}.closing"], columns[f"{label}.sliding"] = closing, sliding
    end = tree.ends[k]
    inner, outer = int(end["journal"]), int(end["bearing"])
    rx, ry = _offset(pose, inner, end["jx"], end["jy"])
    sx, sy = rx + pose[:, inner, 0] - pose[:, outer, 0], ry + pose[:, inner, 1] - pose[:, outer, 1]
    wj, wb = vel[:, inner, 0], vel[:, outer, 0]
    vx = vel[:, inner, 1] - wj * ry - vel[:, outer, 1] + wb * sy
    vy = vel[:, inner, 2] + wj * rx - vel[:, outer, 2] - wb * sx
    columns[f"{label}.power"] = fx * vx + fy * vy + couple * (wj - wb)


def _guide(columns: Columns, tree: Tree, name: str, outputs: Array, pose: Array) -> tuple[Array, Array]:
    """Columns of a guide with play from those of its four corners; returns force and moment on its block."""
    joint = tree.mechanism.joint[name]
    labels = [label for owner, label in tree.contacts if owner == name]
    rows = [k for k, (owner, _) in enumerate(tree.contacts) if owner == name]
    force = outputs[:, :, 2:4].sum(axis=1)
    moment = np.zeros(len(force))
    inner = tree.index[joint.child]
    cx, cy = _offset(pose, inner, *tree.local(joint.child, joint.on_child))
    for i, k in enumerate(rows):
        rx, ry = _offset(pose, inner, tree.ends[k]["jx"], tree.ends[k]["jy"])
        moment += (rx - cx) * outputs[:, i, 3] - (ry - cy) * outputs[:, i, 2]
    columns[f"{name}.eccentricity_ratio"] = np.max(
        [columns[f"{x}.eccentricity_ratio"] for x in labels], axis=0
    )
    columns[f"{name}.power"] = np.sum([columns[f"{x}.power"] for x in labels], axis=0)
    outer = tree.index[joint.parent]
    nx, ny = _offset(pose, outer, -joint.direction[1], joint.direction[0])
    columns[f"{name}.offset"] = outputs[:, :, 0].mean(axis=1) * nx + outputs[:, :, 1].mean(axis=1) * ny
    columns[f"{name}.tilt"] = pose[:, inner, 2] - pose[:, outer, 2]
    return force, moment


def _offset(pose: Array, body: int, x: float, y: float) -> tuple[Array, Array]:
    """Turn a vector given in a body's frame into plane axes."""
    c, s = pose[:, body, 3], pose[:, body, 4]
    return c * x - s * y, s * x + c * y
