"""The records that compiled kernels work on."""

from __future__ import annotations

from linkages.base.kernel import record_type

#: A point fixed to a body: joints, contacts, loads, springs and outputs attach to it; see
#: `linkages.mechanics.planar.markers`.
MARKER = record_type(
    body="i8",
    x="f8",  # in the body's frame [m]
    y="f8",
)

#: Types of joints. A `NODE` is no joint: the body is massless, and moves with a place of its parent, a deformable body.
FIXED, REVOLUTE, PRISMATIC, NODE = 0, 1, 2, 3

#: One body and the joint that carries it. A parent comes before its children. See `linkages.mechanics.planar.bodies`.
BODY = record_type(
    mount=MARKER,  # joint on the parent; node: its place on the undeformed body
    type="i8",  # FIXED, REVOLUTE, PRISMATIC or NODE
    dof="i8",  # index of its coordinate in q and v; -1 if fixed
    driven="i8",  # index of the motion that prescribes the coordinate; -1 if free
    moving="i8",  # 1 if a free coordinate moves it, directly or through its parents
    carries="i8",  # 1 if it carries other bodies
    detached="i8",  # node: 1 if other bodies than nodes of its parent are between it and the parent
    sign="f8",  # revolute: +1 if q turns the body counter-clockwise
    ux="f8",  # prismatic: unit direction in the parent's frame; node: e1 of the parent
    uy="f8",
    shapes="i8",  # number of shape coordinates
    bends="i8",  # number of shapes across, which come first; the others are along
    eta="i8",  # index of the first shape coordinate in q and v
    ex="f8",  # deformable body: direction of e1 in its frame
    ey="f8",
    mass="f8",  # [kg]
    cx="f8",  # mass centre in the body's frame [m]
    cy="f8",
    inertia="f8",  # about the mass centre [kg m2]
)

#: Kinds of terms: displacement along a world direction, along a direction fixed to body a, relative angle.
ALONG_WORLD, ALONG_BODY, ANGLE = 0, 1, 2

#: A displacement or angle between markers a and b.
TERM = record_type(
    kind="i8",
    a=MARKER,
    b=MARKER,
    ux="f8",  # direction
    uy="f8",
)

#: One scalar closure equation: a term is zero. Two or three such rows close a cut joint. The row of a gear: the term
#: less ``ratio`` times the other term is ``offset``. Rows multiplied by their ``scale`` are comparable.
ROW = record_type(
    term=TERM,
    ratio="f8",  # 0: no other term
    other=TERM,
    offset="f8",
    scale="f8",
)

#: Kinds of contact: a journal in its bearing, a corner of a block at a wall of its slot (or any point at a straight
#: line), a journal and a bearing at least one of which is worn, a coordinate at its limit,
#: a journal in a bearing with a groove or a tilt, whose film depends on the bearing's angle, and one whose film
#: remembers.
JOURNAL, CORNER, WORN, STOP, ORIENTED, REMEMBERING = 0, 1, 2, 3, 4, 5

#: The two ends of a contact. Journal: centre of the bearing on the outer body, of the journal on the inner one.
#: Corner: a point of the slot's middle line on the outer body, the corner on the inner one. Stop: any points; the
#: value of a row is limited: the angle between the bodies or, for the flank of a gear, its closure error.
ENDS = record_type(
    kind="i8",
    bearing=MARKER,  # on the outer body
    journal=MARKER,  # on the inner body
    nx="f8",  # corner: normal into the wall, in the outer body's frame; stop: +1 if a growing value meets it, else -1
    ny="f8",
    half="f8",  # corner: half the height of the block [m]; stop: nx times the place of the stop, less the clearance
    lever="f8",  # stop: its depth and place per value: 1, or the base radius of a wheel [m]
    arm="f8",  # stop: sliding speed over the angular velocity of the inner body relative to the outer one
    row=ROW,
)

#: A position or speed that a load depends on: ``scale`` times a term's value less ``offset``, or times its rate.
SIGNAL = record_type(
    term=TERM,
    scale="f8",
    offset="f8",
    rate="i8",  # 1 for the rate
)

#: An additional state: the function that gives its rate or, with a sampling period, its next value; or a controller in
#: Python that gives this state and others after it.
STATE = record_type(
    function="i8",  # of a controller: its first argument after the time; others follow
    period="f8",  # [s]; 0: continuous
    controller="i8",  # CONTROLLERS[name].address; 0: none
    arguments="i8",  # their number after the time
    results="i8",  # number of states that it gives; 0 after the first one
)

#: One friction in an ideal joint. It acts along a term, on its second body and against the first.
LOAD = record_type(
    motion="i8",  # index of the value's function
    sign="f8",  # change of the joint's coordinate, or of the angle, over the change of the term: 1 or -1
    term=TERM,
    joint="i8",  # friction that depends on a joint force: index of the joint; else -1
    share="i8",  # its function: torque or force per joint force
    leverage="f8",  # prismatic: joint force per moment, 2 over the length of the slider [1/m]
)

#: Sources of the force in a joint: the tree's recursion, a cut joint's closure rows, a journal's contact, the contacts
#: of a guide's corners.
OF_TREE, OF_ROWS, OF_JOURNAL, OF_CORNERS = 0, 1, 2, 3

#: One joint of the mechanism, for the force in it.
JOINT = record_type(
    source="i8",
    type="i8",  # FIXED, REVOLUTE or PRISMATIC
    at="i8",  # body that it carries, first row, or first contact
    reversed="i8",  # tree: 1 if it carries the mechanism's parent
    parent="i8",  # body
    child=MARKER,  # place of the joint on the child
    ux="f8",  # prismatic: unit direction in the parent's frame
    uy="f8",
)
