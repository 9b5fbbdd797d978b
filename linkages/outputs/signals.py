"""Scalar outputs of a state, by the names of `linkages.outputs.columns`, in compiled code.

| name                                                              | of what                                        |
|-------------------------------------------------------------------|------------------------------------------------|
| ``POINT.x, .y, .angle, .vx, .vy, .omega, .ax, .ay, .alpha``       | links and frames                               |
| ``POINT.<quantity>.jitter``                                       | its deviation from the ideal linkage's value   |
| ``JOINT.fx, .fy, .force``                                         | any joint: force on its child [N]              |
| ``JOINT.ex, .ey, .eccentricity_ratio, .penetration, .closing, .sliding`` | joints with play                        |
| ``JOINT.film_thickness``                                          | clearance less eccentricity [m]                |
| ``JOINT.torque, .rate, .power``                                   | drives                                         |
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, nearest
from linkages.kernel import kernel
from linkages.model.experiment import QUANTITIES, Experiment
from linkages.planar.contacts import CLEARANCE_OUTPUTS
from linkages.planar.dynamics import inertial_load
from linkages.planar.kinematics import add_row_wrench, point_offset
from linkages.planar.records import REVOLUTE
from linkages.planar.tangent import transmitted
from linkages.system.tree import Tree

Array = NDArray[np.float64]

JITTER = ".jitter"

SIGNAL = np.dtype(
    (
        np.record,
        [
            ("kind", "i8"),
            ("what", "i8"),  # quantity of the kind
            ("at", "i8"),  # body, contact, first row
            ("dof", "i8"),
            ("jitter", "i8"),
            ("sign", "f8"),
            ("x", "f8"),  # point in the body's frame, or constants
            ("y", "f8"),
        ],
    )
)

_POINT, _CONTACT, _TREE, _LOOP, _GUIDE, _DRIVE = range(6)
_FORCES = ("fx", "fy", "force")
_CONTACTS = (*CLEARANCE_OUTPUTS[:4], "force", "eccentricity_ratio", "penetration", "closing", "sliding")
_CONTACT_NAMES = (*_CONTACTS, "film_thickness")
_DRIVES = ("torque", "rate", "power")
_E, _F = CLEARANCE_OUTPUTS.index("ex"), CLEARANCE_OUTPUTS.index("fx")
_DELTA, _CLOSING, _SLIDING = (CLEARANCE_OUTPUTS.index(name) for name in ("penetration", "closing", "sliding"))


def default_outputs(tree: Tree, experiment: Experiment) -> tuple[str, ...]:
    """Name the outputs of the experiment; force and eccentricity of each contact; torques of the drives."""
    labels = [label for _, label in tree.contacts]
    return (
        *experiment.outputs,
        *(f"{label}.{name}" for label in labels for name in ("force", "eccentricity_ratio")),
        *(f"{name}.torque" for name in experiment.drives),
    )


def pack_signals(tree: Tree, experiment: Experiment, names: tuple[str, ...]) -> NDArray[np.record]:
    """Make the records of named outputs.

    Raises
    ------
    InputError
        If a name is unknown, or not available here.
    """
    return np.array([_pack(tree, experiment, name) for name in names], SIGNAL)


def _pack(tree: Tree, experiment: Experiment, name: str) -> tuple[float, ...]:
    wanted = name.removesuffix(JITTER)
    jitter = int(wanted != name)
    owner, _, what = wanted.rpartition(".")
    mechanism = tree.mechanism
    if owner in mechanism.point and what in QUANTITIES:
        point = mechanism.point[owner]
        x, y = tree.local(point.link, point.origin)
        return (_POINT, list(QUANTITIES).index(what), tree.index[point.link], -1, jitter, point.angle, x, y)
    if jitter:
        raise InputError(
            experiment.source, f'output "{name}"', "jitter is that of a link's or frame's motion"
        )
    labels = [label for _, label in tree.contacts]
    if owner in labels and what in _CONTACT_NAMES:
        k = labels.index(owner)
        clearance = experiment.joints[tree.contacts[k][0]].clearance or 0.0
        return (_CONTACT, _CONTACT_NAMES.index(what), k, -1, 0, 1.0, clearance, 0.0)
    if owner in (*tree.driven, *tree.powered) and what in _DRIVES:
        dof = tree.coordinates.index(owner)
        body = int(np.flatnonzero(tree.bodies["dof"] == dof)[0])
        return (_DRIVE, _DRIVES.index(what), body, dof, 0, 1.0, 0.0, 0.0)
    if owner in mechanism.joint and what in _FORCES and owner not in tree.play:
        index = _FORCES.index(what)
        if owner in tree.loops:
            counts = {"revolute": 2, "prismatic": 2, "fixed": 3}
            before = tree.loops[: tree.loops.index(owner)]
            first = sum(counts[mechanism.joint[x].type] for x in before)
            joint = mechanism.joint[owner]
            kind = _GUIDE if joint.type == "prismatic" else _LOOP
            across = (-joint.direction[1], joint.direction[0])
            return (kind, index, first, tree.index[joint.parent], 0, 1.0, *across)
        link = next(link for link, edge in tree.edges.items() if edge.joint == owner)
        return (_TREE, index, tree.index[link], -1, 0, -1.0 if tree.edges[link].reversed else 1.0, 0.0, 0.0)
    known = [*(f"{p}.{q}" for p in mechanism.point for q in QUANTITIES)]
    known += [f"{label}.{q}" for label in labels for q in _CONTACT_NAMES]
    known += [f"{x}.{q}" for x in (*tree.driven, *tree.powered) for q in _DRIVES]
    known += [f"{x}.{q}" for x in mechanism.joint if x not in tree.play for q in _FORCES]
    raise InputError(experiment.source, f'output "{name}"', f"is not there; {nearest(name, known)}")


@kernel
def fill_signals(problem: Any, ideal: Any, signals: NDArray[np.record], out: Array) -> None:
    """Fill ``out`` (ns,) with the signals of the solved state; jitter needs the ideal state filled."""
    model, work = problem.model, problem.work
    w = work.dynamics
    forces = False
    for k in range(len(signals)):
        forces = forces or signals[k].kind == _TREE or signals[k].kind == _DRIVE
    if forces:  # wrenches that the bodies get through their joints
        inertial_load(model.bodies, w.pose, w.vel, w.acc, model.gravity, w.wrench, w.load)
        for k in range(len(model.rows)):
            add_row_wrench(model.rows[k], w.pose, -w.reaction[k], w.load)
        transmitted(model.bodies, w.pose, w.load)
    for k in range(len(signals)):
        signal = signals[k]
        at, what = signal.at, signal.what
        if signal.kind == _POINT:
            out[k] = _point(signal, w.pose, w.vel, w.acc)
            if signal.jitter:
                out[k] -= _point(signal, ideal.pose, ideal.vel, ideal.acc)
        elif signal.kind == _CONTACT:
            out[k] = _contact(signal, work.contacts[at])
        elif signal.kind == _TREE:
            out[k] = _component(what, signal.sign * w.load[at, 1], signal.sign * w.load[at, 2])
        elif signal.kind == _LOOP:
            out[k] = _component(what, w.reaction[at], w.reaction[at + 1])
        elif signal.kind == _GUIDE:
            nx, ny = point_offset(w.pose, signal.dof, signal.x, signal.y)
            out[k] = _component(what, w.reaction[at] * nx, w.reaction[at] * ny)
        else:
            rate = w.v[signal.dof]
            torque = w.tau[signal.dof]
            if model.bodies[at].driven >= 0:
                torque = _along(model.bodies[at], w.pose, w.load[at])
            out[k] = torque if what == 0 else (rate if what == 1 else torque * rate)


@kernel
def _along(body: np.record, pose: Array, load: Array) -> float:
    """Part of a wrench along a joint's coordinate."""
    if body.type == REVOLUTE:
        return body.sign * load[0]
    ux, uy = point_offset(pose, body.parent, body.ux, body.uy)
    return ux * load[1] + uy * load[2]


