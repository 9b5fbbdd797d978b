"""Files that were written for other programs: as Drake reads them, imported, or refused for a reason that is true."""

import math
import re

import numpy as np
import pytest
from foreign_files import angles_on_drake, experiment, written
from machines import bar, circle_intersection, four_bar, joint, model

from linkages import InputError, load_mechanism
from linkages.cli.main import main
from linkages.engines.assessment import simulate
from linkages.input.files.sdf import read_sdf
from linkages.input.files.sdf_text import sdf_text
from linkages.input.files.shipped import data_folder

GOOD = four_bar()


def drake(text, kind="sdf", welded=()):
    """Drake's plant of a text, and its context."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, kind)
    for name in welded:
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(name))
    plant.Finalize()
    return plant, plant.CreateDefaultContext()


def same(mechanism, other):
    """Whether two machines are the same, but for their frames, to rounding."""
    for kind, keys in (("link", "mass com inertia"), ("joint", "parent child on_parent on_child sign direction type")):
        assert getattr(mechanism, kind).keys() == getattr(other, kind).keys()
        for name, part in getattr(mechanism, kind).items():
            for key in keys.split():
                found = getattr(getattr(other, kind)[name], key)
                assert getattr(part, key) == (found if isinstance(found, str) else pytest.approx(found, abs=1e-14)), (
                    name
                )
    return True


# -- valid without changes --------------------------------------------------------------------------------

AS_OTHERS_READ = {
    "hyphens in a comment": GOOD.replace("<link", "<!-- * -- drawn by hand --- \n <joint> --><link"),
    "a prefix that nothing declares": GOOD.replace(
        "<inertial>", '<drake:shape x="1"><drake:y/></drake:shape><inertial>'
    ),
    "our prefix, not declared": GOOD.replace(' xmlns:linkages="urn:linkages:sdf"', ""),
    "ours under another prefix": re.sub(r"(?<=[</])linkages:", "lk:", GOOD).replace("xmlns:linkages", "xmlns:lk"),
    "a text with the signs of a comment": GOOD.replace("<link n", "<x><![CDATA[ <!-- <a> ]]></x><link n"),
}


@pytest.mark.parametrize("case", AS_OTHERS_READ)
def test_text_that_other_readers_take_is_the_same_machine(mechanism_of, case):
    text = AS_OTHERS_READ[case]
    assert text != GOOD
    machine = mechanism_of(text)
    assert same(machine, mechanism_of(GOOD))
    assert machine.joint["A"].bearing.radius == 0.01


def test_errors_below_a_comment_name_the_right_line(mechanism_of):
    broken = "<sdf>\n<!-- one\n two -- three\n-->\n<model></sdf>"
    with pytest.raises(InputError, match="line 5"):
        mechanism_of(broken)


def test_comments_that_do_not_end_are_refused_in_time_of_their_length(mechanism_of):
    with pytest.raises(InputError, match="not well-formed"):
        mechanism_of("<sdf>" + "<!--" * 300_000)


BASE = '<link name="base"><pose>0.02 0.01 0 0 0 0.3</pose><visual name="v"/></link>'


def test_a_link_without_mass_that_is_fixed_to_the_world_is_a_frame_of_it(mechanism_of):
    text = GOOD.replace("</model>", BASE + joint("weld", "world", "base", "fixed") + "</model>")
    text = text.replace("<parent>world</parent><child>follower</child>", "<parent>base</parent><child>follower</child>")
    machine = mechanism_of(text)
    assert same(machine, mechanism_of(GOOD))
    assert machine.point["base"].link == "world"
    assert machine.point["base"].origin == pytest.approx([0.02, 0.01])
    assert machine.point["base"].angle == pytest.approx(0.3)


def test_a_link_without_mass_that_is_fixed_to_a_link_is_a_frame_of_it(mechanism_of):
    tip = '<link name="tip"><pose relative_to="coupler">0.05 0.02 0 0 0 0</pose></link>'
    machine = mechanism_of(GOOD.replace("</model>", tip + joint("glue", "tip", "coupler", "fixed") + "</model>"))
    assert same(machine, mechanism_of(GOOD))
    assert machine.point["tip"].link == "coupler"


LEG = f"""<model name="leg"><pose relative_to="crank_tip">0.02 0.01 0 0 0 0.4</pose>
<frame name="hip"><pose>0.01 0 0 0 0 0.2</pose></frame>
{bar("thigh", 0.2, "hip", 0.3)}{bar("shin", 0.15, "thigh_tip", -0.5)}
<model name="foot"><pose relative_to="shin_tip">0 0 0 0 0 0.7</pose>{bar("toe", 0.05, "__model__", 0.1)}</model>
{joint("knee", "thigh_tip", "shin")}<joint name="ankle" type="revolute"><parent>shin</parent><child>foot::toe</child>
<axis><xyz expressed_in="foot">0 0 1</xyz></axis></joint></model>{joint("hang", "crank_tip", "leg::thigh")}"""
LEG = LEG.replace('relative_to="__model__"', "")  # Drake: only a model's own parts may name it


def test_models_in_models_are_as_drake_reads_them(mechanism_of):
    from pydrake.multibody.tree import BodyIndex

    text = model("host", bar("crank", 0.1, "__model__") + joint("O", "world", "crank") + LEG)
    machine = mechanism_of(text)
    plant, context = drake(text)
    bodies = [plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())]
    found = {body.scoped_name().get_full().removeprefix("host::"): body for body in bodies}
    assert found.keys() == machine.link.keys() >= {"leg::thigh", "leg::foot::toe"}
    for name, body in found.items():
        pose = plant.EvalBodyPoseInWorld(context, body)
        assert machine.link[name].translation == pytest.approx(pose.translation(), abs=1e-15)
        assert machine.link[name].rotation == pytest.approx(pose.rotation().matrix(), abs=1e-15)
    assert {(j.name, j.parent, j.child) for j in machine.joints} >= {
        ("hang", "crank", "leg::thigh"),
        ("leg::knee", "leg::thigh", "leg::shin"),
        ("leg::ankle", "leg::shin", "leg::foot::toe"),
    }
    assert machine.value("links.leg::foot::toe.mass") == 0.2


@pytest.mark.parametrize("version", ["1.4", "1.6"])
def test_files_of_older_versions_are_as_drake_reads_them(mechanism_of, version):
    old = "" if version == "1.4" else "<use_parent_model_frame>1</use_parent_model_frame>"
    inertial = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
    slide = f'<joint name="P" type="prismatic"><pose>0 0 0 0 0 0.5</pose><parent>world</parent><child>a</child>\
<axis>{old}<xyz>1 0 0</xyz></axis></joint>'
    turn = (
        f'<joint name="J" type="revolute"><parent>a</parent><child>b</child><axis>{old}<xyz>0 0 1</xyz></axis></joint>'
    )
    text = f"""<sdf version="{version}"><model name="m"><link name="a"><pose>0.1 0 0 0 0 0.7</pose>{inertial}</link>
