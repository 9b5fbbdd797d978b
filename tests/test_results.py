"""Trajectories, extremes, and the command line's files."""

import json
import math
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from machines import LUBRICATED, four_bar
from scipy.interpolate import Akima1DInterpolator

import linkages
from linkages import InputError, RunError, Status, Trajectory, extremes, integral, load_trajectory
from linkages.cli.main import main
from linkages.input.files.writing import json_text
from linkages.results.akima import interpolated
from linkages.results.extremes import peaks
from linkages.results.impacts import read_impacts
from linkages.results.trajectory import sample


def wave(times):
    return {"time": times, "y": np.sin(7.0 * times) * np.exp(-0.3 * times), "z": np.cos(times)}


def test_dense_output_stays_within_the_run():
    """A cubic continues beyond its steps to any value; so times outside are refused, and rounding is none."""
    run = sample(np.linspace(0.0, 5.0, 19), wave, Status.OK, {})
    part = run.within(1.0, 2.0)
    for one, low, high in ((run, 0.0, 5.0), (part, 1.0, 2.0), (replace(run, units={"y": "m"}), 0.0, 5.0)):
        times = np.array([high, low, 0.5 * (low + high), high * (1.0 + 1e-15)])  # in any order
        np.testing.assert_allclose(one.evaluate(times)["y"], wave(times)["y"], rtol=1e-13)
        for beyond in (low - 1e-6, high + 1e-6, 1e9):
            with pytest.raises(
                InputError, match=re.escape(f"times: have {beyond:g} s, outside the run from {low:g} to {high:g} s")
            ):
                one.evaluate(np.array([low, beyond]))
    for times in (0.5, [[0.5]], [np.nan], [0.5j], ["0.5"]):
        with pytest.raises(InputError, match=r"^argument: times: "):
            run.evaluate(times)
    np.testing.assert_array_equal(run.evaluate(np.array([0.5], np.float32))["y"], wave(np.array([0.5]))["y"])
    np.testing.assert_array_equal(run.evaluate([1])["y"], wave(np.array([1.0]))["y"])


def test_a_part_of_a_run_has_limits_within_it_in_order(tmp_path):
    run = sample(np.linspace(0.0, 5.0, 19), wave, Status.OK, {})
    run.save(tmp_path / "run.npz")
    for one in (run, load_trajectory(tmp_path / "run.npz")):
        part = one.within(0.0, 4.0)
        assert part.time[[0, -1]].tolist() == [0.0, 4.0]
        for start, end in ((-0.1, 1.0), (1.0, 5.1), (6.0, 7.0)):
            with pytest.raises(InputError, match=r"start and end: have .* s, outside the run from 0 to 5 s"):
                one.within(start, end)
        for start, end in ((2.0, 1.0), (1.0, 1.0)):
            with pytest.raises(InputError, match=f"end: is {end:g} s, not after the start of {start:g} s"):
                one.within(start, end)
        with pytest.raises(InputError, match="start: is nan"):
            one.within(float("nan"), 1.0)


def test_extremes_are_those_of_continuous_time_not_of_the_samples():
    run = sample(np.linspace(0.0, 5.0, 19), wave, Status.OK, {})
    found = extremes(run, ["y", "z"])
    top = np.arctan(7.0 / 0.3) / 7.0  # zero of the derivative
    assert np.abs(run["y"]).max() < 0.95 * wave(np.array([top]))["y"][0]
    resolution = (2 * 5.0 / 18 / 54) ** 4 * 7.0**4 / 24  # error of the last parabola from the fourth derivative
    assert resolution < 5e-6
    assert found["y"].max == pytest.approx(wave(np.array([top]))["y"][0], rel=resolution)
    assert found["y"].time == pytest.approx(top, abs=1e-5)
    bottom = (np.arctan(7.0 / 0.3) + np.pi) / 7.0
    assert found["y"].min == pytest.approx(wave(np.array([bottom]))["y"][0], rel=resolution)
    assert (found["z"].max, found["z"].peak) == (1.0, 1.0)  # at the start, not inside


