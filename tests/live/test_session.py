"""The machine behind the live page: values, steady motion, and the same numbers as `linkages simulate`."""

import json
from pathlib import Path

import numpy as np
import pytest
from shipped import FAST_PRESS

import linkages
from linkages import InputError
from linkages.cli.main import main
from linkages.cli.options import path_and_range
from linkages.show.live.answers import Answers
from linkages.show.live.controls import controls
from linkages.show.live.session import Session, checked
from linkages.show.plots.drawing import draw


def loaded(name, **overrides):
    return linkages.load(linkages.find_file(f"{name}.toml"), overrides)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("seven_bar", {"joints.A.clearance": 2e-4, "sdf.links.link2.mass": 0.3}),
        ("slider_crank_dry", {"joints.B.clearance": "0.3 mm", "drives.O.speed": 300.0}),
        ("slider_crank_main_bearing", {"joints.O.clearance": "0.04 mm", "drives.O.speed": 400.0}),
        pytest.param("slider_crank_flexible", {"drives.O.speed": 120.0}, marks=pytest.mark.slow),
    ],
)
def test_a_saved_file_gives_the_numbers_of_the_page(answers, settled, steady_numbers, tmp_path, name, values):
    """The page's table and `linkages simulate` of the saved file agree in every digit."""
    of = answers(name)
    reply = settled(of, values)
    saved = of.answer("save", {"values": values, "name": "changed"})
    assert saved["written"] == str(tmp_path / "changed.toml")
    ours = steady_numbers(tmp_path / "changed.toml")
    table = {row["name"]: row["value"] for row in reply["table"]}
    assert len(ours) > 5
    assert {key: table[key] for key in ours} == ours
    assert "live page" in (tmp_path / "changed.toml").read_text()


def test_the_steady_motion_is_the_end_of_a_long_run(answers, settled):
    """Several short runs, each from the end of the previous one, give the motion of one run of ten periods."""
    reply = settled(answers("seven_bar"), {})
    long = linkages.simulate(loaded("seven_bar", duration=20.0), "compiled")
    last = long.within(18.0, 20.0)
    for orbit in reply["orbits"]:
        name, path = orbit["name"], np.array(orbit["path"])
        theirs = np.column_stack([last[f"{name}.ex"], last[f"{name}.ey"]]) / orbit["clearance"]
        size = np.ptp(theirs, axis=0).max()
        apart = np.linalg.norm(path.T[:, None] - theirs[None], axis=2).min(axis=1)
        assert apart.max() < 0.05 * size  # the page calls an orbit steady that closes to 2 % of its size


def test_a_small_change_settles_in_few_runs(answers, settled):
    of = answers("slider_crank_lubricated")
    settled(of, {})
    again = of.answer("run", {"values": {"joints.B.viscosity": 0.11}})
    assert again["settled"]
    assert again["periodic"]


def test_a_motion_that_does_not_repeat_is_shown_with_the_spread_of_its_peaks(answers):
    of = answers("slider_crank_dry")
    reply = of.answer("run", {"values": {}})
    assert not reply["periodic"]
    row = next(row for row in of.answer("numbers", {})["table"] if row["name"] == "B.force")
    assert 0.0 < row["least"] < row["most"]
    assert row["most"] == pytest.approx(row["value"], rel=0.05)  # of samples against the peak over continuous time
    assert reply["to"] - reply["from"] == pytest.approx(
        2 * 2 * np.pi / loaded("slider_crank_dry").value("drives.O.speed")
    )


def test_poses_follow_the_machine(answers):
    """The picture's bodies are where the run has them: the slider's pin moves as far as the slider."""
    of = answers(FAST_PRESS.with_suffix(""))
    reply, system = of.answer("run", {"values": {}}), of.session.system
    assert "poses" not in reply  # a machine that is not drawn yet is drawn by the next request
    picture = of.answer("picture", {"values": {}})
    assert picture["picture"] == reply["picture"]
    drawing = draw(system)
    body = next(body for body, link in drawing.links_of.items() if link == "slider7")
    moved = np.array(picture["poses"])[:, body, 0]
    curve = next(curve for curve in reply["curves"] if curve["name"] == "slider7.x")["run"]
    place = np.interp(reply["time"], curve["time"], curve["values"])
    offset = drawing.reference[body, 0] - system.mechanism.link["slider7"].origin[0]
    np.testing.assert_allclose(moved - offset, place, rtol=0, atol=2e-4)  # curves are drawn with 160 parts of the time


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"sdf.frames.link2_C.pose.x": 3.0}, "loops do not close"),
        ({"joints.A.clearance": -1.0}, "joints.A.clearance"),
        ({"joints.A.clearance": "1 kg"}, "joints.A.clearance"),
        ({"mechanism": "/etc/passwd"}, "mechanism"),
        ({"joints.A.clearance": [1, 2]}, "joints.A.clearance"),
        ([], "values"),
    ],
)
def test_bad_values_are_named_in_one_line_and_change_nothing(answers, values, named):
    of = answers("seven_bar")
    of.answer("run", {"values": {}, "restart": True})
    before = of.answer("numbers", {})
    reply = of.answer("run", {"values": values})
    assert named in reply["error"]
    assert "\n" not in reply["error"]
    of.answer("run", {"values": {}, "restart": True})
    assert of.answer("numbers", {}) == before


