"""A run of the compiled engine as a trajectory."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import Status, TimeOverError
from linkages.base.signals import deferred
from linkages.elements.analysis import Analysis
from linkages.engines.budget import WINDOW, Budget, most
from linkages.engines.compiled.run.replay import Steps
from linkages.engines.compiled.run.runner import STATUS, Runner, join
from linkages.engines.methods import method
from linkages.engines.numerics import SIMULATION_FEW
from linkages.mechanics.integrate.driver import PAUSED, Record
from linkages.results.derivatives import Direction
from linkages.results.outputs.columns import Columns
from linkages.results.trajectory import Loops, Trajectory, sample
from linkages.system import System
from linkages.system.ideal_motion import cause


def simulate(
    system: System,
    progress: Callable[[float], None] | None = None,
    outputs: Sequence[str] | None = None,
    wrt: Sequence[str | Direction] = (),
) -> Trajectory:
    """Simulate a system with the compiled engine; see `linkages.engines.assessment.simulate`.

    Outputs of linkages with closed loops have their coordinates in addition. `progress` is called after some thousand
    steps, and at once where its attribute `stop` (1,), if it has one, is not zero.
    """
    if wrt:
        system.check_analysis(Analysis.DERIVATIVES)
    started = clock.perf_counter()
    runner = Runner(system, stop=getattr(progress, "stop", None))
    t, y, step, status = 0.0, runner.start, 0.0, Status.OK
    parts, budget, window = [], Budget(system), min(WINDOW, most(system))
    if system.has_light_links:
        window = min(window, SIMULATION_FEW)
    until = np.inf
    try:
        while True:
            with deferred():  # keeps the steps up to a signal
                part = runner.run(t, y, step, window, differentiated=bool(wrt))
                parts.append(part)
            t = float(part.times[-1])
            y, step = part.states[-1], part.next_step
            if progress is not None:
                progress(t)
            if system.has_light_links and (k := _first_alone(runner, part)) is not None:
                status, until = Status.FREE_OF_MASS, float(part.times[k])
                break
            if part.status != PAUSED:
                status = STATUS[part.status]
                break
            if budget.spent(t, part.steps):
                status = Status.TOO_MANY_STEPS
                break
    except (KeyboardInterrupt, TimeOverError) as ended:
        status = Status.TIME_OVER if isinstance(ended, TimeOverError) else Status.INTERRUPTED
        if not parts:
            raise
    provenance = {
        "engine": "compiled",
        "method": method(system, "compiled"),
        "steps": sum(part.steps for part in parts),
        "rejected": sum(part.rejected for part in parts),
        "evaluations": sum(part.evaluations for part in parts),
    }
    steps = join(parts)
    parts.clear()  # their memory is free for the columns
    status, end = cause(status, system, min(float(steps.times[-1]), until))
    provenance["wall_time"] = clock.perf_counter() - started
    loops = Loops(system.tree, system.tree.loop_rows)
    if outputs is not None and len(loops.rows):
        outputs = tuple(dict.fromkeys([*outputs, *(f"q.{name}" for name in system.tree.coordinates)]))
    times = np.unique(steps.times[steps.times <= end])
    run = sample(times, Replay(runner, steps, outputs), status, provenance, loops)
    run = replace(run, accuracy=system.settings.accuracy)
    if not wrt:
        return run
    from linkages.engines.compiled.derivatives.sensitivity import Differentiation

    return replace(run, sensitivity=Differentiation(runner, steps, wrt).derivatives(run.time, outputs))


def _first_alone(runner: Runner, part: Record) -> int | None:
    """Return the first step at which a link without mass can move alone, None if there is none."""
    steps = join([part])
    return runner.system.first_alone(runner.evaluate(steps, steps.times)[0])


def longest_step(system: System) -> float | None:
    """Return the longest step of the experiment [s]; None if it gives none."""
    return system.settings.max_step


@dataclass(frozen=True, eq=False)
class Replay:
    """Columns at any times of a run; see `linkages.engines.compiled.run.replay`."""

    runner: Runner
    steps: Steps
    outputs: Sequence[str] | None = None

    def __call__(self, times: Array) -> Columns:
        """Compute the columns at the given times."""
        return self.runner.outputs(self.steps, times, self.outputs)

    def states_at(self, times: Array) -> tuple[Array, Array, Array, Array]:
        """Compute coordinates, rates, accelerations and contacts at the given times."""
        return self.runner.evaluate(self.steps, times)