<link name="b"><pose>0.3 0 0 0 0 0.2</pose>{inertial}</link>{slide}{turn}</model></sdf>"""
    plant, context = drake(text)
    found = plant.GetJointByName("P")
    axis = found.frame_on_parent().CalcRotationMatrixInWorld(context) @ found.translation_axis()
    assert mechanism_of(text).joint["P"].axis == pytest.approx(axis, abs=1e-15)


UNKNOWN_HERE = {
    "mimic": ("</xyz></axis>", '</xyz><mimic joint="O"><multiplier>2</multiplier></mimic></axis>', "is geared to it"),
    "a force": ("</model>", "<drake:linear_bushing_rpy/></model>", "<drake:linear_bushing_rpy>: is unknown"),
    "a rotor": ("</xyz></axis>", "</xyz></axis><drake:rotor_inertia>1</drake:rotor_inertia>", "linkages import"),
    "an include": ("</model>", "<include><uri>a.sdf</uri></include></model>", "linkages import"),
    "no name": ("</model>", "<model/></model>", "has no name"),
    "static": ("</model>", '<model name="n"><static>1</static></model></model>', "fix its links to the world"),
    "placement": ("</model>", '<model name="n" placement_frame="x"/></model>', "placement frames"),
    "URDF": (GOOD, '<robot name="r"/>', "linkages import m.sdf"),
    "a world": (
        GOOD,
        '<sdf><world name="w"><model name="m"/></world></sdf>',
        "`linkages import` takes the model of a world",
    ),
    "automatic inertia": (
        "<inertial>",
        '<inertial auto="true">',
        "is automatic; `linkages import` computes its values",
    ),
}


@pytest.mark.parametrize("case", UNKNOWN_HERE)
def test_what_can_change_the_motion_is_refused(mechanism_of, case):
    there, instead, reason = UNKNOWN_HERE[case]
    with pytest.raises(InputError, match=r"^m\.sdf: ") as caught:
        mechanism_of(GOOD.replace(there, instead, 1))
    assert reason in str(caught.value)


# -- imported ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", sorted(data_folder().glob("*.sdf")), ids=lambda path: path.stem)
def test_a_machine_that_is_written_is_read_again(tmp_path, path):
    raw = read_sdf(path)
    (tmp_path / "again.sdf").write_text(sdf_text(raw, ["a -- remark"]))
    again, mechanism = load_mechanism(tmp_path / "again.sdf"), load_mechanism(path)
    assert same(mechanism, again)
    for name, point in mechanism.point.items():
        assert again.point[name].origin == pytest.approx(point.origin, abs=1e-14)
        assert again.point[name].angle == pytest.approx(point.angle, abs=1e-14)
    for name, item in mechanism.joint.items():
        assert (again.joint[name].bearing, again.joint[name].slot) == (item.bearing, item.slot)


def urdf_bar(name, length, more=""):
    """A bar of URDF along its x axis, with its inertia in turned axes."""
    moment = 0.3 * length**2 / 12
    tensor = f'ixx="{moment}" iyy="0" izz="{moment}" ixy="0" ixz="0" iyz="0"'
    return f"""<link name="{name}"><inertial><origin xyz="{length / 2} 0 0.01" rpy="0 0 {math.pi / 2}"/>
