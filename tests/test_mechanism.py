"""The loader against Drake's own SDFormat parser, planes, and refusals."""

import re

import numpy as np
import pytest
from machines import BEARING, PLANES, bar, four_bar, joint, model, plane_rotation, slider_crank

from linkages import InputError, find_file, load_mechanism
from linkages.cli.main import main
from linkages.system.spanning import spanning_tree

NESTED = """
<frame name="f1"><pose>0.1 0.2 0 0 0 0.3</pose></frame>
<frame name="f2" attached_to="two"><pose relative_to="f3">0.05 0 0 0 0 0.1</pose></frame>
<frame name="f3" attached_to="one"><pose degrees="true">0.2 0.1 0.05 0 0 30</pose></frame>
<link name="one"><pose relative_to="f1">0.1 0 0 0 0 0.2</pose>
 <inertial><pose>0.01 0.02 0 0 0 0.4</pose><mass>1.5</mass>
 <inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.025</izz><ixy>0.001</ixy></inertia></inertial></link>
<link name="two"><pose relative_to="f1" rotation_format="quat_xyzw">0 0.1 0  0 0 0.6 0.8</pose>
 <inertial><mass>0.7</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>
<joint name="j1" type="revolute"><parent>world</parent><child>one</child>
 <pose relative_to="f1">0 0 0 0 0 0</pose><axis><xyz>0 0 2</xyz></axis></joint>
<joint name="j2" type="prismatic"><parent>one</parent><child>f2</child>
 <axis><xyz expressed_in="f3">1 0.5 0</xyz></axis></joint>
"""


@pytest.mark.parametrize("plane", PLANES)
def test_poses_axes_and_inertias_agree_with_drakes_parser(mechanism_of, plane):
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    text = model("nested", NESTED, plane)
    mechanism = mechanism_of(text)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "sdf")
    plant.Finalize()
    context = plant.CreateDefaultContext()
    for link in mechanism.links:
        body = plant.GetBodyByName(link.name)
        X = plant.EvalBodyPoseInWorld(context, body)
        np.testing.assert_allclose(link.translation, X.translation(), atol=1e-15)
        np.testing.assert_allclose(link.rotation, X.rotation().matrix(), atol=1e-15)
        spatial = body.default_spatial_inertia()
        assert link.mass == spatial.get_mass()
        np.testing.assert_allclose(link.com_local, spatial.get_com(), atol=1e-15)
        central = spatial.Shift(spatial.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        np.testing.assert_allclose(link.inertia_local, central, atol=1e-15)
    for item in mechanism.joints:
        found = plant.GetJointByName(item.name)
        frame = found.frame_on_parent().CalcPoseInWorld(context)
        local = found.revolute_axis() if item.type == "revolute" else found.translation_axis()
        np.testing.assert_allclose(item.axis, frame.rotation() @ local, atol=1e-15)
        np.testing.assert_allclose(item.position, frame.translation(), atol=1e-15)
    frame = plant.GetFrameByName("f3").CalcPoseInWorld(context)
    np.testing.assert_allclose(mechanism.point["f3"].origin, mechanism.basis[:, :2].T @ frame.translation(), atol=1e-15)


@pytest.mark.parametrize("plane", PLANES)
def test_plane_axes_are_right_handed_and_normal_to_it(mechanism_of, plane):
    basis = mechanism_of(four_bar(plane=plane)).basis
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-12)
    assert np.linalg.det(basis) == pytest.approx(1.0)
    normal = plane_rotation(plane)[:, 2]
    assert abs(basis[:, 2] @ normal) == pytest.approx(1.0)
    if plane in ("xy", "xz", "yz"):
        axes = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}[plane]
        np.testing.assert_allclose(basis[:, :2], np.eye(3)[:, axes], atol=1e-12)


def test_tree_cuts_play_first_then_the_fewest_ideal_joints(seven_bar):
    mechanism = seven_bar.mechanism
    both = spanning_tree(mechanism, ("A", "B"), ("O1", "O4"))
    assert (both.play, both.loops, both.size) == (("A", "B"), (), 6)
    one = spanning_tree(mechanism, ("A",), ("O1", "O4"))
    assert one.play == ("A",)
    assert len(one.loops) == 1
    none = spanning_tree(mechanism, (), ("O1", "O4"))
    assert len(none.loops) == 2
    assert {"O1", "O4"} <= set(none.coordinates)


def test_a_link_on_clearance_joints_alone_floats(mechanism_of):
    tree = spanning_tree(mechanism_of(slider_crank()), ("A", "B"), ("O",))
    assert tree.coordinates == ("O", "guide", "rod.x", "rod.y", "rod.angle")


def test_angles_by_path_are_in_radians_whatever_the_file_says():
    path = find_file("four_bar.sdf")  # written in degrees
    turned = load_mechanism(path, {"links.crank.pose.yaw": 1.0})
    assert turned.link["crank"].angle == pytest.approx(1.0, abs=1e-12)


