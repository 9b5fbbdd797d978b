"""The magnified joints of the animation."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from browser import find_browser, open_page
from flexible_machines import bent_machine
from machines import PLANES, bar, four_bar, joint, model, solid, written
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from shipped import shipped

from linkages import AssemblyError, IdealMotion, Status, Trajectory, assess, find_file, load
from linkages.engines.drake.plant import visuals
from linkages.show.plots.animation.bounds import bounds
from linkages.show.plots.animation.recording import add_captions, frames, write_recording
from linkages.show.plots.animation.surroundings import Surroundings
from linkages.show.plots.histories import forces_figure
from linkages.show.plots.instants import guide_frames, journal_frames, strongest
from linkages.show.plots.journals import guides_figure
from linkages.show.plots.style import engineering
from linkages.system.rigid_segments import segmented
from linkages.system.spanning import spanning_tree

DRY = """duration = 0.01
[drives.O]
speed = 15.0
[joints.B]
model = "dry"
clearance = 1e-4
contact = {law = "lankarani-nikravesh", restitution = 0.9, youngs_modulus = 2e11}
"""


@pytest.fixture(scope="module")
def dry(tmp_path_factory):
    path = written(tmp_path_factory.mktemp("animation"), four_bar(), DRY)
    return assess(load(path), "drake", error_estimate=False)


AFTER = """
import gc, sys, threading, linkages
from pathlib import Path
from linkages.show.plots.animation.recording import write_recording
gc.disable()
system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.02})
write_recording(linkages.assess(system, "compiled", error_estimate=False), Path(sys.argv[1]))
collecting = threading.Thread(target=gc.collect)
collecting.start()
collecting.join()
print("alive")
"""


@pytest.mark.slow
@pytest.mark.processes
def test_a_recording_leaves_nothing_that_another_thread_could_free(tmp_path):
    """Drake ends the process where a Meshcat is freed by another thread than its own."""
    command = [sys.executable, "-c", AFTER, str(tmp_path / "animation.html")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout == "alive\n", done.stderr


def test_each_frame_shows_the_largest_force_within_it():
    time = np.linspace(0.0, 1.0, 1001)
    force = np.where(np.abs(time - 0.333) < 2e-3, 50.0, 1.0 + time)  # an impact between frames
    force[333] = 60.0
    run = Trajectory(time, {"time": time, "A.force": force}, Status.OK)
    times = np.linspace(0.0, 1.0, 11)
    moments = strongest(run, "A", times)
    assert moments[3] == pytest.approx(0.333)
    assert np.all(np.abs(moments - times) <= 0.05 + 1e-12)  # within half a frame
    fine = np.linspace(0.0, 1.0, 5001)  # frames without any step: their own time
    empty = np.setdiff1d(np.arange(5001), np.arange(0, 5001, 5))
    np.testing.assert_array_equal(strongest(run, "A", fine)[empty], fine[empty])


def test_where_the_ideal_linkage_does_not_close_the_recorded_motion_is_drawn(dry, tmp_path, monkeypatch):
    """A run passes a dead position by its own errors; the linkage cannot be assembled again there."""

    def cannot(*_):
        raise AssemblyError(Status.NO_ASSEMBLY, "the loops do not close")

    times, drawn, _ = frames(dry)
    monkeypatch.setattr(IdealMotion, "states", cannot)
    _, recorded, _ = frames(dry)
    assert len(times) > 100
    np.testing.assert_allclose(recorded, drawn, atol=1e-4)  # rad, between steps of 20 us
    with pytest.raises(ValueError, match="does not close with its clearance exaggerated 5 times"):
        write_recording(dry, tmp_path / "animation.html", 5.0)


def test_a_contact_that_is_shorter_than_a_frame_is_shown(dry):
    times = np.linspace(0.0, dry.run.time[-1], 41)
    shown = journal_frames(dry.system, dry.run, "B", times)
    assert len(dry.contacts) > 2
    assert min(row.duration for row in dry.contacts) < 0.5 * times[1]
    for row in dry.contacts:  # each contact is in the frame that it starts in
        assert shown.touching[int(np.round(row.start / times[1]))]
    assert np.linalg.norm(shown.force, axis=1).max() == pytest.approx(dry.run["B.force"].max())
    # the force of a contact without friction pushes the journal from the wall
    hard = np.linalg.norm(shown.force, axis=1) > 1.0
    outward = np.sum(shown.e * shown.force, axis=1)[hard]
    apart = np.linalg.norm(shown.e, axis=1)[hard] * np.linalg.norm(shown.force, axis=1)[hard]
    np.testing.assert_allclose(outward, -apart, rtol=1e-9)


SLOTTED = """duration = 0.03
[drives.O]
speed = 30.0
[joints.guide]
model = "dry"
clearance = 1e-4
contact = {law = "flores", restitution = 0.3, stiffness = 1e9}
"""


def slotted_rocker() -> str:
    """Crank whose block slides in a rocker: the slot turns."""
    reach, angle = np.hypot(0.15, 0.05), np.arctan2(0.05, 0.15)
    slot = (
        "<linkages:slot><linkages:length>0.03</linkages:length><linkages:height>0.02</linkages:height></linkages:slot>"
    )
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">-0.15 0 0 0 0 0</pose></frame>
{bar("crank", 0.05, "__model__", np.pi / 2)}{bar("rocker", 0.25, "pivot", angle)}
<frame name="place" attached_to="rocker"><pose>{reach} 0 0 0 0 0</pose></frame>
{solid("block", 0.1, 1e-5, at="place")}
{joint("O", "world", "crank")}{joint("Q", "world", "rocker")}{joint("A", "crank_tip", "block")}
{joint("guide", "place", "block", "prismatic", "1 0 0", inner=slot)}"""
    return model("slotted_rocker", body)