def test_extremes_of_a_loaded_trajectory_come_from_parabolas():
    times = np.linspace(0.0, 5.0, 401)
    run = Trajectory(times, wave(times), Status.OK)
    exact = extremes(sample(times, wave, Status.OK, {}), ["y"])["y"]
    assert extremes(run, ["y"])["y"].max == pytest.approx(exact.max, rel=1e-5)  # fourth order in the sampling


def test_peaks_are_the_larger_extremes_found_with_fewer_evaluations():
    asked = []

    def counted(times):
        asked.append(len(times))
        return wave(times) | {"w": np.abs(np.sin(times - 0.3)) - 0.2}

    run = sample(np.linspace(0.0, 5.0, 61), counted, Status.OK, {})
    counts = []
    for search in (extremes, peaks):
        asked.clear()
        found = search(run, ["y", "z", "w"])
        counts.append(sum(asked))
        if search is extremes:
            largest = found
    assert counts[1] < 0.7 * counts[0]
    for name, peak in found.items():
        assert peak.value == pytest.approx(largest[name].peak, rel=1e-7)
        assert peak.time == pytest.approx(largest[name].time, abs=1e-4)


def test_of_equal_peaks_the_first_is_told():
    run = sample(np.linspace(0.0, 20.0, 173), lambda t: {"time": t, "s": np.sin(t)}, Status.OK, {})
    assert extremes(run, ["s"])["s"].time == pytest.approx(np.pi / 2.0, abs=1e-4)


def test_a_maximum_between_coarse_samples_is_not_lost_to_a_lower_one_that_is_sampled():
    """Its samples are lower by more than a hundredth of the column's range; their parabola is not."""

    def humps(t):
        tops = 1.0 - ((t - 0.2) / 0.1) ** 2, 1.04 - ((t - 0.725) / 0.1) ** 2
        return {"time": t, "s": np.maximum(0.0, np.maximum(*tops))}

    run = sample(np.linspace(0.15, 0.8, 14), humps, Status.OK, {})
    low, high = (run["s"][np.abs(run.time - at).argmin()] for at in (0.2, 0.725))
    assert low > high + 0.02
    assert extremes(run, ["s"])["s"].max == pytest.approx(1.04, abs=1e-6)


def test_a_maximum_at_a_kink_is_found():
    run = sample(np.linspace(0.0, 1.0, 12), lambda t: {"time": t, "s": -np.abs(t - 0.4321)}, Status.OK, {})
    assert abs(extremes(run, ["s"])["s"].max) < 1e-3


def test_a_kink_between_samples_is_not_lost_to_a_rival():
    """As when a contact turns from compression to restitution between two steps: parabolas promise far too little."""

    def spikes(times):
        first = 7066.6 - 5e12 * np.abs(times - 1e-5) ** 1.5
        second = 7087.0 - np.maximum(3.3e7 * (2.1e-5 - times), 1.0e8 * (times - 2.1e-5))
        return {"time": times, "s": np.maximum(np.maximum(first, second), 0.0)}

    times = np.array([0.0, 9e-6, 1.0e-5, 1.3e-5, 1.35e-5, 1.89e-5, 2.43e-5, 3e-5, 1e-4])
    found = peaks(sample(times, spikes, Status.OK, {}), ["s"])["s"]
    assert found.value == pytest.approx(7087.0, abs=2.0)


def test_integral_of_few_samples():
    """Two samples are a straight line; one is no time."""
    two = sample(np.array([1.0, 1.5]), wave, Status.OK, {})
    assert integral(two, np.array([2.0, 4.0])) == 1.5
    assert integral(sample(np.array([1.0]), wave, Status.OK, {}), np.array([2.0])) == 0.0


