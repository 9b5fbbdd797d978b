"""Joints and links that are edited on the page, and pins that are moved: values like any others, with right numbers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import linkages
from linkages.mechanics.planar.kinematics import poses_at
from linkages.show.live.pins import Places
from linkages.show.plots.drawing import draw

CHANGED = (
    "drives.O1.speed",
    "sdf.links.link2.mass",
    "sdf.frames.crank1_A.pose.x",
    "sdf.frames.link6_D.pose.x",
    "joints.B.viscosity",
)


def ask(of, kind, **request):
    """Return a reply that is no error."""
    reply = of.answer(kind, request)
    assert "error" not in reply, reply
    return reply


def random_change(of, seed):
    """Edit a random joint of the press, and change up to two of its numbers by up to 10 %."""
    rng, system = np.random.default_rng(seed), of.session.system
    joint = rng.choice(ask(of, "start")["parts"]["joints"])
    values = {}
    for path in map(str, rng.choice(CHANGED, 2, replace=False)):
        values[path] = system.value(path) * rng.uniform(0.9, 1.1)
    model = joint["models"][seed % len(joint["models"])]
    return ask(of, "edit", values=values, part="joint", name=joint["name"], model=model)["values"]


@pytest.mark.parametrize("seed", [pytest.param(k, marks=() if k % 8 == 1 else pytest.mark.slow) for k in range(30)])
def test_a_random_change_gives_the_numbers_of_simulate(answers, steady_numbers, tmp_path, seed):
    """Joints made lubricated, dry or mixed on the page: the saved file gives the table in every digit."""
    of = answers("seven_bar")
    values = random_change(of, seed)
    for _ in range(3):  # tight joints settle after many more
        ask(of, "run", values=values)
    table = {row["name"]: row["value"] for row in ask(of, "numbers")["table"]}
    ask(of, "save", values=values, name="changed")
    ours = steady_numbers(tmp_path / "changed.toml")
    assert len(ours) > 5
    assert {key: table[key] for key in ours} == ours


def test_values_are_proposed_from_the_size_of_the_bearing(answers):
    """A joint that the file has ideal, and whose machine has no bearing there: clearance 0.001 of the diameter."""
    of = answers("seven_bar")
    reply = ask(of, "edit", values={}, part="joint", name="C2", model="mixed")
    values, controls = reply["values"], {one["path"]: one for one in reply["controls"]}
    radius = values["sdf.joints.C2.bearing.radius"]
    assert radius == of.session.system.mechanism.joint["A"].bearing.radius  # as the others
    assert values["joints.C2.clearance"] == pytest.approx(0.001 * 2.0 * radius)
    assert (values["joints.C2.oil.grade"], values["joints.C2.contact.youngs_modulus"]) == (46, 2.1e11)
    assert set(values) <= {*controls, "joints.C2.mixed.law"}
    assert all(controls[path]["value"] is None for path in controls.keys() & values.keys())  # the file has none of them
    assert controls["joints.C2.clearance"]["first"]


@pytest.mark.parametrize(("name", "add", "joint"), [("seven_bar", "groove", "A"), ("slider_crank_dry", "wear", "B")])
def test_a_groove_and_wear_are_added(answers, name, add, joint):
    of = answers(name)
    values = ask(of, "edit", values={}, name=joint, add=add)["values"]
    ask(of, "run", values={})
    before = ask(of, "run", values={})["curves"]
    assert ask(of, "run", values=values)["curves"] != before
    assert of.session.system.replaced(values).experiment.joints[joint].model_dump()[add]


@pytest.mark.slow  # the kernels of flexible links
def test_a_link_made_flexible_gives_the_numbers_of_simulate(answers, settled, steady_numbers, tmp_path):
    """The file has no section: a steel bar of the link's mass is proposed. A mass that was typed before is dropped."""
    of = answers("slider_crank_lubricated")
    values = ask(of, "edit", values={"sdf.links.rod.mass": 0.4}, part="link", name="rod", model="flexible")["values"]
    assert "sdf.links.rod.mass" not in values
    assert of.session.system.replaced(values).mechanism.link["rod"].mass == pytest.approx(0.4, rel=1e-3)
    table = {row["name"]: row["value"] for row in settled(of, values)["table"]}
    ask(of, "save", values=values, name="changed")
    ours = steady_numbers(tmp_path / "changed.toml")
    assert {key: table[key] for key in ours} == ours


def test_what_the_file_says_stays(answers):
    of = answers("seven_bar")
    values = ask(of, "edit", values={"joints.A.clearance": 2e-4}, part="joint", name="A", model="mixed")["values"]
    assert values["joints.A.clearance"] == 2e-4
    assert not [path for path in values if path.startswith(("joints.A.oil", "joints.A.viscosity", "sdf."))]


def test_a_link_of_an_edited_machine_brings_its_controls(answers):
    of = answers("seven_bar")
    values = ask(of, "edit", values={}, part="joint", name="O1", model="dry")["values"]
    paths = {control["path"] for control in ask(of, "start", values=values)["controls"]}
    assert set(values) <= paths
    assert "joints.O1.clearance" not in {control["path"] for control in ask(of, "start")["controls"]}