def sliding_block(folder):
    return shipped("slider_crank_guide", duration=2e-3)


def turning_slot(folder):
    return load(written(folder, slotted_rocker(), SLOTTED))


def test_a_block_reaches_the_rim_of_its_figure_where_a_corner_touches():
    """The rim is where middle and lift add up to the clearance, as in the definition of a corner's eccentricity ratio."""
    found = assess(shipped("slider_crank_guide", duration=2e-3), "compiled", error_estimate=False)
    whole, ends = guides_figure(found).axes
    lift, middle = np.array(whole.lines[0].get_data())
    ratio = np.max([np.abs(found.run[f"guide.corner{k}.eccentricity_ratio"]) for k in (1, 2, 3, 4)], axis=0)
    _, factor = engineering("m", 5e-5)
    np.testing.assert_allclose((np.abs(middle) + np.abs(lift)) / (factor * 5e-5), ratio, atol=1e-6)
    assert ratio.max() > 1.0
    front, back = (line.get_ydata() for line in ends.lines[:2])
    np.testing.assert_allclose(np.maximum(np.abs(front), np.abs(back)) / (factor * 5e-5), ratio, atol=1e-6)


def test_below_each_force_stands_its_difference_from_the_ideal_one(dry):
    force, difference = forces_figure(dry).axes
    time, drawn = difference.lines[0].get_data()
    (ideal_time, ideal), (run_time, run) = (line.get_data() for line in force.lines)
    scale = {"N": 1.0, "kN": 1e3}
    unit, small = (axis.get_ylabel().rpartition("[")[2].rstrip("]") for axis in (force, difference))
    expected = scale[unit] * (np.interp(time, run_time, run) - np.interp(time, ideal_time, ideal))
    np.testing.assert_allclose(scale[small] * drawn, expected, atol=1e-3 * scale[unit] * np.abs(run).max())


@pytest.mark.slow
@pytest.mark.parametrize("machine", [sliding_block, turning_slot])
def test_a_block_in_its_slot_is_drawn_where_its_corners_are(machine, tmp_path):
    found = assess(machine(tmp_path), "drake", error_estimate=False)
    times = np.linspace(0.0, found.run.time[-1], 61)
    shown, moments = guide_frames(found.system, found.run, "guide", times), strongest(found.run, "guide", times)
    for k, (x, y) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        ratio = np.interp(moments, found.run.time, found.run[f"guide.corner{k + 1}.eccentricity_ratio"])
        # a corner lies as far across as middle and tilt say; between two steps both are interpolated
        np.testing.assert_allclose(y * (shown.offset + x * shown.tilt), ratio, atol=1e-3)
    sides = {1.0: [0, 1], -1.0: [2, 3]}
    pressed = 0
    for side, corners in sides.items():  # where only one wall is touched, it pushes the block away, friction aside
        touches = shown.touching[:, corners].any(axis=1)
        one = touches & ~shown.touching[:, sides[-side]].any(axis=1) & (np.abs(shown.force[:, 1]) > 1.0)
        along, across = shown.force[one].T
        assert np.all(side * across < 0.0)
        assert np.all(np.abs(along) <= 0.06 * np.abs(across))  # friction 0.05, or none
        pressed += np.count_nonzero(one)
    assert pressed > 5


