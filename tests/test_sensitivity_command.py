"""``linkages sensitivity``: files, differences, warnings, bad input."""

import json

import linkages
from linkages.cli.main import main
from linkages.input.model.experiment import value_unit

_RUN = ("sensitivity", "slider_crank_lubricated.toml", "--duration", "0.002", "--output", "slider.ax", "--quiet")


def test_the_command_writes_derivatives_that_agree_with_differences(tmp_path):
    paths = ("joints.B.clearance", "drives.O.speed", "gravity.y")
    assert main([*_RUN, "--wrt", *paths, "--check", "--set", "solver.accuracy=1e-9", "--out", str(tmp_path)]) == 0
    found = json.loads((tmp_path / "sensitivity.json").read_text())
    details = json.loads((tmp_path / "details.json").read_text())
    assert set(found) == set(paths)
    assert set(found["gravity.y"]) == {"slider.ax.peak", "slider.ax.mean", "slider.ax.rms", "O.work"}
    for path in ("joints.B.clearance", "drives.O.speed"):
        rate, error = found[path]["slider.ax.peak"], details["errors"][path]["slider.ax.peak"]
        assert abs(rate - details["differences"][path]["slider.ax.peak"]) < 1e-3 * abs(rate)
        assert error < 1e-3 * abs(rate)
    for path, value in details["values"].items():
        for key, number in details["numbers"].items():
            least = 1e-11 * abs(number) / (abs(value) or 10.0)  # gravity of 10 m/s2
            assert details["errors"][path][key] >= least * (1.0 - 1e-12)
    assert (tmp_path / "tornado.png").exists()


def test_a_value_of_zero_is_checked_with_a_step_of_its_unit(tmp_path):
    """The journal's start in the middle: a step of a part of 1 m would leave the clearance of 0.5 mm."""
    path = "joints.B.offset.0"
    options = ("--check", "--set", "joints.B.offset=[0.0, 0.0]", "--set", "solver.accuracy=1e-9", "--no-plots")
    assert main([*_RUN, "--wrt", path, *options, "--out", str(tmp_path)]) == 0
    rate = json.loads((tmp_path / "sensitivity.json").read_text())[path]["slider.ax.peak"]
    difference = json.loads((tmp_path / "details.json").read_text())["differences"][path]["slider.ax.peak"]
    assert abs(rate - difference) < 1e-3 * abs(rate)
    assert value_unit(path) == "m"


def test_the_command_uses_the_accuracy_that_derivatives_need_and_says_so(tmp_path, capsys):
    """The press at the default accuracy; the values come from runs with the accuracy 1e-12."""
    values = ["joints.A.clearance", "sdf.links.link6.mass"]
    command = ["sensitivity", "seven_bar.toml", "--duration", "0.1", "--output", "slider7.ax", "--no-error-estimate"]
    assert main([*command, "--wrt", *values, "--no-plots", "--out", str(tmp_path)]) == 0
    assert "solver.accuracy is 1e-09" in capsys.readouterr().out
    found = json.loads((tmp_path / "sensitivity.json").read_text())
    overrides = {"duration": 0.1, "solver.accuracy": 1e-12}
    system = linkages.load(linkages.find_file("seven_bar.toml"), overrides)
    right = linkages.sensitivities(system, values, ["slider7.ax"], error_estimate=False).derivatives
    for path in values:
        for key, rate in right[path].items():
            assert abs(found[path][key] - rate) < 0.01 * abs(rate), (path, key)


def test_bad_input_gives_one_line_and_writes_nothing(tmp_path, capsys):
    for path in ("joints.X.clearance", "joints.B.film"):
        assert main([*_RUN, "--wrt", path, "--out", str(tmp_path / "new")]) == 2
        assert path in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "new").exists()
