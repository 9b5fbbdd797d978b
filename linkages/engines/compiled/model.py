"""A system as the named tuples of plain arrays that compiled code runs on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.planar.contacts import WIDTH
from linkages.planar.dynamics import Workspace, make_workspace
from linkages.planar.loads import LOAD_OUTPUTS
from linkages.planar.records import REVOLUTE
from linkages.system import System

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_FILM, _TOUCH = (
    1e4,
    20.0,
)  # clearances that count as the length of a linkage, at most: with oil, in dry contact


class Model(NamedTuple):
    """Everything that does not change during a run.

    The state is y = [q, v of the free coordinates; bristles of the contacts with LuGre friction].

    Attributes
    ----------
    bodies, rows, ends, joints : arrays of BODY, ROW, ENDS, JOINT
        The tree, its cut ideal joints, its contacts, where the force in each joint comes from.
    laws, tables
        As for `linkages.planar.contacts.clearance_wrenches`.
    limits : (nc,) array
        Largest |e| of contacts that have only a film; infinite for others [m].
    touching : (nc,) array of int
        1 where the contact can touch.
    bristles : (nb,) array of int
        Contacts with LuGre friction.
    free, driven, powered : arrays of int
        Coordinates: free (powered ones too), prescribed, with an applied torque.
    driven_bodies, powered_bodies : arrays of int
        Bodies that the prescribed and the powered joints carry.
    motion, motion_c, motion_n, torque, torque_c, torque_n
        `Motions.arrays` of prescribed motions and of torques.
    loads, load_t, load_c, load_n
        As `linkages.system.loads.pack_loads` gives them.
    gravity : (2,) array
    scale : (ny,) array
        What an error of each entry of y is measured by, see `error_scale`.
    size : float
        Length of the linkage [m].
    """

    bodies: NDArray[np.record]
    rows: NDArray[np.record]
    ends: NDArray[np.record]
    joints: NDArray[np.record]
    laws: NDArray[np.record]
    tables: Array
    limits: Array
    touching: Indices
    bristles: Indices
    free: Indices
    driven: Indices
    powered: Indices
    driven_bodies: Indices
    powered_bodies: Indices
    motion: Array
    motion_c: Array
    motion_n: Indices
    torque: Array
    torque_c: Array
    torque_n: Indices
    loads: NDArray[np.record]
    load_t: Array
    load_c: Array
    load_n: Indices
    gravity: Array
    scale: Array
    size: float


class Work(NamedTuple):
    """Arrays that an evaluation fills.

    Attributes
    ----------
    dynamics : Workspace
    contacts : (nc, WIDTH) array
        `linkages.planar.contacts.CLEARANCE_OUTPUTS`.
    memory : (nc, 2) array
        `linkages.planar.contacts.MEMORY`.
    modes : (nc,) array of int
        1 in contact, -1 free.
    value, rate, second : arrays
        For prescribed motions and torques.
    forces, efforts, applied : (nj, 3), (nd,), (nl, 4) arrays
        Of joints, drives and loads; see `linkages.outputs.values.View`.
    """

    dynamics: Workspace
    contacts: Array
    memory: Array
    modes: Indices
    value: Array
    rate: Array
    second: Array
    forces: Array
    efforts: Array
    applied: Array


class Calls(NamedTuple):
    """Addresses of the functions of `linkages.engines.compiled.calls`; 0 where nothing is called."""

    solve: int = 0
    jacobian: int = 0
    project: int = 0
    attempt: int = 0
    loads: int = 0
    loads_tangent: int = 0


class Equations(NamedTuple):
    """What the integrators hand on: the model, arrays to work on, functions."""

    model: Model
    work: Work
    calls: Calls


def make_work(model: Model, memory: Array, modes: Indices) -> Work:
    """Make the work arrays of a model around the contacts' memory and modes."""
    n, nm = len(model.free) + len(model.driven), max(len(model.driven), len(model.powered))
    return Work(
        make_workspace(len(model.bodies), n, len(model.rows)),
        np.zeros((len(model.ends), WIDTH)),
        memory,
        modes,
        np.zeros(nm),
        np.zeros(nm),
        np.zeros(nm),
        np.zeros((len(model.joints), 3)),
        np.zeros(len(model.driven) + len(model.powered)),
        np.zeros((len(model.loads), len(LOAD_OUTPUTS))),
    )


def pack(system: System) -> tuple[Model, Array]:
    """Make the arrays of a system, and the state at t = 0."""
    tree, assembly = system.tree, system.assembly
    limits = system.laws["clearance"] * system.film_limits
    limits[system.touching] = np.inf
    free = tree.free_dofs
    y = np.concatenate([assembly.q[free], assembly.v[free], np.zeros(len(system.bristles))])
    model = Model(
        tree.bodies,
        tree.loop_rows,
        tree.ends,
        tree.joints,
        system.laws,
        system.film_tables,
        limits,
        system.touching.astype(np.int64),
        system.bristles,
        free,
        tree.driven_dofs,
        tree.powered_dofs,
        tree.driven_bodies,
        tree.powered_bodies,
        *system.motions.arrays,
        *system.torques.arrays,
        *system.loads,
        system.gravity,
        error_scale(system),
        tree.extent,
    )
    # what is called by address is compiled for contiguous arrays, and nothing checks them there
    arrays: dict[str, Any] = {
        name: np.ascontiguousarray(x) for name, x in model._asdict().items() if isinstance(x, np.ndarray)
    }
    return model._replace(**arrays), y


def error_scale(system: System) -> Array:
    """Return what an error of each entry of the state is measured by.

    A point may err by the length of the linkage or, if that is less, by so many of its smallest clearances (fewer where
    journals touch: a contact's depth is small against the clearance); a turn by what moves a point at the linkage's
    length so far; a rate by the same in the time in which the fastest drive turns by 1 rad.
    """
    tree, free = system.tree, system.tree.free_dofs
    lengths = [
        (_TOUCH if joint.can_touch else _FILM) * (joint.clearance or np.inf) for joint in system.models
    ]
    length = min(tree.extent, *lengths) if lengths else tree.extent
    duration = system.experiment.duration
    rates = np.abs(system.motions(np.linspace(0.0, duration, 101))[1])
    fastest = rates.max(initial=0.0) or 2.0 * np.pi / duration
    turns = np.zeros(tree.size, dtype=bool)
    turns[tree.bodies["dof"][tree.bodies["type"] == REVOLUTE]] = True
    position = np.where(turns[free], length / tree.extent, length)
    return np.concatenate([position, fastest * position, np.full(len(system.bristles), 1e-6)])