@pytest.mark.parametrize(
    ("request_", "named"),
    [
        ({"part": "joint", "name": "E", "model": "dry"}, "E"),
        ({"part": "joint", "name": "A", "model": "magnetic"}, "magnetic"),
        ({"part": "joint", "name": "guide", "model": "lubricated"}, "lubricated"),
        ({"part": "link", "name": "slider7", "model": "flexible"}, "two ends"),
        ({"part": "wheel", "name": "A", "model": "dry"}, "wheel"),
        ({"part": "joint", "name": 3, "model": "dry"}, "name"),
    ],
)
def test_a_wrong_edit_is_refused_in_one_line(answers, request_, named):
    reply = answers("seven_bar").answer("edit", {"values": {}, **request_})
    assert named in reply["error"]
    assert "\n" not in reply["error"]


@pytest.mark.parametrize(
    "path", ["joints.A.worn", "joints.A", "joints.E.clearance", "drives.O1.file", "mechanism", "sdf.joints.C2.pose.w"]
)
def test_only_values_of_parts_can_be_added(answers, path):
    reply = answers("seven_bar").answer("run", {"values": {path: "/etc/passwd"}})
    assert "is not a value that can be changed" in reply["error"]


def place(system, name):
    """Where the pin of a joint is at t = 0."""
    pin, pose = system.mechanism.pin[name], poses_at(system.tree.bodies, system.assembly.q)
    body, x, y = system.tree.marker(pin.link, pin.origin)
    cosine, sine = np.cos(pose[body, 2]), np.sin(pose[body, 2])
    return pose[body, :2] + [cosine * x - sine * y, sine * x + cosine * y]


@pytest.mark.parametrize("name", ["C2", "O4", "D"])
def test_a_pin_moves_to_its_place_and_no_other_pin_moves(name):
    """The assembled linkage, with the new lengths, has the pin there; the drives' angles and other pins stay."""
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    tree, pose = system.tree, poses_at(system.tree.bodies, system.assembly.q)
    reference = poses_at(tree.bodies, np.zeros(tree.size))
    turned = {link: pose[tree.index[link], 2] - reference[tree.index[link], 2] for link in system.mechanism.link}
    angles = {link: turn + system.mechanism.link[link].angle for link, turn in turned.items()}
    crank = place(system, "B") - place(system, "O4")  # its direction is the drive's
    way = {"D": np.array([0.03, 0.0]), "O4": 0.25 * crank}.get(name, np.array([0.02, -0.015]))
    other = system.replaced(Places(system).shifted(name, way, angles))
    beside = {"C2": {"C3"}}.get(name, set()) | {name}
    for joint in ("O1", "A", "C2", "C3", "O4", "B", "D"):
        expected = place(system, joint) + (way if joint in beside else 0.0)
        assert_allclose(place(other, joint), expected, rtol=0, atol=2e-5)


def test_a_pin_follows_the_mouse_in_the_shown_pose(answers):
    of = answers("slider_crank_dry")
    ask(of, "run", values={})
    picture = ask(of, "picture", values={})
    body, x, y = picture["joints"]["A"]
    px, py, angle = picture["poses"][40][int(body)]
    here = np.array([px + np.cos(angle) * x - np.sin(angle) * y, py + np.sin(angle) * x + np.cos(angle) * y])
    way = 0.01 * here / np.hypot(*here)  # along the crank, whose pivot is the origin
    values = ask(of, "move", values={}, joint="A", to=(here + way).tolist(), phase=40 / 120)["values"]
    system = of.session.system
    assert values["sdf.frames.crank_A.pose.x"] == pytest.approx(
        system.value("sdf.frames.crank_A.pose.x") + 0.01, abs=3e-6
    )
    assert set(values) == {"sdf.frames.crank_A.pose.x", "sdf.frames.rod_B.pose.x"}
    assert draw(system.replaced(values)).problem == ""


def test_a_pin_of_a_link_with_a_beam_moves_in_the_plane(answers):
    """Values that would turn the beam out of the plane are no lengths."""
    of = answers("slider_crank_flexible")
    system = of.session.system
    values = Places(system).shifted("B", np.array([0.01, 0.0]), {})
    assert values == {
        "sdf.frames.rod_B.pose.x": pytest.approx(system.value("sdf.frames.rod_B.pose.x") + 0.01, abs=1e-6)
    }


@pytest.mark.parametrize(("to", "phase"), [([1.0], 0.0), ([1.0, "x"], 0.0), ([0.0, 1.0], 2.0), (None, 0.0)])
def test_a_wrong_place_is_refused(answers, to, phase):
    of = answers("slider_crank_dry")
    ask(of, "run", values={})
    assert "must be a place" in of.answer("move", {"values": {}, "joint": "A", "to": to, "phase": phase})["error"]


def test_a_pin_that_is_not_free_says_so(answers):
    """The slider's pin cannot leave the guide's line: no length has this effect."""
    of = answers("seven_bar")
    ask(of, "run", values={})
    picture = ask(of, "picture", values={})
    body, x, y = picture["joints"]["D"]
    px, py, angle = picture["poses"][0][int(body)]
    above = [px + np.cos(angle) * x - np.sin(angle) * y, py + np.sin(angle) * x + np.cos(angle) * y + 0.02]
    assert "cannot move" in of.answer("move", {"values": {}, "joint": "D", "to": above, "phase": 0.0})["error"]
    assert "is no joint" in of.answer("move", {"values": {}, "joint": "Z", "to": above, "phase": 0.0})["error"]
