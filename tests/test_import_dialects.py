"""One machine in the notations of many exporters: imported with its mass, mobility and motion, or refused in one line."""

import re
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from dialects import MACHINES, Style, motion, sdf, urdf
from foreign_files import experiment, written

from linkages import load_mechanism
from linkages.cli.main import main
from linkages.engines.assessment import simulate

DURATION = 0.2
USUAL, OF_WORLDS = (0.0, 0.0, -9.81), (0.0, 0.0, -9.8)  # gravity that the import proposes, and of an SDFormat world

MESH = '<visual><geometry><mesh filename="package://machine/meshes/part.STL"/></geometry></visual>'
SHAPES = """<visual><origin xyz="0 0 0"/><geometry><box size="0.1 0.01 0.01"/></geometry><material name=""><color rgba="1 0 0 1"/>
</material></visual><collision><geometry><box size="0.1 0.01 0.01"/></geometry></collision>"""
MOTOR = """<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="{0}"><hardwareInterface>
hardware_interface/EffortJointInterface</hardwareInterface></joint><actuator name="m"><mechanicalReduction>1
</mechanicalReduction></actuator></transmission>"""
CONTROLLED = """<ros2_control name="r" type="system"><hardware><plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>
<joint name="{0}"><command_interface name="effort"/><state_interface name="position"/></joint></ros2_control>"""
CONTROLLER = '<gazebo><plugin name="gazebo_ros_control" filename="libgazebo_ros_control.so"/></gazebo>'

#: Notations of exporters of URDF.
EXPORTERS = {
    "solidworks": Style(frames="mixed", base="base_link", link=MESH, loop="gazebo", zero="-1.38777878078145E-17"),
    "onshape": Style(plane="xz", principal=True, link=MESH, loop="closing", zero="2e-114", joint='<joint_properties damping="0.0"/>'),
    "fusion": Style(plane="yz", link=SHAPES, loop="urdf+", tail=CONTROLLER),
    "gazebo": Style(link=SHAPES, loop="plugin", joint='<dynamics damping="0.02"/>'),
    "isaac": Style(frames="mixed", principal=True, loop="spherical", joint='<dynamics damping="0.01" armature="0"/>',
                   tail='<fixed_frame name="reference"><parent link="world"/></fixed_frame>'),
    "drake": Style(plane="oblique", loop="ball", joint="<drake:rotor_inertia value='0'/><drake:gear_ratio value='9'/>",
                   tail='<drake:collision_filter_group name="g"/>'),
}  # fmt: skip


@dataclass
class Case:
    """A file, and what Drake needs to move it."""

    machine: str
    text: str
    style: Style = field(default_factory=Style)
    plain: bool = False  # Drake rejects the file, or ignores a part of it: it moves the plain machine
    gravity: tuple = USUAL
    said: tuple = ()
    tolerance: float = 1e-8
    options: tuple = ()
    files: dict = field(default_factory=dict)
    weld: str = ""
    start: tuple = ()
    springs: tuple = ()
    damping: tuple = ()
    weightless: tuple = ()

    @property
    def kind(self):
        return "urdf" if "<robot" in self.text else "sdf"


def _urdf(machine, style=None, **more):
    style = style or Style()
    return Case(machine, urdf(MACHINES[machine], style), style, weld=style.base * (style.base != "world"), **more)


def _sdf(machine, form="relative", version="1.9", style=None, around="<sdf version='{1}'>{0}</sdf>", **more):
    style = style or Style()
    more = {"plain": bool(MACHINES[machine].loops), **more}
    return Case(machine, around.format(sdf(MACHINES[machine], style, form, version), version), style, **more)


def _exported():
    for exporter, style in EXPORTERS.items():
        for machine in ("arm", "four_bar", "five_bar", "slider_crank"):
            said = {"fusion": ("changes the motion: <plugin> gazebo_ros_control left out",),
                    "solidworks": ("changes the motion: link base_link was not connected to the world",)}  # fmt: skip
            yield f"{exporter}-{machine}", _urdf(machine, style, said=said.get(exporter, ()))


