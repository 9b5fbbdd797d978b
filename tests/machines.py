"""SDFormat files of textbook linkages, written for tests: any lengths, any plane."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

BEARING = """<linkages:bearing>
  <linkages:radius>0.01</linkages:radius><linkages:length>0.02</linkages:length></linkages:bearing>"""

ZERO = "0 0 0 0 0 0"  # x y z roll pitch yaw of a pose
#: Rotations that take the x-y plane to others: as drawn, x-z, y-z, oblique.
PLANES = {
    "xy": np.zeros(3),
    "xz": np.array([np.pi / 2, 0.0, 0.0]),
    "yz": np.array([np.pi / 2, 0.0, np.pi / 2]),
    "oblique": np.array([0.3, -0.5, 0.8]),
}


def model(name: str, body: str, plane: str = "xy", extra: str = "") -> str:
    """A complete SDFormat text; `plane` turns the whole model."""
    pose = " ".join(map(str, PLANES[plane]))
    return f"""<sdf version="1.9" xmlns:linkages="urn:linkages:sdf"><model name="{name}">
<pose>0 0 0 {pose}</pose>{body}{extra}</model></sdf>"""


def written(folder: Path, sdf: str, toml: str) -> Path:
    """Write a machine and its experiment into a folder; returns the path of the experiment."""
    (folder / "machine.sdf").write_text(sdf)
    path = folder / "experiment.toml"
    path.write_text('mechanism = "machine.sdf"\n' + toml)
    return path


def bar(
    name: str, length: float, at: str, angle: float = 0.0, mass: float = 0.2, offset: float = 0.0, inner: str = ""
) -> str:
    """A uniform bar along its x axis with a frame NAME_tip at its end; `at` is the frame it is drawn at."""
    inertia = mass * length**2 / 12
    return f"""
<link name="{name}"><pose relative_to="{at}">0 0 {offset} 0 0 {angle}</pose>
 <inertial><pose>{length / 2} 0 0 0 0 0</pose><mass>{mass}</mass>
 <inertia><ixx>0</ixx><iyy>{inertia}</iyy><izz>{inertia}</izz></inertia></inertial>{inner}</link>
<frame name="{name}_tip" attached_to="{name}"><pose>{length} 0 0 0 0 0</pose></frame>"""


def solid(
    name: str, mass: float, inertia: float = 1.0, pose: str = ZERO, at: str = "__model__", centre: str = ZERO
) -> str:
    """A link with the same moment of inertia about all axes; poses of the link in the frame `at`, of its mass centre."""
    moments = "".join(f"<{axis}>{inertia}</{axis}>" for axis in ("ixx", "iyy", "izz"))
    return f"""
<link name="{name}"><pose relative_to="{at}">{pose}</pose>
 <inertial><pose>{centre}</pose><mass>{mass}</mass><inertia>{moments}</inertia></inertial></link>"""


STEEL = """<linkages:material><linkages:youngs_modulus>2e11</linkages:youngs_modulus>
  <linkages:poisson>0.3</linkages:poisson><linkages:density>7870</linkages:density></linkages:material>"""
SQUARE = "<linkages:rectangle><linkages:width>0.008</linkages:width><linkages:height>0.008</linkages:height></linkages:rectangle>"


def beam(start: str, end: str, section: str = SQUARE, material: str = STEEL) -> str:
    """A beam between two frames of a link, 8 mm square and of steel."""
    ends = f"<linkages:from>{start}</linkages:from><linkages:to>{end}</linkages:to>"
    return f"<linkages:beam>{ends}{section}{material}</linkages:beam>"


def elastic_bar(name: str, length: float, at: str, angle: float = 0.0) -> str:
    """A `bar` with a beam along all of its length, and its mass."""
    return bar(name, length, at, angle, 7870 * 6.4e-5 * length, inner=beam(name, f"{name}_tip"))


def joint(name: str, parent: str, child: str, kind: str = "revolute", axis: str = "0 0 1", inner: str = "") -> str:
    """A joint at the child's origin; a bearing goes into `inner`."""
    return f"""
<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>
<axis><xyz>{axis}</xyz></axis>{inner}</joint>"""


def rotor_in_block(outer="block", inner="rotor", length=0.02) -> str:
    """A driven rotor and a block that can only translate, with a bearing A between: a static bearing under a load."""
    bearing = BEARING.replace("<linkages:length>0.02", f"<linkages:length>{length}")
    return model(
        "rotor",
        solid("rotor", 0.05, 1e-5) + solid("carriage", 0.05, 1e-5) + solid("block", 0.05, 1e-5)
        + joint("O", "world", "rotor") + joint("x", "world", "carriage", "prismatic", "1 0 0")
        + joint("y", "carriage", "block", "prismatic", "0 1 0") + joint("A", outer, inner, inner=bearing),
    )  # fmt: skip


