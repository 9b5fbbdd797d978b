"""Elements of other programs that change the motion: converted to the same motion, or refused."""

import math
import re

import numpy as np
import pytest
from foreign_files import angles_on_drake, experiment, written
from machines import bar, circle_intersection, four_bar, joint, model

from linkages import load_mechanism
from linkages.cli.main import main
from linkages.engines.assessment import simulate

GOOD = four_bar()


# -- welds and balls ---------------------------------------------------------------------------------


def split_four_bar(shadow, constraint, prefix=""):
    """The four-bar of `GOOD` whose coupler is two bars of half the mass, drawn apart, and joined in their middles."""
    body = re.search(r'<link name="coupler">.*?</link>', GOOD, re.DOTALL)[0]
    half = body.replace("<mass>0.2", "<mass>0.1").replace("0.0010416666666666667", "0.00052083333333333333")
    ball = BALL.replace("<drake:ball_constraint>", '<drake:ball_constraint name="B">').replace(">coupler<", ">shadow<")
    more = f"""{shadow}{ball}
<frame name="coupler_middle" attached_to="coupler"><pose>0.125 0 0 0 0 0</pose></frame>
<frame name="shadow_middle" attached_to="shadow"><pose>0.125 0 0 0 0 0</pose></frame>
<drake:{constraint}><{prefix}parent>coupler_middle</{prefix}parent><{prefix}child>shadow_middle</{prefix}child></drake:{constraint}>"""
    return open_four_bar(more).replace(body, half)


@pytest.mark.parametrize("prefix", ["", "drake:"])
@pytest.mark.parametrize("angle", [0.0, 2.0], ids=["in place", "apart"])
def test_a_welded_coupler_is_the_whole_coupler(imported, tmp_path, angle, prefix):
    """Half the mass and half the inertia twice: the four-bar with one degree of freedom that was split."""
    at, turn = ("crank_tip", 0.8956647938578651) if not angle else ("pivot", angle)
    path, text = imported(split_four_bar(bar("shadow", 0.25, at, turn, 0.1), "weld_constraint", prefix))
    assert "<drake:weld_constraint>: shadow is fixed to coupler" in text
    (tmp_path / "good.sdf").write_text(GOOD)
    found, good = load_mechanism(path), load_mechanism(tmp_path / "good.sdf")
    assert found.link.keys() == good.link.keys()
    assert found.link["coupler"].mass == pytest.approx(0.2)
    assert found.link["coupler"].com == pytest.approx(good.link["coupler"].com)
    assert found.link["coupler"].inertia == pytest.approx(good.link["coupler"].inertia)
    assert (found.joint["B"].parent, found.joint["B"].child) == ("coupler", "follower")
    for name, other in good.joint.items():
        assert found.joint[name].on_parent == pytest.approx(other.on_parent, abs=1e-15)
        assert found.joint[name].on_child == pytest.approx(other.on_child, abs=1e-15)
    assert experiment(path, "[drives.O]\nspeed = 5.0\n").assembly.mobility == 1


@pytest.mark.parametrize("order", [("skew", "two"), ("two", "skew")])
def test_a_weld_moves_its_link_with_all_that_is_fixed_to_it(imported, order):
    """Bar three keeps its pose on bar two, whose start becomes the frame on bar one."""
    bars = bar("one", 0.2, "__model__") + bar("two", 0.1, "one_tip", 1.0) + bar("three", 0.1, "two_tip", -0.3)
    skew = '<frame name="skew" attached_to="one"><pose>0.2 0 0 0 0 0.5</pose></frame>'
    joints = joint("O", "world", "one") + joint("glue", "two", "three", "fixed")
    path, _ = imported(model("m", bars + skew + joints + weld(*order)))
    machine = load_mechanism(path)
    tip, start = machine.point["three_tip"], machine.point["skew"]
    turn = start.angle - 0.3
    arm = np.array([math.cos(start.angle) + math.cos(turn), math.sin(start.angle) + math.sin(turn)])
    assert tip.origin - start.origin == pytest.approx(0.1 * arm, abs=1e-12)
    assert tip.angle == pytest.approx(turn, abs=1e-12)
    assert [link.mass for link in machine.links] == [pytest.approx(0.6)]


