"""Planar machines in the notations of other programs' exporters, and their motion by Drake's equations of the tree."""

import math
import re
from dataclasses import dataclass
from functools import cache

import numpy as np
from machines import PLANES, circle_intersection
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Machine:
    """A machine in a plane.

    Attributes
    ----------
    links : dict
        Mass [kg], mass centre x, y [m] in the link's frame, moment of inertia about it [kg m2].
    joints : tuple
        Name, type, parent, child, place x, y [m] and angle [rad] of the child's frame in the parent's; they form a tree.
    loops : tuple
        Name, link, x, y, other link, x, y of pins that close loops [m].
    gears : tuple
        Leader, follower, ratio.
    """

    links: dict
    joints: tuple
    mobility: int
    loops: tuple = ()
    gears: tuple = ()

    def poses(self):
        """Place x, y and angle of each link."""
        found = {"world": (0.0, 0.0, 0.0)}
        for _, _, parent, child, x, y, angle in self.joints:
            at = found[parent]
            c, s = math.cos(at[2]), math.sin(at[2])
            found[child] = (at[0] + c * x - s * y, at[1] + s * x + c * y, at[2] + angle)
        return found


def rod(length, mass=0.3, aside=0.01):
    """A rod along x, with its mass centre a little aside."""
    return mass, 0.45 * length, aside, mass * length**2 / 11.0


def _four_bar():
    x, y = circle_intersection((0.1, 0.0), 0.25, (0.3, 0.0), 0.2)
    pins = ("O", "world", "crank", 0.0, 0.0, 0.0), ("A", "crank", "coupler", 0.1, 0.0, math.atan2(y, x - 0.1))
    joints = (*pins, ("Q", "world", "follower", 0.3, 0.0, math.atan2(y, x - 0.3)))
    links = {"crank": rod(0.1), "coupler": rod(0.25), "follower": rod(0.2)}
    return Machine(links, _revolute(joints), 1, (("B", "coupler", 0.25, 0.0, "follower", 0.2, 0.0),))


def _five_bar():
    left, right = np.array([0.1 * math.cos(1.9), 0.1 * math.sin(1.9)]), np.array([0.25, 0.1])
    x, y = circle_intersection(left, 0.22, right, 0.2)
    angles = math.atan2(y - left[1], x - left[0]) - 1.9, math.atan2(y - right[1], x - right[0]) - math.pi / 2
    ends = ("O", "world", "left", 0.0, 0.0, 1.9), ("P", "world", "right", 0.25, 0.0, math.pi / 2)
    joints = (*ends, ("A", "left", "one", 0.1, 0.0, angles[0]), ("B", "right", "two", 0.1, 0.0, angles[1]))
    links = {"left": rod(0.1), "right": rod(0.1), "one": rod(0.22), "two": rod(0.2)}
    return Machine(links, _revolute(joints), 2, (("C", "one", 0.22, 0.0, "two", 0.2, 0.0),))


def _slider_crank():
    x, y = 0.1 * math.cos(0.7), 0.1 * math.sin(0.7)
    reach, dip = x + math.sqrt(0.3**2 - y**2), -math.asin(y / 0.3)
    pins = _revolute((("O", "world", "crank", 0.0, 0.0, 0.7), ("A", "crank", "rod", 0.1, 0.0, dip - 0.7)))
    joints = (*pins, ("S", "prismatic", "world", "slider", reach, 0.0, 0.0))
    links = {"crank": rod(0.1), "rod": rod(0.3), "slider": (0.4, 0.0, 0.0, 1e-3)}
    return Machine(links, joints, 1, (("B", "rod", 0.3, 0.0, "slider", 0.0, 0.0),))


def _revolute(pins):
    return tuple((name, "revolute", *rest) for name, *rest in pins)


def _arm(angle):
    joints = ("shoulder", "world", "upper", 0.0, 0.0, 0.0), ("elbow", "upper", "fore", 0.3, 0.0, angle)
    return Machine({"upper": rod(0.3), "fore": rod(0.2)}, _revolute(joints), 2)


