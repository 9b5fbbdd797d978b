"""Every shipped experiment: from the command line, and both engines side by side with other equations and integrators."""

import csv
import json

import numpy as np
import pytest
from engines import slow_on_drake
from measures import worst
from shipped import FAST_PRESS, NAMES, run, shipped

from linkages import Status, extremes, ideal, impacts, simulate
from linkages.cli.main import main
from linkages.input.files.shipped import data_folder
from linkages.results.assessment import touching

#: Films, or ideal joints: seconds to simulate, a revolution; how Drake's own error is a few times 1e-7 at most.
IMPLICIT = {"solver.accuracy": 1e-10}
EXPLICIT = {"solver.accuracy": 1e-9, "solver.integrator": "dormand_prince_5_4"}  # this film is not stiff
SMOOTH = {
    "seven_bar": (1.0, IMPLICIT),
    "seven_bar_rig": (1.0, IMPLICIT),
    "slider_crank_lubricated": (0.012, EXPLICIT),
    "slider_crank_motor": (0.1, IMPLICIT),
    "slider_crank_flywheel": (0.1, IMPLICIT),
    "slider_crank_main_bearing": (0.012, IMPLICIT),
}

#: Films whose force jumps, where eqs. (12)-(13) begin: seconds, Drake's accuracy.
JUMPING = {"seven_bar_paper": (0.02, 1e-9)}

#: Contacts: seconds until two of them have ended.
DRY = {
    "four_bar_dry": 0.0055,
    "five_bar_dry": 0.0016,
    "six_bar_dry": 0.0065,
    "seven_bar_dry": 0.016,
    "slider_crank_dry": 0.0008,
    "slider_crank_wear": 0.0008,
    "slider_crank_guide": 0.0012,
    "gear_rattle": 0.028,
}

#: Film and contact, from one to the other and back without end.
MIXED = {"seven_bar_mixed": 0.08}

TIGHT = {"solver.accuracy": 1e-12}


#: Machines that a motor turns.
TURNED = ("slider_crank_motor", "slider_crank_flywheel")


def test_every_shipped_linkage_is_compared():
    assert sorted({*SMOOTH, *JUMPING, *DRY, *MIXED}) == NAMES


# --- command line -----------------------------------------------------------------------------------------------------

#: Seconds to simulate: long enough for each joint that can touch to do so, from its centre.
TOUCHING = {
    "slider_crank_dry": 0.0009,
    "slider_crank_wear": 0.0009,
    "slider_crank_lubricated": 0.002,
    "four_bar_dry": 0.007,
    "five_bar_dry": 0.004,
    "six_bar_dry": 0.008,
    "seven_bar_dry": 0.03,
    "seven_bar_mixed": 0.08,
    "slider_crank_guide": 0.003,
}
DEFAULT = 0.05


#: One of each kind; the others are slow tests.
QUICK = ("seven_bar", "seven_bar_mixed", "slider_crank_dry", "slider_crank_guide")


#: What readers of the file expect.
COLUMNS = "joint,start,approach_speed,tangential_speed,duration,peak_force,peak_penetration,separation_speed"


