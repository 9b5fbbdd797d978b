"""What compiled code runs on: a system's arrays, arrays to work on; the state and the scale of its errors.

The state is y = [q, v of the free coordinates; states of the contacts' laws; states of equations of the experiment's
own]. The last are also the last entries of the workspace's v, their rates those of its a.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices
from linkages.base.kernel.dual import dual_array
from linkages.base.kernel.dual_copy import DualCopy
from linkages.elements.machine import count
from linkages.engines.methods import is_implicit
from linkages.mechanics.planar.arrays import Arrays, size_of
from linkages.mechanics.planar.contact_partials import PARTIALS, no_bounds
from linkages.mechanics.planar.contacts import RESULTS, WIDTH, limits_a_row
from linkages.mechanics.planar.loads import LOAD_OUTPUTS
from linkages.mechanics.planar.motion import switch_counts
from linkages.mechanics.planar.reactive_loads import ReactiveLoads, make_reactive_loads
from linkages.mechanics.planar.record_types import ANGLE
from linkages.mechanics.planar.workspace import Workspace, make_workspace
from linkages.system import System

#: Clearances that count as the length of a linkage, at most: with oil, in dry contact.
_FILM, _TOUCH = 1e4, 20.0


#: Places after the kinks of a contact in the ratio of speeds, in the sliding speed, and at the zero of its force; see
#: `linkages.engines.compiled.run.kinks`.
RATIOS, SPEEDS, KINKS = 2, 6, 7


class Kinked(NamedTuple):
    """Arrays to locate kinks: distances at both ends of a step, sides of the kinks, contacts that act, that touch.

    The first nc lines belong to the contacts, the others to the switches of formulas, `KINKS` in each of nf lines.
    """

    starts: Array  # (nc + nf, KINKS)
    ends: Array
    sides: Array
    spans: Array  # change of a switch in the step that is divided, the unit of its distances
    acting: Array  # (nc,)
    touching: Array  # (nc,)


def make_kinked(model: Arrays) -> Kinked:
    """Make the arrays for a model; no side is known."""
    nc, functions = (
        len(model.ends),
        ((model.motion_c, model.motion_n), (model.torque_c, model.torque_n), (model.load_c, model.load_n)),
    )
    count = sum(int(switch_counts(*each).sum()) for each in functions)
    starts, ends, sides, spans = (np.full((nc - (-count // KINKS), KINKS), value) for value in (0.0, 0.0, np.nan, 1.0))
    return Kinked(starts, ends, sides, spans, np.zeros(nc), np.zeros(nc))


class Scratch(NamedTuple):
    """Arrays of a Jacobian: nc contacts, nr closure rows, n coordinates, nb bodies.

    In the two workspaces what follows from coordinates and rates, or from rates alone, is dual; the rest is the work's.
    """

    partials: Array  # of the contacts, (nc, RESULTS, PARTIALS); see `linkages.mechanics.planar.contact_partials`
    bounds: Array  # of the contacts' speeds, (nc, BOUNDS); see the same, infinite without any
    mass: Array  # mass matrix of all coordinates, (n, n); rows and columns of driven ones are 0
    moved: Workspace
    faster: Workspace
    rows: Array  # accelerations of the rows, dual, (nr,)
    tau: Array  # of one direction: changes of generalised forces, accelerations, (n,)
    a: Array
    reaction: Array  # changes of the rows' reactions, (nr,)
    changed: Indices  # 1 for coordinates that a direction of duals changes, (n,)
    moves: Indices  # which bodies move with them, (nb,); see `linkages.mechanics.planar.traversal.mark_moved`
    reactive: ReactiveLoads  # dual


#: Arrays of a workspace that follow from rates; the coordinates and the poses do not.
_OF_RATES = "v", "tau", "vel", "acc", "wrench", "bias", "shape_bias"


def make_scratch(w: Workspace, nc: int, reactive: ReactiveLoads) -> Scratch:
    """Make the arrays for a workspace, nc contacts and reactive loads, all zero, without bounds."""
    n, nr = len(w.q), len(w.reaction)
    changes: dict[str, Any] = {name: dual_array(*getattr(w, name).shape) for name in ("q", "pose", *_OF_RATES)}
    moved = w._replace(**changes)
    partials, bounds = np.zeros((nc, RESULTS, PARTIALS)), np.tile(no_bounds(), (nc, 1))
    duals = moved, moved._replace(q=w.q, pose=w.pose), dual_array(nr)
    closed = np.zeros(n), np.zeros(n), np.zeros(nr)
    marks = np.zeros(n, np.int64), np.zeros(len(w.bias), np.int64)
    return Scratch(partials, bounds, np.zeros((n, n)), *duals, *closed, *marks, DualCopy(reactive).value)


class Work(NamedTuple):
    """Arrays that an evaluation fills."""

    dynamics: Workspace
    solved: Array  # time and state at which everything is known; NaN if it is not, (1 + ny,)
    contacts: Array  # `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS`, (nc, WIDTH)
    memory: Array  # of the contacts, see `linkages.mechanics.planar.contact_memory`
    modes: Indices  # 1 in contact, -1 free, (nc,)
    value: Array  # for prescribed motions and torques
    rate: Array
    second: Array
    forces: Array  # result for joints, (nj, 3); see `linkages.results.outputs.quantity.Snapshot`
    efforts: Array  # for drives, (nd,)
    applied: Array  # for loads, (nl, 4)
    reactive: ReactiveLoads
    scratch: Scratch
    kinked: Kinked
    due: Array  # time of the next sample of each state [s], infinite for continuous ones, (nz,)


class Equations(NamedTuple):
    """Arguments of the right-hand side other than time and state."""

    model: Arrays
    work: Work
    implicit: bool  # whether the method is Radau IIA; else Dormand and Prince's pair


def make_work(model: Arrays, memory: Array, modes: Indices) -> Work:
    """Make the work arrays of a model around the contacts' memory and modes."""
    nb, nr, nc, nd = len(model.bodies.records), len(model.rows), len(model.ends), len(model.driven)
    n, nm, most = size_of(model), model.bodies.shapes.shape[2], max(nd, len(model.powered))
    dynamics, ny = make_workspace(nb, n, nr, nm), 2 * len(model.free) + len(model.law_states) + len(model.states)
    reactive = make_reactive_loads(model, dynamics)
    return Work(
        dynamics,
        np.full(1 + ny, np.nan),
        np.zeros((nc, WIDTH)),
        memory,
        modes,
        np.zeros(most),
        np.zeros(most),
        np.zeros(most),
        np.zeros((len(model.joints), 3)),
        np.zeros(nd + len(model.powered)),
        np.zeros((len(model.loads) + count(model.elements), len(LOAD_OUTPUTS))),
        reactive,
        make_scratch(dynamics, nc, reactive),
        make_kinked(model),
        np.full(len(model.states), np.inf),
    )


