"""The plain arrays of a linkage that its kernels read."""

from __future__ import annotations

from typing import NamedTuple

from linkages.kernel import Array, Indices, Records
from linkages.planar.bodies import Bodies


class Arrays(NamedTuple):
    """What does not change during a run of a linkage with nc contacts; `linkages.system.System.arrays` makes it."""

    bodies: Bodies  # the tree; see `linkages.planar.bodies`
    stiff: Bodies  # the same with modes that are heavier by their stiffness: by these loops are closed
    rows: Records  # of its cut ideal joints
    rank: int  # how many of the rows are independent, but in singular positions
    ends: Records  # of its contacts
    joints: Records  # where the force in each joint comes from
    laws: Records  # of the contacts
    tables: Array  # maps of finite films, profiles; see `linkages.planar.contacts.clearance_wrenches`
    limits: Array  # largest |e| of contacts that have only a film; infinite for others [m], (nc,)
    touching: Indices  # 1 where the contact can touch, (nc,)
    bristles: Indices  # contacts with LuGre friction, (nb,)
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
    loads: Records  # applied loads; see `linkages.planar.loads`
    signals: Records  # what they depend on
    load_t: Array
    load_c: Array
    load_n: Indices
    beams: Records  # substructures of flexible links
    stations: Records  # where their internal forces are computed, (ns,)
    station_modes: Records  # (ns, nm)
    gravity: Array  # (2,)
    size: float  # length of the linkage [m]