<mass value="0.3"/><inertia {tensor}/></inertial>{more}</link>"""


def urdf_joint(name, parent, child, xyz="0 0 0", kind="continuous", more="", yaw=0.0):
    """A joint of URDF about z."""
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="0 0 {yaw}"/>{ends}<axis xyz="0 0 1"/>{more}</joint>'


BOX = """<visual><origin xyz="0.05 0 0"/><geometry><box size="0.1 0.01 0.01"/></geometry><material name="red"/></visual>"""
ROD = """<visual><geometry><mesh filename="package://x/y.stl"/></geometry></visual><collision name="c"/>"""
LOOP = """<loop_joint name="B" type="continuous"><axis xyz="0 0 1"/><link1 link="coupler" xyz="0.25 0 0" rpy="0 0 0"/>
<link2 link="follower" xyz="0.2 0 0" rpy="0 0 0"/></loop_joint>"""
GAZEBO = """<gazebo><joint name="B" type="revolute"><pose>0.2 0 0 0 0 0</pose><parent>coupler</parent><child>follower</child>
<axis><xyz>0 0 1</xyz></axis></joint></gazebo>"""


def urdf_four_bar(loop, limits="", coupler=0.0, follower=0.0, limited="A"):
    """Crank 0.1, coupler 0.25, follower 0.2, ground 0.3 m; the bars are drawn at angles to the one before."""
    limit = {limited: f"<limit {limits} effort='1' velocity='1'/>" if limits else ""}
    upper, right = (
        urdf_joint(name, *ends, "revolute", limit.get(name, ""), yaw)
        for name, ends, yaw in (
            ("A", ("crank", "coupler", "0.1 0 0"), coupler),
            ("Q", ("base", "follower", "0.3 0 0"), follower),
        )
    )
    return f"""<robot name="four_bar" xmlns="http://example.org"><material name="red"><color rgba="1 0 0 1"/></material>
