"""Minimal coordinates of a linkage near a state: independent free coordinates, rates, states of laws, others.

With closed loops of ideal joints, the state y = [q, v, z, s] moves on the closed loops: changes keep the closure rows
and their rates zero. Some coordinates are independent, the others follow; a change x of the independent ones, of their
rates, of the states of laws and of additional states changes the state by ``tangent @ x`` to first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.base.kernel import Indices
from linkages.engines.compiled.run.linear import Closure
from linkages.explore.numerics import LOCAL_COORDINATES_PREFERRED
from linkages.system import System


@dataclass(frozen=True)
class LocalCoordinates:
    """Minimal coordinates near a state; made by `local_coordinates`."""

    # nx names: ``q.NAME`` of coordinates, ``v.NAME`` of rates, ``z.CONTACT`` of laws' states, ``s.NAME`` of others
    names: tuple[str, ...]
    entries: Indices  # (nx,) their entries in the state y
    tangent: Array  # (ny, nx) change of the state with them


def local_coordinates(system: System, closure: Closure, like: LocalCoordinates | None = None) -> LocalCoordinates:
    """Choose minimal coordinates at a state with these derivatives of the loops; `like` gives the choice."""
    tree, (rows, turning, rank) = system.tree, closure
    n = len(tree.free_dofs)
    independent = np.arange(n)
    dependent, follow, turn = independent[:0], np.zeros((0, n)), np.zeros((0, n))
    if rank:
        independent = _independent(system, closure) if like is None else like.entries[like.entries < n]
        dependent = np.setdiff1d(np.arange(n), independent)
        ways = np.zeros((n, n - rank))
        ways[independent] = np.eye(n - rank)
        own = np.linalg.pinv(rows[:, dependent])
        follow = -own @ rows[:, independent]
        ways[dependent] = follow
        turn = -own @ turning @ ways
    m, nz = len(independent), len(system.law_states.names) + len(system.own_states)
    entries = np.concatenate([independent, n + independent, 2 * n + np.arange(nz)])
    tangent = np.zeros((2 * n + nz, len(entries)))
    tangent[entries, np.arange(len(entries))] = 1.0
    if rank:
        tangent[dependent, :m] = follow
        tangent[n + dependent, :m], tangent[n + dependent, m : 2 * m] = turn, follow
    coordinates = [tree.coordinates[k] for k in tree.free_dofs[independent]]
    kinds = {"q": coordinates, "v": coordinates, "z": _law_states(system), "s": system.own_states}
    names = [f"{kind}.{name}" for kind, owners in kinds.items() for name in owners]
    return LocalCoordinates(tuple(names), entries, tangent)


def _law_states(system: System) -> list[str]:
    """Name the states of laws by their contact, and by their own name too where a contact has several."""
    found = system.law_states
    owners = [system.contacts[k][1] for k in found.places[:, 0]]
    return [
        owner if owners.count(owner) == 1 else f"{owner}.{name}"
        for owner, name in zip(owners, found.names, strict=True)
    ]


def _independent(system: System, closure: Closure) -> Indices:
    """Choose independent free coordinates: the others have the best conditioned closure rows."""
    from scipy.linalg import qr  # SciPy's import takes long

    tree = system.tree
    weight = np.where(np.isin(tree.free_dofs, tree.powered_dofs), LOCAL_COORDINATES_PREFERRED, 1.0)
    order = qr(closure.rows * weight, mode="r", pivoting=True)[1]
    return np.sort(order[closure.rank :])
