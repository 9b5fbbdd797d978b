"""Plans of `precompiled` for the kernels that the engines will call, by the types that the drop test has.

The compiled types of kernels do not depend on the mechanism. Kernels that need the assembled linkage come late, or the
assembly last: the calling process assembles its linkage in the meantime.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, cast

import numpy as np
from numba import types

from linkages.base.arrays import Array
from linkages.base.errors import Status
from linkages.base.kernel import bound
from linkages.base.kernel.by_reference import packed, reference_type
from linkages.engines.drop import drop
from linkages.laws.film.map_nodes import finite_force
from linkages.mechanics.planar.closure import follow_branch
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.reactions import row_reactions
from linkages.results.extremes import extremes, integral
from linkages.results.outputs.columns import columns
from linkages.results.outputs.registry import pack
from linkages.results.trajectory import Trajectory
from linkages.system import System


def compiled(implicit: bool) -> list[Callable[[], Any]]:
    """List the jobs for the compiled engine."""
    from linkages.engines.compiled.run.equations import residual, solve_state
    from linkages.engines.compiled.run.jacobian import jacobian
    from linkages.engines.compiled.run.methods import attempt_dormand_prince_5_4, attempt_radau_iia_5
    from linkages.engines.compiled.run.model import Equations, make_work
    from linkages.mechanics.integrate.stepper import make_stepper

    method = "radau_iia_5" if implicit else "dormand_prince_5_4"
    # accurate runs divide steps at kinks, by kernels that others do not need
    system = drop().replaced({"solver.integrator": method, "solver.accuracy": 1e-7})
    work = make_work(system.arrays, np.zeros((0, 2)), np.zeros(0, np.int64))
    equations = reference_type(packed(Equations(system.arrays, work, implicit)))
    stepper = reference_type(packed(make_stepper(2 * system.tree.size, system.tree.size)))
    number, vector, matrix = types.float64, types.float64[::1], types.float64[:, ::1]
    state, step = (equations, number, vector), (equations, stepper, number, number, vector, types.boolean)
    wanted: list[tuple[Any, ...]] = [(solve_state, *state)]
    if implicit:
        wanted += [(residual, *state, vector, vector), (jacobian, *state, matrix, matrix), (attempt_radau_iia_5, *step)]
    else:
        wanted += [(attempt_dormand_prince_5_4, *step)]
    prepared = [partial(kernel.prepare, *kinds) for kernel, *kinds in wanted]
    return [*prepared, *(partial(job, system) for job in (_outputs, _run, _ideal)), *_NUMBERS]


def drake() -> list[Callable[[], Any]]:
    """List the jobs for the Drake engine, without loading Drake."""
    from linkages.engines.drake.joint_forces import Rooms, drive_forces, joint_forces, placed

    system = drop()
    n, nc = system.tree.size, len(system.ends)
    rooms, total, powered = Rooms(system), np.zeros(n), len(system.tree.powered)
    added, drive = np.zeros(powered), np.zeros(len(system.tree.driven) + powered)
    places, state = np.arange(n), np.zeros(2 * n)
    place = placed(system, places, places + n, places, n)
    return [
        partial(drive_forces, place, rooms.work, rooms.reactive, 0.0, state, np.zeros(n), added, total, drive),
        partial(_outputs, system),
        partial(_ideal, system),
        *_NUMBERS,
        partial(joint_forces, place, rooms.work, np.zeros((nc, 2)), state, np.zeros(n + WIDTH * nc)),
        lambda: system.assembly,
    ]


def _peaks() -> None:
    """Find the peaks of a column, and its integral."""

    def evaluate(times: Array) -> dict[str, Array]:
        return {"time": times, "x": np.sin(times)}

    times = np.arange(9.0)
    run = Trajectory(times, evaluate(times), Status.OK, {}, evaluate, accuracy=1e-12)  # so that it divides intervals
    extremes(run, ["x"])
    integral(run, "x")


_NUMBERS: list[Callable[[], Any]] = [_peaks, partial(finite_force, 0.5, 1.0, 0.1, 1.0)]  # of the table of a run


def _ideal(system: System) -> None:
    """Compile the kernels of the ideal motion."""
    tree, zero = system.tree, np.zeros((1, system.tree.size))
    places = zero[0], 1, zero[0], zero, zero, zero, zero[0]
    bound(follow_branch, tree.bodies, tree.closure_rows, tree.closing_dofs, tree.extent, *places)
    kinds = map(reference_type, (packed(system.arrays), tree.workspace(tree.closure_rows)))
    cast(Any, row_reactions).prepare(*kinds)


def _run(system: System) -> None:
    """Compile the kernels for outputs at any times of a run, and for the run."""
    from linkages.engines.compiled.run.binding import run
    from linkages.engines.compiled.run.job import make_given, make_job
    from linkages.engines.compiled.run.replay import Steps
    from linkages.engines.compiled.run.sampling import tabulate_run

    zero, stop = np.zeros((1, 1)), np.zeros(1, np.int64)
    job = packed(make_job(make_given(system, pack(system, ()), np.zeros((0, 2)))))
    bound(tabulate_run, job, packed(Steps(zero[0], zero, zero)), zero[0], zero)
    bound(run, job, zero, False, 0.0, zero[0], 0.0, 1, 0.0, stop)


def _outputs(system: System) -> None:
    """Compile the formulas of outputs, which are compiled at their first call."""
    n, nc = system.tree.size, len(system.ends)
    zero = np.zeros((1, n))
    columns(system, np.zeros(1), zero, zero, zero, np.zeros((1, nc, WIDTH)))