<link name="base"/>{urdf_bar("crank", 0.1, BOX)}{urdf_bar("coupler", 0.25, ROD)}{urdf_bar("follower", 0.2)}
{urdf_joint("O", "base", "crank")}{right}{upper}{loop}
<transmission name="motor"/><gazebo reference="crank"><mu1>1</mu1></gazebo></robot>"""


def closed(side):
    """Place of B in the plane, and the angles of coupler and follower, on one of both branches."""
    x, y = circle_intersection((0.1, 0.0), 0.25, (0.3, 0.0), 0.2, side)
    return np.array([x, y]), math.atan2(y, x - 0.1), math.atan2(y, x - 0.3)


@pytest.mark.parametrize("loop", [LOOP, GAZEBO], ids=["loop_joint", "gazebo"])
def test_a_four_bar_of_urdf_is_one_of_sdf(imported, mechanism_of, loop):
    place, coupler, follower = closed(1.0)
    path, text = imported(urdf_four_bar(loop, "", coupler, follower))
    machine = load_mechanism(path)
    assert (set(machine.link), set(machine.joint)) == ({"crank", "coupler", "follower"}, {"O", "A", "Q", "B"})
    assert machine.joint["B"].on_parent == pytest.approx(place, abs=1e-15)
    assert machine.joint["B"].on_child == pytest.approx(place, abs=1e-15)
    crank = machine.link["crank"]
    assert (crank.mass, crank.com, crank.inertia) == (0.3, pytest.approx([0.05, 0.0]), pytest.approx(0.3 * 0.1**2 / 12))
    assert machine.point["base"].link == "world"
    for said in (
        "link base was not connected to the world",
        "<mesh> of link coupler left out",
        "<collision> of link coupler left out",
        "<transmission> motor left out",
        "<mu1> of link crank left out",
    ):
        assert said in text
        assert said in " ".join(path.read_text().split())
    assert "<limit>" not in text


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_limits_say_which_assembly_is_meant(imported, side):
    """Nothing in the drawing closes; the angle of the coupler from the crank decides between both branches."""
    _, coupler, _ = closed(side)
    limits = f"lower='{min(coupler - 0.3, 0.9 * coupler)}' upper='{max(coupler + 0.3, 0.9 * coupler)}'"
    path, text = imported(urdf_four_bar(LOOP, limits))
    assert "reference configuration computed" in text
    system = experiment(path, "[drives.O]\nangle = 0.0\nspeed = 0.0\n")
    joints = load_mechanism(path).joint
    assert joints["B"].on_parent == pytest.approx(joints["B"].on_child, abs=1e-9)
    arms = [joints[end].on_child - joints[start].on_child for start, end in (("O", "A"), ("A", "B"))]
    assert np.sign(np.linalg.det(arms)) == side
    assert system.assembly.mobility == 1


def test_limits_that_no_assembly_keeps_are_bad_input(tmp_path, capsys):
    source, out = tmp_path / "theirs.urdf", tmp_path / "ours.sdf"
    source.write_text(urdf_four_bar(LOOP, "lower='-0.1' upper='0.1'", limited="Q"))  # B would be 0.5 m from O
    assert main(["import", str(source), "--out", str(out)]) == 2
    assert "theirs.urdf: <limit>: no pose was found" in capsys.readouterr().err
    assert not out.exists()


ARM = f"""<robot name="arm"><link name="world"/><link name="plate"/>{urdf_bar("upper", 0.3)}{urdf_bar("fore", 0.2)}
<link name="hand"><inertial><origin xyz="0.03 0.02 0.04" rpy="0.1 0.2 0.3"/><mass value="0.5"/>
<inertia ixx="0.01" iyy="0.02" izz="0.025" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial>{BOX}</link><link name="tip"/>
{urdf_joint("weld", "world", "plate", "0 0 1", "fixed", yaw=0.3)}{urdf_joint("shoulder", "plate", "upper", "0.1 0 0.2")}
{urdf_joint("elbow", "upper", "fore", "0.3 0 0", "revolute", '<dynamics damping="0.02" friction="0"/>', yaw=0.5)}
{urdf_joint("wrist", "fore", "hand", "0.2 0.01 0", "fixed", yaw=-0.7)}{urdf_joint("end", "hand", "tip", "0.1 0 0", "fixed")}
</robot>"""


def test_fixed_links_are_one_with_the_inertia_that_drake_gives_them(imported):
    machine = load_mechanism(imported(ARM)[0])
    plant, context = drake(ARM, "urdf")
    assert set(machine.link) == {"upper", "fore"}
    assert {"hand": "fore", "tip": "fore", "plate": "world"}.items() <= {
        p.name: p.link for p in machine.point.values()
    }.items()
    bodies = [plant.GetBodyByName(name).index() for name in ("fore", "hand", "tip")]
    frame = plant.GetFrameByName("fore")
    both = plant.CalcSpatialInertia(context, frame, bodies)
    link = machine.link["fore"]
    assert link.mass == pytest.approx(both.get_mass(), rel=1e-14)
    assert link.com_local == pytest.approx(both.get_com(), abs=1e-15)
    central = both.Shift(both.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    assert link.inertia_local == pytest.approx(central, abs=1e-15)


def test_an_arm_of_urdf_falls_as_on_drakes_own_plant(imported):
    """The joint's damping is where the import says that it belongs."""
    path, text = imported(ARM)
    gravity, joints = [1.0, -2.0, -9.0], ("shoulder", "elbow")
    run = simulate(experiment(path, f"{written(text)}gravity = {gravity}\n", 0.5), "compiled")
    angles = angles_on_drake(ARM, "urdf", gravity, 0.5, joints)
    assert min(map(abs, angles)) > 0.05
    assert [run[f"q.{name}"][-1] for name in joints] == pytest.approx(angles, abs=1e-8)


