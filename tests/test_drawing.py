"""Drawing of a mechanism before a run: facts, positions of parts, content of the files."""

import re

import numpy as np
import pytest
from browser import find_browser, open_page
from machines import PLANES, bar, four_bar, joint, model, slider_crank, solid
from make_pictures import write_moving
from matplotlib.backends.backend_agg import FigureCanvasAgg
from shipped import BENT, NAMES

from linkages import Status, Trajectory
from linkages.base.palette import LINKS
from linkages.cli.main import main
from linkages.elements.gear import GEAR, Gear
from linkages.explore.range_of_motion import movable, travel
from linkages.explore.transmission import dyads
from linkages.input.files.shipped import find_file
from linkages.input.model.experiment import nothing_done
from linkages.input.model.plausibility import doubts
from linkages.input.model.skeleton import skeleton
from linkages.show.plots import orbit, pose
from linkages.show.plots.drawing import draw, page, svg
from linkages.show.plots.drawing.raster import picture
from linkages.show.plots.drawing.shapes import STYLES, placed
from linkages.show.plots.drawing.svg import pixels
from linkages.system import System, load


def alone(mechanism):
    return System(mechanism, nothing_done(mechanism.source))


def angle_between(b, c, diagonal):
    """Angle of a triangle between sides b and c, acute."""
    cosine = (b**2 + c**2 - diagonal**2) / (2.0 * b * c)
    return np.arccos(min(abs(cosine), 1.0))


@pytest.mark.parametrize("plane", PLANES)
def test_transmission_angles_of_a_crank_rocker_are_those_of_its_triangles(mechanism_of, plane):
    """Extremes at the two positions of the crank along the ground; in between it may pass 90 degrees."""
    mechanism = mechanism_of(four_bar(ground=0.3, crank=0.1, coupler=0.25, follower=0.3, plane=plane))
    way = travel(movable(mechanism, {"O": 0.0}), "O")
    (one,) = way.transmissions
    assert way.full
    assert (one.link, one.joint) == ("coupler", "B")
    low, high = angle_between(0.25, 0.3, 0.2), angle_between(0.25, 0.3, 0.4)
    assert np.nanmin(one.angle) == pytest.approx(min(low, high), abs=1e-9)
    for value, angle in zip(way.values, one.angle, strict=True):
        diagonal = np.sqrt(0.3**2 + 0.1**2 - 2 * 0.3 * 0.1 * np.cos(value))
        assert angle == pytest.approx(angle_between(0.25, 0.3, diagonal), abs=1e-7)


def test_links_have_the_colours_of_their_file():
    """As the animation, which shows the file's own visuals."""
    text = find_file("four_bar.sdf").read_text(encoding="utf-8")
    bars = {one.color for one in draw(load(find_file("four_bar_dry.toml"))).shapes if one.role == "bar"}
    parts = re.findall(r'<link name="\w+">.*?<diffuse>(.*?) 1</diffuse>', text, re.DOTALL)
    assert len(parts) == 3
    assert bars == {"#" + "".join(f"{round(255 * float(part)):02x}" for part in rgb.split()) for rgb in parts}


def test_the_wheels_of_gears_lie_within_the_drawing():
    """The wheels have pitch radii of 30 and 60 mm on shafts 90 mm apart."""
    drawing = draw(load(find_file("gear_rattle.toml")))
    assert np.all(drawing.low < [-0.03, -0.06])
    assert np.all(drawing.high > [0.15, 0.06])


def test_a_pale_link_is_darkened_for_its_name(mechanism_of):
    paint = "<visual name='v'><geometry><sphere><radius>1</radius></sphere></geometry><material><diffuse>{}</diffuse>"
    text = four_bar().replace("</link>", f"{paint.format('1 1 1 1')}</material></visual></link>", 1)
    colors = [skeleton(mechanism, link, 1.0).color for mechanism in [mechanism_of(text)] for link in mechanism.links]
    assert colors == ["#b2b2b2", LINKS[1], LINKS[2]]


