"""Static equilibrium of journals and blocks in their clearances.

A start in equilibrium has no free flight across the clearance.

For each clearance joint the solver finds the offset at which the joint law, at zero velocity apart from the rotation of
both bodies, gives the joint force of the ideal linkage at t = 0. Forces and motion belong to the ideal linkage with
these offsets. Moments of films and friction are neglected; they change the forces by about a radius over a link length.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.mechanics.planar.contacts import ContactMotion, contact_action, contact_motion
from linkages.mechanics.planar.elimination import elimination_of
from linkages.mechanics.planar.record_types import JOURNAL
from linkages.system.assembly import Assembly, independent
from linkages.system.contacts import Contacts
from linkages.system.ideal_linkage import IdealLinkage, ideal_forces
from linkages.system.tree import Tree

_PASSES = 3  # each reduces the error by the factor clearance over link length
_NOTHING = 1e-12  # relative to the largest force: below it a joint carries no load
_DOUBLINGS = 60
_EXACT = 1e-14  # tolerance of offsets over the clearance


def resting_offsets(
    linkage: IdealLinkage, contacts: Contacts, source: Path, assemble: Callable[[Array], Assembly]
) -> Array:
    """Compute equilibrium offsets of clearance joints, two for each: x, y [m]; for a guide across [m], tilt [rad].

    `assemble` assembles the linkage with given offsets. InputError, of the file `source`, if no offset balances the
    force at zero velocity, as for a film between parts that do not rotate.
    """
    tree = linkage.tree
    offsets = np.zeros(2 * len(tree.play))
    for _ in range(_PASSES):
        start = assemble(offsets)
        rank = independent(tree, tree.closure_rows, start.q, tree.closing_dofs)
        elimination = elimination_of(tree.bodies, tree.closure_rows, rank, tree.closing_dofs)
        work = ideal_forces(linkage, 0.0, start.q, start.v, elimination)
        forces = work.reaction[: len(offsets)]
        largest = np.abs(forces).max(initial=0.0)
        for k, name in enumerate(tree.play):
            two = slice(2 * k, 2 * k + 2)
            joint = _LooseJoint(tree, contacts, source, name, work.pose, work.vel, offsets[two])
            if np.abs(forces[two]).max() > _NOTHING * largest:
                offsets[two] = (joint.block if joint.guide else joint.journal)(forces[two])
    return offsets


class _LooseJoint:
    """The contacts of one clearance joint, at a pose that includes its offset."""

    def __init__(
        self, tree: Tree, records: Contacts, source: Path, name: str, pose: Array, vel: Array, offset: Array
    ) -> None:
        self.records, self.source, self.name = records, source, name
        self.contacts = [k for k, (owner, _) in enumerate(tree.contacts) if owner == name]
        self.motions, self.arms = [], []
        self.guide = len(self.contacts) > 1
        joint, end = tree.joints[name], records.ends[self.contacts[0]]
        parent = pose[end["bearing"]["body"]]
        x, y = joint.direction
        self.across = np.array([-parent[4] * x - parent[3] * y, parent[3] * x - parent[4] * y])
        child = tree.marker(joint.child, joint.on_child)[1:]
        for k in self.contacts:
            motion, _ = contact_motion(records.ends[k], pose, vel)
            body = pose[records.ends[k]["journal"]["body"]]
            px, py = records.ends[k]["journal"]["x"] - child[0], records.ends[k]["journal"]["y"] - child[1]
            arm = np.array([body[3] * px - body[4] * py, body[4] * px + body[3] * py])
            self.arms.append(arm)
            place = np.array(motion[:2]) - self._shift(offset, arm)
            self.motions.append((place, motion[2:]))
        if not self.guide:
            self.motions = [(np.zeros(2), (0.0, 0.0, *rest[2:])) for _, rest in self.motions]

    def _shift(self, offset: Array, arm: Array) -> Array:
        if not self.guide:
            return offset
        return offset[0] * self.across + offset[1] * np.array([-arm[1], arm[0]])

    def force(self, offset: Array) -> Array:
        """Compute the journal force at an offset, (2,) [N]; for a guide: force across the slot and moment [N m]."""
        records, total = self.records, np.zeros(3)
        for k, arm, (place, rest) in zip(self.contacts, self.arms, self.motions, strict=True):
            e = place + self._shift(offset, arm)
            motion = cast(ContactMotion, (float(e[0]), float(e[1]), *(float(x) for x in rest)))
            remembered = records.states.remembered(k)
            found = contact_action(records.ends[k], records.laws[k], records.tables[k], remembered, motion)
            total += found[0], found[1], arm[0] * found[1] - arm[1] * found[0]
        return np.array([total[:2] @ self.across, total[2]]) if self.guide else total[:2]

    def journal(self, wanted: Array) -> Array:
        """Find the eccentricity for a force from its size, then its direction (round bearings are isotropic)."""
        from scipy.optimize import brentq, root  # half a second of import time

        law, size = self.records.laws[self.contacts[0]], float(np.hypot(*wanted))
        clearance, reach = float(law["clearance"]), float(self.records.reach[self.contacts[0]])
        can_touch = not np.isfinite(reach)

        def excess(distance: float) -> float:
            return float(np.hypot(*self.force(np.array([distance, 0.0])))) - size

        far = clearance if can_touch else reach * (1.0 - 1e-9)
        depth = 1e-6 * clearance
        for _ in range(_DOUBLINGS if can_touch else 0):
            if excess(far) > 0.0:
                break
            depth *= 2.0
            far = clearance + depth
        if not excess(far) > 0.0:
            self._refuse(size)
        distance = float(brentq(excess, 0.0, far, xtol=_EXACT * clearance, rtol=1e-15))
        given = self.force(np.array([distance, 0.0]))
        angle = np.arctan2(wanted[1], wanted[0]) - np.arctan2(given[1], given[0])
        place = distance * np.array([np.cos(angle), np.sin(angle)])
        if self.records.ends[self.contacts[0]]["kind"] == JOURNAL:
            return place
        found = root(lambda x: (self.force(x * clearance) - wanted) / size, place / clearance, tol=1e-12)
        if not found.success or np.hypot(*found.x) * clearance >= reach:
            self._refuse(size)
        return np.asarray(found.x) * clearance

    def block(self, wanted: Array) -> Array:
        """Find a block's offset from the transverse force and its tilt from the moment; both laws are monotonic."""
        clearance = float(self.records.laws[self.contacts[0]]["clearance"])
        reach = max(np.hypot(*arm) for arm in self.arms)

        def place(tilt: float) -> float:
            return self._balanced(lambda y: self.force(np.array([y, tilt]))[0] - wanted[0], clearance, 1.0)

        tilt = self._balanced(
            lambda tilt: self.force(np.array([place(tilt), tilt]))[1] - wanted[1], clearance / reach, reach
        )
        return np.array([place(tilt), tilt])

    def _balanced(self, excess: Callable[[float], float], scale: float, arm: float) -> float:
        """Find the zero of a residual force (or moment over an arm) that decreases with the offset."""
        from scipy.optimize import brentq

        if excess(0.0) == 0.0:
            return 0.0
        side = scale if excess(0.0) > 0.0 else -scale
        far = side
        for _ in range(_DOUBLINGS):
            if excess(far) * side <= 0.0:
                return float(brentq(excess, 0.0, far, xtol=_EXACT * scale, rtol=1e-15))
            far += side
            side *= 1.1
        self._refuse(abs(excess(far)) / arm)
        return far

    def _refuse(self, size: float) -> None:
        problem = f'is "equilibrium"; no offset of {self.name} balances {size:.3g} N at zero velocity; use "centred"'
        raise InputError(self.source, "start", problem)
