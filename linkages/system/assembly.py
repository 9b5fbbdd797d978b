"""Loop closure, assembly branch, consistent initial state, and the ideal motion over time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, RunError, Status
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism
from linkages.outputs.columns import Columns, columns_from_states
from linkages.planar.closure import close, closure_error, closure_jacobian, consistent_rates, follow
from linkages.planar.motion import Motions
from linkages.system.loads import check_lengths
from linkages.system.tree import Tree, spanning_tree

Array = NDArray[np.float64]

_SINGULAR = 1e-8  # ratio of singular values below which a position counts as singular
_CONTINUATION = 0.05  # largest step of a drive from the drawn pose to its start angle [rad or m]
_GRID = 0.02  # step of the fastest drive between two stored positions of the ideal motion [rad or m]


class AssemblyError(RunError):
    """The linkage cannot be assembled; `status` says how it failed."""

    def __init__(self, status: Status, detail: str) -> None:
        super().__init__(f"{status.value}: {detail}; {status.remedy}")
        self.status = status


@dataclass(frozen=True)
class Assembly:
    """A linkage assembled at t = 0 on the branch that the SDF file draws.

    Attributes
    ----------
    tree : Tree
        Clearance joints and the remaining loops are cut.
    q, v : (n,) arrays
        Coordinates of the *ideal* linkage (displaced by the joints' offsets) and their rates.
    mobility : int
        Degrees of freedom of the ideal linkage.
    quality : float
        Smallest over largest singular value of the closure Jacobian's free columns; zero at a singular position.
    """

    tree: Tree
    motions: Motions
    q: Array
    v: Array
    mobility: int
    quality: float

    @property
    def determinate(self) -> bool:
        """Whether the prescribed drives alone determine the ideal motion."""
        return self.mobility == len(self.tree.driven)


def tree_of(mechanism: Mechanism, experiment: Experiment) -> Tree:
    """Spanning tree for an experiment: joints with play are cut, drives stay."""
    drives = experiment.drives
    return spanning_tree(
        mechanism,
        experiment.play,
        tuple(name for name, drive in drives.items() if drive.prescribed),
        tuple(name for name, drive in drives.items() if not drive.prescribed),
    )


def assemble(mechanism: Mechanism, experiment: Experiment) -> Assembly:
    """Assemble the ideal linkage at t = 0 with consistent velocities.

    Drives are brought from the drawn pose to their start angles in small steps, so that the assembly stays on
    the drawn branch. Coordinates that nothing prescribes keep their drawn values as far as the loops allow, and
    start at rest; powered joints start at their `angle` and `speed`.

    Raises
    ------
    AssemblyError
        If the loops cannot be closed or the position is singular.
    InputError
        If more joints are driven than the linkage has degrees of freedom, or a spring has no direction at t = 0.
    """
    tree = tree_of(mechanism, experiment)
    motions = Motions([experiment.drives[name].motion() for name in tree.driven])
    held = np.concatenate([tree.driven_dofs, tree.powered_dofs]).astype(np.int64)
    free = tree.free_dofs[[tree.coordinates[i] not in tree.powered for i in tree.free_dofs]]
    value, rate, _ = motions(np.zeros(1))
    powered = [experiment.drives[name] for name in tree.powered]
    start = np.concatenate([value[0], [drive.angle for drive in powered]])
    speed = np.concatenate([rate[0], [drive.speed or 0.0 for drive in powered]])
    rows, size = tree.closure_rows, tree.extent
    none = np.zeros(len(rows))
    q, v = np.zeros(tree.size), np.zeros(tree.size)
    steps = max(1, int(np.ceil(np.max(np.abs(start), initial=0.0) / _CONTINUATION)))
    for fraction in np.linspace(0.0, 1.0, steps + 1):
        q[held] = fraction * start
        if not close(tree.bodies, rows, none, free, size, q):
            at = ", ".join(f"{tree.coordinates[i]} = {q[i]:.4g}" for i in held) or "the drawn pose"
            raise AssemblyError(Status.NO_ASSEMBLY, f"the loops do not close at {at}")
    mobility = _mobility(tree, q)
    if len(held) > mobility:
        raise InputError(
            experiment.source,
            "drives",
            f"{len(held)} joints are driven, but {mechanism.name} has {mobility} degrees of freedom; drive fewer",
        )
    offset = np.zeros(len(rows))
    for k, name in enumerate(tree.play):
        offset[2 * k : 2 * k + 2] = experiment.joints[name].offset
    if np.any(offset) and not close(tree.bodies, rows, offset, free, size, q):
        raise AssemblyError(Status.NO_ASSEMBLY, "the loops do not close with these journal offsets")
    check_lengths(tree, experiment, q)
    v[held] = speed
    quality = consistent_rates(tree.bodies, rows, free, q, v, np.zeros(tree.size))
    determined = mobility == len(held)
    if determined and quality < _SINGULAR:
        raise AssemblyError(Status.SINGULAR, "the start position is singular")
    return Assembly(tree, motions, q, v, mobility, quality if determined else float("nan"))


def with_other_masses(assembly: Assembly, mechanism: Mechanism, experiment: Experiment) -> Assembly:
    """Return the assembly of a mechanism that has other masses only, in an experiment that has other laws only."""
    return replace(assembly, tree=tree_of(mechanism, experiment))


def _mobility(tree: Tree, q: Array) -> int:
    """Degrees of freedom of the ideal linkage at q: coordinates less independent closure rows."""
    if len(tree.closure_rows) == 0:
        return tree.size
    pose = np.empty((len(tree.bodies), 5))
    closure_error(tree.bodies, tree.closure_rows, np.zeros(len(tree.closure_rows)), q, pose)
    jacobian = closure_jacobian(tree.bodies, tree.closure_rows, pose, tree.size)
    return tree.size - int(np.linalg.matrix_rank(jacobian, tol=1e-9 * np.abs(jacobian).max()))


class IdealMotion:
    """Exact motion, reactions and drive torques of the linkage with every joint ideal.

    Only for linkages whose prescribed drives determine the motion (`Assembly.determinate`). The motion is
    closed by Newton's method at every time asked for; a stored table of positions supplies the guesses.

    Attributes
    ----------
    times : (nt,) array
        Times of the stored table, dense enough to follow the branch [s].
    status : Status
        OK, or why the table ends early.
    """

    def __init__(self, assembly: Assembly, experiment: Experiment) -> None:
        self.assembly = assembly
        self.experiment = experiment
        self.status = Status.OK
        coarse = np.linspace(0.0, experiment.duration, 501)
        fastest = np.abs(assembly.motions(coarse)[1]).max(initial=0.0)
        count = int(np.clip(np.ceil(experiment.duration * fastest / _GRID), 200, 200_000))
        self.times = np.linspace(0.0, experiment.duration, count + 1)
        self._follow_branch()

    def _follow_branch(self) -> None:
        tree = self.assembly.tree
        q, v, a = self._prescribed(self.times)
        quality = np.zeros(len(self.times))
        free = tree.free_dofs
        none = np.zeros((1, len(tree.closure_rows)))
        q[0, free] = self.assembly.q[free]
        step = self.times[1] - self.times[0]
        for k in range(len(self.times)):
            if k:  # second-order prediction from the last position
                guess = q[k - 1] + step * (v[k - 1] + 0.5 * step * a[k - 1])
                q[k, free] = guess[free]
            line = slice(k, k + 1)
            done = follow(
                tree.bodies,
                tree.closure_rows,
                none,
                free,
                tree.extent,
                q[line],
                v[line],
                a[line],
                quality[line],
            )
            if done < 1 or quality[k] < _SINGULAR:
                self.status = Status.NO_ASSEMBLY if done < 1 else Status.SINGULAR
                self.times, q, v, a, quality = self.times[:k], q[:k], v[:k], a[:k], quality[:k]
                break
        self.q, self.v, self.a, self.quality = q, v, a, quality

    def _prescribed(self, times: Array) -> tuple[Array, Array, Array]:
        tree = self.assembly.tree
        result = []
        for values in self.assembly.motions(times):
            table = np.zeros((len(times), tree.size))
            table[:, tree.driven_dofs] = values
            result.append(table)
        return result[0], result[1], result[2]

    def states(self, times: Array, offset: Array | None = None) -> tuple[Array, Array, Array]:
        """Coordinates, rates and accelerations (nt, n) at any times within the table.

        Parameters
        ----------
        times : (nt,) array
        offset : (nt, nr) array, optional
            Wanted values of the tree's closure rows instead of zero (rates and accelerations are then those of a
            constant offset): places journals away from their bearings' centres.

        Raises
        ------
        AssemblyError
            If the loops do not close.
        """
        tree = self.assembly.tree
        q, v, a = self._prescribed(times)
        near = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        near -= times - self.times[near - 1] < self.times[near] - times
        step = (times - self.times[near])[:, None]
        guess = self.q[near] + step * (self.v[near] + 0.5 * step * self.a[near])
        free = tree.free_dofs
        q[:, free] = guess[:, free]
        if offset is None:
            offset = np.zeros((len(times), len(tree.closure_rows)))
        done = follow(
            tree.bodies, tree.closure_rows, offset, free, tree.extent, q, v, a, np.zeros(len(times))
        )
        if done < len(times):
            raise AssemblyError(Status.NO_ASSEMBLY, f"the loops do not close at t = {times[done]:.6g} s")
        return q, v, a

    def evaluate(self, times: Array) -> Columns:
        """All columns (see `linkages.outputs.columns`) of the ideal linkage at the given times."""
        q, v, a = self.states(times)
        return columns_from_states(self.assembly.tree, self.experiment, times, q, v, a)