def weld(parent, child):
    return f"<drake:weld_constraint><parent>{parent}</parent><child>{child}</child></drake:weld_constraint>"


BALL = """<drake:ball_constraint><drake:ball_constraint_body_A>coupler</drake:ball_constraint_body_A>
<drake:ball_constraint_p_AP>0.25 0 0</drake:ball_constraint_p_AP>
<drake:ball_constraint_body_B>follower</drake:ball_constraint_body_B>
<drake:ball_constraint_p_BQ>0.2 0 0</drake:ball_constraint_p_BQ></drake:ball_constraint>"""


def open_four_bar(more):
    """The four-bar of `GOOD` without its joint B."""
    return re.sub(r'<joint name="B".*?</joint>', "", GOOD, flags=re.DOTALL).replace("</model>", f"{more}</model>")


def test_a_ball_joint_is_a_revolute_one_in_the_plane(imported):
    path, text = imported(open_four_bar(BALL))
    assert "<drake:ball_constraint>: revolute joint ball_constraint between coupler and follower" in text
    machine, place = load_mechanism(path), circle_intersection((0.1, 0.0), 0.25, (0.3, 0.0), 0.2)
    assert machine.joint["ball_constraint"].on_parent == pytest.approx(place, abs=1e-15)
    assert machine.joint["ball_constraint"].on_child == pytest.approx(place, abs=1e-15)
    assert experiment(path, "[drives.O]\nspeed = 5.0\n").assembly.mobility == 1


def test_constraints_of_models_in_models_and_of_urdf_are_found(imported):
    inner = re.search("<model.*</model>", open_four_bar(BALL), re.DOTALL)[0]
    path, _ = imported(f'<sdf version="1.9"><model name="outer">{inner}</model></sdf>')
    machine = load_mechanism(path)
    made = machine.joint["ball_constraint"]
    assert (made.parent, made.child) == ("four_bar::coupler", "four_bar::follower")
    path.unlink()
    told = re.sub(r"<(drake:\w+_body_.)>(\w+)</\1>", r'<\1 name="\2"/>', BALL)
    told = re.sub(r"<(drake:\w+_p_..)>([^<]+)</\1>", r'<\1 value="\2"/>', told)
    links = "".join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
        for name in ("coupler", "follower")
    )
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="world"/><child link="{child}"/><axis xyz="0 0 1"/>'
        f'<origin xyz="{x} 0 0"/></joint>'
        for name, child, x in (("P", "coupler", 0.0), ("Q", "follower", 0.05))
    )
    path, _ = imported(f'<robot name="r">{links}{joints}{told}</robot>')
    made = load_mechanism(path).joint["ball_constraint"]
    assert made.on_parent == pytest.approx([0.25, 0.0])
    assert made.on_child == pytest.approx([0.25, 0.0])


# -- entries of the experiment -----------------------------------------------------------------------

SPRING = """<drake:linear_spring_damper><drake:linear_spring_damper_body_A>one</drake:linear_spring_damper_body_A>
<drake:linear_spring_damper_p_AP>0.1 0.02 0</drake:linear_spring_damper_p_AP>
<drake:linear_spring_damper_body_B>world</drake:linear_spring_damper_body_B>
<drake:linear_spring_damper_p_BQ>0.3 0.1 0</drake:linear_spring_damper_p_BQ>
<drake:linear_spring_damper_free_length>0.15</drake:linear_spring_damper_free_length>
<drake:linear_spring_damper_stiffness>200</drake:linear_spring_damper_stiffness>
<drake:linear_spring_damper_damping>3</drake:linear_spring_damper_damping></drake:linear_spring_damper>"""


def test_a_spring_between_links_moves_them_as_drakes_does(imported):
    arm = bar("one", 0.2, "__model__", 0.3) + bar("two", 0.1, "one_tip", 0.4)
    text = model("arm", arm + joint("O", "world", "one") + joint("A", "one_tip", "two"))
    path, said = imported(text.replace("</model>", SPRING + "</model>"))
    run = simulate(experiment(path, written(said) + "gravity = [1.0, -9.0, 0.0]\n"), "compiled")
    from pydrake.multibody.tree import LinearSpringDamper

    def spring(plant):
        ends = plant.GetBodyByName("one"), [0.1, 0.02, 0.0], plant.world_body(), [0.3, 0.1, 0.0]
        plant.AddForceElement(LinearSpringDamper(*ends, 0.15, 200.0, 3.0))

    angles = angles_on_drake(text, "sdf", [1.0, -9.0, 0.0], 0.3, "OA", spring)
    assert min(map(abs, angles)) > 0.05
    assert [run[f"q.{name}"][-1] for name in "OA"] == pytest.approx(angles, abs=1e-8)


