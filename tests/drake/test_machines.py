"""Every shipped experiment with a linkage runs from the command line; the four-bar moves as its closed form says."""

import csv
import json

import numpy as np
import pytest
from machines import circle_intersection

from linkages.cli.main import main
from linkages.errors import Status
from linkages.files.shipped import data_folder
from linkages.model.experiment import load
from linkages.system.assembly import IdealMotion, assemble

# the flexible robot has a command of its own
FILES = sorted(path.name for path in data_folder().glob("*.toml") if not path.name.startswith("three_rrr"))

#: Seconds to simulate: long enough for each joint that can touch to do so, from its centre.
SHORT = {
    "slider_crank_dry.toml": 0.0009,
    "slider_crank_lubricated.toml": 0.002,
    "four_bar_dry.toml": 0.007,
    "five_bar_dry.toml": 0.004,
    "six_bar_dry.toml": 0.008,
    "seven_bar_dry.toml": 0.03,
    "seven_bar_mixed.toml": 0.08,
    "slider_crank_guide.toml": 0.003,
}
DEFAULT = 0.05


def test_the_linkages_of_the_sources_are_there():
    names = ("four_bar_dry", "five_bar_dry", "six_bar_dry", "seven_bar", "seven_bar_dry", "slider_crank_dry")
    assert {f"{name}.toml" for name in names} <= set(FILES)


@pytest.mark.parametrize("name", FILES)
def test_experiment_runs_and_writes_its_results(name, tmp_path):
    duration = SHORT.get(name, DEFAULT)
    arguments = ["simulate", str(data_folder() / name), "--duration", str(duration), "--out", str(tmp_path)]
    assert main([*arguments, "--no-error-estimate"]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == summary["ideal"]["status"] == "ok"
    assert summary["duration"] == pytest.approx(duration, rel=1e-12)
    mechanism, experiment = load(data_folder() / name)
    dry = [name for name in experiment.play if experiment.joints[name].can_touch]
    figures = {"joint_forces.png", "drive_torques.png"}
    figures |= {"orbits.png" for name in experiment.play if mechanism.joint[name].bearing}
    figures |= {f"output_{output}.png" for output in experiment.outputs}
    contacts = {"impacts.csv", "impacts.png"} if dry else set()
    written = {path.name for path in tmp_path.iterdir()}
    assert written == {"summary.json", "trajectory.npz", "animation.html"} | figures | contacts
    rows = list(csv.DictReader((tmp_path / "impacts.csv").open())) if dry else []
    for joint in experiment.play:
        entry, own = (
            summary["joints"][joint],
            [row for row in rows if row["joint"].partition(".")[0] == joint],
        )
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


@pytest.mark.parametrize("name", FILES)
def test_ideal_linkage_moves_through_the_whole_experiment(name):
    mechanism, experiment = load(data_folder() / name)
    motion = IdealMotion(assemble(mechanism, experiment.ideal()), experiment)
    assert motion.status is Status.OK
    assert motion.times[-1] == experiment.duration


def test_drag_link_follows_its_closed_form():
    """Pins by intersecting circles; the follower's speed from the vector loop; both cranks turn fully."""
    ground, crank, coupler, follower = 0.1, 0.2, 0.18, 0.22  # m, as in the file
    mechanism, experiment = load(data_folder() / "four_bar_dry.toml", {"drives.O.ramp": 0.0})
    turn = 2.0 * np.pi / experiment.drives["O"].speed
    times = np.linspace(0.0, turn, 73)
    ideal = IdealMotion(assemble(mechanism, experiment.ideal()), experiment).evaluate(times)
    theta = 0.5 * np.pi + experiment.drives["O"].speed * times
    a = crank * np.column_stack([np.cos(theta), np.sin(theta)])
    b = np.array([circle_intersection(pin, coupler, (ground, 0.0), follower) for pin in a])
    rounding = 1e-9  # m: the file's angles close the loop to its nine digits; the assembly does the rest
    np.testing.assert_allclose(ideal["follower_B.x"], b[:, 0], rtol=0, atol=rounding)
    np.testing.assert_allclose(ideal["follower_B.y"], b[:, 1], rtol=0, atol=rounding)
    theta_3 = np.arctan2(*(b - a).T[::-1])
    theta_4 = np.arctan2(b[:, 1], b[:, 0] - ground)
    speed = (
        experiment.drives["O"].speed * crank / follower * np.sin(theta - theta_3) / np.sin(theta_4 - theta_3)
    )
    np.testing.assert_allclose(ideal["follower.omega"], speed, rtol=1e-8)
    assert speed.min() > 0.0
    assert np.ptp(ideal["follower.angle"]) == pytest.approx(2.0 * np.pi, rel=1e-9)