@slow_on_drake
@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in NAMES if name not in QUICK)]
)
def test_experiment_runs_and_writes_its_results(engine, name, tmp_path):
    duration = TOUCHING.get(name, DEFAULT)
    words = ["simulate", f"{name}.toml", "--engine", engine, "--duration", str(duration), "--out", str(tmp_path)]
    drawn = engine == "compiled" or name in QUICK
    assert main([*words, "--no-error-estimate", *([] if drawn else ["--no-plots", "--no-animation"])]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["engine"] == summary["provenance"]["run"]["engine"] == engine
    assert summary["status"] == summary["ideal"]["status"] == "ok"
    assert summary["duration"] == pytest.approx(duration, rel=1e-12)
    system = shipped(name)
    experiment, play = system.experiment, system.tree.play
    dry = [name for name in play if experiment.joints[name].can_touch]
    touches = dry or experiment.loose
    carrying = any(joint["force"]["peak"] for joint in summary["joints"].values())  # no joint of a gear pair does
    figures = {"drawing.svg", "animation.html"} | ({"joint_forces.png"} if carrying else set())
    figures |= {"drive_torques.png"} if experiment.actuators else set()
    figures |= {"orbits.png" for name in play if system.mechanism.joint[name].bearing}
    figures |= {"guides.png" for name in play if system.mechanism.joint[name].slot}
    figures |= {f"output_{output}.png" for output in experiment.outputs} | ({"impacts.png"} if touches else set())
    tables = {"impacts.csv", "impacts_normal.csv"} if touches else set()
    written = {path.name for path in tmp_path.iterdir()}
    assert written == {"summary.json", "trajectory.npz", "ideal.npz"} | tables | (figures if drawn else set())
    rows = []
    if dry:
        head, *lines = (tmp_path / "impacts.csv").read_text().splitlines()
        assert head == COLUMNS
        rows = list(csv.DictReader([head, *lines]))
    for joint in play:
        entry = summary["joints"][joint]
        own = [row for row in rows if row["joint"].partition(".")[0] == joint]
        assert entry["model"] == experiment.joints[joint].model
        assert entry["impacts"] == len(own)
        if joint in dry:
            assert entry["impacts"] > 0
            assert 0.0 < entry["contact_fraction"] < 1.0
            assert entry["eccentricity_ratio"]["peak"] > 1.0
            deepest = max(float(row["peak_penetration"]) for row in own)
            clearance = experiment.joints[joint].clearance
            assert 1.0 + deepest / clearance == pytest.approx(entry["eccentricity_ratio"]["peak"], rel=1e-6)
            assert all(0.0 < float(row["start"]) < duration for row in own)
        else:
            assert entry["contact_fraction"] == 0.0
            assert entry["impacts"] == 0
            assert 0.0 < entry["eccentricity_ratio"]["peak"] < 1.0


@slow_on_drake
def test_command_line_writes_a_summary_with_errors(engine, tmp_path):
    words = ["simulate", str(FAST_PRESS), "--engine", engine, "--duration", "1"]
    assert main([*words, "--no-plots", "--no-animation", "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["engine"] == summary["provenance"]["run"]["engine"] == engine
    if engine == "compiled":
        assert summary["provenance"]["run"]["method"] == "radau_iia_5"
    assert summary["status"] == summary["ideal"]["status"] == "ok"
    # from two computations that are independent of each other and of the package
    assert summary["joints"]["A"]["force"]["peak"] == pytest.approx(3.345, abs=1e-3)
    assert summary["joints"]["B"]["force"]["peak"] == pytest.approx(2.481, abs=1e-3)
    assert summary["outputs"]["slider7.ax"]["peak"] == pytest.approx(4.667, abs=1e-3)
    assert summary["ideal"]["outputs"]["slider7.ax"]["max"] == pytest.approx(3.524, abs=1e-3)
    error = summary["error"]
    assert 0.0 < error["A.force.peak"] < 1e-3 * 3.345
    assert 0.0 < error["slider7.ax.peak"] < 1e-3 * 4.667


def test_command_line_says_how_a_run_failed(engine, tmp_path, capsys):
    thin = [part for joint in "AB" for part in ("--set", f"joints.{joint}.viscosity=1e-7")]
    words = ["simulate", str(data_folder() / "seven_bar.toml"), "--engine", engine, *thin]
    assert main([*words, "--no-plots", "--no-animation", "--out", str(tmp_path)]) == 1
    assert "journal-left-bearing" in capsys.readouterr().err
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "journal-left-bearing"


# --- side by side -----------------------------------------------------------------------------------------------------


def at(engine, name, duration, solver):
    """Columns of a run, at 401 times."""
    result = run(engine, name, duration=duration, **solver)
    assert result.status is Status.OK
    return result.evaluate(np.linspace(0.0, duration, 401))


@pytest.mark.slow
@pytest.mark.parametrize("name", SMOOTH)
def test_lubricated_linkages_move_alike(name):
    """Every column of the results, to the required accuracy of 1e-6."""
    duration, solver = SMOOTH[name]
    ours, theirs = at("compiled", name, duration, TIGHT), at("drake", name, duration, solver)
    assert ours.keys() == theirs.keys()
    column, difference = worst(ours, theirs)
    assert difference <= 1e-6, column


@pytest.mark.slow
@pytest.mark.parametrize("name", JUMPING)
def test_linkages_whose_film_jumps_move_alike(name):
    """The peak at the jump, and every column from 1 ms on: each engine steps over the jump in its own way."""
    duration, accuracy = JUMPING[name]
    runs = [
        run(engine, name, duration=duration, **{"solver.accuracy": tight})
        for engine, tight in (("compiled", 1e-10), ("drake", accuracy))
    ]
    ours, theirs = (extremes(found, ["slider7.ax"])["slider7.ax"].peak for found in runs)
    assert ours == pytest.approx(theirs, rel=1e-5)
    times = np.linspace(1e-3, duration, 201)
    column, difference = worst(*(found.evaluate(times) for found in runs))
    assert difference <= 2e-5, column


@pytest.mark.slow
@pytest.mark.parametrize("name", MIXED)
def test_mixed_linkages_move_alike(name):
    ours, theirs = at("compiled", name, MIXED[name], TIGHT), at("drake", name, MIXED[name], IMPLICIT)
    assert max(ours["A.penetration"].max(), ours["B.penetration"].max()) > 0.0
    column, difference = worst(ours, theirs)
    assert difference <= 1e-5, column


def first_contacts(engine, name, **changes):
    """Joints of the first two contacts, and all numbers of both."""
    result = run(engine, name, duration=DRY[name], **changes)
    assert result.status is Status.OK
    rows = impacts(result, touching(shipped(name)))[:2]
    return [row.joint for row in rows], np.array([list(vars(row).values())[1:] for row in rows])


@pytest.mark.slow
@pytest.mark.parametrize("name", DRY)
def test_first_two_impacts_are_alike(name):
    """Times, speeds, durations and peaks to the required accuracy of 1e-5."""
    joints, ours = first_contacts("compiled", name, **TIGHT)
    others, theirs = first_contacts("drake", name, **{"solver.accuracy": 1e-10, "solver.max_step": 5e-6})
    assert joints == others
    assert len(joints) == 2
    assert np.all(np.isfinite(ours))
    np.testing.assert_allclose(ours, theirs, rtol=1e-5)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in TURNED])
def test_ideal_linkages_move_by_their_kinematics(name):
    """Loops integrated and projected, against each instant's closure and inverse dynamics."""
    system = shipped(name)
    duration = system.experiment.duration
    exact = ideal(system)
    assert exact.provenance["engine"] == "kinematics"
    assert exact.status is Status.OK
    assert exact.time[-1] == duration
    result = simulate(system.ideal().replaced({"solver.accuracy": 1e-10}), "compiled")
    assert result.status is Status.OK
    times = np.linspace(0.0, duration, 101)
    column, difference = worst(result.evaluate(times), exact.evaluate(times))
    assert difference <= 1e-7, column
    assert result.provenance["loop_error"] <= 1e-10
