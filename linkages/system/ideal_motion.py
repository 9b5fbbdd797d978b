"""The motion of the linkage with every joint ideal, over time: closed exactly wherever it is asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.errors import AssemblyError, Status
from linkages.planar.closure import follow
from linkages.system.assembly import SINGULAR
from linkages.system.system import System

Array = NDArray[np.float64]

_GRID = 0.02  # step of the fastest drive between two stored positions [rad or m]


class IdealMotion:
    """Exact motion, reactions and drive torques of the linkage with every joint ideal.

    Only for linkages whose prescribed drives determine the motion (`System.determinate`). The motion is
    closed by Newton's method at every time asked for; a stored table of positions supplies the guesses.

    Attributes
    ----------
    times : (nt,) array
        Times of the stored table, dense enough to follow the branch [s].
    status : Status
        OK, or why the table ends early.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"))
    >>> motion = linkages.IdealMotion(system)
    >>> q, v, a = motion.states(motion.times[:3])
    >>> q.shape == (3, len(system.tree.coordinates))
    True
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.status = Status.OK
        duration = system.experiment.duration
        count = int(np.clip(np.ceil(duration * system.drive_rate / _GRID), 200, 200_000))
        self.times = np.linspace(0.0, duration, count + 1)
        self._follow_branch()

    def _follow_branch(self) -> None:
        tree = self.system.tree
        rows, free, size = tree.closure_rows, tree.free_dofs, tree.extent
        q, v, a = self._prescribed(self.times)
        quality = np.zeros(len(self.times))
        none = np.zeros((1, len(rows)))
        q[0, free] = self.system.assembly.q[free]
        step = self.times[1] - self.times[0]
        for k in range(len(self.times)):
            if k:  # second-order prediction from the last position
                guess = q[k - 1] + step * (v[k - 1] + 0.5 * step * a[k - 1])
                q[k, free] = guess[free]
            line = (x[k : k + 1] for x in (q, v, a, quality))
            done = follow(tree.bodies, rows, none, free, size, *line)
            if done < 1 or quality[k] < SINGULAR:
                self.status = Status.NO_ASSEMBLY if done < 1 else Status.SINGULAR
                self.times, q, v, a, quality = self.times[:k], q[:k], v[:k], a[:k], quality[:k]
                break
        self.q, self.v, self.a, self.quality = q, v, a, quality

    def _prescribed(self, times: Array) -> tuple[Array, Array, Array]:
        tree = self.system.tree
        q, v, a = np.zeros((3, len(times), tree.size))
        for table, values in zip((q, v, a), self.system.motions(times), strict=True):
            table[:, tree.driven_dofs] = values
        return q, v, a

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
        tree = self.system.tree
        q, v, a = self._prescribed(times)
        near = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        near -= times - self.times[near - 1] < self.times[near] - times
        step = (times - self.times[near])[:, None]
        guess = self.q[near] + step * (self.v[near] + 0.5 * step * self.a[near])
        free = tree.free_dofs
        q[:, free] = guess[:, free]
        rows = tree.closure_rows
        if offset is None:
            offset = np.zeros((len(times), len(rows)))
        done = follow(tree.bodies, rows, offset, free, tree.extent, q, v, a, np.zeros(len(times)))
        if done < len(times):
            raise AssemblyError(Status.NO_ASSEMBLY, f"the loops do not close at t = {times[done]:.6g} s")
        return q, v, a
