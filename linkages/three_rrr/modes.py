"""Natural frequencies and mode shapes of the robot over poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from linkages.base.arrays import Array
from linkages.mechanics.flexible.modes import ModesAt, dense_modes, sparse_modes, track
from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion

DENSE = 80  # up to this many unknowns the dense, batched solver is the faster one (benchmarks/flexible.py)
_BATCH = 64  # poses solved together by the dense solver


def frequencies(model: FiniteElementModel, state: RobotMotion, count: int | None = None) -> Array:
    """Natural frequencies (N, count) at each pose, rising [Hz]; all of them without a count."""
    return modes(model, state, count, vectors=False)[0]


def modes(
    model: FiniteElementModel,
    state: RobotMotion,
    count: int | None = None,
    progress: Callable[[float], None] | None = None,
    vectors: bool = True,
) -> tuple[Array, Array]:
    """Frequencies (N, count) [Hz] and, with `vectors`, shapes (N, size, count) of unit modal mass."""
    count = model.size if count is None else min(count, model.size)
    sparse_pays = model.size > DENSE and count < model.size // 4
    values = np.empty((len(state), count))
    shapes = np.empty((len(state), model.size, count) if vectors else (0, 0, 0))
    step = 1 if sparse_pays else _BATCH if model.size <= DENSE else 4
    for start in range(0, len(state), step):
        part = slice(start, start + step)
        if sparse_pays:
            values[start], found = sparse_modes(*next(model.sparse_matrices(state.part(part))), count)
        else:
            values[part], found = dense_modes(*model.matrices(state.part(part)), count, vectors)
        if vectors:
            shapes[part] = found
        if progress is not None:
            progress(min(start + step, len(state)) / len(state))
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi), shapes


def tracked_modes(
    model: FiniteElementModel, branch: AssemblyBranch, state: RobotMotion, values: Array, shapes: Array, count: int
) -> tuple[Array, Array, Array]:
    """Follow the lowest modes from pose to pose, see `linkages.mechanics.flexible.modes.track`.

    From rising frequencies (N, n) and shapes (N, size, n) at the poses of a state, with n a few more than `count` for
    modes that cross; the branch supplies poses in between. Returns frequencies (N, count) [Hz], shapes (N, size,
    count), and the least MAC within each step (N - 1, count).
    """

    def at(one: RobotMotion, values: Array, shapes: Array) -> ModesAt:
        return ModesAt(float(one.time[0]), values, shapes, model.matrices(one)[1][0])

    def between(time: float) -> ModesAt:
        one = branch.motion(np.array([time]))
        found, forms = modes(model, one, values.shape[1])
        return at(one, found[0], forms[0])

    points = (at(state.part(slice(n, n + 1)), values[n], shapes[n]) for n in range(len(state)))
    return track(points, between, count)