def test_every_frame_has_its_captions(dry, tmp_path):
    write_recording(dry, tmp_path / "animation.html")
    page = (tmp_path / "animation.html").read_text()
    data = json.loads(re.search(r"const data = (\{.*\});", page)[1])
    label, *names, scale = data["labels"]
    assert label["title"] == "B"
    assert scale["title"] == "100 mm"  # of a linkage that is 0.3 m long
    assert [curve["name"] for curve in data["curves"]] == ["B.force", "O.torque"]
    assert max(data["curves"][0]["run"]["values"]) == pytest.approx(dry.run["B.force"].max(), rel=1e-5)
    assert data["end"] == dry.run.time[-1]
    assert {name["title"] for name in names} == {"O", "A", "B", "Q"}  # every joint, at a place of its link
    assert all(name["path"][:3] == ["drake", "visualizer", "four_bar"] and not name["lines"] for name in names)
    assert len(label["lines"]) == len(data["clock"])
    largest = max(float(line.split()[2]) for line in label["lines"])
    assert largest == pytest.approx(dry.run["B.force"].max(), rel=5e-3)  # three digits
    assert data["clock"][-1].startswith("t = 0.0100 s, 800 times slower")


def test_the_camera_sees_the_wheels_of_gears(tmp_path):
    """The wheels have radii of 30 and 60 mm on shafts 90 mm apart, which are all joints and points."""
    gears = load(find_file("gear_rattle.toml"), {"duration": 0.02})
    write_recording(assess(gears, "compiled", error_estimate=False), tmp_path / "animation.html")
    data = json.loads(re.search(r"const data = (\{.*\});", (tmp_path / "animation.html").read_text())[1])
    width, height = data["view"]
    assert 0.18 <= width < 0.4
    assert 0.12 <= height < 0.4