def _in_sdf():
    forms = {
        "gazebo-1.4": ("absolute", "1.4"), "gazebo-1.5": ("absolute", "1.5"), "gazebo-1.6": ("absolute", "1.6"),
        "gz-1.9": ("relative", "1.9"), "gz-degrees": ("degrees", "1.9"), "gz-quaternion": ("quaternion", "1.9"),
    }  # fmt: skip
    for name, (form, version) in forms.items():
        for machine in ("arm", "four_bar", "slider_crank"):
            style = Style(plane="xz", frames="z" if version < "1.7" else "mixed", principal=version > "1.7")
            yield f"{name}-{machine}", _sdf(machine, form, version, style)


GEAR = '<mimic joint="L" multiplier="-1.5"/>'
PLUGIN = """<plugin filename="libroboticsgroup_upatras_gazebo_mimic_joint_plugin.so" name="p"><joint>L</joint>
<mimicJoint>R</mimicJoint><multiplier>-1.5</multiplier><offset>0</offset></plugin>"""
PARAMETERS = """<ros2_control name="r" type="system"><joint name="L"><command_interface name="position"/></joint>
<joint name="R"><param name="mimic">L</param><param name="multiplier">-1.5</param></joint></ros2_control>"""
COUPLING = """<coupling name="c"><predecessor link="left"/><successor link="right"/><ratio value="-1.5"/></coupling>"""
GEARED = ('changes the motion: <mimic> of joint R left out; write it into the experiment as gears."R_mimic"',)


def _geared():
    def in_joint(text):
        whole = urdf(MACHINES["gripper"], Style())
        return Case("gripper", whole[: whole.rindex("</joint>")] + text + "</joint></robot>", said=GEARED)

    yield "mimic", in_joint(GEAR)
    yield (
        "mimic-drake",
        replace(in_joint(GEAR.replace("mimic", "drake:mimic")), said=(GEARED[0].replace("<", "<drake:"),)),
    )
    for name, tail in {
        "ros2_control": PARAMETERS, "plugin": f"<gazebo>{PLUGIN}</gazebo>", "coupling": COUPLING,
        "plugin-of-joint": f'<gazebo reference="R">{PLUGIN}</gazebo>',
        "twice": PARAMETERS + f"<gazebo>{PLUGIN}</gazebo>",
    }.items():  # fmt: skip
        yield f"mimic-{name}", _urdf("gripper", Style(tail=tail), said=GEARED)
    shared = sdf(MACHINES["gripper"], Style(), "absolute")
    at = shared.rindex("</axis>")
    within = '<mimic joint="L"><multiplier>-1.5</multiplier></mimic>'
    text = f'<sdf version="1.11">{shared[:at]}{within}{shared[at:]}</sdf>'
    yield "mimic-sdf", Case("gripper", text, plain=True, said=GEARED)


GROUND = '<model name="ground_plane"><static>true</static><link name="link"><collision name="c"/></link></model>'
SCENE = """<physics name="p" type="ode"/><plugin filename="gz-sim-physics-system" name="gz::sim::systems::Physics"/>
<light name="sun" type="directional"/><scene/>"""
AUTO = """<sdf version="1.11"><model name="machine"><link name="arm"><inertial auto="true">{}</inertial>{}</link>
<joint name="O" type="revolute"><parent>world</parent><child>arm</child><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"""
COLLISION = """<collision name="{0}"><pose>{1}</pose>{2}<geometry>{3}</geometry></collision>"""
BODIES = {
    "box": "<box><size>0.3 0.02 0.01</size></box>",
    "cylinder": "<cylinder><radius>0.03</radius><length>0.2</length></cylinder>",
    "sphere": "<sphere><radius>0.05</radius></sphere>",
    "capsule": "<capsule><radius>0.03</radius><length>0.2</length></capsule>",
    "ellipsoid": "<ellipsoid><radii>0.1 0.02 0.05</radii></ellipsoid>",
}