def test_a_run_that_ends_early_says_why(answers):
    reply = answers("seven_bar").answer("run", {"values": {"joints.A.viscosity": 1e-6}})
    assert reply["status"] != "ok"
    assert reply["remedy"]
    assert reply["curves"]


def test_a_run_that_takes_too_long_is_given_up(answers):
    reply = answers("slider_crank_dry", limit=1e-9).answer("run", {"values": {"duration": 1.0}})
    assert "given up" in reply["error"]


@pytest.mark.parametrize("name", ["../escape", "a/b", "", ".hidden", "x" * 200, None, "na<me"])
def test_files_are_written_into_the_folder_alone(answers, tmp_path, name):
    reply = answers("seven_bar").answer("save", {"values": {}, "name": name})
    assert "is no name of a file here" in reply["error"]
    assert not list(tmp_path.iterdir())


def test_a_file_is_replaced_only_if_asked(answers, tmp_path):
    of = answers("seven_bar")
    of.answer("run", {"values": {}})
    assert "written" in of.answer("save", {"values": {}, "name": "mine"})
    before = (tmp_path / "mine.toml").read_bytes()
    assert "exists" in of.answer("save", {"values": {"joints.A.viscosity": 0.5}, "name": "mine"})["error"]
    assert (tmp_path / "mine.toml").read_bytes() == before
    assert "written" in of.answer("save", {"values": {"joints.A.viscosity": 0.5}, "name": "mine.toml", "replace": True})
    assert linkages.load(tmp_path / "mine.toml").value("joints.A.viscosity") == 0.5