def test_integral_is_of_third_order_at_least():
    errors = []
    for n in (41, 81):
        run = sample(np.linspace(0.0, 2.0, n) ** 1.5, wave, Status.OK, {})
        errors.append(abs(integral(run, run["z"]) - np.sin(run.time[-1])))
    assert np.log2(errors[0] / errors[1]) > 3.0


def test_save_and_load(tmp_path):
    run = sample(np.linspace(0, 1, 11), wave, Status.SINGULAR, {"engine": "drake"})
    run.save(tmp_path / "t.npz")
    again = load_trajectory(tmp_path / "t.npz")
    assert again.status is Status.SINGULAR
    assert again.provenance == {"engine": "drake"}
    for name, column in run.columns.items():
        np.testing.assert_array_equal(again[name], column)
    assert [p.name for p in tmp_path.iterdir()] == ["t.npz"]


@pytest.mark.parametrize("content", [b"", b"nonsense", b"PK\x03\x04broken"])
def test_a_broken_trajectory_is_refused(tmp_path, content):
    path = tmp_path / "t.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"t\.npz: is not a trajectory"):
        load_trajectory(path)


def damaged_archives(path):
    """A trajectory's file, spoilt as disks and other programs spoil files."""
    whole, arrays = path.read_bytes(), dict(np.load(path))
    header = json.loads(str(arrays["header"]))

    def written(**changed):
        np.savez_compressed(path, **(arrays | {name: np.array(value) for name, value in changed.items()}))
        return path.read_bytes()

    start = whole.index(b"PK\x01\x02")  # of the directory
    yield "encrypted", whole[: start + 8] + b"\x01" + whole[start + 9 :]
    yield "compressed by other means", whole[: start + 10] + b"\x63" + whole[start + 11 :]
    middle = whole.index(b"PK\x03\x04", 4) - 20
    yield "a bit", whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    yield "no table", written(header="[]")
    yield "deep", written(header="[" * 100_000)
    yield "units", written(header=json.dumps(header | {"units": {"z": 1}}))
    yield "provenance", written(header=json.dumps(header | {"provenance": "x"}))
    yield "shorter", written(z=[1.0])
    yield "text", written(z=["x"] * 11)
    yield "table", written(time=np.zeros((11, 1)))
    yield "backwards", written(time=np.linspace(1, 0, 11))
    yield "no number", written(time=[0.0] * 10 + [math.nan])
    yield "empty", written(time=[], z=[])


def test_a_damaged_trajectory_is_refused(tmp_path):
    path = tmp_path / "t.npz"
    sample(np.linspace(0, 1, 11), wave, Status.OK, {}).save(path)
    for name, content in damaged_archives(path):
        path.write_bytes(content)
        print(name)
        with pytest.raises(InputError, match=r"t\.npz: is not a trajectory"):
            load_trajectory(path)


TOML = "duration = 0.2\n" + LUBRICATED


def test_simulate_writes_all_files_and_a_complete_summary(experiment_file, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["simulate", str(experiment_file(four_bar(), TOML)), "--out", str(out), "--exaggerate", "5"]) == 0
    names = {path.name for path in out.iterdir()}
    assert names == {
        "summary.json", "trajectory.npz", "ideal.npz", "animation.html", "output_follower.omega.png", "orbits.png",
        "drawing.svg", "joint_forces.png", "drive_torques.png",
    }  # fmt: skip
    summary = json.loads((out / "summary.json").read_text())
    a = summary["joints"]["A"]
    assert summary["status"] == "ok"
    assert a["model"] == "lubricated"
    assert a["force"]["peak"] == pytest.approx(summary["ideal"]["joints"]["A"]["force"]["peak"], rel=0.1)
    assert 0.0 < a["eccentricity_ratio"]["peak"] < 1.0
    assert summary["joints"]["Q"]["model"] == "ideal"
    assert summary["error"]["A.force.peak"] < 1e-3 * a["force"]["peak"]
    assert summary["mechanism"]["mobility"] == 1
    assert load_trajectory(out / "trajectory.npz")["A.force"].max() == pytest.approx(a["force"]["peak"], rel=1e-3)
    text = capsys.readouterr().out
    assert "follower.omega [rad/s]" in text
    page = (out / "animation.html").read_text()
    assert "<script" in page
    assert 'src="http' not in page