def _in_worlds():
    around = "<sdf version='{1}'><world name='w'>" + GROUND + "{0}</world></sdf>"
    yield "world-ground", _sdf("arm", around=around, gravity=OF_WORLDS)
    moon = around.replace(GROUND, "<gravity>0 0 -1.62</gravity>" + SCENE + GROUND)
    yield "world-moon", _sdf("four_bar", around=moon, gravity=(0.0, 0.0, -1.62))
    scenery = "<include><uri>model://sun</uri></include><include><uri>https://fuel.example.org/a/ground</uri></include>"
    yield "world-scenery", _sdf("arm", around=around.replace(GROUND, scenery), gravity=OF_WORLDS, plain=True)
    pieces = {"models/machine/model.sdf": f'<sdf version="1.9">{sdf(MACHINES["arm"], Style(), "relative")}</sdf>'}
    include = f"<sdf version='1.9'><world name='w'>{GROUND}<include><uri>model://machine</uri></include></world></sdf>"
    yield "world-include", Case("arm", include, plain=True, gravity=OF_WORLDS, files=pieces)
    robot = {"machine.urdf": urdf(MACHINES["four_bar"], replace(Style(), loop="loop_joint"))}
    include = (
        "<sdf version='1.9'><model name='m'><include merge='false'><uri>machine.urdf</uri></include></model></sdf>"
    )
    yield "include-urdf", Case("four_bar", include, plain=True, files=robot)
    two = around.replace(GROUND, '<model name="box"><link name="b"/></model>')
    yield "world-two", _sdf("arm", around=two, gravity=OF_WORLDS, options=("--model", "machine"), plain=True)
    held = sdf(MACHINES["arm"], Style(), "absolute").replace("<parent>world</parent>", "<parent>foot</parent>")
    held = held.replace("<link ", '<link name="foot"/><link ', 1)
    joint = "<joint name='stand' type='fixed'><parent>world</parent><child>machine::foot</child></joint>"
    yield (
        "world-joint",
        Case("arm", f"<sdf version='1.11'><world name='w'>{held}{joint}</world></sdf>", gravity=OF_WORLDS),
    )
    whole = sdf(MACHINES["arm"], Style(), "absolute")
    fore, elbow = (
        re.search(rf'<{tag} name="{name}".*?</{tag}>', whole, re.DOTALL)[0]
        for tag, name in (("link", "fore"), ("joint", "elbow"))
    )
    first = whole.replace(fore, "").replace(elbow, "")
    second = f'<model name="other">{re.search("<pose>.*?</pose>", whole)[0]}{fore}</model>'
    joint = elbow.replace("<parent>upper", "<parent>machine::upper").replace("<child>fore", "<child>other::fore")
    text = f"<sdf version='1.11'><world name='w'>{GROUND}{first}{second}{joint}</world></sdf>"
    yield "world-models-joined", Case("arm", text, plain=True, gravity=OF_WORLDS)
    ball = sdf(MACHINES["four_bar"], Style(frames="mixed"), "relative")
    at = ball.rindex('"revolute"')
    ball = ball[:at] + '"ball"' + re.sub("<axis>.*?</axis>", "", ball[at + len('"revolute"') :], flags=re.DOTALL)
    text = f"<sdf version='1.9'><world name='w'><physics type='ode'><gravity>0 0 -5</gravity></physics>{ball}</world></sdf>"
    said = ("- ball joint B: a revolute joint in the plane",)
    yield "world-ball", Case("four_bar", text, plain=True, gravity=(0.0, 0.0, -5.0), said=said)
    inner = sdf(MACHINES["slider_crank"], Style(), "relative")
    nested = f"<sdf version='1.9'><model name='outer'>{inner}</model></sdf>"
    yield "nested", Case("slider_crank", nested, plain=True)