def sdf_arm(pose, frame):
    """Two bars; the second one is drawn at the frame "end" of the first, and its joint names another frame of it."""
    frames = "".join(
        f'<frame name="{name}" attached_to="upper"><pose>{x} 0 0 0 0 0</pose></frame>'
        for name, x in (("end", 0.3), ("other", 0.2))
    )
    fore = (
        bar("fore", 0.2, "end", 0.5).replace("<pose relative_to", f"<pose {pose}relative_to").replace(" 0.5<", " 28.6<")
    )
    return model("arm", bar("upper", 0.3, "__model__") + frames + fore + joint("shoulder", "world", "upper")
                 + joint("elbow", frame, "fore"))  # fmt: skip


@pytest.mark.parametrize("frame", ["upper", "end", "other"])
def test_an_arm_of_sdf_falls_as_on_drakes_own_plant(imported, frame):
    """A parent that is a frame names the link that carries it; the joint is at its own pose on both links."""
    text = sdf_arm('degrees="True" ', frame)
    path, _ = imported(text)
    gravity, joints = [1.0, -2.0, -9.0], ("shoulder", "elbow")
    run = simulate(experiment(path, f"gravity = {gravity}\n", 0.5), "compiled")
    angles = angles_on_drake(text, "sdf", gravity, 0.5, joints)
    assert min(map(abs, angles)) > 0.05
    assert [run[f"q.{name}"][-1] for name in joints] == pytest.approx(angles, abs=1e-8)


def test_joints_about_one_axis_between_two_links_are_one(imported):
    """A crank in two bearings, next to each other; the second is written in reverse."""
    second = '<loop_joint name="O2" type="continuous"><axis xyz="0 0 1"/><link1 link="crank" xyz="0 0 0.1"/>\
<link2 link="base" xyz="0 0 0.1"/></loop_joint>'
    _, coupler, follower = closed(1.0)
    path, text = imported(urdf_four_bar(LOOP + second, "", coupler, follower))
    assert "joint O2 has the axis of O between the same links" in text
    assert set(load_mechanism(path).joint) == {"O", "A", "Q", "B"}


def test_shapes_and_colours_are_drawn(imported):
    """Drake takes the shapes with the machine; a mesh would need a file."""
    path, _ = imported(ARM)
    visual = read_sdf(path).links[1].visuals[0]
    assert "<size>0.1 0.01 0.01</size>" in visual
    assert simulate(experiment(path, "", 0.01), "drake").status.value == "ok"


def test_included_files_are_followed(tmp_path, capsys):
    (tmp_path / "pair").mkdir()
    pair = bar("one", 0.2, "__model__") + bar("two", 0.1, "one_tip", 0.3) + joint("J", "one_tip", "two")
    (tmp_path / "pair" / "model.sdf").write_text(model("pair", pair, "xy"))
    include = "<include><uri>model://pair</uri><name>{}</name><pose>{} 0 0 0 0 0.2</pose></include>"
    body = (
        include.format("a", 0.1)
        + include.format("b", 0.7)
        + joint("L", "world", "a::one")
        + joint("M", "a::two", "b::one")
    )
    (tmp_path / "all.sdf").write_text(model("all", body))
    out = tmp_path / "out.sdf"
    assert main(["import", str(tmp_path / "all.sdf"), "--out", str(out)]) == 0
    machine = load_mechanism(out)
    assert set(machine.link) == {"a::one", "a::two", "b::one", "b::two"}
    assert machine.link["b::one"].origin == pytest.approx([0.7, 0.0])
    assert machine.joint["b::J"].on_child == pytest.approx([0.7 + 0.2 * math.cos(0.2), 0.2 * math.sin(0.2)])
    assert capsys.readouterr().out.count("\n") == 2  # nothing was left out


