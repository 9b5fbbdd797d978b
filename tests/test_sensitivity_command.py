"""``linkages sensitivity``: files, differences, warnings, bad input."""

import json

import pytest

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
    assert (tmp_path / "matrix.png").exists()


def test_the_peaks_are_those_of_the_reported_part_with_their_times(tmp_path, capsys):
    """The film's start-up at 0.24 ms has a peak of 6289 N; the reported part none above 2800 N."""
    command = ["slider_crank_lubricated.toml", "--no-plots", "--no-error-estimate"]
    more = ["--wrt", "joints.B.viscosity", "--output", "B.force"]
    run = linkages.simulate(linkages.load(linkages.find_file(command[0])))
    for setting, window in (("report_from=0.006", (0.006, 0.024)), ('report="whole"', (0.0, 0.024)), (None, None)):
        out = tmp_path / str(setting)
        settings = ["--set", setting] if setting else []
        assert main(["sensitivity", *command, *more, *settings, "--out", str(out)]) == 0
        text, details = capsys.readouterr().out, json.loads((out / "details.json").read_text())
        if window is None:  # as the tables of the run
            assert main(["simulate", *command, "--no-animation", "--quiet", "--out", str(out / "run")]) == 0
            summary = json.loads((out / "run" / "summary.json").read_text())
            part = summary["windows"][summary["report"]]
            window = part["from"], part["to"]
            assert details["numbers"]["B.force.peak"] == pytest.approx(part["joints"]["B"]["force"]["peak"], rel=1e-5)
        peak = linkages.extremes(run.within(*window), ["B.force"])["B.force"]
        assert details["window"] == pytest.approx(window)
        assert details["numbers"]["B.force.peak"] == pytest.approx(peak.peak, rel=1e-5)
        assert details["times"]["B.force.peak"] == pytest.approx(peak.time, rel=1e-3)
        assert f"of the run from {window[0]:.6g} to {window[1]:.6g} s" in text
        assert f" at {details['times']['B.force.peak']:.6g} s" in text


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