def test_a_run_leaves_nothing_of_another_run_in_its_folder(experiment_file, tmp_path, capsys):
    """It does not report unwritten files, and keeps the user's files."""
    out = tmp_path / "out"
    out.mkdir()
    for name in ("animation.html", "impacts.csv", "output_crank.x.png", "report.html", "summary.json", "mine.txt"):
        (out / name).write_text("of old")
    words = ["simulate", str(experiment_file(four_bar(), TOML)), "--engine", "compiled", "--out", str(out)]
    assert main([*words, "--no-plots", "--no-animation"]) == 0
    assert {path.name for path in out.iterdir()} == {"summary.json", "trajectory.npz", "ideal.npz", "mine.txt"}
    assert (out / "summary.json").read_text() != "of old"
    said = " ".join(capsys.readouterr().out.split())
    assert said.endswith(f"written to {out}/: ideal.npz, summary.json, trajectory.npz")


@pytest.mark.slow
def test_the_same_input_gives_the_same_summary(experiment_file, tmp_path):
    path = experiment_file(four_bar(), TOML)
    texts = []
    for name in ("a", "b"):
        assert main(["simulate", str(path), "--out", str(tmp_path / name), "--no-plots", "--no-animation"]) == 0
        summary = json.loads((tmp_path / name / "summary.json").read_text())
        del summary["provenance"]["wall_time"]
        texts.append(json.dumps(summary))
    assert texts[0] == texts[1]


BAD = {
    "no such file": (None, []),
    "unknown key": (TOML.replace("viscosity", "viscocity"), []),
    "unknown override": (TOML, ["--set", "joints.A.clearence=1"]),
    "override without value": (TOML, ["--set", "duration"]),
    "negative duration": (TOML, ["--duration", "-1"]),
    "too many drives": (TOML + "[drives.Q]\nspeed = 1.0\n", []),
    "exaggeration too large": (TOML, ["--exaggerate", "1e6", "--no-plots", "--no-error-estimate"]),
    "exaggeration negative": (TOML, ["--exaggerate", "-1"]),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_exits_with_2_one_line_and_nothing_written(experiment_file, tmp_path, capsys, case):
    text, options = BAD[case]
    path = experiment_file(four_bar(), text) if text else tmp_path / "none.toml"
    out = tmp_path / "out"
    assert main(["simulate", str(path), "--out", str(out), *options]) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith("error: ")
    assert "\n" not in error
    assert not out.exists() or not list(out.iterdir())


def test_a_failed_run_exits_with_1_and_keeps_its_results(experiment_file, tmp_path, capsys):
    out = tmp_path / "out"
    weak = TOML.replace("viscosity = 0.1", "viscosity = 1e-9")
    assert main(["simulate", str(experiment_file(four_bar(), weak)), "--out", str(out), "--no-animation"]) == 1
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "journal-left-bearing"
    assert 0.0 < summary["duration"] < 0.2
    assert summary["error"] == {}
    assert "raise the viscosity" in capsys.readouterr().err


def test_no_assembly_exits_with_1(experiment_file, tmp_path, capsys):
    path = experiment_file(four_bar(crank=0.2, coupler=0.15), TOML.replace("speed", "angle = 3.0\nspeed"))
    assert main(["simulate", str(path), "--out", str(tmp_path / "out")]) == 1
    assert "no-assembly" in capsys.readouterr().err


@pytest.mark.processes
@pytest.mark.slow
@pytest.mark.parametrize(
    ("ctrl_c", "number", "status"),
    [
        (signal.default_int_handler, signal.SIGINT, 130), (signal.default_int_handler, signal.SIGTERM, 143),
        (signal.SIG_IGN, signal.SIGTERM, 143),
    ],
    ids=["ctrl-c", "terminated", "terminated in the background"],
)  # fmt: skip
def test_an_interrupted_run_is_written_and_its_exit_status_names_the_signal(
    ctrl_c, number, status, experiment_file, tmp_path, monkeypatch, request
):
    from linkages.cli import progress

    def bar(name, total, unit):
        def stop(time):
            if time > 0.5 * total:
                signal.raise_signal(number)

        return stop

    monkeypatch.setattr(progress, "progress_bar", bar)
    before = signal.signal(signal.SIGINT, ctrl_c)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, before))
    out = tmp_path / "out"
    assert (
        main(
            [
                "simulate",
                str(experiment_file(four_bar(), TOML)),
                "--out",
                str(out),
                "--no-animation",
                "--engine",
                "drake",
            ]
        )
        == status
    )
    assert signal.getsignal(signal.SIGINT) is ctrl_c
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "interrupted"
    assert 0.1 < summary["duration"] < 0.2


