"""`Arrays`: the constant model of a linkage that its kernels read."""

from __future__ import annotations

from typing import Any, NamedTuple

from linkages.base.kernel import Array, Indices, Records, inlined_kernel
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.elimination import Elimination
from linkages.mechanics.planar.functions import Functions


class Arrays(NamedTuple):
    """Constants of the runs of a linkage with nc contacts; `linkages.system.System.arrays` makes them."""

    bodies: Bodies  # the tree
    stiff: Bodies  # the same with stiff shapes made heavy, for the projection onto closed loops
    rows: Records  # closure rows of the cut ideal joints
    elimination: Elimination  # of their reactions
    ends: Records  # of the contacts
    joints: Records  # sources of the forces in the joints
    laws: Records  # of the contacts
    tables: Array  # maps of finite films, profiles; see `linkages.mechanics.planar.contacts.clearance_wrenches`
    limits: Array  # largest eccentricity ratio of contacts that have only a film; infinite for others, (nc,)
    touching: Indices  # 1 where the contact can touch, (nc,)
    law_states: Indices  # continuous states of the contacts' laws: contact, place among its states, (ns, 2)
    free: Indices  # coordinates that are free, powered ones too
    driven: Indices  # coordinates that are prescribed
    powered: Indices  # coordinates with an applied torque
    driven_bodies: Indices  # bodies that the prescribed joints carry
    powered_bodies: Indices  # bodies that the powered joints carry
    motion: Array  # `Motions.arrays` of prescribed motions
    motion_c: Array
    motion_n: Indices
    torque: Array  # `Motions.arrays` of torques
    torque_c: Array
    torque_n: Indices
    loads: Records  # applied loads; see `linkages.mechanics.planar.loads`
    signals: Records  # positions and speeds on which functions of elements, loads and states depend
    states: Records  # additional states
    load_t: Array
    load_c: Array
    load_n: Indices
    beams: Records  # substructures of deformable links
    stations: Records  # of their internal forces, (ns,)
    station_modes: Records  # (ns, nm)
    gravity: Array  # (2,)
    elements: Any  # `linkages.elements.machine.Elements`
    size: float  # length of the linkage [m]


@inlined_kernel
def loads_of(model: Arrays) -> tuple[Records, Records, Records, Array, Array, Indices]:
    """Return what `linkages.mechanics.planar.loads` reads."""
    return model.loads, model.signals, model.states, model.load_t, model.load_c, model.load_n


@inlined_kernel
def functions_of(model: Arrays) -> Functions:
    """Return the functions on which elements, loads and states depend."""
    return model.signals, model.states, model.load_t, model.load_c, model.load_n


def size_of(model: Arrays) -> int:
    """Return the number of coordinates and states, which is the number of entries of a workspace's v."""
    return len(model.free) + len(model.driven) + len(model.states)
