"""Common part of the seven-bar benchmarks: its right-hand side, compiled; a reference solution; the orbit error."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from linkages import System
from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.by_reference import reference as reference_to
from linkages.elements.contact_kinds import ContactWork, add_contacts
from linkages.laws.states import REMEMBERED
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.elimination import make_pivots
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.loop_dynamics import forward_dynamics
from linkages.mechanics.planar.motion import evaluate_motions
from linkages.mechanics.planar.workspace import make_workspace

Array = NDArray[np.float64]
register_jitable(make_pivots)
workspace = kernel(make_workspace)


class FreeMotion(NamedTuple):
    """Equations of motion of y (2n,), a mechanism's free coordinates and their rates, its drives eliminated."""

    #: ``rates(t, y)`` gives y'.
    rates: Callable[[float, Array], Array]
    #: y at the start.
    start: Array
    #: ``eccentricities(t, y)`` gives the clearance joints' eccentricities (nj, 2) [m].
    eccentricities: Callable[[float, Array], Array]


def free_motion(system: System) -> FreeMotion:
    """Set up the equations of motion and compile them.

    Its data are constants of the compiled function, or a reference: array arguments would cost more than
    the dynamics.
    """
    tree, assembly = system.tree, system.assembly
    rows, driven, gravity, model = tree.loop_rows, tree.driven_dofs, system.gravity, packed(system.arrays)
    memory = np.zeros((len(system.ends), REMEMBERED))
    curves = system.motions.arrays
    free = np.setdiff1d(np.arange(tree.size), driven)
    nf, nd, n = len(free), len(driven), tree.size

    @njit
    def evaluate(given, t, y):
        model = reference_to(given)
        bodies, elimination = model.bodies, model.elimination
        work = workspace(len(bodies.records), n, len(rows), bodies.shapes.shape[2])
        joints, rate = np.empty((len(memory), WIDTH)), np.empty(2 * nf)
        value, speed, acceleration = np.empty(nd), np.empty(nd), np.empty(nd)
        evaluate_motions(curves, t, value, speed, acceleration)
        for k in range(nf):
            work.q[free[k]], work.v[free[k]] = y[k], y[nf + k]
        for k in range(nd):
            work.q[driven[k]], work.v[driven[k]], work.a[driven[k]] = value[k], speed[k], acceleration[k]
        body_states(bodies, work.q, work.v, work.pose, work.vel)
        add_contacts(model, reference_to(ContactWork(work, memory, joints)))
        forward_dynamics(bodies, rows, elimination, gravity, work)
        for k in range(nf):
            rate[k], rate[nf + k] = work.v[free[k]], work.a[free[k]]
        return rate, joints

    def rates(t, y):
        return evaluate(model, t, y)[0]

    start = np.concatenate([assembly.q[free], assembly.v[free]])
    rates(0.0, start)
    return FreeMotion(rates, start, lambda t, y: evaluate(model, t, y)[1][:, :2])


def reference(system: System) -> Callable[[Array], Array]:
    """Eccentricities (nt, nj, 2) over time by SciPy's Radau at a tolerance of 1e-10."""
    motion = free_motion(system)
    span = (0.0, system.experiment.duration)
    run = solve_ivp(motion.rates, span, motion.start, "Radau", rtol=1e-10, atol=1e-13, dense_output=True)
    return lambda times: np.array([motion.eccentricities(t, run.sol(t)) for t in times])


def orbit_error(orbit: Array, truth: Array) -> float:
    """Largest distance of a journal from its true place, in parts of its largest eccentricity.

    Parameters
    ----------
    orbit, truth : (nt, nj, 2) arrays
        Eccentricities at the same times.
    """
    apart, size = (np.hypot(e[..., 0], e[..., 1]).max(axis=0) for e in (orbit - truth, truth))
    return float((apart / size).max())
