"""Names of the outputs of links, frames and joints that an experiment can request, with meanings and units."""

from __future__ import annotations

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

#: Additional outputs of a frame on a flexible link.
FRAME_BENDING = {
    "deflection": "distance of a frame from the beam's chord, positive to its left, less the undeformed one [m]"
}

#: Outputs of a joint's position.
PIN_QUANTITIES = {name: text for name, text in QUANTITIES.items() if name not in ("angle", "omega", "alpha")}
PIN_QUANTITIES["x"] = "position of the joint, on its child, along x_P [m]"

#: Outputs of all joints, and of driven ones.
FORCES_OF_JOINTS, OF_DRIVES = ("fx", "fy", "force", "moment"), ("torque", "rate", "power")

#: Additional outputs of a flexible link.
LINK_BENDING = {
    "deflection": "largest magnitude of the distance from the chord between the beam's ends [m]",
    "deflection_place": "its position from the beam's first end [m]",
    "bending": "largest magnitude of the bending moment [N m]",
    "stress": "largest magnitude of the normal stress [Pa]",
    "stress_place": "its position from the beam's first end [m]",
    "compression": "largest compressive force, zero in tension [N]",
}
BENDING_QUANTITIES = {**FRAME_BENDING, **LINK_BENDING}
