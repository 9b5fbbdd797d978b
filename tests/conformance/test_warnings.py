"""Warnings of a summary about unreliable numbers: singular positions, large or unknown errors."""

import json
from dataclasses import replace

import numpy as np
import pytest
from engines import slow_on_drake
from machines import BEARING, bar, joint, model
from reference_machines import parallelogram_sdf
from shipped import shipped

from linkages import Status, assess, ideal, simulate, summarize
from linkages.base.errors import listed
from linkages.cli.main import main
from linkages.results.peak_errors import SAFETY, noise
from linkages.results.soundness import CHANGE_POINT, NEAR, Soundness
from linkages.results.warnings import rough
from linkages.show.report.answer import answer, remarks
from linkages.show.report.terminal import format_summary

#: Drawn at 1 rad and driven at 6 rad/s: flat at pi and 2 pi.
DRIVEN = """duration = {}
outputs = ["follower.angle", "follower.alpha"]
[drives.O]
speed = 6.0
"""
#: A film for the press's L/D of 1.33.
FINITE = {"joints.A.film": "finite", "joints.B.film": "finite"}
FLAT = (np.array([1.0, 2.0]) * np.pi - 1.0) / 6.0


@slow_on_drake
def test_change_points_that_are_passed_are_named_and_no_force_is_given(engine, system_of):
    summary = summarize(assess(system_of(parallelogram_sdf(), DRIVEN.format(1.0)), engine, error_estimate=False))
    (warning,) = summary["warnings"]
    assert warning["kind"] == "singular"
    assert warning["time"] == pytest.approx(FLAT[0], abs=1e-4)
    assert f"{FLAT[1]:.3f}"[:4] in warning["what"]
    assert all(name in warning["what"] for name in ("A", "Q"))
    assert "another branch crosses there" in warning["what"]
    for numbers in (summary, summary["ideal"]):
        assert all(joint["force"] == {"peak": None, "time": None} for joint in numbers["joints"].values())
        assert numbers["drives"]["O"] == {"torque": {"peak": None, "time": None}, "unit": "N m", "work": None}
        assert numbers["outputs"]["follower.alpha"]["peak"] is None
        assert numbers["outputs"]["follower.angle"]["min"] == pytest.approx(1.0)
    assert warning["what"] in format_summary(summary)
    json.dumps(summary.content, allow_nan=False)


def three_cranks_sdf(doubled=False) -> str:
    """A rod on three parallel cranks at the same distance; or on two of them, doubled."""
    body = ""
    for i in range(2 if doubled else 3):
        body += (
            f'<frame name="g{i}" attached_to="world"><pose relative_to="__model__">{0.2 * i} 0 0 0 0 0</pose></frame>'
        )
        body += bar(f"c{i}", 0.05, f"g{i}", 1.0, mass=0.08) + joint(f"G{i}", "world", f"c{i}")
    for rod in ("rod", "twin") if doubled else ("rod",):
        body += bar(rod, 0.4, "c0_tip", -1.0, mass=0.6) + joint(f"{rod}0", "c0_tip", rod)
        for i in range(1, 2 if doubled else 3):
            body += f'<frame name="{rod}_{i}" attached_to="{rod}"><pose>{0.2 * i} 0 0 0 0 0</pose></frame>'
            body += joint(f"{rod}{i}", f"c{i}_tip", f"{rod}_{i}")
    return model("locomotive", body)


CRANKS = """duration = 1.0
outputs = ["rod.ay", "rod.angle"]
gravity = [0.0, -9.81, 0.0]
[drives.G0]
speed = 6.0
"""


