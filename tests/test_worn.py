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
