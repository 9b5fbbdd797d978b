"""``linkages modes``: its files, and one-line messages for bad input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from linkages.cli.main import main
from linkages.input.files.shipped import data_folder
from linkages.three_rrr.branch import follow
from linkages.three_rrr.direct import assemblies, count
from linkages.three_rrr.robot import changed, load_robot


def test_modes_command_writes_what_it_promises(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    status = main(
        ["modes", str(data_folder() / "three_rrr.toml"), "--verify", "--branch", "98", "--no-plots", "--out", str(out)]
    )
    assert status == 0
    found = json.loads((out / "modes.json").read_text())
    angles = [np.rad2deg(a["theta"]) for a in found["assemblies"]]
    np.testing.assert_allclose(angles, [98.05, -87.51], atol=0.005)
    assert found["locked_frequencies"][0] == pytest.approx(133.56, abs=0.005)
    assert len(found["locked_frequencies"]) == len(found["ranges"]) == 21
    assert np.all(np.abs(found["free_frequencies"][:3]) < 1e-3)
    assert found["free_frequencies"][3] > 100.0
    low, high = found["ranges"][0]
    assert low <= found["locked_frequencies"][0] <= high
    check = found["verify"]
    assert check["zero_modes"] == 3
    assert max(check["principal_angle"], check["mass_error"]) <= 1e-10
    printed = capsys.readouterr().out
    assert "133.56" in printed
    assert "zero_modes" in printed
    assert "against Drake's rigid plant: passed" in printed
    assert sorted(p.name for p in out.iterdir()) == ["animation.html", "modes.json", "record.json"]


def test_a_failed_comparison_with_drake_ends_with_status_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drake's plant has another density than the finite elements: the mass matrices differ by 0.1 %."""
    from linkages.three_rrr import verify as verification

    heavy = verification.RigidPlant
    monkeypatch.setattr(
        verification, "RigidPlant", lambda robot: heavy(changed(robot, material={"density": 1.001 * 7850.0}))
    )
    arguments = ["modes", "three_rrr.toml", "--verify", "--no-plots", "--no-animation", "--out", str(tmp_path / "out")]
    assert main(arguments) == 1
    shown = capsys.readouterr()
    assert "against Drake's rigid plant: FAILED" in shown.out
    lines = shown.err.splitlines()
    assert any(
        line.startswith("the comparison with Drake fails: mass_error is 0.000999; it must be at most") for line in lines
    )
    assert any("torque is" in line for line in lines)
    assert json.loads((tmp_path / "out" / "modes.json").read_text())["verify"]["failed"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("density        = 7850.0", "density        = 0.0", "material.density: is 0.0; it should be greater than 0"),
        ("density        = 7850.0", "densty         = 7850.0", 'unknown key; did you mean "density"?'),
        ("coupler_diameter   = 0.04", "coupler_diameter   = -0.04", "sections.coupler_diameter: is -0.04"),
        ("elements = 1 ", "elements = 0 ", "model.elements: is 0; it should be greater than or equal to 1"),
        ("phi0   = [60.0, 0.0, 220.0]", "phi0   = [60.0, 0.0]", "drives.phi0"),
        ('roots  = "locked"', 'roots  = "servo"', "drives: give servo_stiffness [N m/rad]"),
        ("phidot = [0.6, 0.5, 0.66]", "ramp = 1.0", "drives: give phi0 and phidot, or times with angles"),
        (
            "phidot = [0.6, 0.5, 0.66]",
            "times = [0.0, 1.0]\nangles = [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]]",
            "drives: angles prescribe the whole motion; remove phi0, phidot and ramp",
        ),
        (
            "phi0   = [60.0, 0.0, 220.0]       # deg, section 4\nphidot = [0.6, 0.5, 0.66]",
            "times = [0.0, 1.0]\nangles = [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]]",
            "drives.times: end at 1 s; they must reach the duration, 12.5664 s",
        ),
        ("[damping]", "[load]\nat = [0.1]\n[damping]", "load.at"),
        ('mechanism = "three_rrr.sdf"', 'mechanism = "none.sdf"', "none.sdf: cannot be read"),
        ("[drives]", "[drives", "is not valid TOML"),
    ],
)
def test_bad_robots_get_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    check_refused(tmp_path, capsys, {"three_rrr.toml": (old, new)}, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'attached_to="crank2"><pose>0.112',
            'attached_to="crank2"><pose>0.0',
            "crank2: has the length 0 m; it must be positive",
        ),
        ('name="B2"', 'name="Q2"', '<joint name="B2">: is missing; did you mean'),
        ("<parent>crank3_B</parent>", "<parent>world</parent>", '<joint name="B3">: is a revolute joint of world'),
    ],
)
def test_bad_mechanisms_get_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    check_refused(tmp_path, capsys, {"three_rrr.sdf": (old, new)}, message)


