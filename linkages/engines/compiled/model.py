"""A mechanism and an experiment as plain arrays: all that compiled code needs to run them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.laws import FRICTIONS
from linkages.model.experiment import Experiment
from linkages.planar.contacts import WIDTH
from linkages.planar.dynamics import Workspace, make_workspace
from linkages.planar.motion import Motions
from linkages.system.assembly import Assembly
from linkages.system.law_records import film_limits, film_tables, law_parameters
from linkages.system.loads import pack_loads

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
    bodies, rows, ends : arrays of BODY, ROW, ENDS
        The tree, its cut ideal joints, its contacts.
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
    laws: NDArray[np.record]
    tables: Array
    limits: Array
    touching: Indices
    bristles: Indices
    free: Indices
    driven: Indices
    powered: Indices
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
    """

    dynamics: Workspace
    contacts: Array
    memory: Array
    modes: Indices
    value: Array
    rate: Array
    second: Array


class Calls(NamedTuple):
    """Addresses of the functions of `linkages.engines.compiled.calls`; 0 where nothing is called."""

    solve: int = 0
    jacobian: int = 0
    project: int = 0
    attempt: int = 0
    loads: int = 0
    loads_tangent: int = 0


class Problem(NamedTuple):
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
    )


def pack(assembly: Assembly, experiment: Experiment) -> tuple[Model, Array]:
    """Make the arrays of an assembled experiment, and the state at t = 0."""
    tree = assembly.tree
    laws = law_parameters(tree, experiment)
    tables = film_tables(tree, experiment)
    joints = [experiment.joints[name] for name, _ in tree.contacts]
    touching = np.array([joint.can_touch for joint in joints], dtype=np.int64)
    limits = laws["clearance"] * film_limits(laws, tables)
    limits[touching == 1] = np.inf
    bristles = np.flatnonzero(laws["friction"] == FRICTIONS["lugre"].code)
    free = tree.free_dofs
    torques = Motions([experiment.drives[name].torque_history() for name in tree.powered])
    loads, load_t, load_c, load_n = pack_loads(tree, experiment)
    y = np.concatenate([assembly.q[free], assembly.v[free], np.zeros(len(bristles))])
    model = Model(
        tree.bodies,
        tree.loop_rows,
        tree.ends,
        laws,
        tables,
        limits,
        touching,
        bristles.astype(np.int64),
        free,
        tree.driven_dofs,
        tree.powered_dofs,
        *assembly.motions.arrays,
        *torques.arrays,
        loads,
        load_t,
        load_c,
        load_n,
        tree.mechanism.basis[:, :2].T @ np.array(experiment.gravity),
        error_scale(assembly, experiment, free, len(bristles)),
        tree.extent,
    )
    # what is called by address is compiled for contiguous arrays, and nothing checks them there
    arrays: dict[str, Any] = {
        name: np.ascontiguousarray(x) for name, x in model._asdict().items() if isinstance(x, np.ndarray)
    }
    return model._replace(**arrays), y


def error_scale(assembly: Assembly, experiment: Experiment, free: Indices, bristles: int) -> Array:
    """Return what an error of each entry of the state is measured by.

    A point may err by the length of the linkage or, if that is less, by so many of its smallest clearances (fewer where
    journals touch: a contact's depth is small against the clearance); a turn by what moves a point at the linkage's
    length so far; a rate by the same in the time in which the fastest drive turns by 1 rad.
    """
    tree = assembly.tree
    joints = [experiment.joints[name] for name in tree.play]
    lengths = [(_TOUCH if joint.can_touch else _FILM) * (joint.clearance or np.inf) for joint in joints]
    length = min(tree.extent, *lengths) if lengths else tree.extent
    rates = np.abs(assembly.motions(np.linspace(0.0, experiment.duration, 101))[1])
    fastest = rates.max(initial=0.0) or 2.0 * np.pi / experiment.duration
    turning = np.array([name != "" and _turns(tree.bodies, i) for i, name in enumerate(tree.coordinates)])
    position = np.where(turning[free], length / tree.extent, length)
    return np.concatenate([position, fastest * position, np.full(bristles, 1e-6)])


def _turns(bodies: NDArray[np.record], dof: int) -> bool:
    from linkages.planar.records import REVOLUTE

    return bool(bodies[bodies["dof"] == dof]["type"][0] == REVOLUTE)
