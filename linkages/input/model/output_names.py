"""Names of the outputs of links, frames and joints that an experiment can request, with meanings and units."""

from __future__ import annotations

from linkages.elements.machine import outputs_of_models
from linkages.elements.outputs import Source

#: Outputs of a link or frame, in plane axes, with units.
QUANTITIES = {
    "x": "position of the frame's origin along x_P [m]",
    "y": "position along y_P [m]",
    "angle": "angle of the frame's x axis [rad]",
    "vx": "velocity along x_P [m/s]",
    "vy": "velocity along y_P [m/s]",
    "omega": "angular velocity [rad/s]",
    "ax": "acceleration along x_P [m/s2]",
    "ay": "acceleration along y_P [m/s2]",
    "alpha": "angular acceleration [rad/s2]",
    "acceleration": "magnitude of the point's acceleration [m/s2]",
}

#: Outputs of a joint's position.
PIN_QUANTITIES = {name: text for name, text in QUANTITIES.items() if name not in ("angle", "omega", "alpha")}
PIN_QUANTITIES["x"] = "position of the joint, on its child, along x_P [m]"

#: Outputs of all joints.
FORCES_OF_JOINTS = "fx", "fy", "force", "moment"

#: Outputs that a model of a link adds at a frame and at the link, such as its deflection.
FRAME_SHAPES, LINK_SHAPES = outputs_of_models("link", Source.FRAME), outputs_of_models("link", Source.ALONG)
SHAPE_QUANTITIES = FRAME_SHAPES | LINK_SHAPES