def check_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: dict[str, tuple[str, str]], message: str
) -> None:
    run = edited(tmp_path, changes)
    assert run == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def edited(tmp_path: Path, changes: dict[str, tuple[str, str]]) -> int:
    for name in ("three_rrr.sdf", "three_rrr.toml"):
        text = (data_folder() / name).read_text()
        old, new = changes.get(name, ("", ""))
        assert old in text
        (tmp_path / name).write_text(text.replace(old, new, 1) if old else text)
    return main(
        ["modes", str(tmp_path / "three_rrr.toml"), "--no-plots", "--no-animation", "--out", str(tmp_path / "out")]
    )


def test_no_assembly_and_wrong_branch_are_failures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert edited(tmp_path, {"three_rrr.toml": ("branch    = 98.05", "branch    = 10.0")}) == 1
    error = capsys.readouterr().err
    assert "no-assembly: no assembly starts near theta = 10 deg; there are 98.05, -87.51 deg" in error
    assert error.count("\n") == 1
    far = (
        'attached_to="world"><pose relative_to="__model__">0.3 ',
        'attached_to="world"><pose relative_to="__model__">3.0 ',
    )
    assert edited(tmp_path, {"three_rrr.sdf": far}) == 1
    assert "no assembly at the crank angles 60, 0, 220 deg" in capsys.readouterr().err


@pytest.mark.slow
def test_a_crossed_fold_ends_the_analysis_with_a_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = load_robot(data_folder() / "three_rrr.toml")
    times = np.linspace(0.0, robot.duration, 2001)
    number = count(robot.geometry, robot.cranks(times)[0])
    phi0 = np.rad2deg(robot.cranks(times)[0][np.flatnonzero(number == 4)[0] + 5])
    found = assemblies(robot.geometry, np.deg2rad(phi0))
    kept = [assemblies(robot.geometry, robot.phi0).x]
    for x in found.x:
        branch = follow(robot.geometry, changed(robot, drives={"phi0": phi0.tolist()}).cranks, x, robot.duration)
        if branch.status.value == "singular":
            kept.append(x)
    text = (data_folder() / "three_rrr.toml").read_text()
    text = text.replace("[60.0, 0.0, 220.0]", str(phi0.tolist())).replace("98.05 ", f"{np.rad2deg(kept[1][0])} ")
    (tmp_path / "three_rrr.sdf").write_text((data_folder() / "three_rrr.sdf").read_text())
    (tmp_path / "fold.toml").write_text(text)
    assert (
        main(["modes", str(tmp_path / "fold.toml"), "--no-plots", "--no-animation", "--out", str(tmp_path / "out")])
        == 1
    )
    assert "ends at a fold" in capsys.readouterr().err
    result = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert result["status"] == "singular"
    assert result["singularities"][-1]["type"] == 2
    assert result["duration"] < result["singularities"][-1]["time"] < robot.duration
    assert result["ranges"][0][0] > 1.0  # the last moments, where stiffness vanishes, are left out
    assert max(result["elastic_displacement"].values()) < 1e-3


@pytest.mark.slow
def test_vibration_is_an_option(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Started on the quasi-static solution the robot scarcely vibrates; from rest it vibrates."""
    text = (data_folder() / "three_rrr.toml").read_text().replace("duration  = 12.566370614359172", "duration  = 0.5")
    (tmp_path / "three_rrr.sdf").write_text((data_folder() / "three_rrr.sdf").read_text())
    (tmp_path / "short.toml").write_text(text)
    found = {}
    for start in ("quasi-static", "rest"):
        out = tmp_path / start
        options = ["--no-plots", "--no-animation", "--dynamic", start, "--out", str(out)]
        assert main(["modes", str(tmp_path / "short.toml"), *options]) == 0
        assert "with vibration: elastic platform displacement" in capsys.readouterr().out
        found[start] = json.loads((out / "modes.json").read_text())
    static = found["rest"]
    for name in ("elastic_displacement", "stress"):
        for key, value in static[name].items():
            assert found["quasi-static"]["dynamic"][name][key] == pytest.approx(value, rel=0.03)
            assert found["rest"]["dynamic"][name][key] > 1.3 * value
    assert static["dynamic"]["stress"]["platform"] > 100.0


@pytest.mark.slow
def test_command_repeats_itself(tmp_path: Path) -> None:
    """A short motion, twice: the same bytes of modes.json. `test_figures` draws every figure of the paper."""
    text = (data_folder() / "three_rrr.toml").read_text().replace("duration  = 12.566370614359172", "duration  = 1.5")
    (tmp_path / "three_rrr.sdf").write_text((data_folder() / "three_rrr.sdf").read_text())
    (tmp_path / "short.toml").write_text(text)
    first, second = tmp_path / "first", tmp_path / "second"
    words = ["modes", str(tmp_path / "short.toml"), "--no-plots", "--out"]
    assert main([*words, str(first)]) == 0
    assert main([*words, str(second), "--no-animation"]) == 0
    assert (first / "modes.json").read_bytes() == (second / "modes.json").read_bytes()
    assert (first / "animation.html").exists()


@pytest.mark.parametrize("option", ["--count", "--cycle"])
def test_options_of_linkages_are_refused_whatever_their_value(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["modes", "three_rrr", option, "0"]) == 2
    assert capsys.readouterr().err == f"error: {option}: three_rrr: is only for linkages; remove it\n"