MIMICS = {
    "SDFormat": ('<axis><xyz>0 0 1</xyz>{}<mimic joint="{}"><multiplier>-2</multiplier><offset>0.3</offset>'
                 "<reference>0.1</reference></mimic></axis>", 0.5),
    "Drake": ('<axis><xyz>0 0 1</xyz>{}</axis><drake:mimic joint="{}" multiplier="-2" offset="0.3"/>', 0.3),
}  # fmt: skip


@pytest.mark.parametrize(
    "limits", ["", "<limit><lower>0.4</lower><upper>0.6</upper></limit>"], ids=["", "within limits"]
)
@pytest.mark.parametrize("kind", MIMICS)
def test_a_joint_that_mimics_another_is_geared_to_it(imported, kind, limits):
    """Follower = multiplier (leader - reference) + offset, in the coordinates of the file, wherever it is drawn."""
    form, offset = MIMICS[kind]
    arm = bar("one", 0.2, "__model__", 0.3) + bar("two", 0.1, "one_tip", 0.4)
    follows = joint("A", "one_tip", "two").replace("<axis><xyz>0 0 1</xyz></axis>", form.format("", "O"))
    leads = joint("O", "world", "one").replace("</xyz>", f"</xyz>{limits}")
    path, said = imported(model("arm", arm + leads + follows))
    assert ("reference configuration computed" in said) == bool(limits)
    run = simulate(experiment(path, written(said) + "gravity = [1.0, -9.0, 0.0]\n"), "compiled")
    leader = run["one.angle"] - 0.3
    follower = run["two.angle"] - run["one.angle"] - 0.4
    assert np.ptp(leader) > 0.05
    assert np.abs(follower - (-2.0 * leader + offset)).max() < 1e-8


def test_friction_and_damping_of_joints_are_entries_of_the_experiment(imported):
    lost = "<dynamics><damping>0.2</damping><friction>0.1</friction></dynamics>"
    turns, slides = joint("O", "world", "one"), joint("P", "one_tip", "two", "prismatic", "1 0 0")
    arm = bar("one", 0.2, "__model__", 0.3) + bar("two", 0.1, "one_tip", 0.4)
    path, said = imported(model("arm", arm + (turns + slides).replace("</xyz>", f"</xyz>{lost}")))
    found = experiment(path, written(said)).experiment
    assert found.torsion_springs["O_spring"].damping == 0.2
    assert found.torsion_springs["O_spring"].stiffness == 0.0
    assert (found.frictions["O_friction"].constant, found.frictions["O_friction"].viscous) == (0.1, 0.0)
    assert (found.frictions["P_friction"].constant, found.frictions["P_friction"].viscous) == (0.1, 0.2)


def test_a_spring_in_a_slider_is_an_entry_of_the_experiment(imported):
    """A mass on a spring: x = x0 (1 - cos(omega t))."""
    spring = "<spring_stiffness>50</spring_stiffness><spring_reference>0.1</spring_reference><damping>0</damping>"
    slide = joint("P", "world", "one", "prismatic", "1 0 0")
    path, said = imported(
        model(
            "slide",
            bar("one", 0.2, "__model__", mass=0.5) + slide.replace("</xyz>", f"</xyz><dynamics>{spring}</dynamics>"),
        )
    )
    run = simulate(experiment(path, written(said)), "compiled")
    np.testing.assert_allclose(run["one.x"], 0.1 * (1.0 - np.cos(10.0 * run.time)), atol=1e-6)


# -- refused -----------------------------------------------------------------------------------------


def in_model(text):
    return GOOD.replace("</model>", f"{text}</model>")


def in_link(text):
    return GOOD.replace("<inertial>", f"{text}<inertial>", 1)


def in_joint(text):
    return GOOD.replace("</axis>", f"</axis>{text}", 1)


def in_axis(text):
    return GOOD.replace("</axis>", f"{text}</axis>", 1)