_FINGERS = _revolute((("L", "world", "left", -0.02, 0.0, 0.3), ("R", "world", "right", 0.02, 0.0, 0.8)))
MACHINES = {
    "pendulum": Machine({"arm": rod(0.3)}, _revolute((("O", "world", "arm", 0.0, 0.0, 0.0),)), 1),
    "arm": _arm(0.5),
    "straight": _arm(0.0),
    "four_bar": _four_bar(),
    "five_bar": _five_bar(),
    "slider_crank": _slider_crank(),
    "gripper": Machine({"left": rod(0.1), "right": rod(0.12)}, _FINGERS, 1, gears=(("L", "R", -1.5),)),
}

#: Rotations of the frames of successive links against the plane's: joint axes along z; y, z, x, ...
FRAMES = {
    "z": [np.eye(3)],
    "mixed": [Rotation.from_euler("xyz", angles).as_matrix() for angles in ((np.pi / 2, 0, 0), (0, 0, 0), (0, np.pi / 2, 0))],
}  # fmt: skip


@dataclass(frozen=True)
class Style:
    """The notation of an exporter: plane, frames, digits of angles, base, inertia frames, additional elements."""

    plane: str = "xz"
    frames: str = "z"
    digits: int = 16
    base: str = "world"
    principal: bool = False
    zero: str = "0"
    link: str = ""
    joint: str = ""
    tail: str = ""
    loop: str = ""

    def local(self, machine, link):
        """Rotation of a link's frame against the plane's axes."""
        turns = FRAMES[self.frames]
        return np.eye(3) if link == "world" else turns[list(machine.links).index(link) % len(turns)]

    @property
    def up(self):
        """Rotation of the plane in the world."""
        return Rotation.from_euler("xyz", PLANES[self.plane]).as_matrix()

    def angles(self, matrix):
        """Roll, pitch, yaw as text."""
        return " ".join(repr(round(float(a), self.digits) + 0.0) for a in _rpy(matrix))


def _rpy(matrix):
    """Roll, pitch, yaw; without roll where pitch is a right angle."""
    pitch = math.atan2(-matrix[2, 0], math.hypot(matrix[0, 0], matrix[1, 0]))
    if abs(math.cos(pitch)) < 1e-9:
        return 0.0, pitch, math.atan2(-matrix[0, 1], matrix[1, 1])
    return math.atan2(matrix[2, 1], matrix[2, 2]), pitch, math.atan2(matrix[1, 0], matrix[0, 0])


def _turn(angle):
    return Rotation.from_euler("z", angle).as_matrix()


def _words(vector, zero="0"):
    return " ".join(repr(round(float(v), 15) + 0.0) if abs(v) > 1e-15 else zero for v in vector)


def _tensor(machine, link, style):
    """Mass, centre, rotation of the inertia's frame and tensor in it, in the frame of the file's link."""
    mass, x, y, moment = machine.links[link]
    own = style.local(machine, link).T
    tensor = own @ np.diag([0.2 * moment, 0.9 * moment, moment]) @ own.T
    turned = Rotation.from_euler("xyz", [0.4, -0.3, 1.1]).as_matrix() if style.principal else np.eye(3)
    return mass, own @ [x, y, 0.0], turned, turned.T @ tensor @ turned