@slow_on_drake
def test_three_cranks_on_one_rod_have_one_branch_and_a_finite_torque(engine, system_of):
    """The third crank leaves the rod no antiparallel motion; the torque follows from the weights' power."""
    system = system_of(three_cranks_sdf(), CRANKS)
    found = assess(system, engine, error_estimate=False)
    summary = summarize(found)
    singular, indeterminate = summary["warnings"]
    assert (singular["kind"], indeterminate["kind"]) == ("singular", "indeterminate")
    assert singular["time"] == pytest.approx(FLAT[0], abs=1e-4)
    assert "one branch only" in singular["what"]
    assert "another branch" not in singular["what"]
    torque = (0.6 + 3 * 0.5 * 0.08) * 9.81 * 0.05 * np.cos(1.0 + 6.0 * found.run.time)
    np.testing.assert_allclose(found.run["G0.torque"], torque, atol=1e-6)
    for numbers in (summary, summary["ideal"]):
        assert all(joint["force"]["peak"] is None for joint in numbers["joints"].values())
        assert numbers["drives"]["G0"]["torque"]["peak"] == pytest.approx(0.72 * 9.81 * 0.05, rel=1e-6)
        assert numbers["outputs"]["rod.ay"]["peak"] == pytest.approx(0.05 * 36.0, rel=1e-6)


def test_forces_that_are_indeterminate_are_not_zero_in_the_answer(system_of):
    """The rod weighs 5.9 N and hangs on the cranks, whose forces are indeterminate; the bob of 10 g weighs 0.1 N."""
    bob = bar("bob", 0.02, "rod_1", -1.0, mass=0.01) + joint("P", "rod_1", "bob")
    short = CRANKS.replace("1.0", "0.2", 1)  # before the cranks lie flat
    for more, wanted in ((bob, "The largest known joint force is "), ("", "The forces in G0, ")):
        sdf = three_cranks_sdf().replace("</model>", f"{more}</model>")
        summary = summarize(assess(system_of(sdf, short), error_estimate=False))
        said = answer(summary, "cranks.toml")[1]
        assert said.startswith(wanted)
        assert said.endswith("G0, G1, G2, rod0, rod1 and rod2 are statically indeterminate.")
        assert ("in P;" in said) == bool(more)
        output = remarks(summary | {"outputs": {"G0.fx": {"peak": None}}})
        assert "The output G0.fx is statically indeterminate." in output


def test_an_overlay_has_no_peak_of_an_indeterminate_force(experiment_file, tmp_path, capsys):
    path, out = experiment_file(three_cranks_sdf(), CRANKS.replace("1.0", "0.2", 1)), str(tmp_path / "out")
    assert main(["simulate", str(path), "--quiet", "--no-plots", "--no-animation", "--out", out]) == 0
    names = ["--output", "G0.force", "--output", "rod.ay"]
    assert main(["overlay", out, *names, "--no-plots", "--out", str(tmp_path / "over")]) == 0
    found = json.loads((tmp_path / "over" / "overlay.json").read_text())["peaks"]
    assert found["G0.force"]["out"] == {"peak": None, "time": None}
    assert found["rod.ay"]["out"]["peak"] == pytest.approx(0.05 * 36.0, rel=1e-6)
    assert json.loads((tmp_path / "over" / "record.json").read_text())["answer"][0] == "No run has a value of G0.force."


def test_forces_at_change_points_are_not_zero_in_the_answer(system_of):
    summary = summarize(assess(system_of(parallelogram_sdf(), DRIVEN.format(1.0)), error_estimate=False))
    assert answer(summary, "parallelogram.toml")[1] == f"The forces in {listed(summary['joints'])} are unbounded."


def test_a_doubled_rod_leaves_both_branches(system_of):
    """It is redundant everywhere, and does not forbid the antiparallel motion."""
    system = system_of(three_cranks_sdf(doubled=True), CRANKS)
    assert {position.kind for position in Soundness.of_ideal(system, ideal(system)).singular} == {CHANGE_POINT}


def test_peaks_without_a_bound_are_not_looked_for(system_of):
    """Evaluation of a run close to a singular position is slow."""
    found = assess(system_of(parallelogram_sdf(), DRIVEN.format(1.0)), "compiled", error_estimate=False)
    asked = {}
    for which in ("run", "ideal"):
        motion, asked[which] = getattr(found, which), []

        def counted(times, motion=motion, asked=asked[which]):
            asked.extend(times)
            return motion.evaluate(times)

        found = replace(found, **{which: replace(motion, evaluate=counted)})
    summarize(found)
    assert all(len(times) < 20 for times in asked.values()), {which: len(times) for which, times in asked.items()}


