"""Both engines on one experiment: differences, and the horizon up to which they mean anything."""

import itertools
import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from reference_machines import parallelogram_sdf
from shipped import shipped

from linkages import Status, compare
from linkages.cli.main import main
from linkages.explore.compare import differences
from linkages.results.divergence import PARTED, horizon
from linkages.results.trajectory import sample

TIMES = np.linspace(0.0, 1.0, 5001)


def synthetic(**functions):
    """A run whose columns are the given functions of time; `_` in a name stands for a dot."""

    def evaluate(times):
        return {"time": times} | {name.replace("_", "."): f(times) for name, f in functions.items()}

    return sample(TIMES, evaluate, Status.OK, {})


@pytest.fixture(scope="module")
def dry():
    return shipped("slider_crank_dry", duration=8e-4, **{"solver.accuracy": 1e-10})


def test_the_largest_difference_is_found_and_nothing_beyond_the_horizon_counts():
    run = synthetic(a=lambda t: 3.0 * np.sin(np.pi * t), b=np.zeros_like)
    other = synthetic(a=lambda t: 3.0 * np.sin(np.pi * t) + 0.01 * t + 100.0 * (t > 0.6), b=np.zeros_like)
    found = differences(run, other, ["a", "b"], 0.6)
    assert found["a"].max_difference == pytest.approx(0.006)
    assert found["a"].time == pytest.approx(0.6)
    assert found["a"].relative == pytest.approx(0.006 / 3.005, rel=1e-3)
    assert found["b"].max_difference == found["b"].relative == 0.0


def test_horizon_of_two_solutions_that_part_exponentially(dry):
    clearance, rate = dry.value("joints.B.clearance"), 30.0
    run = synthetic(B_ex=np.zeros_like, B_ey=np.zeros_like)
    other = synthetic(B_ex=np.zeros_like, B_ey=lambda t: 1e-9 * clearance * np.exp(rate * t))
    expected = np.log(PARTED / 1e-9) / rate
    assert horizon(run, other, dry) == pytest.approx(expected, abs=TIMES[1])
    assert horizon(run, run, dry) == TIMES[-1]


def test_the_horizon_is_found_with_few_evaluations_of_the_run_between_its_steps(dry):
    """Drake takes a millisecond for each; here they are needed from a tenth of the limit on, 0.077 s of 1 s."""
    clearance, rate, times, told = dry.value("joints.B.clearance"), 30.0, [], []
    run = synthetic(B_ex=np.zeros_like, B_ey=lambda t: times.extend(t) or np.zeros_like(t))
    other = synthetic(B_ex=np.zeros_like, B_ey=lambda t: 1e-9 * clearance * np.exp(rate * t))
    times.clear()
    until = horizon(run, other, dry, told.append)
    assert until == pytest.approx(np.log(PARTED / 1e-9) / rate, abs=TIMES[1])
    assert len(times) < 0.15 * len(TIMES)
    assert told == sorted(told)
    assert max(told) <= until


@pytest.mark.slow
def test_the_engines_agree_where_the_motion_is_smooth():
    result = compare(shipped("slider_crank_lubricated", duration=2e-4, **{"solver.accuracy": 1e-10}))
    assert not result.parted
    assert {"slider.ax", "B.force", "B.eccentricity_ratio", "O.torque"} <= result.differences.keys()
    assert max(row.relative for row in result.differences.values()) < 1e-8
    assert all(row.peak > 0.0 for row in result.differences.values())


def test_the_engines_agree_through_the_first_two_impacts(dry):
    stages = []
    result = compare(dry, lambda name: stages.append(name) or (lambda time: None))
    assert stages == [
        *(f"{engine}{what}" for engine in ("compiled", "drake") for what in ("", ", looser", ", horizon")),
        "differences",
    ]
    assert len(result.contacts) == 2
    for ours, other in result.contacts:
        for field in ("start", "approach_speed", "tangential_speed", "duration", "peak_force"):
            assert getattr(ours, field) == pytest.approx(getattr(other, field), rel=1e-5)