_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def urdf(machine, style):
    """The machine as URDF."""
    body = '<link name="world"/>'
    if style.base != "world":
        body = f'<link name="{style.base}">{_plate()}</link>'
    for link in machine.links:
        mass, centre, turned, tensor = _tensor(machine, link, style)
        entries = " ".join(f'{key}="{float(tensor[at])!r}"' for key, at in _ENTRIES.items())
        body += f"""<link name="{link}"><inertial><origin xyz="{_words(centre)}" rpy="{style.angles(turned)}"/>
<mass value="{mass}"/><inertia {entries}/></inertial>{style.link}</link>"""
    for name, kind, parent, child, x, y, angle in machine.joints:
        above, below = style.local(machine, parent), style.local(machine, child)
        base = style.up if parent == "world" else above.T
        axis = below.T @ ([0.0, 0.0, 1.0] if kind == "revolute" else [1.0, 0.0, 0.0])
        kind = "continuous" if kind == "revolute" and "<limit" not in style.joint else kind
        body += f"""<joint name="{name}" type="{kind}">
<origin xyz="{_words(base @ [x, y, 0.0], style.zero)}" rpy="{style.angles(base @ _turn(angle) @ below)}"/>
<parent link="{style.base if parent == "world" else parent}"/><child link="{child}"/><axis xyz="{_words(axis)}"/>{style.joint}
</joint>"""
    for loop in machine.loops:
        body += LOOPS[style.loop](machine, style, *loop)
    return f'<?xml version="1.0"?><robot name="machine">{body}{style.tail}</robot>'


def _plate():
    return """<inertial><origin xyz="0 0 0.01"/><mass value="5"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>
</inertial><visual><geometry><mesh filename="package://machine/meshes/base_link.STL"/></geometry></visual>"""


def _ends(machine, style, one, x, y, other, u, v):
    """Places of both pins in the frames of the file, and the axis in the second."""
    turns = style.local(machine, one), style.local(machine, other)
    return _words(turns[0].T @ [x, y, 0.0]), _words(turns[1].T @ [u, v, 0.0]), turns


def _loop_joint(machine, style, name, one, x, y, other, u, v, kind="continuous"):
    first, second, turns = _ends(machine, style, one, x, y, other, u, v)
    return f"""<loop_joint name="{name}" type="{kind}"><axis xyz="{_words(turns[0].T[:, 2])}"/>
<link1 link="{one}" xyz="{first}" rpy="0 0 0"/><link2 link="{other}" xyz="{second}" rpy="0 0 0"/></loop_joint>"""


def _spherical(*loop):
    return _loop_joint(*loop, kind="spherical")


def _gazebo_joint(machine, style, name, one, x, y, other, u, v):
    _, second, turns = _ends(machine, style, one, x, y, other, u, v)
    return f"""<gazebo><joint name="{name}" type="revolute"><pose>{second} 0 0 0</pose><parent>{one}</parent>
<child>{other}</child><axis><xyz>{_words(turns[1].T[:, 2])}</xyz></axis></joint></gazebo>"""


def _loop_of_urdf_plus(machine, style, name, one, x, y, other, u, v):
    first, second, turns = _ends(machine, style, one, x, y, other, u, v)
    return f"""<loop name="{name}" type="continuous"><predecessor link="{one}"><origin xyz="{first}"/></predecessor>
<successor link="{other}"><origin xyz="{second}"/></successor><axis xyz="{_words(turns[0].T[:, 2])}"/></loop>"""


def _loop_plugin(machine, style, name, one, x, y, other, u, v):
    _, second, _ = _ends(machine, style, one, x, y, other, u, v)
    return f"""<gazebo><plugin name="close" filename="libpegasus_gazebo_closed_loop_plugin.so"><joint>{name}</joint>
<parent>{one}</parent><child>{other}</child><rotation>0 0 0</rotation><position>{second}</position></plugin></gazebo>"""


def _ball(machine, style, name, one, x, y, other, u, v, form='<{} name="{}"/>', place='<{} value="{}"/>'):
    first, second, _ = _ends(machine, style, one, x, y, other, u, v)
    parts = (form, "body_A", one), (place, "p_AP", first), (form, "body_B", other), (place, "p_BQ", second)
    body = "".join(
        how.format(f"drake:ball_constraint_{tag}", text, f"drake:ball_constraint_{tag}") for how, tag, text in parts
    )
    return f"<drake:ball_constraint>{body}</drake:ball_constraint>"