def test_links_with_drives_of_their_own_have_no_transmission_angle(mechanism_of):
    """A driven rod on the coupler and a driven foot on the rod: only coupler and follower are a dyad."""
    text = four_bar(extra=FOOT + bar("rod", 0.1, "toe", 0.3) + bar("foot", 0.2, "rod_tip", 1.0))
    text = text.replace("</model>", joint("T", "coupler", "rod") + joint("S", "rod_tip", "foot") + "</model>")
    way = travel(movable(mechanism_of(text), {"O": 0.0, "T": 0.0, "S": 0.0}), "O")
    assert [(one.link, one.other, one.joint) for one in way.transmissions] == [("coupler", "follower", "B")]
    assert way.together == ()


def test_a_geared_crank_counts_as_moved_by_the_drive():
    """A five-bar with one driven crank: the rods are a dyad only if a gear moves the other crank."""
    mechanism = load(find_file("five_bar_dry.toml")).mechanism
    found, rest = dyads(mechanism, ["O1"], [GEAR.couples(Gear(joints=["O1", "O2"], ratio=-2.0))])
    assert [one.inner.name for one in found] == ["C"]
    assert rest == ()
    found, rest = dyads(mechanism, ["O1"])
    assert found == []
    assert len(rest) == len(mechanism.links) - 1


def test_dead_centres_of_a_rocker_are_where_crank_and_coupler_lie_in_line(mechanism_of):
    way = travel(movable(mechanism_of(four_bar(0.3, 0.1, 0.25, 0.2)), {"O": 0.0}), "O")
    expected = []
    for reach, turn in ((0.35, 0.0), (0.15, np.pi)):  # stretched, folded: the triangle reach - follower - ground
        expected.append((np.arccos((reach**2 + 0.3**2 - 0.2**2) / (2 * reach * 0.3)) + turn) % (2 * np.pi))
    np.testing.assert_allclose(way.transmissions[0].turns, sorted(expected), atol=1e-3)  # between steps of 0.02 rad


def test_dead_centres_and_transmission_of_a_slider_crank(mechanism_of):
    system = movable(mechanism_of(slider_crank(0.05, 0.12)), {})
    assert list(system.experiment.drives) == ["O"]
    (one,) = travel(system, "O").transmissions
    assert one.least[1] == pytest.approx(np.arccos(0.05 / 0.12), abs=1e-7)  # with the crank upright
    assert one.most[1] == 0.5 * np.pi
    np.testing.assert_allclose(sorted(np.cos(one.turns)), [-1.0, 1.0], atol=1e-6)


def test_a_rocker_ends_at_dead_points_where_coupler_and_follower_are_in_line(mechanism_of):
    way = travel(movable(mechanism_of(four_bar(0.3, 0.2, 0.25, 0.2)), {"O": 0.0}), "O")
    limit = np.arccos((0.3**2 + 0.2**2 - 0.45**2) / (2 * 0.3 * 0.2))
    assert not way.full
    assert way.ends == (Status.LOCKED, Status.LOCKED)
    np.testing.assert_allclose(way.values[[0, -1]], [-limit, limit], atol=1e-7)
    assert np.all(np.diff(way.values) > 0.0)


def test_a_crank_that_turns_fully_is_chosen_before_a_rocker(mechanism_of):
    text = four_bar(0.3, 0.1, 0.25, 0.2)
    rocker_first = text.replace(joint("O", "world", "crank"), "").replace(
        joint("Q", "world", "follower"), joint("Q", "world", "follower") + joint("O", "world", "crank")
    )
    mechanism = mechanism_of(rocker_first)
    assert [one.name for one in mechanism.joints].index("Q") < [one.name for one in mechanism.joints].index("O")
    assert list(movable(mechanism, {}).experiment.drives) == ["O"]


