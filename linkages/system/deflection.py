"""Quasi-static shape of flexible links at t = 0, so that the start excites no vibration."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError, Status
from linkages.mechanics.planar.closure import close, consistent_rates
from linkages.mechanics.planar.closure_rows import add_row_wrench
from linkages.mechanics.planar.elimination import elimination_of
from linkages.mechanics.planar.kinematics import body_accelerations, body_states, poses_at
from linkages.mechanics.planar.newton_euler import generalised_force, inertial_forces
from linkages.system.assembly import Assembly, independent
from linkages.system.ideal_linkage import IdealLinkage, ideal_forces
from linkages.system.tree import without

_ROUNDS = 60  # most iterations of Newton's method
_STIFF = 1e-12  # least stiffness, relative to the largest
_DONE, _DIFFERENCE = 1e-11, 1e-6  # tolerance and difference step of a deflection over the length
_TURN = 0.5  # largest rotation of a section in one Newton step [rad]
_STEP = 1e-3  # difference step of the fastest coordinate for the rates [rad, or linkage lengths]


def deflected(linkage: IdealLinkage, assembly: Assembly, source: Path, time: float = 0.0) -> Assembly:
    """Return the assembly with deformable links deflected by the steady loads of the ideal linkage.

    The steady loads are the inertia of the rigid motion, weight, applied loads and the reactions of joints whose
    journals keep their offsets. Accelerations of shapes are neglected; their rates follow from the change of the shape
    with the motion. Links that do not settle stay straight. Loads and prescribed motions are evaluated at `time` [s].
    InputError, of the file `source`, if no stable shape exists: a load exceeds the buckling load of a link.
    """
    if not linkage.tree.deformable or not len((finder := _Finder(linkage, assembly, source, time)).shapes):
        return assembly
    q, a = finder.shape(time, assembly.q, assembly.v)
    fastest = np.max(np.abs(assembly.v[linkage.tree.joint_dofs]), initial=0.0)
    v = assembly.v.copy()
    if fastest > 0.0:
        step = _STEP / fastest
        ahead = ((h, assembly.q + h * assembly.v + 0.5 * h * h * a, v + h * a) for h in (-step, step))
        sides = [finder.shape(time + h, *state)[0] for h, *state in ahead]
        v[finder.shapes] = (sides[1] - sides[0])[finder.shapes] / (2.0 * step)
    consistent_rates(linkage.tree.bodies, finder.rows, finder.free, q, v, np.zeros(len(q)))
    return Assembly(q, v, assembly.mobility, assembly.quality)


class _Finder:
    """Finds the quasi-static shape for given positions and rates of the joints."""

    def __init__(self, linkage: IdealLinkage, assembly: Assembly, source: Path, time: float) -> None:
        tree, self.source, self.time = linkage.tree, source, time
        self.linkage, self.tree, self.rows = linkage, tree, tree.closure_rows
        owned = {
            tree.coordinates.index(name): link
            for link, substructures in tree.deformable.items()
            for part in substructures
            for name in part.coordinates
            if part.settles
        }
        self.shapes, self.links = np.array(list(owned), np.int64), list(owned.values())
        self.free = without(tree.closing_dofs, tree.powered_dofs)
        self.offset = tree.gaps(assembly.q)
        rank = independent(tree, self.rows, assembly.q, tree.closing_dofs) if len(self.rows) else 0
        self.elimination = elimination_of(tree.bodies, self.rows, rank, tree.closing_dofs)

    def shape(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Compute coordinates and accelerations of the deflected linkage near the given coordinates and rates."""
        tree, q, v, count = self.tree, q.copy(), v.copy(), len(self.shapes)
        for table, values in zip((q, v), self.linkage.motions(np.array([t]))[:2], strict=True):
            table[tree.driven_dofs] = values[0]
        step, slope = _DIFFERENCE * tree.extent, np.empty((count, count))
        for _ in range(_ROUNDS):
            left, a = self._left(t, q, v)
            for k in range(count):
                beside = q.copy()
                beside[self.shapes[k]] += step
                slope[:, k] = (self._left(t, beside, v)[0] - left) / step
            if not np.all(np.isfinite(slope)):
                raise AssemblyError(Status.NO_ASSEMBLY, "the loops do not close with links deflected by their loads")
            values, ways = np.linalg.eig(slope)
            softest = int(np.argmin(values.real))
            if values.real[softest] > 0.0:
                change = np.linalg.solve(slope, left)
            else:  # Newton's method would converge to an unstable shape: step away from it
                sizes = np.abs(values)
                if not np.any(sizes):
                    raise self._refused(0, "deflect it without any resistance")
                change = (ways @ (np.linalg.pinv(ways) @ left / np.maximum(sizes, _STIFF * sizes.max()))).real
            beside = q.copy()
            beside[self.shapes] -= change
            turns = np.abs(poses_at(tree.bodies, beside) - poses_at(tree.bodies, q))[:, 2]
            change *= min(1.0, _TURN / np.max(turns, initial=_DONE))
            q[self.shapes] -= change
            size = np.max(np.abs(change))
            if size <= _DONE * tree.extent:
                break
        if values.real[softest] <= 0.0:
            raise self._refused(int(np.argmax(np.abs(ways[:, softest]))), "exceed its buckling load")
        if size > _DONE * tree.extent:
            found = f"give no static deflection within {_ROUNDS} Newton iterations"
            raise self._refused(int(np.argmax(np.abs(change))), found)
        return q, a

    def _refused(self, mode: int, problem: str) -> InputError:
        where = f"links.{self.links[mode]}.start"
        return InputError(self.source, where, f'the loads at t = {self.time:g} {problem}; set "undeformed"')

    def _left(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """Compute the residual forces on the shapes, and the accelerations of the linkage with a fixed shape.

        Closes the loops by the joint coordinates: changes q and v.
        """
        tree = self.tree
        if not close(tree.bodies, self.rows, self.offset, self.free, tree.extent, q):
            return np.full(len(self.shapes), np.nan), q
        consistent_rates(tree.bodies, self.rows, self.free, q, v, np.zeros(len(q)))
        work = ideal_forces(self.linkage, t, q, v, self.elimination)
        bodies, pose, vel, load, left = tree.bodies, work.pose, work.vel, work.bias, np.zeros(tree.size)
        work.a[len(tree.joint_dofs) :] = 0.0
        body_states(bodies, q, v, pose, vel)
        work.wrench[:] = 0.0
        self.linkage.add_loads(t, v, work)
        body_accelerations(bodies, pose, vel, v, work.a, work.acc)
        inertial_forces(bodies, work, self.linkage.gravity, load, left)
        for row, size in zip(self.rows, work.reaction, strict=True):
            add_row_wrench(row, pose, -size, load)
        generalised_force(bodies, pose, load, left)
        return left[self.shapes], work.a