@kernel
def _component(what: int, fx: float, fy: float) -> float:
    return fx if what == 0 else (fy if what == 1 else math.hypot(fx, fy))


@kernel
def _contact(signal: np.record, contact: Array) -> float:
    what = signal.what
    if what < 4:
        return contact[what]
    if what == 4:
        return math.hypot(contact[_F], contact[_F + 1])
    if what == 5:
        return 1.0 + contact[_DELTA] / signal.x
    if what == 6:
        return contact[_DELTA]
    if what == 7:
        return contact[_CLOSING]
    if what == 8:
        return contact[_SLIDING]
    return -contact[_DELTA]


@kernel
def _point(signal: np.record, pose: Array, vel: Array, acc: Array) -> float:
    b, what = signal.at, signal.what
    rx, ry = point_offset(pose, b, signal.x, signal.y)
    w, al = vel[b, 0], acc[b, 0]
    if what == 0:
        return pose[b, 0] + rx
    if what == 1:
        return pose[b, 1] + ry
    if what == 2:
        return pose[b, 2] + signal.sign
    if what == 3:
        return vel[b, 1] - w * ry
    if what == 4:
        return vel[b, 2] + w * rx
    if what == 5:
        return w
    if what == 6:
        return acc[b, 1] - al * ry - w * w * rx
    if what == 7:
        return acc[b, 2] + al * rx - w * w * ry
    return al
