"""An operating point of a linkage: a state of its motion, or an equilibrium, and the equations there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, RunError, Status
from linkages.base.kernel.private import OFF
from linkages.elements.analysis import Analysis
from linkages.engines.compiled.run.linear import slopes
from linkages.engines.compiled.run.model import per_length
from linkages.engines.compiled.run.replay import Steps
from linkages.engines.compiled.run.runner import Runner
from linkages.explore.flow import Flow, expect_valid
from linkages.explore.local_coordinates import LocalCoordinates, local_coordinates
from linkages.explore.numerics import (
    OPERATING_POINT_AT_REST,
    OPERATING_POINT_FLAT,
    OPERATING_POINT_LONGEST,
    OPERATING_POINT_ROUNDS,
    OPERATING_POINT_SAME,
)
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS
from linkages.results.outputs.columns import columns
from linkages.system import System


class Observed(NamedTuple):
    """State on the closed loops (ny,), accelerations of the free coordinates (n,), outputs (no,)."""

    y: Array
    accelerations: Array
    outputs: Array


class LinearisationPoint:
    """A state of a linkage whose prescribed drives stand still, at a time [s].

    `y` (ny,) is the state, see `linkages.engines.compiled.run.model`; `scale` (ny,) the usual change of each entry: of
    clearances, or of the linkage's length, in the time of its motion. InputError if a drive prescribes a motion, or
    nothing can move; RunError if the run to the time fails, or a journal lies outside its film there.
    """

    def __init__(self, system: System, time: float) -> None:
        if OFF:
            raise InputError("environment", "NUMBA_DISABLE_JIT", "linear models need the compiler; unset it")
        system.check_analysis(Analysis.LINEAR)
        for name in system.tree.driven:
            if system.drives[name].speed or system.drives[name].varies:
                problem = "prescribes a motion; give the torque instead (torque = ...), or speed = 0 to hold the joint"
                raise InputError(system.description.source, f"drives.{name}", problem)
        self.system = system.replaced({"solver.integrator": "radau_iia_5"})
        self.time = time
        self.runner = Runner(self.system)
        n = len(self.runner.model.free)
        if n == self.runner.model.elimination.rank:
            raise InputError(
                system.description.source, "drives", "hold all joints, and no link deforms: nothing can move"
            )
        self.y = self.runner.start.copy()
        if time > 0.0:
            flow = Flow(self.system)
            flow.reach(time)
            self.y = flow.y
        expect_valid(self.runner.status(time, self.y), time)
        clearances = system.laws["clearance"]
        self.large = per_length(self.system) * system.tree.extent
        position = self.large * min([1.0, *(clearances[clearances > 0.0] / system.tree.extent)])
        self.scale = np.concatenate([position, system.motion_rate * position, self.runner.scale[2 * n :]])

    def observe(self, y: Array, names: Sequence[str] = (), system: System | None = None) -> Observed:
        """Evaluate the equations and outputs at a state, which is projected onto closed loops."""
        system = system or self.system
        runner = self.runner if system is self.system else Runner(system)
        model = runner.model
        steps = Steps(np.array([self.time]), y[None].copy(), np.zeros((1, len(model.ends))))
        q, v, a, contacts = runner.evaluate(steps, steps.times)
        depth = contacts[0, :, CLEARANCE_OUTPUTS.index("penetration")]
        for k in np.flatnonzero((model.touching == 1) & (depth > 0.0)):
            problem = "is closed at this state, where its law depends on the approach speed and has no derivative"
            raise InputError(system.description.source, system.contacts[k][1], problem)
        found = columns(system, steps.times, q, v, a, contacts, names)
        closed = np.concatenate([q[0, model.free], v[0, model.free], y[2 * len(model.free) :]])
        return Observed(closed, a[0, model.free], np.array([found[name][0] for name in names]))

    def matrix(self) -> tuple[Array, LocalCoordinates, Array]:
        """Return A, the local coordinates, and their rates at the state."""
        found = slopes(self.runner, self.time, self.y)
        local = local_coordinates(self.system, found.closure)
        return (found.jacobian @ local.tangent)[local.entries], local, found.rates[local.entries]

    def settle(self) -> None:
        """Move to an equilibrium near the state, or if Newton's method finds none to a stable one.

        RunError if none is found, or a journal lies outside its film in the one that is found.
        """
        if self.system.own_states:
            raise RunError("no equilibrium is searched for with additional states; give a time of a run instead")
        start = self.y.copy()
        ends = []
        for step_of in (newton_step, falling_step):
            self.y = start.copy()
            if self._settled(step_of):
                ends.append(self.runner.status(self.time, self.y))
                if ends[-1] is Status.OK:
                    return
        problem = "no equilibrium is found from this state"
        if ends or any(joint.has_film for joint in self.system.joints.values()):
            raise RunError(f"{problem} with every journal inside its film; a film without motion may carry no load")
        raise RunError(f"{problem}; start closer to one (positions of the experiment)")

    def _settled(self, step_of: Callable[[Array, Array], Array]) -> bool:
        """Iterate on the accelerations of the independent coordinates at rest; return whether they vanish."""
        n = len(self.runner.model.free)
        self.y[n:] = 0.0
        for _ in range(OPERATING_POINT_ROUNDS):
            a, local, rates = self.matrix()
            m = sum(name.startswith("q.") for name in local.names)
            step = step_of(a[m : 2 * m, :m], rates[m : 2 * m])
            if not np.isfinite(step).all():  # a journal left its film
                return False
            part = np.abs(step / self.large[local.entries[:m]]).max()
            step *= min(1.0, OPERATING_POINT_LONGEST / part) if part > 0.0 else 1.0
            moved = self.y + local.tangent[:, :m] @ step
            moved[n:] = 0.0
            self.y = self.observe(moved).y
            if part <= OPERATING_POINT_SAME:
                break
        return at_rest(a, rates, self.scale[local.entries])


def at_rest(a: Array, rates: Array, scale: Array) -> bool:
    """Check whether the rates of the states vanish, relative to their scale and the largest pole."""
    return bool(
        np.all(np.abs(rates) <= OPERATING_POINT_AT_REST * scale * max(np.abs(np.linalg.eigvals(a)).max(), 1e-300))
    )


def newton_step(slope: Array, acceleration: Array) -> Array:
    """Return Newton's step to where the accelerations vanish; the smallest one if the slope (m, m) is singular."""
    return np.linalg.lstsq(slope, -acceleration, rcond=None)[0].astype(np.float64)


def falling_step(slope: Array, acceleration: Array) -> Array:
    """Return a step along the accelerations, Newton's near a stable equilibrium: all eigenvalues count as stable."""
    values, vectors = np.linalg.eig(slope)
    parts = np.linalg.solve(vectors, acceleration)
    with np.errstate(invalid="ignore", over="ignore"):
        return (vectors @ (parts / np.maximum(np.abs(values), OPERATING_POINT_FLAT))).real
