"""Derivatives of the state at t = 0 with respect to values, which the closed ideal linkage determines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Records, kernel
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.dual import DIRECTIONS, dual_array
from linkages.base.kernel.dual_copy import DualCopy
from linkages.engines.compiled.derivatives.neighbours import Neighbours
from linkages.engines.compiled.run.model import start_state
from linkages.engines.numerics import START_DERIVATIVES_DEPENDENT, START_DERIVATIVES_LEFT
from linkages.mechanics.planar.bodies import Bodies, make_motion, make_pose
from linkages.mechanics.planar.closure import jacobian_at
from linkages.mechanics.planar.closure_rows import row_rate, row_value
from linkages.mechanics.planar.kinematics import body_states
from linkages.system import System
from linkages.system.replacing import keeps_start
from linkages.system.tree import without


class Closure(NamedTuple):
    """Numbers that the start follows: the tree, its closure rows and their values, places and speeds of the drives."""

    bodies: Bodies
    rows: Records
    offset: Array
    places: Array
    speeds: Array


class Start(NamedTuple):
    """A closure of duals and arrays of duals: coordinates and rates (n,), poses, velocities, errors (2, nr)."""

    closure: Closure
    q: Array
    v: Array
    pose: Array
    vel: Array
    errors: Array  # of the closure rows, and their rates


def _closure(system: System) -> Closure:
    tree = system.tree
    powered = [system.drives[name] for name in tree.powered]
    places, speeds = system.motions.start
    places = np.concatenate([places, [drive.angle for drive in powered]])
    speeds = np.concatenate([speeds, [drive.speed or 0.0 for drive in powered]])
    return Closure(tree.bodies, tree.closure_rows, system.start_offsets, places, speeds)


def start_derivatives(system: System, nearby: Sequence[Neighbours]) -> Array:
    """Differentiate the state at t = 0 with respect to np values, (ny, np).

    Where the loops of the tree and the drives alone determine the position, the closure rows with dual numbers give the
    change of coordinates and rates that keeps them closed. Otherwise neighbouring systems are assembled.
    """
    tree, unloaded = system.tree, system.starts_unloaded
    determined = unloaded and not (tree.powered and (tree.play or tree.loose))
    determined = determined and bool(np.isfinite(system.assembly.quality))
    found = np.zeros((len(nearby), len(start_state(system))))
    # in other machines masses and laws change the start
    moved = [k for k, near in enumerate(nearby) if not (unloaded and all(map(keeps_start, near.along)))]
    for first in range(0, len(moved), DIRECTIONS):
        part = moved[first : first + DIRECTIONS]
        followed = _followed(system, [nearby[k] for k in part]) if determined else None
        if followed is None:
            found[part] = [nearby[k].derivative(start_state) for k in part]
        else:
            found[part, : 2 * len(tree.free_dofs)] = followed
            if system.own_states:
                states = [nearby[k].derivative(lambda one: one.start_states) for k in part]
                found[part, -len(system.own_states) :] = states
    return found.T.copy()


def _followed(system: System, nearby: Sequence[Neighbours]) -> Array | None:
    """Differentiate positions and rates at the start with respect to some values; None if the loops do not follow."""
    tree, closure = system.tree, DualCopy(_closure(system))
    for k, near in enumerate(nearby, 1):
        places, rates = near.rates(_closure)
        closure.memory[places, k] = rates
    moved = np.concatenate([tree.driven_dofs, tree.powered_dofs])
    free, n, bodies = without(tree.closing_dofs, moved), tree.size, tree.bodies
    pose, vel = dual_array(*make_pose(bodies).shape), dual_array(*make_motion(bodies).shape)
    errors = dual_array(2, len(tree.closure_rows))
    start = packed(Start(closure.value, dual_array(n), dual_array(n), pose, vel, errors))
    inner = jacobian_at(bodies, tree.closure_rows, system.assembly.q)[:, free]
    start.q[:, 0], start.v[:, 0] = system.assembly.q, system.assembly.v
    start.q[moved], start.v[moved] = closure.value.places, closure.value.speeds
    for x, changes in zip((start.q, start.v), errors.view(np.ndarray)[:, :, 1:], strict=True):
        _set_errors(start)
        found = np.linalg.lstsq(inner, -changes, START_DERIVATIVES_DEPENDENT)[0]
        if np.abs(inner @ found + changes).max(initial=0.0) > START_DERIVATIVES_LEFT * np.abs(changes).max(initial=0.0):
            return None
        x[free, 1:] = found
    both = np.concatenate([start.q[tree.free_dofs], start.v[tree.free_dofs]])
    return np.asarray(both[:, 1 : 1 + len(nearby)].T)


@kernel
def _set_errors(start: Start) -> None:
    """Fill the errors of the closure rows and their rates."""
    closure, pose, vel = start.closure, start.pose, start.vel
    body_states(closure.bodies, start.q, start.v, pose, vel)
    for k in range(len(closure.rows)):
        start.errors[0, k] = row_value(closure.rows[k], pose) - closure.offset[k]
        start.errors[1, k] = row_rate(closure.rows[k], pose, vel)