def test_every_joint_stays_together_in_every_pose_and_every_link_rigid():
    drawing = draw(load(find_file("seven_bar.toml")))
    system = load(find_file("seven_bar.toml")).ideal()
    assert [slider.name for slider in drawing.sliders] == ["O1", "O4"]
    bars = [one.at for one in drawing.shapes if one.role == "bar"]
    lengths = np.array([np.linalg.norm(np.subtract(*placed(at, drawing.pose))) for at in bars])
    tree = movable(system.mechanism, {"O1": 0.0, "O4": 0.0}).tree
    ends = [
        [np.array([(*tree.marker(*end), 0.0, 0.0)]) for end in ((one.parent, one.on_parent), (one.child, one.on_child))]
        for one in system.mechanism.joints
        if one.type == "revolute"
    ]
    for slider in drawing.sliders:
        moved = np.abs(np.diff(slider.poses[:, 1:], axis=0)).max()
        assert moved > 1e-3
        for shown in slider.poses[::10]:
            np.testing.assert_allclose(
                [np.linalg.norm(np.subtract(*placed(at, shown))) for at in bars], lengths, rtol=1e-12
            )
            for one, other in ends:
                np.testing.assert_allclose(placed(one, shown), placed(other, shown), atol=1e-12)


FOOT = """<frame name="toe" attached_to="coupler"><pose>0.1 -0.1 0 0 0 0</pose></frame>
<frame name="inside" attached_to="coupler"><pose>0.1 -0.02 0 0 0 0</pose></frame>
<frame name="on_pin" attached_to="coupler"><pose>0.25 0 0 0 0 0</pose></frame>"""


@pytest.mark.parametrize("plane", PLANES)
def test_a_link_is_drawn_to_all_its_joints_and_frames(mechanism_of, plane):
    mechanism = mechanism_of(four_bar(plane=plane, extra=FOOT))
    form = skeleton(mechanism, mechanism.link["coupler"], 0.3)
    assert len(form.places) == 4  # what lies on a pin is drawn once
    toe, inside = (mechanism.point[name].origin for name in ("toe", "inside"))
    corners = form.places[list(form.plate)]
    assert len(corners) == 3
    assert np.abs(corners - toe).sum(axis=1).min() < 1e-12
    assert np.abs(corners - inside).sum(axis=1).min() > 1e-3
    ends = {k for ends in form.bars for k in ends}
    assert ends == set(range(4))
    x, y = corners.T
    assert 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) == pytest.approx(0.5 * 0.25 * 0.1)


LOADED = """
duration = 0.1
title = "<b> & a \\"title\\""
gravity = [0.0, -9.81, 0.0]
outputs = ["toe.x", "follower.omega"]
[drives.O]
speed = 1.0
angle = 0.5
[joints.B]
model = "lubricated"
clearance = 1e-4
viscosity = 0.1
[forces.push]
point = "toe"
force = [0.0, 5.0]
[torques.brake]
link = "follower"
torque = -1.0
[springs.back]
point = "toe"
anchor = [0.9, 0.3]
stiffness = 10.0
free_length = 0.1
[torsion_springs.wind]
joint = "Q"
stiffness = 1.0
free_angle = 0.0
"""


@pytest.fixture
def loaded(experiment_file):
    return experiment_file(four_bar(extra=FOOT), LOADED)


def test_everything_that_is_done_with_a_machine_is_drawn_and_named(loaded):
    drawing = draw(load(loaded))
    assert {one.text for one in drawing.shapes if one.role == "load name"} == {"push", "brake", "back", "wind"}
    assert {one.text for one in drawing.shapes if one.role == "point name"} == {"toe"}  # omega is no place
    names = {one.text for one in drawing.shapes if one.role in ("joint name", "link name")}
    assert names == {"O", "A", "B", "Q", "crank", "coupler", "follower"}
    assert [one.role for one in drawing.shapes].count("play") == 1
    roles = [one.role for one in drawing.shapes]
    last_bar = max(k for k, role in enumerate(roles) if role in ("bar", "plate"))
    assert min(k for k, role in enumerate(roles) if role == "pin") > last_bar  # pins above bars
    everywhere = np.concatenate([placed(one.at, drawing.pose) for one in drawing.shapes])
    assert np.all((everywhere > drawing.low) & (everywhere < drawing.high))
    (slider,) = drawing.sliders
    assert slider.values[slider.first] == pytest.approx(np.degrees(0.5))
    np.testing.assert_allclose(slider.poses[slider.first], drawing.pose, atol=1e-12)
    (arrow,) = [one for one in drawing.shapes if one.role == "load" and len(one.at) == 2]
    tail, tip = placed(arrow.at, slider.poses[0])
    assert tip[1] > tail[1]  # the force is upwards whatever the link does
    assert tip[0] == pytest.approx(tail[0])


