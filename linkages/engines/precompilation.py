"""Plans of `precompiled` for the kernels that the engines will call, found by a run of the drop test.

The compiled types of kernels do not depend on the mechanism. Plans do not assemble the linkage of the drop test, and
kernels that need the assembled linkage come last: the calling process assembles its linkage in the meantime.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba import types

from linkages.base.kernel.by_reference import packed, reference_type
from linkages.engines.assessment import assess
from linkages.engines.drop import drop
from linkages.laws.film.map_nodes import finite_force
from linkages.mechanics.planar.contacts import WIDTH
from linkages.results.outputs.columns import columns
from linkages.results.summary import summarize
from linkages.system import System


def compiled(implicit: bool) -> list[Callable[[], Any]]:
    """List the jobs for the compiled engine."""
    from linkages.engines.compiled.run.equations import solve_state
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
    step = (equations, stepper, number, number, vector, types.boolean)
    wanted: list[tuple[Any, ...]] = [(solve_state, equations, number, vector)]
    if implicit:
        wanted += [(jacobian, equations, number, vector, matrix, matrix), (attempt_radau_iia_5, *step)]
    else:
        wanted += [(attempt_dormand_prince_5_4, *step)]
    prepared = [partial(kernel.prepare, *kinds) for kernel, *kinds in wanted]
    return [*prepared, partial(_outputs, system), partial(_numbers, system), partial(finite_force, 0.5, 1.0, 0.1, 1.0)]


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
        partial(drive_forces, place, rooms.work, rooms.friction, 0.0, state, np.zeros(n), added, total, drive),
        partial(_outputs, system),
        partial(joint_forces, place, rooms.work, np.zeros((nc, 2)), state, np.zeros(n + WIDTH * nc)),
        lambda: system.assembly,
    ]


def _numbers(system: System) -> None:
    """Run a system, and compile what its table needs: peaks and their errors."""
    summarize(assess(system, "compiled"))


def _outputs(system: System) -> None:
    """Compile the formulas of outputs, which are compiled at their first call."""
    n, nc = system.tree.size, len(system.ends)
    zero = np.zeros((1, n))
    columns(system, np.zeros(1), zero, zero, zero, np.zeros((1, nc, WIDTH)))