@pytest.mark.parametrize(
    ("shape", "high"),
    [
        ("<cylinder><radius>0.3</radius><length>0.1</length></cylinder>", 0.3),
        ("<sphere><radius>0.2</radius></sphere>", 0.2),
        ("<box><size>0.6 0.8 0.1</size></box>", 0.5),  # as its diagonal turns by a revolution
    ],
)
def test_bounds_are_those_of_the_turning_shape(shape, high):
    """A shape turns about its middle, which is 2 m to the right and 1 m above the origin."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    Parser(plant).AddModelsFromString(TURNING.format(shape), "sdf")
    plant.Finalize()
    root = builder.Build().CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)

    def poses():
        for angle in np.linspace(0.0, 2.0 * np.pi, 721):
            plant.SetPositions(context, [angle])
            yield context

    found = bounds(plant, scene_graph, poses(), np.eye(3)[:, :2])
    np.testing.assert_allclose(found, [[2.0 - high, 1.0 - high], [2.0 + high, 1.0 + high]], atol=1e-4)


TURNING = """<sdf version="1.9"><model name="one"><link name="a"><pose>2 1 0 0 0 0</pose>
<inertial><mass>1</mass></inertial><visual name="v"><geometry>{}</geometry></visual></link>
<joint name="j" type="revolute"><parent>world</parent><child>a</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>"""


def test_captions_cannot_break_the_page():
    text = "</script><b>"
    labels = [{"path": ["joints", "A"], "title": text, "lines": [text]}]
    shown = {"labels": labels, "clock": ["t"], "legend": text, "curves": [], "start": 0.0, "end": 1.0}
    page = add_captions("<html><body>scene</body></html>", shown)
    assert text not in page
    with pytest.raises(ValueError, match="no body"):
        add_captions("nothing", shown)


class Scene:
    """A replacement of Meshcat that records the drawn shapes."""

    def __init__(self):
        self.meshes = {}

    def SetTriangleMesh(self, path, vertices, faces, color):  # noqa: N802 - Drake's name
        self.meshes[path] = (vertices, faces)

    def __getattr__(self, name):
        return lambda *_: None


@pytest.mark.parametrize("plane", PLANES)
def test_paths_lie_where_points_went_and_the_ground_below_its_joints(system_of, plane):
    text = 'duration = 0.5\noutputs = ["coupler.x", "coupler.omega"]\n[drives.O]\nspeed = 15.0\n'
    found = assess(system_of(four_bar(plane=plane), text), "compiled", error_estimate=False)
    scene = Scene()
    Surroundings(found, scene).draw()
    basis, size = found.system.mechanism.basis, found.system.tree.extent
    run = np.column_stack([found.run["coupler.x"], found.run["coupler.y"]])
    vertices, faces = scene.meshes["/ground/paths"]
    at = (basis[:, :2].T @ vertices).T
    away = np.linalg.norm(at[:, None] - run[None, :: 1 + len(run) // 500], axis=2).min(axis=1)
    assert away.max() < 0.02 * size
    assert np.linalg.norm(run[:, None] - at[None], axis=2).min(axis=1).max() < 0.05 * size  # all of it, to a step
    assert faces.max() == vertices.shape[1] - 1
    for pivot in ("O", "Q"):
        hatch = basis[:, :2].T @ (scene.meshes[f"/ground/{pivot}/hatching"][0])
        place = basis[:, :2].T @ found.system.mechanism.joint[pivot].position
        assert np.all(hatch[1] < place[1] - 0.03 * size)
        assert np.abs(hatch[0] - place[0]).max() < 0.1 * size


@pytest.mark.parametrize("plane", PLANES)
def test_a_link_without_visuals_is_drawn_between_its_joints(mechanism_of, plane):
    tree = spanning_tree(mechanism_of(four_bar(plane=plane)))
    wide = 0.02 * tree.extent
    for link, length in (("crank", 0.1), ("coupler", 0.25), ("follower", 0.2)):
        (visual,) = visuals(tree, tree.links[link])
        pose = [float(v) for v in re.search(r"<pose>(.*)</pose>", visual)[1].split()]
        size = [float(v) for v in re.search(r"<size>(.*)</size>", visual)[1].split()]
        np.testing.assert_allclose(pose, [length / 2, 0, 0, 0, 0, 0], atol=1e-12)  # the bars lie along x
        np.testing.assert_allclose(size, [length + wide, wide, wide], rtol=1e-12)


def test_links_that_bend_are_drawn_bent_so_that_it_is_seen(tmp_path):
    """Hinges are turned by the factor times what their beam's sections are, drives are where they are, loops closed."""
    found = assess(bent_machine(tmp_path, "slider_crank"), "compiled", error_estimate=False)
    shown = segmented(found.system)
    times, drawn, factor = frames(found, None, shown)
    assert factor == 10.0  # 1.5 mm of 450 mm
    tree, system = shown.tree, found.system
    recorded = np.column_stack([np.interp(times, found.run.time, found.run[f"q.{n}"]) for n in system.tree.coordinates])
    np.testing.assert_allclose(drawn[:, tree.hinge_dofs], factor * shown.coordinates(recorded)[:, tree.hinge_dofs])
    np.testing.assert_allclose(drawn[:, 0], 150.0 * times, atol=1e-12)
    assert max(np.abs(tree.gaps(q)).max() for q in drawn[::40]) < 1e-9
    write_recording(found, tmp_path / "animation.html")
    assert "Deflections of links are magnified 10 times." in (tmp_path / "animation.html").read_text()


@pytest.mark.skipif(find_browser() is None, reason="no Chromium with its driver")
@pytest.mark.slow
def test_keys_play_and_step_the_animation_and_tab_reaches_its_button_first(dry, tmp_path):
    write_recording(dry, tmp_path / "animation.html")
    look = """
    await decoded(window);
    const [button, slider] = [document.querySelector("#bar button"), document.querySelector("#bar input")];
    const press = (key) => document.body.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
    const told = [button.textContent];
    press(" ");
    told.push(button.textContent);
    slider.value = 10;
    slider.dispatchEvent(new Event("input"));
    await frames(2);
    press("ArrowRight");
    await frames(2);
    told.push(slider.value);
    const reached = [...document.querySelectorAll("a[href], button, input, select, [tabindex]")]
      .find((one) => one.tabIndex >= 0 && one.checkVisibility());
    return {told, first: reached === button, lang: document.documentElement.lang, title: document.title,
      viewport: document.querySelector("meta[name=viewport]") !== null};
    """
    seen = open_page(tmp_path / "animation.html", tmp_path, look, (1280, 900)).seen
    assert seen["told"] == ["pause", "play", "11"]
    assert (seen["first"], seen["lang"], seen["viewport"], seen["title"]) == (True, "en", True, "four_bar")
