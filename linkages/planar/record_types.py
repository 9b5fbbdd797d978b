"""The plain arrays that compiled kernels work on."""

from __future__ import annotations

from linkages.kernel import record_type

#: A point fixed to a body: what joints, contacts, loads, springs and outputs attach to; see `linkages.planar.markers`.
MARKER = record_type(
    body="i8",
    x="f8",  # in the body's frame [m]
    y="f8",
)

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2

#: One body and the joint that carries it. A parent always stands before its children.
BODY = record_type(
    mount=MARKER,  # joint on the parent
    type="i8",  # FIXED, REVOLUTE or PRISMATIC
    dof="i8",  # index of its coordinate in q and v; -1 if fixed
    driven="i8",  # index of the motion that prescribes it; -1 if free
    moving="i8",  # whether a free joint carries it, directly or through its parents
    sign="f8",  # revolute: +1 if q turns the body counter-clockwise
    ux="f8",  # prismatic: unit direction in the parent's frame
    uy="f8",
    mass="f8",  # [kg]
    cx="f8",  # mass centre in the body's frame [m]
    cy="f8",
    inertia="f8",  # about the mass centre [kg m2]
)

#: Row kinds: displacement along a world direction, along a direction fixed to body a, relative angle.
ALONG_WORLD, ALONG_BODY, ANGLE = 0, 1, 2

#: One scalar closure equation between markers a and b. Two or three rows close a cut joint.
ROW = record_type(
    kind="i8",
    a=MARKER,
    b=MARKER,
    ux="f8",  # direction
    uy="f8",
)

#: Kinds of contact: a journal in its bearing, a corner of a block at a wall of its slot, a journal and a bearing of
#: which one or both are worn.
JOURNAL, CORNER, WORN = 0, 1, 2

#: The two ends of a contact. Journal: centre of the bearing on the outer body, of the journal on the inner one.
#: Corner: a point of the slot's middle line on the outer body, the corner on the inner one.
ENDS = record_type(
    kind="i8",
    bearing=MARKER,  # on the outer body
    journal=MARKER,  # on the inner body
    nx="f8",  # corner: normal into the wall, in the outer body's frame
    ny="f8",
    half="f8",  # corner: half the height of the block [m]
)

#: Kinds of applied load.
FORCE, TORQUE, SPRING, TORSION = 0, 1, 2, 3

#: One applied load. A force acts at marker a, a torque on its body; their values over time are motions
#: ``motion`` (and ``motion + 1``, a force's second component). A spring joins marker a to marker b; a torsion spring
#: turns b's body against a's.
LOAD = record_type(
    kind="i8",
    a=MARKER,
    b=MARKER,
    motion="i8",  # index of the value over time; -1 for springs
    turns="i8",  # force: 1 if given in the body's axes, 0 if in plane axes
    sign="f8",  # torsion: +1 if its angle grows with b's angle from a
    stiffness="f8",  # [N/m], torsion [N m/rad]
    free="f8",  # free length [m] or angle [rad]
    damping="f8",  # [N s/m], torsion [N m s/rad]
)

#: Where the force in a joint comes from: the tree's recursion, a cut joint's closure rows, a journal's contact, the
#: contacts of a guide's corners.
OF_TREE, OF_ROWS, OF_JOURNAL, OF_CORNERS = 0, 1, 2, 3

#: One joint of the mechanism, for the force in it.
JOINT = record_type(
    source="i8",
    type="i8",  # FIXED, REVOLUTE or PRISMATIC
    at="i8",  # body that it carries, first row, or first contact
    reversed="i8",  # tree: 1 if it carries the mechanism's parent
    parent="i8",  # body
    child=MARKER,  # where the joint is on the child
    ux="f8",  # prismatic: unit direction in the parent's frame
    uy="f8",
)