def _automatic():
    for shape, text in BODIES.items():
        collisions = COLLISION.format("a", "0.15 0 0.02 0.2 0.5 0.1", "<density>2700</density>", text)
        yield f"auto-{shape}", Case("pendulum", AUTO.format("", collisions))
    both = COLLISION.format("a", "0.1 0 0 0 0 0", "", BODIES["box"]) + COLLISION.format(
        "b", "0.2 0 0.1 0 1 0", "", BODIES["sphere"]
    )
    yield "auto-two", Case("pendulum", AUTO.format("<density>500</density>", both))
    yield "auto-mass", Case("pendulum", AUTO.format("<mass>2</mass>", both))


def _special():
    none = '<gazebo reference="{}"><turnGravityOff>true</turnGravityOff></gazebo>'
    off = "".join(none.format(link) for link in ("upper", "fore"))
    start = '<gazebo reference="elbow"><initialJointPosition>0.4</initialJointPosition></gazebo>'
    started = "changes the motion: <initial_position> of joint elbow left out; write it into the experiment as drives"
    yield (
        "gravity-off",
        _urdf("arm", Style(tail=off + start), gravity=(0.0, 0.0, 0.0), start=(("elbow", 0.4),), said=(started,)),
    )
    spring = (
        '<gazebo reference="elbow"><springStiffness>3</springStiffness><springReference>0.5</springReference></gazebo>'
    )
    yield "spring-of-gazebo", _urdf("arm", Style(tail=spring), springs=(("elbow", 3.0, 0.5),))
    own = "<dynamics><spring_stiffness>2</spring_stiffness><spring_reference>-0.2</spring_reference><damping>0.03</damping></dynamics>"
    yield "spring-of-sdf", _sdf("arm", style=Style(joint=own))
    yield "damping-of-sdf", _sdf("pendulum", style=Style(joint="<dynamics><damping>0.1</damping></dynamics>"))
    value = CONTROLLED.replace('"position"/>', '"position"><param name="initial_value">0.3</param></state_interface>')
    yield "start-of-ros2_control", _urdf("arm", Style(tail=value.format("shoulder")), start=(("shoulder", 0.3),))
    for plane in ("xz", "yz"):
        said = ("rad: aligned",) if plane == "xz" else ()
        rounded = Style(plane=plane, frames="mixed", digits=4)
        yield f"rounded-{plane}", _urdf("straight", rounded, said=said, tolerance=1e-6)
    yield "rounded-coarsely", _urdf("straight", Style(frames="mixed", digits=3), said=("rad: aligned",), tolerance=1e-5)
    limit = '<limit lower="-3" upper="3" effort="10" velocity="1"/><safety_controller k_velocity="1"/><calibration rising="0"/>'
    stops = ("changes the motion: <limit> of joints shoulder, elbow left out",)
    yield "limits", _urdf("arm", Style(joint=limit), said=stops)
    yield (
        "motors",
        _urdf(
            "arm", Style(tail=MOTOR.format("elbow") + CONTROLLED.format("elbow")), said=("<transmission> t left out\n",)
        ),
    )
    plate = urdf(MACHINES["pendulum"], Style())
    moments = re.search('ixx="(.*?)" iyy="(.*?)" izz="(.*?)"', plate)
    thin = [0.4 * float(moments[3]), 0.5999 * float(moments[3]), float(moments[3])]
    text = plate.replace(moments[0], 'ixx="{!r}" iyy="{!r}" izz="{!r}"'.format(*thin))
    yield "rounded-inertia", Case("pendulum", text, plain=True, said=("- moments of inertia of arm are rounded",))
    noise = Style(zero="-3e-320")
    yield "noise", _urdf("four_bar", replace(noise, loop="loop_joint"))
    hand = """<link name="tool"><inertial><mass value="0.2"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="weld" type="fixed"><parent link="fore"/><child link="tool"/><origin xyz="0.1 0 0" rpy="0 0 1"/>
<dynamics damping="0.7" friction="0.1"/></joint>"""
    yield "dynamics-of-fixed-joint", _urdf("arm", Style(tail=hand))
    twin = """<loop_joint name="elbow2" type="continuous"><axis xyz="0 0 -1"/><link1 link="fore" xyz="0 0 0.1"/>
<link2 link="upper" xyz="0.3 0 0.1"/><dynamics damping="0.02"/></loop_joint>"""
    yield (
        "coaxial-damping",
        _urdf("arm", Style(joint='<dynamics damping="0.01"/>', tail=twin), damping=(("elbow", 0.02),)),
    )


