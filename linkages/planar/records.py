"""The plain arrays that compiled kernels work on."""

from __future__ import annotations

import numpy as np

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2

#: One body and the joint that carries it. A parent always stands before its children.
BODY = np.dtype(
    (
        np.record,
        [
            ("parent", "i8"),
            ("type", "i8"),  # FIXED, REVOLUTE or PRISMATIC
            ("dof", "i8"),  # index of its coordinate in q and v; -1 if fixed
            ("driven", "i8"),  # index of the motion that prescribes it; -1 if free
            ("sign", "f8"),  # revolute: +1 if q turns the body counter-clockwise
            ("x", "f8"),  # joint in the parent's frame [m]
            ("y", "f8"),
            ("ux", "f8"),  # prismatic: unit direction in the parent's frame
            ("uy", "f8"),
            ("mass", "f8"),  # [kg]
            ("cx", "f8"),  # mass centre in the body's frame [m]
            ("cy", "f8"),
            ("inertia", "f8"),  # about the mass centre [kg m2]
        ],
    )
)

#: Row kinds: displacement along a world direction, along a direction fixed to body a, relative angle.
ALONG_WORLD, ALONG_BODY, ANGLE = 0, 1, 2

#: One scalar closure equation between point a on body a and point b on body b. Two or three rows close a cut joint.
ROW = np.dtype(
    (
        np.record,
        [
            ("kind", "i8"),
            ("a", "i8"),
            ("b", "i8"),
            ("ax", "f8"),  # point on body a, in its frame [m]
            ("ay", "f8"),
            ("bx", "f8"),
            ("by", "f8"),
            ("ux", "f8"),  # direction
            ("uy", "f8"),
        ],
    )
)

#: The two ends of a clearance joint: centre of the bearing on body b, of the journal on body j.
ENDS = np.dtype(
    (
        np.record,
        [("bearing", "i8"), ("journal", "i8"), ("bx", "f8"), ("by", "f8"), ("jx", "f8"), ("jy", "f8")],
    )
)