def test_report_and_figures_of_a_run_through_change_points(experiment_file, tmp_path):
    path, out = experiment_file(parallelogram_sdf(), DRIVEN.format(0.5)), str(tmp_path / "out")
    assert main(["simulate", str(path), "--engine", "compiled", "--quiet", "--no-animation", "--out", out]) == 0
    assert main(["report", out]) == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "passes or nears singular positions at 0.35" in page
    assert "follower.alpha is unbounded." in page


def test_a_motion_that_stays_away_from_its_change_points_has_all_numbers(engine, system_of):
    summary = summarize(assess(system_of(parallelogram_sdf(), DRIVEN.format(0.9 * FLAT[0])), engine))
    assert summary["warnings"] == []
    assert all(joint["force"]["peak"] > 0.0 for joint in summary["joints"].values())
    assert None not in summary["error"].values()


@pytest.mark.parametrize("offset", [0.3, 0.01])
def test_passages_are_found_between_samples(system_of, offset):
    """Wherever the samples lie; the ratio of singular values is |sin| of the crank angle times a factor near one."""
    system = system_of(parallelogram_sdf(), DRIVEN.format(1.0))
    motion = ideal(system)
    every = 20  # 0.4 rad
    coarse = replace(motion, columns={k: x[int(offset * every) :: every] for k, x in motion.columns.items()})
    coarse = replace(coarse, time=coarse.columns["time"])
    found = Soundness.of_ideal(system, coarse).singular
    assert [passage.time for passage in found] == pytest.approx(FLAT, abs=2e-3)
    assert all(passage.quality < NEAR for passage in found)


def test_exactly_in_a_change_point_the_motion_is_that_of_its_branch(engine, system_of):
    """Only the flat position is requested: rates from the closure alone are inaccurate there."""
    system = system_of(parallelogram_sdf(), DRIVEN.format(1.0))
    for motion in (ideal(system), simulate(system, engine)):
        found = motion.evaluate(FLAT)
        np.testing.assert_allclose(found["follower.angle"], [np.pi, 2.0 * np.pi], rtol=0, atol=1e-7)
        np.testing.assert_allclose(found["follower.omega"], 6.0, rtol=0, atol=1e-6)
        np.testing.assert_allclose(found["follower.alpha"], 0.0, rtol=0, atol=1e-3)


def press_sdf() -> str:
    """A beam on three parallel cranks, one more than needed, and a bar that hangs from its end."""
    body = ""
    for i in range(3):
        body += (
            f'<frame name="g{i}" attached_to="world"><pose relative_to="__model__">{0.2 * i} 0 0 0 0 0</pose></frame>'
        )
        body += bar(f"c{i}", 0.1, f"g{i}", 1.0) + joint(f"G{i}", "world", f"c{i}")
    body += bar("beam", 0.4, "c0_tip", -1.0) + joint("P0", "c0_tip", "beam")
    for i in (1, 2):
        body += f'<frame name="b{i}" attached_to="beam"><pose>{0.2 * i} 0 0 0 0 0</pose></frame>'
        body += joint(f"P{i}", f"c{i}_tip", f"b{i}", inner=BEARING if i == 1 else "")
    return model("press", body + bar("load", 0.1, "beam_tip", -np.pi / 2) + joint("hook", "beam_tip", "load"))


PRESS = """duration = 0.1
outputs = ["beam.ay"]
gravity = [0.0, -9.81, 0.0]
[drives.G0]
torque = 0.0
speed = 0.5
"""