CASES = {
    name: case for part in (_exported, _in_sdf, _geared, _in_worlds, _automatic, _special) for name, case in part()
}


def test_the_table_has_enough_files():
    assert len(CASES) >= 60


def extra_mass(case):
    return 0.2 if 'name="tool"' in case.text else 0.0


@pytest.mark.parametrize("name", CASES)
def test_a_file_is_imported_with_its_mass_mobility_and_motion(tmp_path, capsys, name):
    case = CASES[name]
    machine, source, out = MACHINES[case.machine], tmp_path / f"theirs.{case.kind}", tmp_path / "ours.sdf"
    source.write_text(case.text)
    for file, text in case.files.items():
        (tmp_path / file).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / file).write_text(text)
    assert main(["import", str(source), "--out", str(out), *case.options]) == 0, capsys.readouterr().err
    said = capsys.readouterr().out
    for line in case.said:
        assert line in said
    last = said.splitlines()[-1]
    parts = len(machine.links), len(machine.joints) + len(machine.loops), len(machine.loops)
    found = re.search(r"(\d+) links?, (\d+) joints?, (\d+) loops?, mobility (\d+)", last)
    assert tuple(map(int, found.groups())) == (*parts, machine.mobility)
    gravity = re.search(r"gravity = (\[.*\])", said)[1]
    assert gravity == str(list(case.gravity))
    ours = load_mechanism(out)
    text = case.machine if case.plain else case.text
    if name.startswith("auto"):
        expected = _mass_in_drake(case.text)
    else:
        expected = sum(link[0] for link in machine.links.values()) + extra_mass(case)
    assert sum(link.mass for link in ours.links) == pytest.approx(expected, rel=1e-12)
    run = simulate(experiment(out, f"gravity = {gravity}\n{written(said)}", DURATION), "compiled")
    more = {key: getattr(case, key) for key in ("start", "springs", "damping", "weightless")}
    first, then = motion(machine, case.style, text, case.kind, case.gravity, DURATION, case.weld, **more)
    scope = {
        link: link if link in ours.point else next(p for p in ours.point if p.endswith(f"::{link}"))
        for link in machine.links
    }
    moved = 0.0
    for link, own in scope.items():
        turn = ours.basis.T @ then[link].rotation().matrix() @ first[link].rotation().matrix().T @ ours.basis
        place = ours.basis[:, :2].T @ then[link].translation()
        assert [run[f"{own}.x"][-1], run[f"{own}.y"][-1]] == pytest.approx(place, abs=case.tolerance)
        change = run[f"{own}.angle"][-1] - run[f"{own}.angle"][0]
        assert np.angle(np.exp(1j * (change - np.arctan2(turn[1, 0], turn[0, 0])))) == pytest.approx(
            0.0, abs=case.tolerance
        )
        moved = max(moved, abs(change))
    assert moved > 0.05 or case.gravity == (0.0, 0.0, 0.0)


def _mass_in_drake(text):
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "sdf")
    plant.Finalize()
    return plant.CalcTotalMass(plant.CreateDefaultContext())


# -- marked, or refused for the true reason --------------------------------------------------------------------------------