GEARED = """
duration = 1.0
[drives.O]
speed = -2.0
[gears.mesh]
joints = ["O", "Q"]
ratio = -0.5
[frictions.pin]
joint = "Q"
constant = 0.1
[stops.end]
joint = "Q"
side = "upper"
limit = 0.5
contact = { law = "hertz", restitution = 1.0, stiffness = 100.0 }
[forces.drag]
point = "one"
formula = ["-3*one.vx", "0"]
[forces.own]
point = "two_tip"
axes = "body"
force = [0.0, -2.0]
"""


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
def test_gears_stops_and_frictions_are_drawn(experiment_file, axis):
    """Pitch circles touch between the axes; the stop is a ray from the joint, turned from the link by its limit."""
    text = bar("one", 0.1, "__model__", 0.3) + bar("two", 0.2, "pivot", 1.0) + joint("O", "world", "one", axis=axis)
    text += '<frame name="pivot" attached_to="world"><pose>0.3 0 0 0 0 0</pose></frame>'
    drawing = draw(load(experiment_file(model("pair", text + joint("Q", "world", "two", axis=axis)), GEARED)))
    assert drawing.facts[0].endswith("1 degree of freedom")  # the gear takes the other
    assert [slider.name for slider in drawing.sliders] == ["O"]
    assert {"mesh", "pin", "end", "drag", "own"} <= {one.text for one in drawing.shapes if one.role == "load name"}
    (middle,) = [placed(one.at, drawing.pose)[0] for one in drawing.shapes if one.role == "ring"]
    np.testing.assert_allclose(middle, [0.3, 0.0], atol=1e-12)
    circles = [placed(one.at, drawing.pose) for one in drawing.shapes if one.role == "pitch line"]
    for rim, centre, radius in zip(circles, (0.0, 0.3), (0.1, 0.2), strict=True):
        np.testing.assert_allclose(np.linalg.norm(rim[1:] - [centre, 0.0], axis=1), radius, rtol=1e-9)
    rays = [placed(one.at, drawing.pose) - [0.3, 0.0] for one in drawing.shapes if one.role == "hatch"]
    angle = 1.0 + (0.5 if axis == "0 0 1" else -0.5)
    along = [ray[1] - ray[0] for ray in rays if np.isclose(abs(np.linalg.det(ray)), 0.65 * 4.4 * drawing.unit**2)]
    assert any(np.allclose(one / np.linalg.norm(one), [np.cos(angle), np.sin(angle)]) for one in along)


@pytest.mark.parametrize(("speed", "sign"), [(2.0, 1.0), (-2.0, -1.0)])
def test_arrows_point_where_drives_go_and_loads_push(experiment_file, speed, sign):
    text = model("arm", bar("one", 0.1, "__model__", 0.3) + joint("O", "world", "one"))
    done = f"""
duration = 0.1
[drives.O]
speed = {speed}
[forces.drag]
point = "one_tip"
formula = ["0", "-3*one_tip.vy"]
[forces.own]
point = "one_tip"
axes = "body"
force = [0.0, -2.0]
[torques.brake]
link = "one"
formula = "-one.omega"
"""
    drawing = draw(load(experiment_file(text, done)))
    drag, own, brake = (placed(one.at, drawing.pose) for one in drawing.shapes if one.role == "load")
    np.testing.assert_allclose((drag[1] - drag[0]) / np.linalg.norm(drag[1] - drag[0]), [0.0, -sign], atol=1e-12)
    across = [np.sin(0.3), -np.cos(0.3)]  # y of the link, backwards
    np.testing.assert_allclose((own[1] - own[0]) / np.linalg.norm(own[1] - own[0]), across, atol=1e-12)
    (drive,) = [placed(one.at, drawing.pose) for one in drawing.shapes if one.role == "drive"]
    for ring, way in ((drive, sign), (brake, -sign)):
        assert np.sign(np.linalg.det([ring[1] - ring[0], ring[2] - ring[1]])) == way
    assert drawing.sliders[0].sense == sign