def test_forces_that_redundant_loops_leave_open_are_no_numbers(engine, system_of):
    """What passes between three cranks moves nothing; the force that a hanging bar gets is known all the same."""
    cranks = {"G0", "G1", "G2", "P0", "P1", "P2"}
    summary = summarize(assess(system_of(press_sdf(), PRESS), engine))
    for numbers in (summary, summary["ideal"]):
        assert {name for name, joint in numbers["joints"].items() if joint["force"]["peak"] is None} == cranks
        assert numbers["joints"]["hook"]["force"]["peak"] > 0.0
        assert numbers["outputs"]["beam.ay"]["peak"] > 0.0
    assert all(summary["error"][f"{name}.force.peak"] is None for name in cranks)
    (warning,) = summary["warnings"]
    assert warning["kind"] == "indeterminate"
    assert all(name in warning["what"] for name in cranks)
    assert "hook" not in warning["what"]
    assert warning["what"] in format_summary(summary)


def test_play_in_a_redundant_link_makes_the_forces_determinate(system_of):
    film = '[joints.P1]\nmodel = "lubricated"\nclearance = 1e-4\nviscosity = 0.1\n'
    summary = summarize(assess(system_of(press_sdf(), PRESS + film), "compiled", error_estimate=False))
    assert all(joint["force"]["peak"] > 0.0 for joint in summary["joints"].values())
    assert summary["ideal"]["joints"]["P1"]["force"]["peak"] is None
    (warning,) = [entry for entry in summary["warnings"] if entry["kind"] == "indeterminate"]
    assert "of the ideal linkage" in warning["what"]


@pytest.mark.parametrize(
    "name", ["seven_bar", "four_bar_dry", "five_bar_dry", "six_bar_dry", "slider_crank_dry", "slider_crank_guide"]
)
def test_the_shipped_machines_pass_no_singular_position(name):
    system = shipped(name)
    assert Soundness.of_ideal(system, ideal(system)).singular == []


def test_peaks_that_another_tolerance_changes_by_more_than_a_tenth_are_rough():
    found = assess(shipped("seven_bar", duration=0.05, **FINITE), "compiled")
    assert summarize(found)["warnings"] == []
    columns = found.tighter.columns | {"A.force": 1.2 * found.tighter["A.force"]}
    summary = summarize(replace(found, tighter=replace(found.tighter, columns=columns, evaluate=None)))
    (warning,) = summary["warnings"]
    assert (warning["kind"], warning["time"]) == ("rough", None)
    assert f"{100 * SAFETY * 0.2:.0f} % of A.force.peak" in warning["what"]
    assert "B.force" not in warning["what"]


def test_the_noise_of_a_zero_is_not_rough():
    """Rounding of an angle of 1 rad is 1e-16; a peak of 1e-14 that changes by all of itself is zero."""
    system = shipped("slider_crank_dry")
    zeros = {
        "slider.angle.peak": 1.7e-14,
        "slider.omega.peak": 3e-13,
        "slider.alpha.peak": 2e-11,
        "slider.y.peak": 2e-15,
    }
    rounding = noise(system, [key.removesuffix(".peak") for key in zeros])
    assert rough(None, zeros, zeros, rounding) == []
    small = {key: 1e6 * peak for key, peak in zeros.items()}
    (warning,) = rough(None, small, small, rounding)
    assert all(key.removesuffix(".peak") in warning["what"] for key in small)


def test_errors_that_could_not_be_estimated_are_null_and_said(tmp_path, capsys, monkeypatch):
    from linkages.engines import assessment as runs

    original = runs.simulate

    def failing(system, engine, progress=None):
        run = original(system, engine, progress)
        return replace(run, status=Status.STEP_SIZE_COLLAPSE) if system.experiment.solver.accuracy < 1e-7 else run

    monkeypatch.setattr(runs, "simulate", failing)
    words = ["simulate", "seven_bar.toml", "--duration", "0.05", "--engine", "compiled", "--out", str(tmp_path / "out")]
    words += [word for path, value in FINITE.items() for word in ("--set", f"{path}={value}")]
    assert main([*words, "--no-plots", "--no-animation"]) == 0
    told = capsys.readouterr()
    assert "the run that estimates the errors ended at t = 0.05 s" in told.err
    assert "warning (rough)" in told.out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert set(summary["error"].values()) == {None}
    assert [entry["kind"] for entry in summary["warnings"]] == ["rough"]