def start_state(system: System) -> Array:
    """State at t = 0, (ny,): positions and rates of the free coordinates, then states of laws, other states."""
    free, assembly = system.tree.free_dofs, system.assembly
    return np.concatenate([assembly.q[free], assembly.v[free], system.law_states.starts, system.start_states])


def clearances(system: System) -> Array:
    """Return the clearance of the joint of each end of a contact, infinite without one, (nj,) [m]."""
    return np.array([joint.clearance or np.inf for joint in system.models])


def error_scale(system: System, extent: Array | float | None = None, play: Array | None = None) -> Array:
    """Return the scale of an error of each entry of the state, (..., ny).

    A point may err by the length of the linkage or, if that is less, by so many of its smallest clearances (fewer where
    journals touch: a contact's depth is small against the clearance); a turn by what moves a point at the linkage's
    length so far; a rate by the same in the time in which the motion turns by 1 rad (`System.motion_rate`); states of
    laws by their magnitude; vibrations see `_limit_vibrations`. `extent` (...) has the length of the linkage, `play`
    (..., nj) its `clearances`; default its own [m].
    """
    size = np.asarray(system.tree.extent if extent is None else extent)[..., None]
    turns = limits_a_row(system.ends) & (system.ends["row"]["term"]["kind"] == ANGLE)
    counts, lever = [_TOUCH if joint.can_touch else _FILM for joint in system.models], system.ends["lever"]
    least = np.array(counts) * (clearances(system) if play is None else play)
    length = np.minimum(size, (least * np.where(turns, size / lever, 1.0)).min(axis=-1, initial=np.inf, keepdims=True))
    angle = (least / np.where(turns, lever, size)).min(axis=-1, initial=1.0, keepdims=True)
    position = np.repeat(length, len(system.tree.free_dofs), axis=-1)
    position[..., system.tree.free_angles] = angle
    rate = system.motion_rate * position
    resolved = system.settings.resolve_vibrations or not is_implicit(system)
    if len(system.tree.shape_frequencies) and resolved:
        _limit_vibrations(system, size, position, rate)
    others = np.concatenate([system.law_states.scales, system.state_scales])
    others = np.broadcast_to(others, (*size.shape[:-1], len(others)))
    return np.concatenate([position, rate, others], axis=-1)


def _limit_vibrations(system: System, size: Array, position: Array, rate: Array) -> None:
    """Limit the scales of shape coordinates, the last ones, and of their rates (..., n).

    A mode that limits the steps of an explicit method vibrates with an amplitude as large as its tolerance. So it may
    err by its static deflection under the accelerations of the motion and of gravity, its rate by the same times its
    frequency. An implicit method damps such modes, and omits vibrations that carry up to 0.3 % of a force in slow
    machines, unless ``solver.resolve_vibrations`` asks for them. `size` (..., 1) is the length of the linkage [m].
    """
    frequencies = system.tree.shape_frequencies
    acceleration = size * system.motion_rate**2 + np.linalg.norm(system.gravity)
    for scale, largest in (position, acceleration / frequencies**2), (rate, acceleration / frequencies):
        of_shapes = scale[..., -len(frequencies) :]
        np.minimum(of_shapes, largest, out=of_shapes)


def per_length(system: System) -> Array:
    """Return the change of each free coordinate that moves a point at the linkage's length by 1 m, (n,) [rad, m]."""
    result = np.ones(len(system.tree.free_dofs))
    result[system.tree.free_angles] = 1.0 / system.tree.extent
    return result
