"""The plain arrays of a linkage that its kernels read."""

from __future__ import annotations

from typing import NamedTuple

from linkages.kernel import Array, Indices, Records


class Arrays(NamedTuple):
    """What does not change during a run of a linkage with nc contacts; `linkages.system.System.arrays` makes it.

    Attributes
    ----------
    bodies, rows, ends, joints : arrays of BODY, ROW, ENDS, JOINT
        The tree, its cut ideal joints, its contacts, where the force in each joint comes from.
    laws, tables
        Records of the force laws, maps of finite films; see `linkages.planar.contacts.clearance_wrenches`.
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
        Applied loads; see `linkages.planar.loads`.
    gravity : (2,) array
    size : float
        Length of the linkage [m].
    """

    bodies: Records
    rows: Records
    ends: Records
    joints: Records
    laws: Records
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
    loads: Records
    load_t: Array
    load_c: Array
    load_n: Indices
    gravity: Array
    size: float