ROTOR = "<drake:rotor_inertia>0.01</drake:rotor_inertia>"
REFUSED = {
    "weld of nothing": (in_model(weld("crank_tp", "coupler")), 'its <parent> is "crank_tp"; did you mean "crank_tip"?'),
    "weld without a child": (in_model("<drake:weld_constraint><parent>crank</parent></drake:weld_constraint>"), '<child> is ""'),
    "weld of one link": (in_model(weld("crank", "crank_tip")), "are fixed to one another elsewhere"),
    "weld out of the plane": (
        in_model('<frame name="up" attached_to="crank"><pose>0 0 0 1 0 0</pose></frame>' + weld("up", "coupler")),
        'rotates "coupler" out of the plane of joint "A"',
    ),
    "ball of nothing": (open_four_bar(BALL.replace("coupler<", "world2<")), "<drake:ball_constraint_body_A> is"),
    "ball without a point": (open_four_bar(re.sub("<drake:ball_constraint_p_AP>.*", "", BALL)), "p_AP>: is missing"),
    "ball without a plane": (
        model("m", bar("a", 0.1, "__model__") + joint("P", "world", "a", "prismatic", "1 0 0")
              + BALL.replace("coupler", "a").replace("follower", "world")),
        "without revolute joints",
    ),
    "spring in two planes": (
        in_model(SPRING.replace("one", "crank").replace("0.3 0.1 0", "0.3 0.1 0.2")), "in two planes"
    ),
    "bushing": (in_model("<drake:linear_bushing_rpy/>"), "<drake:linear_bushing_rpy>: is a soft joint"),
    "tendon": (in_model("<drake:tendon_constraint/>"), "is not supported; write a gear"),
    "joint of Drake": (in_model('<drake:joint name="J" type="planar"/>'), "no planar linkage has"),
    "unknown element of Drake": (in_model("<drake:new_constraint/>"), "may change the motion and is not supported"),
    "rotor": (in_joint(ROTOR), "adds the rotor's inertia"),
    "rotor of URDF": (in_model(f"<transmission><actuator>{ROTOR}</actuator></transmission>"), "the rotor's inertia"),
    "soft body": (in_link("<drake:deformable_properties/>"), "may change the motion"),
    "kinematic": (in_link("<kinematic>1</kinematic>"), "<kinematic>: is 1, which is not supported"),
    "in a fluid": (in_link("<velocity_decay><linear>0.1</linear></velocity_decay>"), "<velocity_decay>: is not supp"),
    "in water": (
        GOOD.replace("<mass>", "<fluid_added_mass><xx>1</xx></fluid_added_mass><mass>", 1), "<inertial/fluid_added_mass>"
    ),
    "joint of a world": (
        f'<sdf version="1.9"><world name="w">{re.search("<model.*</model>", GOOD, re.DOTALL)[0]}'
        '<joint name="J" type="fixed"/></world></sdf>',
        "joins models that are not imported",
    ),
    "mimic of nothing": (in_axis('<mimic joint="Z"/>'), 'follows joint "Z"; known are: A, B, Q'),
    "mimic without motion": (in_axis('<mimic joint="A"><multiplier>0</multiplier></mimic>'), "has the multiplier 0"),
    "mimic of a word": (in_axis('<mimic joint="A"><multiplier>x</multiplier></mimic>'), '"x" is not a number'),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_an_element_that_changes_the_motion_is_refused_in_one_line(tmp_path, capsys, case):
    text, reason = REFUSED[case]
    assert text != GOOD
    source, out = tmp_path / "theirs.sdf", tmp_path / "ours.sdf"
    source.write_text(text)
    assert main(["import", str(source), "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("error: theirs.sdf: ")
    assert reason in error
    assert not out.exists()


@pytest.mark.parametrize("text", [
    in_model('<drake:collision_filter_group name="g"/>'), in_link("<gravity>true</gravity>"),
    in_joint("<drake:rotor_inertia>0</drake:rotor_inertia><drake:gear_ratio>5</drake:gear_ratio>"),
    in_link("<velocity_decay><linear>0</linear></velocity_decay>"),
])  # fmt: skip
def test_an_element_without_influence_is_left_out(imported, text):
    path, said = imported(text)
    assert "left out" in said
    assert len(load_mechanism(path).links) == 3