def test_of_a_world_its_one_model_is_taken(imported, mechanism_of):
    inside = GOOD[GOOD.index("<model") : GOOD.index("</sdf>")]
    world = "<gravity>0 0 -9.8</gravity><light name='sun'/><include><uri>model://ground_plane</uri></include>"
    path, text = imported(f'<sdf version="1.6"><world name="w">{world}{inside}</world></sdf>')
    assert same(load_mechanism(path), mechanism_of(GOOD))
    for left in ("world/light", "world/include"):
        assert f"<{left}>" in text
    assert "gravity = [0.0, 0.0, -9.8]" in text


def test_a_universal_joint_of_two_hinges_is_a_hinge_in_the_plane(imported):
    """A parallel robot's leg in URDF: the second hinge is at the place of the first, and would turn out of the plane."""

    def arm(name, mass):
        inertia = f'<inertia ixx="{mass}" iyy="{mass}" izz="{mass}" ixy="0" ixz="0" iyz="0"/>'
        return f'<link name="{name}"><inertial><origin xyz="0.1 0 0"/><mass value="{mass}"/>{inertia}</inertial></link>'

    def hinge(name, parent, child, x, axis):
        ends = f'<parent link="{parent}"/><child link="{child}"/>'
        return f'<joint name="{name}" type="continuous">{ends}<origin xyz="{x} 0 0"/><axis xyz="{axis}"/></joint>'

    links = '<link name="world"/><link name="cross"/>' + arm("a", 0.3) + arm("b", 0.2)
    joints = hinge("U1", "world", "a", 0, "0 0 1") + hinge("U2", "a", "cross", 0.3, "0 1 0")
    path, said = imported(f'<robot name="r">{links}{joints}{hinge("U3", "cross", "b", 0, "0 0 1")}</robot>')
    assert "changes the motion: joint U2 of a universal or ball joint would turn out of the plane: held" in said
    assert "with 2 links, 2 joints, 0 loops, mobility 2" in said
    assert list(load_mechanism(path).joint) == ["U1", "U3"]


def test_hinges_at_two_places_are_no_universal_joint(tmp_path, capsys):
    """The link between them would move: the reason is the axis."""
    links = "".join(f'<link name="{name}"/>' for name in ("world", "cross"))
    body = '<link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    joints = "".join(
        f'<joint name="{n}" type="continuous"><parent link="{p}"/><child link="{c}"/><origin xyz="0.2 0 0"/><axis xyz="{a}"/></joint>'
        for n, p, c, a in (("P", "world", "cross", "0 1 0"), ("Q", "cross", "b", "0 0 1"))
    )
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{links}{body}{joints}</robot>')
    assert main(["import", str(tmp_path / "r.urdf"), "--out", str(tmp_path / "r.sdf")]) == 2
    assert "not planar: its axis is not parallel to the axis of" in capsys.readouterr().err