FLIGHT = '<gazebo><plugin name="flight_simulation" filename="libflight_simulation.so"/></gazebo>'
PUSH = '<plugin name="push" filename="libpush.so"><link>fore</link></plugin>'
MARKED = {
    "plugin": (Style(tail=f"<gazebo>{PUSH}</gazebo>"), "<plugin> push left out: it can move joints or apply forces"),
    "plugin of a long name": (Style(tail=FLIGHT), "<plugin> flight_simulation left out"),
    "plugin of a link": (Style(link=PUSH), "<plugin> of links upper, fore left out"),
    "unknown in a joint": (Style(joint="<drag value='3'/>"), "<drag> of joints shoulder, elbow left out: it is unknown"),
    "detachable to another model": (
        Style(tail="""<gazebo><plugin filename="gz-sim-detachable-joint-system" name="gz::sim::systems::DetachableJoint">
<parent_link>fore</parent_link><child_model>load</child_model><child_link>body</child_link></plugin></gazebo>"""),
        "<plugin> gz::sim::systems::DetachableJoint left out",
    ),
    "damping": (Style(joint='<dynamics damping="0.1"/>'), '<dynamics> of joint elbow left out; write it into the experiment'),
}  # fmt: skip


@pytest.mark.parametrize("case", MARKED)
def test_content_that_changes_the_motion_is_marked(imported, case):
    style, line = MARKED[case]
    _, said = imported(urdf(MACHINES["arm"], style))
    assert any(each.startswith(f"changes the motion: {line}") for each in said.splitlines())
    assert said.splitlines()[-1].endswith("2 links, 2 joints, 0 loops, mobility 2")


@pytest.mark.parametrize("content", [
    '<gazebo reference="fore"><mu1>1</mu1><material>Gazebo/Red</material><sensor name="s" type="imu"/></gazebo>',
    '<gazebo><plugin name="gazebo_ros_joint_state_publisher" filename="libgazebo_ros_joint_state_publisher.so"/></gazebo>',
    '<gazebo reference="elbow"><provideFeedback>true</provideFeedback></gazebo>',
    '<mujoco><compiler balanceinertia="true"/></mujoco>',
    '<gazebo><self_collide>true</self_collide><static>false</static></gazebo>',
])  # fmt: skip
def test_content_without_influence_is_not_marked(imported, content):
    assert "changes the motion" not in imported(urdf(MACHINES["arm"], Style(tail=content)))[1]


def test_a_start_state_of_a_world_is_marked(imported):
    state = "<state world_name='w'><model name='machine'><pose>0 0 1 0 0 0</pose></model></state>"
    text = f"<sdf version='1.9'><world name='w'>{sdf(MACHINES['arm'], Style(), 'absolute')}{state}</world></sdf>"
    assert "changes the motion: <world/state> left out: the other program starts there" in imported(text)[1]


def test_a_detachable_joint_fixes_its_links_to_one_another(imported):
    """The five-bar with its two middle links as one body is a four-bar."""
    plugin = """<gazebo><plugin filename="gz-sim-detachable-joint-system" name="gz::sim::systems::DetachableJoint">
<parent_link>one</parent_link><child_model>machine</child_model><child_link>two</child_link></plugin></gazebo>"""
    path, said = imported(urdf(replace(MACHINES["five_bar"], loops=()), Style(tail=plugin)))
    assert said.splitlines()[-1].endswith("3 links, 4 joints, 1 loop, mobility 1")
    assert load_mechanism(path).link["one"].mass == pytest.approx(0.6)


def test_a_detachable_joint_fixes_a_model_to_another(imported):
    """The load is one of three links with a mass, on the second."""
    plugin = """<plugin filename="gz-sim-detachable-joint-system" name="gz::sim::systems::DetachableJoint">
<parent_link>fore</parent_link><child_model>load</child_model><child_link>body</child_link></plugin>"""
    load = """<model name="load"><pose>0.4 0 0 0 0 0</pose><link name="body"><inertial><mass>2</mass><inertia><ixx>1</ixx>
<iyy>1</iyy><izz>1</izz></inertia></inertial></link></model>"""
    arm = sdf(MACHINES["arm"], Style(tail=plugin), "absolute")
    path, said = imported(f"<sdf version='1.9'><world name='w'>{load}{arm}</world></sdf>")
    assert said.splitlines()[-1].endswith("2 links, 2 joints, 0 loops, mobility 2")
    assert load_mechanism(path).link["machine::fore"].mass == pytest.approx(2.3)