def _closing(machine, style, name, one, x, y, other, u, v):
    first, second, _ = _ends(machine, style, one, x, y, other, u, v)
    return "".join(
        f"""<link name="closing_{name}_{k}"/><joint name="closing_{name}_{k}_frame" type="fixed"><parent link="{link}"/>
<child link="closing_{name}_{k}"/><origin xyz="{place}" rpy="0 0 0"/></joint>"""
        for k, link, place in ((1, one, first), (2, other, second))
    )


#: Notations of loops in URDF.
LOOPS = {
    "loop_joint": _loop_joint,
    "spherical": _spherical,
    "gazebo": _gazebo_joint,
    "urdf+": _loop_of_urdf_plus,
    "plugin": _loop_plugin,
    "ball": _ball,
    "closing": _closing,
}


def sdf(machine, style, form, version="1.9"):
    """The ``<model>`` of the machine; `form` says how poses are given: absolute, relative, degrees, quaternion."""
    poses, up = machine.poses(), _rpy(style.up)
    body = f"<pose>0 0 0 {_words(up)}</pose>"
    own = {child: (x, y, angle, parent) for _, _, parent, child, x, y, angle in machine.joints}
    named = "frame" if version < "1.7" else "relative_to"
    for link in machine.links:
        mass, centre, turned, tensor = _tensor(machine, link, style)
        x, y, angle = poses[link]
        place, turn, base = np.array([x, y, 0.0]), _turn(angle) @ style.local(machine, link), ""
        if form == "relative" and own[link][3] != "world":
            x, y, angle, parent = own[link]
            above = style.local(machine, parent).T
            place, turn = above @ [x, y, 0.0], above @ _turn(angle) @ style.local(machine, link)
            base = f' {named}="{parent}"'
        entries = "".join(f"<{key}>{float(tensor[at])!r}</{key}>" for key, at in _ENTRIES.items())
        body += f"""<link name="{link}">{_pose(place, turn, form, base)}
<inertial>{_pose(centre, turned, form)}<mass>{mass}</mass><inertia>{entries}</inertia></inertial>{style.link}</link>"""
    for name, kind, parent, child, *_ in machine.joints:
        along = [0.0, 0.0, 1.0] if kind == "revolute" else [1.0, 0.0, 0.0]
        body += _sdf_joint(machine, style, name, kind, parent, child, "", along, poses, version)
    for name, one, _, _, other, u, v in machine.loops:
        place = f"<pose>{_words(style.local(machine, other).T @ [u, v, 0.0])} 0 0 0</pose>"
        body += _sdf_joint(machine, style, name, "revolute", one, other, place, [0.0, 0.0, 1.0], poses, version)
    return f'<model name="machine">{body}{style.tail}</model>'


def _pose(place, turn, form, base=""):
    place = _words(place)
    if form == "degrees":
        return f'<pose degrees="true"{base}>{place} {_words(np.degrees(_rpy(turn)))}</pose>'
    if form == "quaternion":
        return f'<pose rotation_format="quat_xyzw"{base}>{place} {" ".join(map(repr, map(float, Rotation.from_matrix(turn).as_quat())))}</pose>'
    return f"<pose{base}>{place} {_words(_rpy(turn))}</pose>"


def _sdf_joint(machine, style, name, kind, parent, child, place, along, poses, version):
    axis, more = style.local(machine, child).T @ along, ""
    if version < "1.5":  # axes in the model's frame
        axis = _turn(poses[child][2]) @ along
    elif version < "1.7":
        axis, more = _turn(poses[child][2]) @ along, "<use_parent_model_frame>1</use_parent_model_frame>"
    return f"""<joint name="{name}" type="{kind}">{place}<parent>{parent}</parent><child>{child}</child>
<axis>{more}<xyz>{_words(axis)}</xyz>{style.joint}</axis></joint>"""


# -- the motion, by Drake's equations of the tree ------------------------------------------------------------------------


_CONSTRAINTS = re.compile(r"<(loop_joint|drake:ball_constraint)\b.*?</\1>|<(drake:)?mimic[^>]*/>", re.DOTALL)


@cache
def _plain(name):
    """The machine as URDF without anything of an exporter, and without its loops."""
    whole = MACHINES[name]
    return urdf(Machine(whole.links, whole.joints, whole.mobility), Style())