def test_words_of_a_file_cannot_break_the_picture_or_the_page(loaded):
    drawing = draw(load(loaded))
    for text in (svg(drawing), page(drawing)):
        assert "<b> &" not in text
        assert "&lt;b&gt; &amp;" in text
    assert picture(drawing).texts[0].get_text() == drawing.title


def test_a_machine_that_does_not_close_is_drawn_with_its_gap(mechanism_of, tmp_path, capsys):
    text = four_bar().replace(
        '<frame name="B_on_follower" attached_to="follower"><pose>0.2',
        '<frame name="B_on_follower" attached_to="follower"><pose>0.9',
    )
    drawing = draw(alone(mechanism_of(text)))
    assert drawing.problem.startswith("no-assembly")
    (gap,) = [one for one in drawing.shapes if one.role == "gap"]
    assert np.linalg.norm(np.subtract(*placed(gap.at, drawing.pose))) == pytest.approx(0.7)
    assert "open by up to 700 mm, at B" in drawing.facts[1]
    assert main(["draw", str(tmp_path / "m.sdf"), "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err.startswith("failed: no-assembly")
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"drawing.html", "drawing.png", "drawing.svg", "record.json"}


def test_a_second_drive_of_a_machine_with_one_freedom_is_named(experiment_file):
    file = experiment_file(four_bar(), "duration = 1.0\n[drives.O]\nspeed = 1.0\n[drives.Q]\nspeed = 1.0\n")
    drawing = draw(load(file))
    assert [slider.name for slider in drawing.sliders] == ["O"]
    assert drawing.facts[0].endswith("1 degree of freedom, 2 drives: Q cannot be moved by itself")


@pytest.mark.parametrize(
    ("values", "question"),
    [
        ({}, None),
        ({"sdf.frames.ground_Q.pose.x": 100.0, "sdf.frames.crank_A.pose.x": 200.0}, "is this file in millimetres?"),
        ({"sdf.links.crank.pose.yaw": 90.0}, "are these degrees?"),
        ({"sdf.links.crank.mass": 314.0}, "are these grams?"),
        ({"sdf.links.crank.inertia": 1057.0}, "is it in kg mm2?"),
        ({"drives.O.angle": 90.0}, "are these degrees?"),
        ({"drives.O.speed": 3000.0}, "is it in r/min, or in degrees?"),
        ({"drives.O.speed": 600.0}, "is it in r/min, or in degrees?"),
        ({"drives.O.speed": "600 rad/s"}, None),
        ({"gravity": [0.0, -9810.0, 0.0]}, "is it in mm/s2?"),
        (
            {"gravity": [0.0, 0.0, -9.81]},
            "does the machine lie flat? If it stands upright, write gravity = [0.0, -9.81",
        ),
        ({"gravity": [0.0, -8.0, -5.7]}, None),
    ],
)
def test_a_value_in_another_unit_is_asked_about(values, question):
    system = load(find_file("four_bar_dry.toml"), values)
    asked = doubts(system.mechanism, system.tree.extent, system.experiment)
    assert asked == [] if question is None else (len(asked) == 1 and asked[0].partition(": ")[2].startswith(question))


def test_a_heavy_link_that_reaches_far_beyond_its_joints_raises_no_question(experiment_file):
    """47 kg with 6.7 kg m2 are a radius of gyration of 0.38 m: a boom of 1 m, on two pins at a distance of 3 cm."""
    body = solid("base", 20.0) + solid("boom", 47.0, 6.7, "0.03 0 0 0 0 0", centre="0.5 0 0 0 0 0")
    system = load(
        experiment_file(
            model("crane", body + joint("O", "world", "base") + joint("A", "base", "boom")), "duration = 1.0\n"
        )
    )
    asked = doubts(system.mechanism, system.tree.extent, system.experiment)
    assert not any("boom" in question for question in asked)


def crank_machine(crank, rod, sizes, drive, com=None):
    """A slider-crank of these lengths; `sizes` are masses and moments of inertia of crank, rod and slider."""
    of_crank, of_rod, of_slider = sizes
    body = solid("crank", *of_crank, "0 0 0 0 0 0", centre=f"{crank / 2 if com is None else com} 0 0 0 0 0")
    body += solid("rod", *of_rod, f"{crank} 0 0 0 0 0", centre=f"{rod / 2} 0 0 0 0 0")
    body += solid("slider", *of_slider, f"{crank + rod} 0 0 0 0 0")
    body += joint("O", "world", "crank") + joint("A", "crank", "rod") + joint("B", "rod", "slider")
    body += joint("guide", "world", "slider", "prismatic", "1 0 0")
    return model("machine", body), f"duration = 1.0\n[drives.O]\n{drive}\n"


@pytest.mark.parametrize(
    "machine",
    [
        crank_machine(8.0, 50.0, [(900.0, 5e3), (5000.0, 1e6), (800.0, 50.0)], "speed = 0.1"),
        crank_machine(1e-4, 3e-4, [(2e-10, 4e-19), (1e-9, 1e-17), (4e-9, 1e-17)], "speed = 1e4"),
        crank_machine(0.0155, 0.0655, [(0.2, 1e-5), (0.02, 1e-5), (0.05, 1e-5)], "speed = '5000 r/min'", com=0.005),
    ],
    ids=["a crane", "a micromachine", "the needle bar of a sewing machine"],
)
def test_true_special_machines_raise_no_question(system_of, machine):
    system = system_of(*machine)
    assert doubts(system.mechanism, system.tree.extent, system.experiment) == []


@pytest.mark.parametrize(("com", "count"), [(None, 1), (0.0, 0)])
def test_a_driven_wheel_with_its_centre_beside_the_joint_is_asked_about(system_of, com, count):
    """40 kg with 0.5 kg m2 on a crank of 40 mm at 1,500 r/min: m e w^2 = 40 * 0.02 * 157.08^2 = 19.7 kN."""
    machine = crank_machine(0.04, 0.15, [(40.0, 0.5), (0.2, 4e-4), (0.3, 1e-4)], "speed = '1500 r/min'", com)
    system = system_of(*machine)
    asked = doubts(system.mechanism, system.tree.extent, system.experiment)
    assert len(asked) == count
    for question in asked:
        assert "mass centre of crank turns 0.02 m beside O, and pulls with 1.97e+04 N" in question


def test_a_link_without_inertial_is_asked_about(experiment_file):
    tip = '<link name="tip"><pose relative_to="crank_tip">0 0 0 0 0 0</pose></link>' + joint(
        "T", "crank", "tip", "fixed"
    )
    system = load(experiment_file(four_bar().replace("</model>", f"{tip}</model>"), "duration = 1.0\n"))
    (question,) = doubts(system.mechanism, system.tree.extent, system.experiment)
    assert question == "tip has no <inertial>: 0 kg here, 1 kg in other programs: is it massless? Write its <inertial>"


def test_a_run_begins_with_the_questions_of_the_drawing(tmp_path, capsys):
    """Each as a warning before the table; --quiet omits them."""
    values = ["--set", "gravity=[0, -9810, 0]", "--set", "drives.O.speed=3000"]
    assert main(["draw", "four_bar_dry.toml", *values, "--out", str(tmp_path / "drawing")]) == 0
    drawn = " ".join(capsys.readouterr().out.split())
    options = ["--engine", "compiled", "--ideal", "--duration", "1e-4", "--no-plots", "--no-animation"]
    options += ["--no-error-estimate", "--out", str(tmp_path / "run")]
    assert main(["simulate", "four_bar_dry.toml", *values, *options]) == 0
    asked = " ".join(capsys.readouterr().out.partition("engine:")[0].split()).split("! warning: ")[1:]
    assert len(asked) == 2
    assert all(question.strip() in drawn for question in asked)
    assert main(["simulate", "four_bar_dry.toml", *values, *options, "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_shipped_machines_raise_no_doubts():
    folder = find_file("seven_bar.toml").parent
    for file in set(folder.glob("*.toml")) - {folder / "three_rrr.toml", folder / "three_rrr_aluminium.toml"}:
        system = load(file)
        assert doubts(system.mechanism, system.tree.extent, system.experiment) == [], file.name


def test_the_command_draws_a_machine_with_other_values(tmp_path, capsys):
    options = ["--set", "sdf.links.crank.mass=0.5", "--out", str(tmp_path)]
    assert main(["draw", "four_bar.sdf", *options]) == 0
    assert "crank 0.5 kg" in capsys.readouterr().out
    assert "crank 0.5 kg" in (tmp_path / "drawing.svg").read_text()
    assert main(["draw", "four_bar.sdf", "--set", "sdf.links.crnk.mass=0.5", "--out", str(tmp_path / "none")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_the_moving_picture_moves(mechanism_of, tmp_path):
    from PIL import Image

    write_moving(draw(alone(mechanism_of(four_bar()))), tmp_path / "moving.gif", frames=4, dpi=20.0)
    with Image.open(tmp_path / "moving.gif") as moving:
        assert moving.n_frames == 4
        first = np.asarray(moving.convert("L"), dtype=float)
        moving.seek(2)
        assert np.abs(np.asarray(moving.convert("L"), dtype=float) - first).max() > 50.0


LOOK = """
const input = document.querySelectorAll("input")[1];
const pins = () => [...document.querySelectorAll("circle[r='7.20']")].map((pin) => [+pin.getAttribute("cx"), +pin.getAttribute("cy")]);
input.value = 40;
input.dispatchEvent(new Event("input"));
const result = {pins: pins(), shown: document.querySelectorAll("output")[1].value};
document.querySelectorAll("button")[0].click();
result.others = document.querySelectorAll("input")[1].value;
return result;"""


@pytest.mark.slow
@pytest.mark.skipif(find_browser() is None, reason="no Chromium with its chromedriver on the PATH")
def test_the_slider_moves_the_machine_as_its_loops_close(tmp_path):
    drawing = draw(load(find_file("seven_bar.toml")))
    (tmp_path / "drawing.html").write_text(page(drawing), encoding="utf-8")
    seen = open_page(tmp_path / "drawing.html", tmp_path, LOOK)
    slider = drawing.sliders[1]
    pins = [one.at for one in drawing.shapes if one.role == "pin"]
    expected = np.concatenate([pixels(drawing, placed(at, slider.poses[40])) for at in pins])
    np.testing.assert_allclose(seen.seen["pins"], expected, atol=0.02)
    assert seen.seen["shown"] == f"{slider.values[40]:.1f} deg"
    assert seen.requests == []
    assert re.search(r"[1-9]", seen.seen["shown"])


def test_pose_draws_the_machine_for_a_notebook(loaded):
    figure = pose(load(loaded))
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert {text.get_text() for text in figure.axes[0].texts} >= {"O", "A", "B", "Q", "crank", "toe", "push"}
    assert not figure.texts  # facts are the command's


def test_orbits_of_runs_share_one_clearance_circle(loaded):
    system, time = load(loaded), np.linspace(0.0, 1.0, 50)
    runs = [
        Trajectory(time, {"time": time, "B.ex": e * np.cos(time), "B.ey": e * np.sin(time)}, Status.OK)
        for e in (3e-5, 8e-5)
    ]
    axis = orbit(system, runs[0], "B")
    assert orbit(system, runs[1], "B", axis, label="second") is axis
    (circle,) = axis.patches
    np.testing.assert_allclose(np.linalg.norm(circle.get_xy(), axis=1), 100.0)  # µm
    radii = [np.linalg.norm(line.get_xydata(), axis=1) for line in axis.lines]
    np.testing.assert_allclose(radii, [np.full(50, 30.0), np.full(50, 80.0)])
    assert [line.get_label() for line in axis.lines] == ["B", "second"]


def _texts(drawing):
    """Texts of the picture as matplotlib sets them: text and box [px]."""
    figure = picture(drawing, said=False)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    (axes,) = figure.axes
    return axes, {text: text.get_window_extent(renderer) for text in axes.texts}


def _check_names(drawing, name=""):
    """No name lies on another name, on an arrow or on a bar's middle line, and none is cut off."""
    axes, boxes = _texts(drawing)
    arrows = [one for one in drawing.shapes if one.role in ("drive", "load", "bar") and len(one.at) == 2]
    ends = [axes.transData.transform(placed(one.at, drawing.pose)) for one in arrows]
    found = list(boxes.items())
    for k, (one, box) in enumerate(found):
        for other, beside in found[k + 1 :]:
            inside = max(0.0, min(box.x1, beside.x1) - max(box.x0, beside.x0))
            inside *= max(0.0, min(box.y1, beside.y1) - max(box.y0, beside.y0))
            part = inside / min(box.width * box.height, beside.width * beside.height)
            assert part < 0.05, f"{name}: {one.get_text()} lies on {other.get_text()}"
        for tail, tip in ends:
            on = tail + np.linspace(0.0, 1.0, 50)[:, None] * (tip - tail)
            hit = (on > [box.x0, box.y0]).all(axis=1) & (on < [box.x1, box.y1]).all(axis=1)
            assert not hit.any(), f"{name}: {one.get_text()} lies on an arrow or a bar"
        frame = axes.get_window_extent()
        assert frame.x0 - 2.0 < box.x0 < box.x1 < frame.x1 + 2.0, f"{name}: {one.get_text()} is cut off"


@pytest.mark.parametrize("name", [*NAMES, *BENT, "three_rrr_clearance"])
def test_names_of_shipped_machines_lie_apart(name):
    _check_names(draw(load(find_file(f"{name}.toml"))), name)


def test_rounding_of_the_files_digits_is_no_gap():
    assert draw(load(find_file("five_bar_dry.toml"))).facts[1] == "drawn closed"  # 7e-11 m
    assert draw(load(find_file("seven_bar.toml"))).facts[1] == "as drawn, its loops are open by up to 255.1 µm, at C3"


@pytest.mark.parametrize("name", ["corner", "left_end", "D_and_more"])
def test_a_joint_in_the_corner_is_not_named_on_the_arrow_of_gravity(experiment_file, name):
    """A short arm to the left on a pin in the upper right corner: its name would be above it to the right."""
    text = '<frame name="pivot" attached_to="world"><pose>0.3 0.3 0 0 0 0</pose></frame>'
    text += bar("arm", 0.002, "pivot", np.pi) + joint(name, "world", "arm")
    text += bar("low", 0.1, "__model__", 0.0) + joint("O", "world", "low")
    done = "duration = 0.1\ngravity = [0, -9.81, 0]\n[drives.O]\nspeed = 1.0\n"
    drawing = draw(load(experiment_file(model("corner", text), done)))
    assert any(one.text == "g" for one in drawing.shapes)
    _check_names(drawing)


def test_a_still_drawing_is_not_at_a_dead_centre_and_is_cropped():
    """The press starts at a dead centre, where its crank, its rods and its slider are on one line."""
    system = load(find_file("slider_crank_dry.toml"))
    start, still = draw(system), draw(system, spread=True)
    assert not still.sliders

    def area(drawing):
        corners = [placed(one.at, drawing.pose)[0] for one in drawing.shapes if one.role in ("pin", "play")]
        return np.linalg.det(np.cov(np.array(corners).T))

    assert area(start) < 1e-12 < area(still)
    for one in still.shapes:
        if STYLES[one.role].kind != "text":
            points = placed(one.at, still.pose)
            assert np.all((still.low <= points) & (points <= still.high)), one.role
    assert np.prod(still.high - still.low) < np.prod(start.high - start.low)
