"""Imported joints whose named parent frame lies elsewhere than the joint's own pose: marked, or placed there."""

import numpy as np
import pytest

from linkages import load_mechanism
from linkages.cli.main import main

LENGTHS = {"crank": 0.05, "coupler": 0.2, "rocker": 0.12, "ground": 0.18}
JOINTS = {"left": ("crank",), "right": ("rocker",), "low": ("crank", "coupler"), "high": ("rocker", "coupler")}


def link(name, along, pose=""):
    """A bar from its own origin, along x or y, with a frame NAME_end at its end."""
    length = LENGTHS[name]
    middle, end = (f"{x} 0 0" if along == "x" else f"0 {x} 0" for x in (0.5 * length, length))
    return f"""<link name="{name}">{pose}<inertial><pose>{middle} 0 0 0</pose><mass>0.3</mass><inertia><ixx>1e-3</ixx>
<iyy>1e-3</iyy><izz>1e-3</izz></inertia></inertial></link>
<frame name="{name}_end" attached_to="{name}"><pose relative_to="{name}">{end} 0 0 0</pose></frame>"""


def hinge(name, parent, child, inner=""):
    return f"""<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>{inner}
<axis><xyz>0 0 1</xyz></axis></joint>"""


GROUND = f"""<frame name="one" attached_to="world"><pose>0 0 0.01 0 0 0</pose></frame>
<frame name="two" attached_to="world"><pose>{LENGTHS["ground"]} 0 0 0 0 0</pose></frame>"""
BARS = link("crank", "y") + link("rocker", "y") + link("coupler", "x")


def frames(parent, child):
    """Drake's elements for the frames of a joint on both links."""
    return f"<drake:parent_frame>{parent}</drake:parent_frame><drake:child_frame>{child}</drake:child_frame>"


#: Four-bars that are drawn open, with all links at the origin: frames named as parents, frames of Drake on both links.
NAMED = BARS + "".join(
    (
        hinge("left", "one", "crank"),
        hinge("right", "two", "rocker"),
        hinge("low", "crank_end", "coupler"),
        hinge("high", "rocker_end", "coupler_end"),
    )
)
OF_DRAKE = BARS + "".join(
    (
        hinge("left", "world", "crank", frames("one", "crank")),
        hinge("right", "world", "rocker", frames("two", "rocker") + "<pose>9 9 0 0 0 0</pose>"),
        hinge("low", "crank", "coupler", frames("crank_end", "coupler")),
        hinge("high", "rocker", "coupler", frames("rocker_end", "coupler_end")),
    )
)


@pytest.fixture
def imported(tmp_path, capsys):
    """Import the text of a model; returns the mechanism, and what the command says."""

    def call(body, *options, ground=GROUND):
        path, out = tmp_path / "theirs.sdf", tmp_path / "ours.sdf"
        path.write_text(f'<sdf version="1.9"><model name="four_bar">{ground}{body}</model></sdf>')
        assert main(["import", str(path), *options, "--out", str(out)]) == 0
        return load_mechanism(out), capsys.readouterr().out

    return call


def is_the_four_bar(mechanism):
    """Whether joints are at one place on both links, and as far from each other as the links are long."""
    for joint in mechanism.joints:
        np.testing.assert_allclose(joint.on_parent, joint.on_child, atol=1e-12)
    places = {joint.name: joint.on_child for joint in mechanism.joints}
    pairs = {
        "crank": ("left", "low"),
        "coupler": ("low", "high"),
        "rocker": ("high", "right"),
        "ground": ("left", "right"),
    }
    found = {name: np.linalg.norm(places[a] - places[b]) for name, (a, b) in pairs.items()}
    return found == pytest.approx(LENGTHS, abs=1e-10)


def test_parent_frames_elsewhere_are_marked_and_joints_stay_at_their_own_poses(imported):
    """SDFormat: three of the hinges are at the origin of their children, and the fourth at the coupler's end."""
    mechanism, said = imported(NAMED)
    first = said.splitlines()[0]
    assert first.startswith(
        "changes the motion: joints right, low, high: the frames named as parents lie up to 0.233 m"
    )
    assert first.endswith("--joints-at-parent places them at these frames")
    assert said.splitlines()[-1].endswith("mobility 2")
    np.testing.assert_allclose([mechanism.joint[name].on_parent for name in ("left", "right", "low")], 0.0, atol=1e-15)
    assert not is_the_four_bar(mechanism)


@pytest.mark.parametrize(("body", "options"), [(NAMED, ("--joints-at-parent",)), (OF_DRAKE, ())])
def test_joints_at_the_frames_of_both_links_make_a_four_bar(imported, body, options):
    mechanism, said = imported(body, *options)
    assert said.splitlines()[-1].endswith("3 links, 4 joints, 1 loop, mobility 1")
    assert "joints right, low, high: placed at the frames named as parents, up to 0.233 m" in said
    assert "changes the motion" not in said
    assert is_the_four_bar(mechanism)


def test_a_displaced_pendulum_hangs_at_its_parents_frame(imported):
    """No loop is open: the link itself moves to the frame."""
    mechanism, said = imported(link("crank", "y") + hinge("pin", "two", "crank"), "--joints-at-parent")
    assert "reference configuration computed: " in said
    np.testing.assert_allclose(mechanism.joint["pin"].on_child, [LENGTHS["ground"], 0.0], atol=1e-15)
    np.testing.assert_allclose(mechanism.point["crank_end"].origin, [LENGTHS["ground"], LENGTHS["crank"]], atol=1e-15)


def test_an_offset_along_the_axis_is_no_other_place_in_the_plane(imported):
    """The frame "one" lies 10 mm above the origin."""
    body = link("crank", "y") + hinge("pin", "one", "crank")
    assert "changes the motion" not in imported(body)[1]


def test_the_option_says_where_it_changes_nothing(imported):
    said = imported(link("crank", "y") + hinge("pin", "world", "crank"), "--joints-at-parent")[1]
    assert "--joints-at-parent changes nothing: no joint that moves names a frame elsewhere as its parent" in said


def test_a_loop_that_cannot_close_at_the_parents_frames_is_refused(imported, capsys):
    with pytest.raises(AssertionError):
        imported(NAMED, "--joints-at-parent", ground=GROUND.replace(f"{LENGTHS['ground']} 0 0", "0.6 0 0"))
    assert "<joint>: no pose was found in which all loops close; check the places" in capsys.readouterr().err


def test_an_imported_mimic_joint_keeps_its_own_coordinate_where_the_joints_share_no_link(imported):
    """The third joint of a chain follows the first: without the key the gear would be refused."""
    frame = '<frame name="middle" attached_to="rocker"><pose relative_to="rocker">0 0.06 0 0 0 0</pose></frame>'
    mimic = hinge("third", "rocker", "coupler").replace(
        "</xyz>", '</xyz><mimic joint="first"><multiplier>2</multiplier></mimic>'
    )
    chain = BARS + frame + hinge("first", "world", "crank") + hinge("second", "crank", "rocker") + mimic
    mechanism, said = imported(chain)
    assert 'gears."third_mimic" = {joints = ["first", "third"], ratio = 2.0, offset = 0.0, mimic = true}' in said
    assert said.splitlines()[-1].endswith("mobility 2 with the gears above, 3 without")
    assert not mechanism.meet("first", "third")