def test_overrides_reach_the_file(tmp_path):
    path = tmp_path / "m.sdf"
    path.write_text(four_bar())
    changed = load_mechanism(
        path,
        {
            "links.coupler.mass": 0.5,
            "links.coupler.inertia": 2e-3,
            "links.crank.com.y": 0.01,
            "frames.crank_tip.pose.x": 0.11,
            "joints.A.bearing.radius": 0.02,
        },
    )
    assert (changed.link["coupler"].mass, changed.link["coupler"].inertia) == (0.5, pytest.approx(2e-3))
    assert changed.link["crank"].com == pytest.approx([0.05, 0.01])
    assert changed.joint["A"].on_parent == pytest.approx([0.11, 0.0])
    assert changed.joint["A"].bearing.radius == 0.02


def test_a_joint_gets_a_bearing_by_both_sizes(mechanism_of):
    """The numbers of the bearing are then values like others."""
    bare = re.sub(r"<linkages:bearing>.*?</linkages:bearing>", "", four_bar(), flags=re.DOTALL)
    sizes = {"joints.A.bearing.radius": 0.01, "joints.A.bearing.length": 0.03}
    changed = mechanism_of(bare, sizes)
    assert mechanism_of(bare).joint["A"].bearing is None
    assert (changed.joint["A"].bearing.radius, changed.joint["A"].bearing.length) == (0.01, 0.03)
    assert changed.values | sizes == changed.values
    with pytest.raises(InputError, match="has no <linkages:length>"):
        mechanism_of(bare, {"joints.A.bearing.radius": 0.01})
    with pytest.raises(InputError, match=r'"slot.length" is unknown'):
        mechanism_of(bare, {"joints.A.slot.length": 0.01})


def test_a_link_gets_a_beam_between_its_pins_by_four_numbers(mechanism_of):
    """It is the beam that a file can have, with the mass of a steel bar of this section."""
    sizes = {"width": 0.01, "height": 0.02, "youngs_modulus": 2.1e11, "density": 7850.0}
    values = {f"links.coupler.beam.{key}": value for key, value in sizes.items()}
    link = mechanism_of(four_bar(), values).link["coupler"]
    assert link.mass == pytest.approx(0.01 * 0.02 * 0.25 * 7850.0)
    assert link.inertia == pytest.approx(link.mass * 0.25**2 / 12.0)
    assert (link.beam.frames, link.beam.section, link.beam.sizes) == (
        ("coupler", "coupler_tip"), "rectangle", {"width": 0.01, "height": 0.02},
    )  # fmt: skip
    with pytest.raises(InputError, match="has no <linkages:density>"):
        mechanism_of(four_bar(), {key: value for key, value in values.items() if "density" not in key})
    with pytest.raises(InputError, match="follows from the link's beam"):
        mechanism_of(four_bar(), values | {"links.coupler.mass": 1.0})


def test_a_number_of_numpy_is_a_number(mechanism_of):
    values = {"links.coupler.mass": 0.1 + 0.2, "frames.crank_tip.pose.x": 0.11, "frames.crank_tip.pose.yaw": 0.1}
    plain, numpy = (mechanism_of(four_bar(), {k: kind(v) for k, v in values.items()}) for kind in (float, np.float64))
    assert numpy.values == plain.values
    assert numpy.link["coupler"].mass == 0.1 + 0.2


def test_an_override_does_not_complete_a_pose(tmp_path):
    path = tmp_path / "m.sdf"
    text = four_bar()
    path.write_text(text.replace("<pose>0.1 0 0 0 0 0</pose>", "<pose>0.1 0 0</pose>", 1))
    assert path.read_text() != text
    for override in ({}, {"frames.crank_tip.pose.x": 0.2}, {"frames.crank_tip.pose.yaw": 0.2}):
        with pytest.raises(InputError, match=r'<frame name="crank_tip">/<pose>: has 3 numbers; 6 are needed'):
            load_mechanism(path, override)


GOOD = four_bar()
LINK = bar("spare", 0.1, "__model__")

