"""The arrays that kernels read, from the parts of a system."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.elimination import Elimination, elimination_of
from linkages.system.assembly import balanced, independent
from linkages.system.contacts import Contacts
from linkages.system.flexible_link import beam_records
from linkages.system.ideal_linkage import IdealLinkage
from linkages.system.tree import Tree


def make_arrays(linkage: IdealLinkage, contacts: Contacts, q: Array, rate: float) -> Arrays:
    """Collect the arrays of a linkage at coordinates q (n,) at t = 0, whose motion has a rate [rad/s]."""
    tree, packed = linkage.tree, linkage.packed
    moved = tree.driven_dofs, tree.powered_dofs
    dofs = tree.free_dofs, *moved, *map(tree.bodies_of, moved)
    applied = *linkage.motions.arrays, *linkage.torques.arrays, *packed.loads, *beam_records(tree), linkage.gravity
    # calls by address assume contiguous arrays without a check
    rest = map(np.ascontiguousarray, (contacts.ends, tree.joint_records(), *_of_laws(contacts), *dofs, *applied))
    bodies = tree.bodies, tree.stiff_bodies(rate) if tree.deformable else tree.bodies
    closed = _closed_by(tree, tree.loop_rows, tree.free_dofs, q)
    return Arrays._make([*bodies, *closed, *rest, packed.elements, tree.extent])


def with_contacts(arrays: Arrays, contacts: Contacts) -> Arrays:
    """Return the arrays with other contacts."""
    names = "ends", "laws", "tables", "limits", "touching", "law_states"
    found: dict[str, Any] = dict(
        zip(names, map(np.ascontiguousarray, (contacts.ends, *_of_laws(contacts))), strict=True)
    )
    return arrays._replace(**found)


def with_ideal_joints(arrays: Arrays, tree: Tree, q: Array) -> Arrays:
    """Return the arrays with every joint ideal, closed by `Tree.closure_rows` at coordinates q (n,)."""
    rows, elimination = _closed_by(tree, tree.closure_rows, tree.closing_dofs, q)
    return arrays._replace(
        rows=rows,
        elimination=elimination,
        ends=arrays.ends[:0],
        joints=tree.joint_records(ideal=True),
        free=tree.closing_dofs,
    )


def _of_laws(contacts: Contacts) -> tuple[Any, ...]:
    """Return records and tables of the laws, largest eccentricity ratios, which contacts touch, places of states."""
    largest = np.where(contacts.touching, np.inf, contacts.own.film_limits)
    return contacts.laws, contacts.tables, largest, contacts.touching.astype(np.int64), contacts.states.places


def _closed_by(tree: Tree, rows: Records, free: NDArray[np.int64], q: Array) -> tuple[Records, Elimination]:
    """Return the rows, and how their reactions are eliminated in free coordinates."""
    if not len(rows):
        return rows, elimination_of(tree.bodies, rows, 0, free)
    rank = independent(tree, rows, q, free)
    elimination = elimination_of(tree.bodies, rows, rank, free)
    return np.ascontiguousarray(balanced(tree, rows, q)), elimination