def test_springs_and_gears_of_a_merged_joint_act_in_the_joint_that_is_kept(imported):
    """The second joint has the opposite axis: a spring at 0.4 rad is one at -0.4 rad, a ratio of 2 one of -2."""
    twin = """<gazebo><joint name="twin" type="revolute"><pose>0 0 0.1 0 0 0</pose><parent>upper</parent><child>fore</child><axis>
<xyz>0 0 -1</xyz><dynamics><spring_stiffness>3</spring_stiffness><spring_reference>0.4</spring_reference></dynamics>
<mimic joint="shoulder"><multiplier>2</multiplier><offset>0.1</offset></mimic></axis></joint></gazebo>"""
    said = written(imported(urdf(MACHINES["arm"], Style(tail=twin)))[1])
    assert (
        'torsion_springs."twin_spring" = {joint = "elbow", stiffness = 3.0, free_angle = -0.4, damping = 0.0}' in said
    )
    assert 'gears."twin_mimic" = {joints = ["shoulder", "elbow"], ratio = -2.0, offset = -0.1}' in said


def _model(body):
    return f'<sdf version="1.11"><world name="w">{body}</world></sdf>'


ARM = sdf(MACHINES["arm"], Style(), "absolute")
PLATE = "<mesh><uri>plate.stl</uri></mesh>"
CONTRADICTION = PLUGIN.replace("-1.5", "2").join(("<gazebo>", "</gazebo>")) + PARAMETERS
COAXIAL = """<gazebo><joint name="twin" type="revolute"><parent>upper</parent><child>fore</child><axis><xyz>0 0 1</xyz>
<mimic joint="elbow"/></axis></joint></gazebo>"""
LONG = """<coupling name="c"><predecessor link="upper"/><successor link="world"/><ratio value="1"/></coupling>"""
REFUSED = {
    "armature": (urdf(MACHINES["arm"], Style(joint='<dynamics armature="0.1"/>')),
                 '<joint name="shoulder">/<armature>: adds the rotor\'s inertia'),
    "damping of a link": (urdf(MACHINES["arm"], Style(tail='<gazebo reference="fore"><dampingFactor>0.1</dampingFactor></gazebo>')),
                          '<link name="fore">/<gazebo>/<dampingFactor>: is not supported'),
    "underscore": (urdf(MACHINES["arm"], Style()).replace('xyz="0.3 0', 'xyz="0_3 0'),
                   '<joint name="elbow">/<origin>: its xyz is "0_3 0 0"; give three numbers'),
    "two numbers": (urdf(MACHINES["arm"], Style()).replace('xyz="0.3 0 0"', 'xyz="0.3 0"'), 'its xyz is "0.3 0"'),
    "too large": (urdf(MACHINES["arm"], Style()).replace('xyz="0.3 0', 'xyz="3e60 0'), '<joint name="elbow">/<origin>: is 3e+60'),
    "limit": (urdf(MACHINES["arm"], Style(joint='<limit lower="a" upper="1"/>')), '<joint name="shoulder">/<limit>: from a to 1'),
    "damping of a word": (urdf(MACHINES["arm"], Style(joint='<dynamics damping="much"/>')),
                          '<joint name="shoulder">/<dynamics>/<damping>: "much" is not a number'),
    "tilted": (urdf(MACHINES["straight"], Style(frames="mixed", digits=1)), 'the axis of "shoulder" by 0.0292 rad (1.67 degrees)'),
    "sliding axis": (urdf(MACHINES["slider_crank"], Style(loop="ball")).replace('xyz="1.0 0 0"/>', 'xyz="1 0 0.1"/>'),
                     'leaves the plane normal to "O" by 0.0997 rad (5.71 degrees)'),
    "automatic inertia of a mesh": (AUTO.format("", COLLISION.format("c", "0 0 0 0 0 0", "", PLATE)), "boxes, cylinders, spheres"),
    "automatic inertia of nothing": (AUTO.format("", ""), "has no <collision> with a volume"),
    "automatic inertia without a size": (AUTO.format("", COLLISION.format("c", "0 0 0 0 0 0", "", "<sphere/>")), "has no <radius>"),
    "two models": (_model(ARM + ARM.replace("machine", "other")), "2 <model> elements that are not static: machine and other; choose one"),
    "only scenery": (_model("<include><uri>model://sun</uri></include>"), "<include> model://sun: is neither in"),
    "frame of a world": (_model(ARM.replace("<pose>", '<pose relative_to="table">', 1)), "is placed relative to a frame"),
    "part of an include": (_model("<include><uri>a.sdf</uri><experimental:params/></include>"), "<include>/<experimental:params>: is not"),
    "two ways": (urdf(MACHINES["gripper"], Style(tail=CONTRADICTION)), '<joint name="R">: mimics in two different ways'),
    "coaxial gear": (urdf(MACHINES["arm"], Style(tail=COAXIAL)), '<mimic> of joint twin: couples joint "elbow" with itself'),
    "coupling of many": (urdf(MACHINES["arm"], Style(tail=LONG.replace("upper", "fore"))), "couples 2 joints to 0"),
    "mimic of nothing": (urdf(MACHINES["gripper"], Style(tail=f"<gazebo>{PLUGIN}</gazebo>".replace(">R<", ">Z<"))),
                         '<plugin name="p">: names joint "Z", which does not exist'),
    "loop of nothing": (urdf(MACHINES["four_bar"], Style(loop="urdf+")).replace('predecessor link="coupler"', 'predecessor link="cup"'),
                        'names "cup", which does not exist'),
    "universal joint": (sdf(MACHINES["arm"], Style(), "absolute").replace('"revolute"', '"universal"', 1).join(
        ("<sdf version='1.9'>", "</sdf>")), 'type "universal" is not supported'),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_file_that_cannot_be_imported_is_refused_in_one_line(tmp_path, capsys, case):
    text, reason = REFUSED[case]
    source, out = tmp_path / "theirs.xml", tmp_path / "ours.sdf"
    source.write_text(text)
    (tmp_path / "a.sdf").write_text(f"<sdf version='1.9'>{ARM}</sdf>")
    assert main(["import", str(source), "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert reason in error
    assert not out.exists()


@pytest.mark.parametrize("text", [_model(ARM), f"<sdf>{ARM}</sdf>", urdf(MACHINES["arm"], Style())])
def test_a_model_that_a_file_lacks_is_refused(tmp_path, capsys, text):
    (tmp_path / "w.xml").write_text(text)
    assert main(["import", str(tmp_path / "w.xml"), "--model", "machin", "--out", str(tmp_path / "o.sdf")]) == 2
    assert '<model name="machin">: does not exist; did you mean "machine"?' in capsys.readouterr().err


def test_a_link_without_inertial_has_the_mass_that_sdformat_gives_it(imported):
    """Drake's total mass is the reference; the file itself is read with a question."""
    tip = '<link name="tip"><pose>0.3 0 0 0 0 0</pose></link><joint name="T" type="fixed"><parent>arm</parent><child>tip</child></joint>'
    text = f"<sdf version='1.9'>{sdf(MACHINES['pendulum'], Style(tail=tip), 'absolute')}</sdf>"
    path, said = imported(text)
    assert "- link tip: values that <inertial> lacks are 1 kg" in said
    assert sum(link.mass for link in load_mechanism(path).links) == pytest.approx(_mass_in_drake(text))