REFUSED = {
    "not well-formed": (GOOD.replace("</model>", ""), "not well-formed"),
    "DTD": ('<!DOCTYPE sdf [<!ENTITY x "1">]>' + GOOD, "entities are rejected"),
    "not SDFormat": ("<mujoco/>", "the root must be <sdf>"),
    "two models": (GOOD.replace("</sdf>", '<model name="b"/></sdf>'), "exactly one"),
    "unknown link": (GOOD.replace("<child>coupler</child>", "<child>couplr</child>"), 'did you mean "coupler"'),
    "defined twice": (GOOD.replace("</model>", LINK + LINK + "</model>"), "is defined twice"),
    "not planar": (GOOD.replace("<xyz>0 0 1</xyz>", "<xyz>0 1 1</xyz>", 1), "not planar"),
    "slides out of plane": (
        model(
            "m",
            LINK + joint("J", "world", "spare") + bar("b", 0.1, "__model__") + joint("P", "spare", "b", "prismatic"),
        ),
        "its axis leaves the plane",
    ),
    "no inertial": (GOOD.replace("</model>", '<link name="x"/></model>'), "has no <inertial>"),
    "negative mass": (GOOD.replace("<mass>0.2</mass>", "<mass>-1</mass>", 1), "must be positive"),
    "non-physical inertia": (GOOD.replace("<ixx>0</ixx>", "<ixx>9</ixx>", 1), "are impossible"),
    "non-positive radius": (GOOD.replace("radius>0.01<", "radius>0<", 1), "must be positive"),
    "negative length": (GOOD.replace("length>0.02<", "length>-1<", 1), "must be positive"),
    "no bearing length": (GOOD.replace("<linkages:length>0.02</linkages:length>", "", 1), "has no <linkages:length>"),
    "unknown bearing key": (GOOD.replace("linkages:length", "linkages:lenght"), 'did you mean "length"'),
    "not connected": (GOOD.replace("</model>", LINK + "</model>"), "not connected to the world"),
    "unsupported joint": (GOOD.replace('name="A" type="revolute"', 'name="A" type="ball"'), "is not supported"),
    "joint to itself": (GOOD.replace("<parent>crank_tip</parent>", "<parent>coupler</parent>"), "to itself"),
    "pose circle": (
        GOOD.replace(
            "</model>",
            '<frame name="a"><pose relative_to="b"/></frame><frame name="b"><pose relative_to="a"/></frame></model>',
        ),
        "break the circle",
    ),
    "not a number": (GOOD.replace("<mass>0.2</mass>", "<mass>heavy</mass>", 1), "is not a number"),
    "a number with an underscore": (GOOD.replace("<mass>0.2<", "<mass>2_0<", 1), '"2_0" is not a number'),
    "a number in other digits": (GOOD.replace("<pose>0.1 0", "<pose>\u0661 0", 1), "is not 6 numbers"),
    "not parallel by an angle": (
        GOOD.replace("<xyz>0 0 1</xyz>", "<xyz>0 0.0004 1</xyz>", 1),
        "by 0.0004 rad (0.0229 degrees); `linkages import` aligns it",
    ),
    "not finite": (GOOD.replace("<mass>0.2</mass>", "<mass>nan</mass>", 1), "must be finite"),
    "wrong count": (GOOD.replace("<xyz>0 0 1</xyz>", "<xyz>0 1</xyz>", 1), "3 are needed"),
    "zero axis": (GOOD.replace("<xyz>0 0 1</xyz>", "<xyz>0 0 0</xyz>", 1), "has no length"),
    "damping": (
        GOOD.replace("</xyz></axis>", "</xyz><dynamics><damping>0.1</damping></dynamics></axis>", 1),
        "is not supported",
    ),
    "damping that is text": (
        GOOD.replace("</xyz></axis>", "</xyz><dynamics><damping>x</damping></dynamics></axis>", 1),
        "is not a number",
    ),
    "out of all proportion": (GOOD.replace("<mass>0.2</mass>", "<mass>1e200</mass>", 1), "at most 1e+50"),
    "another encoding": ('<?xml version="1.0" encoding="idna"?>' + GOOD, "save the file as UTF-8"),
    "nested deep": (GOOD.replace("</model>", "<a>" * 200 + "</a>" * 200 + "</model>"), "100 levels deep"),
    "long chain of frames": (
        GOOD.replace(
            "</model>", "".join(f'<frame name="f{i}" attached_to="f{i + 1}"/>' for i in range(5000)) + "</model>"
        ),
        "of more than 100 frames that are attached to each other",
    ),
    "static": (GOOD.replace("<pose>0 0 0", "<static>true</static><pose>0 0 0", 1), "static"),
    "bearing in a slider": (
        slider_crank().replace("<axis><xyz>1 0 0</xyz></axis>", "<axis><xyz>1 0 0</xyz></axis>" + BEARING),
        "cannot carry",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_files_are_refused_in_one_line_with_exit_status_2(tmp_path, capsys, case):
    text, reason = REFUSED[case]
    assert text != GOOD
    path = tmp_path / "bad.sdf"
    path.write_text(text)
    (tmp_path / "e.toml").write_text('mechanism = "bad.sdf"\nduration = 1.0\n')
    assert main(["simulate", str(tmp_path / "e.toml"), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith(("error: bad.sdf: ", 'error: e.toml: mechanism: is "bad.sdf"'))
    assert reason in error
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError) as caught:
        load_mechanism(path)
    message = str(caught.value)
    assert message.startswith("bad.sdf: ")
    assert reason in message
    assert "\n" not in message
