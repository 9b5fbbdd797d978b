"""The linkage with ideal joints and all that acts on it, before it is assembled; its reactions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.drive import Drive
from linkages.elements.machine import add_elements
from linkages.input.functions.definitions import Quantity
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Mechanism
from linkages.mechanics.planar.elimination import Elimination
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.loads import load_wrenches
from linkages.mechanics.planar.motion import Motions
from linkages.mechanics.planar.singularities import constrained_dynamics
from linkages.mechanics.planar.workspace import Workspace
from linkages.system.flexible_link import flexible_link
from linkages.system.load_records import Packed, pack_loads
from linkages.system.masses import with_all_masses
from linkages.system.spanning import spanning_tree
from linkages.system.tree import Tree


class IdealLinkage(NamedTuple):
    """A linkage with ideal joints, and what moves it."""

    tree: Tree
    motions: Motions  # of the tree's driven joints
    torques: Motions  # of its powered joints
    packed: Packed  # elements and loads
    start_states: Array  # additional states at t = 0, (nz,)
    gravity: Array  # in plane axes, (2,) [m/s2]

    def add_loads(self, t: float, v: Array, work: Workspace) -> None:
        """Add elements and loads at time t [s] and rates v (n,) to the wrenches of a workspace with pose and vel."""
        rates = np.concatenate([v, self.start_states])
        if any(map(len, self.packed.elements)):
            add_elements(self.packed.elements, self.packed.functions, t, rates, work.pose, work.vel, work.wrench)
        if len(self.packed.loads[0]):
            load_wrenches(self.packed.loads, t, rates, work.pose, work.vel, work.wrench)


def ideal_linkage(mechanism: Mechanism, experiment: Experiment, quantities: Mapping[str, Quantity]) -> IdealLinkage:
    """Build a linkage, and what moves it; `quantities` are those of `pack_loads`."""
    tree = tree_of(mechanism, experiment)
    return IdealLinkage(
        tree,
        motions_of(tuple(experiment.drives[name] for name in tree.driven), experiment.values),
        torques_of(tuple(experiment.drives[name] for name in tree.powered)),
        pack_loads(tree, experiment, quantities),
        start_states(experiment),
        plane_gravity(mechanism, experiment),
    )


def tree_of(mechanism: Mechanism, experiment: Experiment) -> Tree:
    """Build the spanning tree: clearance joints are cut, driven joints stay."""
    drives = experiment.drives
    tree = spanning_tree(
        with_all_masses(mechanism, experiment),
        experiment.play,
        tuple(name for name, drive in drives.items() if drive.prescribed),
        tuple(name for name, drive in drives.items() if not drive.prescribed),
        {name: partial(flexible_link, mechanism, experiment, name) for name in experiment.deforming},
        experiment.wheels,
    )
    return replace(tree, coupled=experiment.closed, loose=experiment.loose)


def motions_of(drives: tuple[Drive, ...], values: Mapping[str, float]) -> Motions:
    """Return the prescribed motions of drives."""
    return Motions([drive.motion(values) for drive in drives])


def torques_of(drives: tuple[Drive, ...]) -> Motions:
    """Return the torque histories of drives."""
    return Motions([drive.torque_history() for drive in drives])


def start_states(experiment: Experiment) -> Array:
    """Return the additional states at t = 0, (nz,)."""
    return np.array([one.start for one in experiment.own_states.values()], float)


def plane_gravity(mechanism: Mechanism, experiment: Experiment) -> Array:
    """Return gravity in plane axes, (2,) [m/s2]."""
    return np.asarray(mechanism.basis[:, :2].T @ experiment.gravity)


def ideal_forces(linkage: IdealLinkage, t: float, q: Array, v: Array, elimination: Elimination) -> Workspace:
    """Solve the ideal linkage at time t [s], coordinates q and rates v (n,), with shapes that do not accelerate.

    The elimination is that of `Tree.closure_rows`. The workspace has its pose, vel, a, tau and reaction, see
    `linkages.mechanics.planar.singularities.constrained_dynamics`.
    """
    tree, at = linkage.tree, np.array([t])
    work = tree.workspace(tree.closure_rows)
    work.q[:], work.v[:] = q, v
    body_states(tree.bodies, q, v, work.pose, work.vel)
    linkage.add_loads(t, work.v, work)
    work.tau[tree.powered_dofs] = linkage.torques(at)[0][0]
    work.a[tree.driven_dofs] = linkage.motions(at)[2][0]
    constrained_dynamics(
        tree.undeforming_bodies, tree.closure_rows, elimination, tree.extent, 0.0, linkage.gravity, work,
        np.zeros(tree.size),
    )  # fmt: skip
    return work