REFUSED = {
    "two models in a world": ('<sdf><world><model name="a"/><model name="b"/></world></sdf>', "has 2 <model> elements"),
    "xacro": (urdf_four_bar('<xacro:macro name="leg"/>'), "cannot be expanded by xacro ("),
    "xacro in a value": (
        urdf_four_bar(LOOP).replace('"0.25 0 0"', '"${a} 0 0"'),
        "cannot be expanded by xacro (name 'a' is not defined",
    ),
    "mimic": (urdf_four_bar("").replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><mimic joint="O"/>', 1), "<mimic>"),
    "ball": (urdf_four_bar(LOOP).replace('"continuous"', '"floating"', 1), 'type "floating" is not supported'),
    "not planar": (urdf_four_bar(LOOP).replace('"0 0 1"', '"0 1 1"', 1), "not parallel to the axis of"),
    "two parents": (urdf_four_bar(urdf_joint("B", "coupler", "follower")), 'is carried by two joints, "Q" and "B"'),
    "link that is not there": (urdf_four_bar(LOOP).replace('link="crank"', 'link="crnk"'), 'did you mean "crank"'),
    "no mass": (urdf_four_bar(urdf_joint("Z", "crank", "z") + '<link name="z"/>'), "has no <inertial>"),
    "text": (urdf_four_bar(LOOP).replace('mass value="0.3"', 'mass value="x"'), '"x" is not a number'),
    "no range": (urdf_four_bar(LOOP, "lower='1' upper='0'"), "from 1 to 0 is not a range"),
    "held": (urdf_four_bar(LOOP.replace('"B"', '"F"').replace("continuous", "fixed") + LOOP), "fixed to each other"),
    "far away": (model("m", "<include><uri>https://example.org/a</uri></include>"), "is not a local file"),
    "nowhere": (model("m", "<include><uri>a.sdf</uri></include>"), "is neither in"),
    "itself": (model("m", "<include><uri>theirs.xml</uri></include>"), "includes itself"),
    "merged": (model("m", '<include merge="true"><uri>other.sdf</uri></include>'), "remove merge"),
    "too heavy together": (
        ARM.replace('mass value="0.3"', 'mass value="9e49"').replace('mass value="0.5"', 'mass value="9e49"'),
        "at most 1e+50",
    ),
    "nothing moves": (model("m", bar("a", 0.1, "__model__")), "no moving link"),
    "neither": (
        "<Robot/>",
        "is a robot of OpenRAVE; SDFormat (<sdf>), URDF and xacro (<robot>) and MJCF (<mujoco>) are",
    ),
    "neither true nor false": (sdf_arm('degrees="yes" ', "end"), '<pose> degrees: is "yes"; write true or false'),
    "static": (model("m", "<static>True</static>" + bar("a", 0.1, "__model__")), "a static model cannot move"),
    "two masses": (GOOD.replace("<mass>", "<mass>1</mass><mass>", 1), "<inertial>: has 2 <mass> elements; keep one"),
    "two axes": (GOOD.replace("<axis>", "<axis><xyz>0 1 0</xyz></axis><axis>", 1), "has 2 <axis> elements; keep one"),
    "two worlds": ('<sdf version="1.9"><world name="a"/><world name="b"/></sdf>', "has 2 <world> elements"),
    "two origins": (ARM.replace("<origin", "<origin/><origin", 1), "has 2 <origin> elements; keep one"),
    "a mass centre elsewhere": (
        GOOD.replace("<inertial><pose>", '<inertial><pose relative_to="pivot">', 1),
        "is relative to another element",
    ),
    "pose of old versions": (
        sdf_arm("", "end").replace("<pose relative_to", "<pose frame"),
        "<pose frame>: belongs to SDFormat before 1.7",
    ),
    "world as a child": (
        ARM.replace('<link name="world"/>', '<link name="world"/>' + urdf_joint("back", "tip", "world")),
        '<joint name="back">: has the child world; make world the parent',
    ),
    "quaternion": (ARM.replace("<origin", '<origin quat_xyzw="0 0 1 0"', 1), "has quat_xyzw; write the angles as rpy"),
    "element for an attribute": (
        ARM.replace('damping="0.02" friction="0"/>', "><damping>0.02</damping></dynamics>"),
        "<dynamics>: contains <damping>, which URDF does not read; write the attribute damping",
    ),
    "unknown dynamics": (ARM.replace('friction="0"', 'stiffness="4"'), "<dynamics>/<stiffness>: is unknown"),
    "dynamics twice": (
        ARM.replace("</robot>", '<gazebo reference="elbow"><dynamics><damping>1</damping></dynamics></gazebo></robot>'),
        "<dynamics> of joint elbow: is given twice; keep one",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_planar_linkage_is_refused_in_one_line_with_exit_status_2(tmp_path, capsys, case):
    text, reason = REFUSED[case]
    source, out = tmp_path / "theirs.xml", tmp_path / "ours.sdf"
    source.write_text(text)
    (tmp_path / "other.sdf").write_text(GOOD)
    assert main(["import", str(source), "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("error: theirs.xml: ")
    assert reason in error
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.sdf", "theirs.xml"]


def test_nothing_is_overwritten(tmp_path, capsys):
    (tmp_path / "a.sdf").write_text(GOOD)
    for out, reason in (("a.sdf", "already exists"), ("b.xml", "must end in .sdf")):
        assert main(["import", str(tmp_path / "a.sdf"), "--out", str(tmp_path / out)]) == 2
        assert reason in capsys.readouterr().err
    assert (tmp_path / "a.sdf").read_text() == GOOD