def test_importing_the_package_loads_no_engine():
    code = "import sys, linkages; print([m for m in ('pydrake', 'numba', 'matplotlib', 'scipy', 'pint') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.drake
def test_run_sevenbar_script_runs_from_anywhere(tmp_path):
    script = Path(__file__).resolve().parents[1] / "run_sevenbar.py"
    command = [sys.executable, script, "--duration", "0.05", "--no-plots", "--no-animation", "--no-error-estimate"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "slider7.ax [" in done.stdout
    assert (tmp_path / "results" / "seven_bar" / "summary.json").exists()


def test_a_run_ends_before_the_first_number_that_is_not_finite():
    def evaluate(times):
        return {"time": times, "x": np.where(times < 0.35, times, np.inf)}

    run = sample(np.linspace(0.0, 1.0, 11), evaluate, Status.OK, {})
    assert run.status is Status.NOT_FINITE
    assert run.time[-1] == run["x"][-1] == pytest.approx(0.3)
    with pytest.raises(RunError, match="not-finite at the start"):
        sample(np.linspace(0.5, 1.0, 6), evaluate, Status.OK, {})


def test_json_has_null_where_a_number_does_not_exist():
    assert json_text({"a": [1.0, float("nan")], "b": (float("inf"), "nan", None)}) == (
        '{"a": [1.0, null], "b": [null, "nan", null]}\n'
    )


def test_akimas_cubics_are_those_of_scipy():
    """With constant parts, where both weights vanish, and at both ends; straight lines, and two samples, are met."""
    dice = np.random.default_rng(0)
    times = np.cumsum(0.1 + dice.random(40))
    samples = np.column_stack([dice.standard_normal(40), np.repeat(np.arange(8.0), 5), np.sin(times), times])
    at = np.linspace(times[0], times[-1], 1001)
    expected = Akima1DInterpolator(times, samples, method="makima")(at)
    assert interpolated(times, samples, at) == pytest.approx(expected, abs=1e-12)
    assert interpolated(times[:2], samples[:2], times[:2]) == pytest.approx(samples[:2])


def test_a_line_of_impacts_with_more_cells_than_columns_is_no_table(tmp_path):
    """The reader of tables gives the other cells as a list."""
    (tmp_path / "impacts.csv").write_text("joint,start\nB,1.0,2.0\n")
    with pytest.raises((ValueError, TypeError)):
        read_impacts(tmp_path)


@pytest.mark.parametrize(("former", "present"), [("study", "assess"), ("Study", "Assessment")])
def test_a_former_name_works_with_a_line_of_notice(former, present, capsys, monkeypatch):
    monkeypatch.delitem(vars(linkages), former, raising=False)
    for _ in range(2):
        assert getattr(linkages, former) is getattr(linkages, present)
    assert capsys.readouterr().err == f"notice: linkages.{former} is now linkages.{present}\n"
