"""A run with the worn joints of a wear.json."""

import json

import numpy as np
import pytest
from shipped import shipped

import linkages
from linkages.cli.main import main

DEPTHS = (1e-5 * (1.0 + np.cos(2.0 * np.pi * np.arange(360) / 360))).tolist()
WORDS = ["--duration", "0.01", "--no-plots", "--no-animation", "--no-error-estimate", "-q"]


def written(folder, joint="B", **parts):
    """Write a wear.json with profiles of a joint."""
    angles = 2.0 * np.pi * np.arange(360) / 360
    numbers = dict.fromkeys(("volume", "depth", "play", "clearance", "load_distance"), 1e-6) | {"coefficient": 1e-14}
    worn = numbers | {side: {"profile": np.column_stack([angles, depths]).tolist()} for side, depths in parts.items()}
    content = {"cycles": 10, "status": "ok", "title": None, "experiment": "x.toml", "simulated_cycles": 3,
               "tolerance": 1e-7, "joints": {joint: worn}}  # fmt: skip
    content["blocks"] = [{"cycles": 0, "error": 0.0, "peaks": {}, "joints": {joint: worn}}]
    path = folder / "wear.json"
    path.write_text(json.dumps(content))
    return str(path)


def test_a_run_with_a_worn_file_equals_the_run_with_its_profiles(tmp_path):
    """The profile also goes to a machine whose file has no wear."""
    out = tmp_path / "out"
    words = ["slider_crank_dry", "--worn", written(tmp_path, bearing=DEPTHS), "--out", str(out), *WORDS]
    assert main(["simulate", *words]) == 0
    wear = {"coefficient": 1e-14, "bearing_depth": DEPTHS, "nodes": 360}
    system = shipped("slider_crank_dry", **{"duration": 0.01, "joints.B.wear": wear})
    wanted, found = linkages.simulate(system), linkages.load_trajectory(out / "trajectory.npz")
    np.testing.assert_array_equal(found["B.force"], wanted["B.force"])
    assert not np.array_equal(found["slider.x"][-1], linkages.simulate(shipped("slider_crank_dry"))["slider.x"][-1])


@pytest.mark.parametrize(
    ("machine", "joint", "said"), [("slider_crank_dry", "Z", "joints.Z"), ("seven_bar", "A", "wear needs a contact")]
)
def test_a_joint_that_cannot_wear_is_refused_in_one_line(tmp_path, capsys, machine, joint, said):
    assert main(["simulate", machine, "--worn", written(tmp_path, joint, bearing=DEPTHS), *WORDS]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_another_file_is_refused(tmp_path, capsys):
    path = tmp_path / "wear.json"
    path.write_text("{}")
    assert main(["simulate", "slider_crank_dry", "--worn", str(path), *WORDS]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def worn_joint(folder, text='worn = "wear.json"', joint="B"):
    """Write an experiment whose joint B has these lines."""
    source = linkages.find_file("slider_crank_dry.toml")
    lines = source.read_text(encoding="utf-8").splitlines()
    lines.insert(lines.index(f"[joints.{joint}]") + 1, text)
    (folder / "mine.toml").write_text("\n".join(lines))
    (folder / "slider_crank.sdf").write_text(linkages.find_file("slider_crank.sdf").read_text())
    return folder / "mine.toml"


def test_the_key_worn_gives_the_profiles_of_the_file(tmp_path):
    written(tmp_path, bearing=DEPTHS, journal=DEPTHS[::-1])
    system = linkages.load(worn_joint(tmp_path), {"duration": 0.004})
    wear = {"coefficient": 1e-14, "side": "bearing", "bearing_depth": DEPTHS, "journal_depth": DEPTHS[::-1]}
    other = shipped("slider_crank_dry", **{"duration": 0.004, "joints.B.wear": wear})
    assert system.experiment.joints["B"].is_worn
    assert system.experiment.joints["B"].wear == other.experiment.joints["B"].wear
    np.testing.assert_array_equal(linkages.simulate(system)["B.force"], linkages.simulate(other)["B.force"])
    given = system.experiment.model_dump(exclude_unset=True)["joints"]["B"]
    assert given["worn"] == "wear.json"
    assert "wear" not in given  # the record of a run has no thousand depths
    changed = system.replaced({"joints.B.clearance": 2e-4})
    assert changed.experiment.joints["B"].wear == other.experiment.joints["B"].wear


def test_what_the_experiment_gives_of_wear_remains(tmp_path):
    written(tmp_path, bearing=DEPTHS)
    system = linkages.load(worn_joint(tmp_path, 'worn = "wear.json"\nwear = { coefficient = 3e-15 }'))
    assert system.experiment.joints["B"].wear.coefficient == 3e-15
    assert system.experiment.joints["B"].wear.bearing_depth == DEPTHS


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('worn = "none.json"', "none.json cannot be read"),
        ('worn = "other.json"', "has no joint B; it has Z"),
        ('worn = "list.json"', "is not a JSON object"),
        ('worn = "wear.json"\nwear = { coefficient = 1e-15, nodes = 360 }', "the file of worn gives it"),
    ],
)
def test_a_wrong_key_worn_is_refused_in_one_line(tmp_path, capsys, text, said):
    written(tmp_path, "Z", bearing=DEPTHS)
    (tmp_path / "wear.json").rename(tmp_path / "other.json")
    written(tmp_path, bearing=DEPTHS)
    (tmp_path / "list.json").write_text("[]")
    assert main(["simulate", str(worn_joint(tmp_path, text)), *WORDS]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("error: mine.toml: joints: B.w")
    assert said in error