def motion(machine, style, text, kind, gravity, duration, weld="", start=(), springs=(), damping=(), weightless=()):
    """Rotation and place of each link in the world, at the start and after a fall from rest.

    Drake parses the text and gives accelerations, mass matrix and Jacobians of the tree; the pins of the loops and the
    gears, which its plant in continuous time rejects or its parser ignores, act by their multipliers.

    Parameters
    ----------
    text : str
        What Drake parses; a name of `MACHINES` for the plain machine, if Drake rejects the file.
    weld : str
        A base that Drake leaves floating.
    start : pairs of joint and coordinate
    springs : triples of joint, stiffness and free angle
        Torsion springs that Drake's parser ignores.
    damping : pairs of joint and coefficient
        Damping that it ignores.
    weightless : names of links
        Links without gravity, which it ignores.
    """
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JacobianWrtVariable

    plain = text in MACHINES
    style = Style() if plain else style
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    text = _plain(text) if plain else _CONSTRAINTS.sub("", text)
    Parser(plant).AddModelsFromString(text, "urdf" if plain else kind)
    if weld and not plain:
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(weld))
    plant.Finalize()
    context, world = plant.CreateDefaultContext(), plant.world_frame()
    size, plane = plant.num_velocities(), style.up[:, :2].T
    assert size == plant.num_positions()
    pins = [
        [
            (plant.GetBodyByName(link), style.local(machine, link).T @ [x, y, 0.0])
            for link, x, y in ((a, x, y), (b, u, v))
        ]
        for _, a, x, y, b, u, v in machine.loops
    ]
    index = {name: plant.GetJointByName(name).velocity_start() for name, *_ in machine.joints}
    gears = np.zeros((len(machine.gears), size))
    for k, (leader, follower, ratio) in enumerate(machine.gears):
        gears[k, [index[leader], index[follower]]] = -ratio, 1.0

    def rates(_, state):
        plant.SetPositionsAndVelocities(context, state)
        free = plant.EvalTimeDerivatives(context).CopyToVector()[size:]
        mass = plant.CalcMassMatrix(context)
        torque = np.zeros(size)
        for name, stiffness, rest in springs:
            torque[index[name]] -= stiffness * (state[index[name]] - rest)
        for body in map(plant.GetBodyByName, weightless):
            how = context, JacobianWrtVariable.kV, body.body_frame(), body.default_com(), world, world
            torque -= plant.CalcJacobianTranslationalVelocity(*how).T @ (body.default_mass() * np.array(gravity))
        for name, coefficient in damping:
            torque[index[name]] -= coefficient * state[size + index[name]]
        free = free + np.linalg.solve(mass, torque)
        rows, right = [*gears], list(np.zeros(len(gears)))
        for ends in pins:
            row, rest = np.zeros((2, size)), np.zeros(2)
            for (body, at), sign in zip(ends, (1.0, -1.0), strict=True):
                how = context, JacobianWrtVariable.kV, body.body_frame()
                row += sign * plane @ plant.CalcJacobianTranslationalVelocity(*how, at, world, world)
                rest += sign * plane @ plant.CalcBiasTranslationalAcceleration(*how, at, world, world)[:, 0]
            rows += [*row]
            right += [*rest]
        if rows:
            jacobian = np.array(rows)
            inner = jacobian @ np.linalg.solve(mass, jacobian.T)
            force = np.linalg.solve(inner, jacobian @ free + right)
            free = free - np.linalg.solve(mass, jacobian.T @ force)
        return np.concatenate([state[size:], free])

    state = np.zeros(2 * size)
    for name, coordinate in start:
        state[index[name]] = coordinate
    end = solve_ivp(rates, (0.0, duration), state, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    poses = []
    for at in (state, end):
        plant.SetPositionsAndVelocities(context, at)
        poses.append({link: plant.GetBodyByName(link).EvalPoseInWorld(context) for link in machine.links})
    return poses