def test_command_says_the_horizon_and_keeps_to_it(tmp_path, capsys):
    arguments = ["--duration", "2e-3", "--accuracy", "1e-6", "--out", str(tmp_path)]
    assert main(["compare", "slider_crank_dry.toml", *arguments]) == 0
    printed = capsys.readouterr().out
    assert "horizon: " in printed
    rows = json.loads((tmp_path / "compare.json").read_text())
    assert rows.keys() == {
        "slider.x", "slider.vx", "slider.ax", "B.force", "B.eccentricity_ratio", "O.torque",
    }  # fmt: skip
    assert all(row.keys() == {"max_difference", "relative"} for row in rows.values())
    assert rows["B.eccentricity_ratio"]["max_difference"] < 10.0 * PARTED


def test_engines_are_compared_on_one_machine_where_links_are_flexible():
    """Drake's rigid segments do not stretch: the first microseconds of the slider differ by a third of its peak.

    Both engines run the segments, so they agree. Segments and flexible links agree without stretching.
    """
    values = {"duration": 5e-6, "solver.accuracy": 1e-10}
    result, rigid = (
        compare(shipped("slider_crank_flexible", **values, **{"links.rod.axial": axial})) for axial in (1, 0)
    )
    assert max(row.relative for row in result.differences.values()) < 1e-7
    assert 0.3 < result.segments["slider.ax"].relative < 0.4
    assert rigid.segments["slider.ax"].relative < 1e-4


@pytest.fixture
def ticking(monkeypatch):
    """A clock of comparisons that goes on by a second at each look."""
    looks = itertools.count()
    clock = SimpleNamespace(monotonic=lambda: float(next(looks)))
    monkeypatch.setattr(sys.modules["linkages.explore.compare"], "clock", clock)


def test_a_limit_of_time_ends_the_runs_and_what_they_reached_is_compared(ticking):
    """Drake looks at the clock after each step, hundreds of times; the compiled engine takes one part."""
    dry = shipped("slider_crank_dry", duration=8e-4, **{"solver.accuracy": 1e-10})
    result = compare(dry, limit=400.0)
    assert result.late
    assert not result.parted
    assert 0.0 < result.until < 8e-4
    assert result.runs["drake"].status is Status.TIME_OVER
    assert max(row.relative for row in result.differences.values()) < 1e-5


def test_the_command_says_that_the_limit_ended_it(ticking, tmp_path, capsys):
    arguments = ["--duration", "2e-3", "--accuracy", "1e-9", "--limit", "400", "--out", str(tmp_path)]
    assert main(["compare", "slider_crank_dry.toml", *arguments]) == 0
    assert "the limit of time ended the runs at" in capsys.readouterr().out


def test_a_limit_that_is_too_short_for_two_samples_leaves_some(tmp_path):
    arguments = ["--duration", "1e-3", "--accuracy", "1e-9", "--limit", "1 us", "--out", str(tmp_path)]
    assert main(["compare", "slider_crank_dry.toml", *arguments]) == 0


def test_an_interruption_within_a_run_ends_the_comparison(dry):
    begun = []

    def stage(name):
        def interrupt(time):
            if name == "drake" and time > 1e-4:
                raise KeyboardInterrupt

        begun.append(name)
        return interrupt

    with pytest.raises(KeyboardInterrupt):
        compare(dry, stage)
    assert begun[-1] == "drake"


def test_bad_input_is_refused_in_one_line(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["compare", "slider_crank_dry.toml", "--accuracy", "2", "--out", str(out)]) == 2
    assert main(["compare", "slider_crank_dry.toml", "--limit", "0", "--out", str(out)]) == 2
    assert capsys.readouterr().err.count("\n") == 2
    assert not out.exists()


def test_what_has_no_bound_is_not_compared(experiment_file, tmp_path, capsys):
    """The parallelogram passes a flat position at 0.36 s: near it forces and accelerations are unbounded."""
    outputs = '["follower.angle", "follower.alpha"]'
    path = experiment_file(parallelogram_sdf(), f"duration = 0.5\noutputs = {outputs}\n[drives.O]\nspeed = 6.0\n")
    assert main(["compare", str(path), "--accuracy", "1e-8", "--out", str(tmp_path / "out")]) == 0
    rows = json.loads((tmp_path / "out" / "compare.json").read_text())
    assert rows["O.torque"] == rows["follower.alpha"] == {"max_difference": None, "relative": None}
    assert rows["follower.angle"]["max_difference"] < 1e-5
    assert "singular" in capsys.readouterr().out