def test_an_interrupted_save_leaves_the_file_as_it_was(answers, tmp_path, monkeypatch):
    of = answers("seven_bar")
    of.answer("save", {"values": {}, "name": "mine"})
    before, write = (tmp_path / "mine.toml").read_bytes(), Path.write_text

    def half(path, text, **options):
        write(path, text[: len(text) // 2], **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_text", half)
    for name, replace in (("mine", True), ("other", False)):
        with pytest.raises(KeyboardInterrupt):
            of.answer("save", {"values": {"joints.A.viscosity": 0.5}, "name": name, "replace": replace})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"mine.toml": before}


def test_pages_have_their_own_runs(answers):
    """The table, the warnings and the start of the next run are those of the page that asks."""
    of, alone = answers("seven_bar"), answers("seven_bar")
    one, other = ({"page": k, "values": {"joints.A.clearance": c}} for k, c in (("one", 1e-4), ("other", 6e-4)))
    for request in (one, other, one):
        of.answer("run", request)
    for request in (one, one):
        alone.answer("run", request)
    of.answer("run", other)
    assert of.answer("numbers", {"page": "one"}) == alone.answer("numbers", {"page": "one"})
    assert of.answer("numbers", {"page": "one"}) != of.answer("numbers", {"page": "other"})
    assert "no run yet" in of.answer("numbers", {"page": "third"})["error"]


def test_a_folder_is_made_for_the_first_file(tmp_path):
    system = loaded("seven_bar")
    of = Answers(Session(system), controls(system), tmp_path / "new" / "folder")
    assert not list(tmp_path.iterdir())
    assert "written" in of.answer("save", {"values": {}, "name": "mine"})
    assert (tmp_path / "new" / "folder" / "mine.toml").is_file()


def test_values_of_the_command_line_are_saved(answers, tmp_path):
    of = answers("seven_bar", **{"joints.B.viscosity": 0.7})
    of.answer("run", {"values": {}})
    of.answer("save", {"values": {}, "name": "mine"})
    assert linkages.load(tmp_path / "mine.toml").value("joints.B.viscosity") == 0.7


@pytest.mark.slow
def test_an_export_is_the_folder_of_simulate(answers, settled, tmp_path):
    of = answers("slider_crank_lubricated")
    settled(of, {})
    reply = of.answer("export", {"values": {}, "name": "mine"})
    assert reply["written"] == str(tmp_path / "mine")
    summary = json.loads((tmp_path / "mine" / "summary.json").read_text())
    assert summary["status"] == "ok"
    assert (tmp_path / "mine" / "animation.html").stat().st_size > 1000


def test_ranges_contain_the_values_and_first_controls_are_those_of_the_machine():
    for name in ("seven_bar", "slider_crank_dry", "slider_crank_flexible", "three_rrr_clearance", "slider_crank_guide"):
        found = controls(loaded(name))
        numbers = [control for control in found.values() if not control.choices]
        assert len(numbers) > 30
        assert all(control.low <= control.value <= control.high for control in numbers)
        assert all(control.low * control.high > 0.0 for control in numbers if control.logarithmic)
        drives = [control for control in numbers if control.path.endswith(".speed") and control.first]
        assert all(
            sorted([control.low / control.value, control.high / control.value]) == pytest.approx([0.2, 5.0])
            for control in drives
        )
        assert any(control.path.endswith(".clearance") and control.first for control in numbers)


def test_a_wear_coefficient_has_a_range_of_decades():
    """It is a number of 1e-15 m2/N, no share from 0 to 1."""
    control = controls(loaded("slider_crank_wear"))["joints.B.wear.coefficient"]
    assert control.logarithmic
    assert control.high == pytest.approx(10.0 * control.value)


def test_sliders_begin_at_values_that_the_experiment_accepts():
    """No duration, exponent or number of nodes below zero, except for quantities with a sign."""
    for name in ("seven_bar_mixed", "slider_crank_flexible", "slider_crank_wear"):
        system = loaded(name)
        for control in controls(system).values():
            if not control.choices and not control.path.startswith("sdf."):
                system.experiment.replaced({control.path: control.low})


def test_parameters_of_a_description_have_units_and_ranges_of_their_kind(tmp_path):
    (tmp_path / "text.toml").write_text(
        """duration = 1.0
        section = ["8 mm", "6 mm"]
        density = 7850.0
        drives = { O = { speed = "60 r/min" } }
        parameters = { m = "500 g", r = "60 mm", turn = "30 deg", plain = 0.28 }
        links = { ground = "O Q", crank = "O A", coupler = { points = "A B", mass = "m" }, rocker = "B Q" }
        points = { O = [0, 0], Q = ["300 mm", 0], A = ["O", "r", "turn"], B = ["A", "plain", "Q", "240 mm"] }"""
    )
    assert main(["new", "four", "--from", str(tmp_path / "text.toml"), "--out", str(tmp_path)]) == 0
    found = controls(linkages.load(tmp_path / "four.toml"))
    of = {name: found[f"sdf.parameters.{name}"] for name in ("m", "r", "turn", "plain")}
    assert {name: control.unit for name, control in of.items()} == {"m": "kg", "r": "m", "turn": "rad", "plain": ""}
    assert all(0.0 < of[name].low < of[name].value < of[name].high for name in ("m", "r", "plain"))
    assert of["turn"].low < 0.0 < of["turn"].high


def test_given_ranges_come_first():
    system = loaded("seven_bar")
    path, low, high = path_and_range("sdf.links.link2.mass=100 g:0.4", system)
    assert (path, low, high) == ("sdf.links.link2.mass", 0.1, 0.4)
    found = controls(system, {path: (low, high)})
    assert next(iter(found)) == path
    assert [control.path for control in found.values() if control.first] == [path]
    with pytest.raises(InputError, match="is not the path of a number"):
        controls(system, {"joints.A.clearanc": (0.0, 1.0)})


@pytest.mark.parametrize(
    "text",
    [
        "joints.A.clearance",
        "a=1",
        "a=2:1",
        "a=x:y",
        "=1:2",
        "a=1:inf",
        "joints.A.clearance=1kg:2kg",
        "drives.O1.speed=1 m/s:2 m/s",
    ],
)
def test_wrong_ranges_are_refused(text):
    with pytest.raises(InputError, match="--vary"):
        path_and_range(text, loaded("seven_bar"))


def test_every_control_can_be_changed():
    """Each number can be set to its own value again, so that a slider never names a path that the model refuses."""
    for name in ("seven_bar", "slider_crank_flexible"):
        system = loaded(name)
        known = controls(system)
        for control in known.values():
            system.replaced(checked({control.path: control.value}, known))


def test_a_controller_in_python_has_no_controls_of_another_kind(own_registries):
    linkages.laws.register_controller("held", lambda t, gain: gain)
    keys = {"kind": "python", "function": "held", "parameters": {"gain": 1.0}, "sample_time": 0.01}
    found = [path for path in controls(loaded("slider_crank_dry", **{"controllers.C": keys})) if path.startswith("con")]
    assert found == ["controllers.C.parameters.gain", "controllers.C.sample_time"]


def test_additional_states_settle_within_the_whole_experiment(answers):
    """df/dt = (1 - f)/tau: they cannot be carried from run to run as the journals are."""
    state = {"states.f": {"rate": "(1 - f)/0.02"}, "outputs": ["f.value"], "duration": 0.2}
    shown = answers("slider_crank_lubricated", **state).answer("run", {"values": {}})
    assert shown["settled"]
    assert shown["to"] == pytest.approx(0.2)