def four_bar(ground=0.3, crank=0.1, coupler=0.25, follower=0.2, plane="xy", extra="") -> str:
    """Crank-rocker with bearings in the pins A (crank-coupler) and B (coupler-follower); drawn closed, crank along x."""
    x, y = circle_intersection((crank, 0.0), coupler, (ground, 0.0), follower)
    coupler_angle = np.arctan2(y, x - crank)
    follower_angle = np.arctan2(y, x - ground)
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">{ground} 0 0 0 0 0</pose></frame>
{bar("crank", crank, "__model__")}{bar("coupler", coupler, "crank_tip", coupler_angle)}
{bar("follower", follower, "pivot", follower_angle)}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler", inner=BEARING)}
{joint("Q", "world", "follower")}
<frame name="B_on_follower" attached_to="follower"><pose>{follower} 0 0 0 0 0</pose></frame>
{joint("B", "coupler_tip", "B_on_follower", inner=BEARING)}"""
    return model("four_bar", body, plane, extra)


def slider_crank(crank=0.05, rod=0.12, plane="xy", offset=0.0) -> str:
    """In-line (or offset) slider-crank; bearings in A (crank-rod) and B (rod-slider)."""
    x = crank + np.sqrt(rod**2 - offset**2)
    angle = np.arctan2(offset, x - crank)
    body = f"""
{bar("crank", crank, "__model__", mass=0.3)}{bar("rod", rod, "crank_tip", angle, mass=0.21)}
{solid("slider", 0.14, 1e-4, f"{x} {offset} 0 0 0 0")}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "rod", inner=BEARING)}
{joint("B", "rod_tip", "slider", inner=BEARING)}{joint("guide", "world", "slider", "prismatic", "1 0 0")}"""
    return model("slider_crank", body, plane)


#: An experiment of `slider_crank`: friction from the joint force in all joints, on an implicit method.
RUBBING_CRANK = "duration = 0.1\ngravity = [0.0, -9.81, 0.0]\n[drives.O]\ntorque = 0.5\nspeed = 20.0\nangle = 0.7\n"
RUBBING_CRANK += "".join(
    f"[frictions.in_{name}]\njoint = '{name}'\ncoefficient = 0.3\nradius = 0.01\nspeed = 3.0\n" for name in "OAB"
)
RUBBING_CRANK += "[frictions.rail]\njoint = 'guide'\ncoefficient = 0.2\nlength = 0.02\nspeed = 0.5\n"
RUBBING_CRANK += "static_coefficient = 0.4\nstribeck_speed = 0.3\n"
RUBBING_CRANK += "[solver]\nintegrator = 'radau_iia_5'\naccuracy = 1e-9\n"


def elastic_slider_crank(crank=0.15, rod=0.3, mass=0.075552, elastic_crank=False) -> str:
    """Simeon's: a rod of steel, 8 mm square, between a crank and a slider, with a frame at its middle."""
    first = elastic_bar("crank", crank, "__model__") if elastic_crank else bar("crank", crank, "__model__", mass=0.36)
    body = f"""
{first}{elastic_bar("rod", rod, "crank_tip")}
<frame name="middle" attached_to="rod"><pose>{rod / 2} 0 0 0 0 0</pose></frame>
{solid("slider", mass, 1e-4, f"{crank + rod} 0 0 0 0 0")}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "rod", inner=BEARING)}
{joint("B", "rod_tip", "slider", inner=BEARING)}{joint("guide", "world", "slider", "prismatic", "1 0 0")}"""
    return model("slider_crank", body)


#: An experiment of `four_bar` with a film in A, without its duration.
LUBRICATED = """outputs = ["follower.omega"]
[drives.O]
speed = 15.0
[joints.A]
model = "lubricated"
clearance = 1e-4
viscosity = 0.1
"""


def circle_intersection(p, r, q, s, side=1.0):
    """The point at distance r from p and s from q, on the left (side = 1) or right of the line from p to q."""
    p, q = np.asarray(p), np.asarray(q)
    d = np.linalg.norm(q - p)
    along = (r**2 - s**2 + d**2) / (2 * d)
    across = np.sqrt(r**2 - along**2)
    u = (q - p) / d
    return p + along * u + side * across * np.array([-u[1], u[0]])


def seven_bar_slider(t, w1=2 * np.pi, w4=2 * np.pi):
    """Slider position from three dyads, Chen 2025 Table 2."""
    a = 0.08 * np.array([np.cos(w1 * t), np.sin(w1 * t)])
    phase = np.radians(310.79) + w4 * t
    b = np.array([0.08 * np.cos(phase), 0.301 + 0.08 * np.sin(phase)])
    c = np.array([circle_intersection(p, 0.18, q, 0.318, side=-1.0) for p, q in zip(a.T, b.T, strict=True)])
    return c[:, 0] + np.sqrt(0.3**2 - c[:, 1] ** 2)


def plane_rotation(plane: str) -> np.ndarray:
    """Rotation matrix of a plane."""
    return Rotation.from_euler("xyz", PLANES[plane]).as_matrix()


#: A wheel of 0.02 kg m2 on joint O, and a controller with limits for its speed.
FLYWHEEL = model("flywheel", solid("wheel", 1.0, 0.02) + joint("O", "world", "wheel"))
CONTROL = """[torques.T]
joint = "O"
formula = "C.output"
[controllers.C]
kind = "pid"
signal = "O.rate"
reference = "5"
proportional = 0.3
integral = 1.5
derivative = 0.002
filter_time = 0.01
limits = [-0.4, 0.4]
"""
