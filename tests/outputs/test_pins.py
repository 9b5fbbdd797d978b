"""Joints as points: their places and speeds, and how a wrong name is answered."""

import re

import numpy as np
import pytest
from machines import four_bar, joint, model, slider_crank, solid

import linkages
from linkages import InputError, load, simulate
from linkages.cli.main import main

SPEED = 30.0
DRIVEN = f"duration = 0.1\n[drives.O]\nspeed = {SPEED}\n"


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_a_pin_moves_as_the_end_of_its_crank(system_of, engine):
    """A crank of 0.1 m from the origin: r (cos, sin) of the angle, and its derivatives."""
    outputs = [f"A.{name}" for name in ("x", "y", "vx", "vy", "ax", "ay", "acceleration")]
    system = system_of(four_bar(), f"outputs = {outputs}\n{DRIVEN}".replace("'", '"'))
    for run in (simulate(system, engine), linkages.ideal(system)):
        angle = SPEED * run.time
        turn = np.stack([np.cos(angle), np.sin(angle)])
        for factor, names in ((0.1, "x y"), (-0.1 * SPEED**2, "ax ay")):
            for name, along in zip(names.split(), turn, strict=True):
                assert run[f"A.{name}"] == pytest.approx(factor * along, abs=1e-6 * abs(factor))
        assert run["A.vx"] == pytest.approx(-0.1 * SPEED * turn[1], abs=1e-6 * SPEED)
        assert run["A.vy"] == pytest.approx(0.1 * SPEED * turn[0], abs=1e-6 * SPEED)
        assert run["A.acceleration"] == pytest.approx(0.1 * SPEED**2, rel=1e-6)
        assert not [name for name in run.columns if name.startswith("B.") and name[2:] in ("x", "y", "vx")]


def test_a_joint_with_play_is_where_its_journal_is(system_of):
    play = '[joints.B]\nmodel = "dry"\nclearance = 1e-4\ncontact = { law = "flores", restitution = 0.8, youngs_modulus = 2e11 }\n'
    system = system_of(slider_crank(), f'outputs = ["B.x", "B.vy"]\n{DRIVEN}{play}')
    run = simulate(system, "compiled")
    assert np.ptp(run["B.ex"]) > 1e-5
    assert run["B.x"] == pytest.approx(run["rod_tip.x"] + run["B.ex"], abs=1e-12)
    assert run["B.x"] == pytest.approx(run["slider.x"], abs=1e-12)
    assert set(linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))["outputs"]) == {
        "B.x",
        "B.vy",
    }


def test_sections_and_forces_can_ask_for_a_pin_that_is_no_output(system_of):
    spring = '[forces.push]\npoint = "slider"\nformula = ["-100*A.y - 2*A.vx", "0"]\n'
    system = system_of(slider_crank(), f"{DRIVEN}{spring}")
    found = linkages.stroboscopic(system, ["A.x", "A.vy"], 1)
    assert found.high["A.x"] == pytest.approx(0.05, rel=1e-6)
    assert found.high["A.vy"] == pytest.approx(0.05 * SPEED, rel=1e-6)
    run = simulate(system, "compiled")
    angle = SPEED * run.time
    assert run["push.fx"] == pytest.approx(-5.0 * np.sin(angle) + 2 * 0.05 * SPEED * np.sin(angle), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('outputs = ["crnak_tip.x"]', 'has no link, frame or joint "crnak_tip"; did you mean "crank_tip"?'),
        ('outputs = ["AA.x"]', 'did you mean "A"?'),
        ('outputs = ["A.omega"]', '"omega" of a joint is no output here; known are: acceleration, ax'),
        ('outputs = ["A.rate"]', 'outputs: "A.rate": needs a drive, and "A" has none; name a driven joint'),
        ('outputs = ["A.vz"]', '"vz" of a joint is no output here; did you mean "vy"?'),
        ('forces = { f = { point = "A", force = [1, 0] } }', "is a joint of two links; name a link or frame, such as coupler or crank_tip"),
        ('forces = { f = { point = "crank", formula = ["B.angle", "0"] } }', '"B" is not in'),
    ],
)  # fmt: skip
def test_a_wrong_name_is_answered_with_a_right_one(experiment_file, text, problem):
    with pytest.raises(InputError) as caught:
        load(experiment_file(four_bar(), f"duration = 0.1\n{text}\n"))
    assert problem in str(caught.value)


EVERYTHING = """outputs = ["O.rate", "O.torque", "B.ex", "A.force", "push.fx", "push.power", "kinetic_energy", "q.O", "z.value"]
[forces.push]
point = "slider"
force = [-5.0, 0.0]
[states.z]
rate = "1"
[joints.B]
model = "dry"
clearance = 1e-4
contact = { law = "flores", restitution = 0.8, youngs_modulus = 2e11 }
"""


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_every_recorded_output_can_be_reported(system_of, engine):
    """An output of joints, drives, loads, states, coordinates, or of the whole linkage; not only of points."""
    head, tables = EVERYTHING.split("\n", 1)
    system = system_of(slider_crank(), f"{head}\n{DRIVEN.replace('0.1', '0.005')}{tables}")
    found = linkages.summarize(linkages.assess(system, engine, error_estimate=False))["outputs"]
    assert list(found) == system.experiment.outputs
    assert found["O.rate"]["min"] == found["O.rate"]["max"] == pytest.approx(SPEED)
    assert found["push.fx"]["min"] == -5.0
    assert found["z.value"]["max"] == pytest.approx(0.005)
    assert found["q.O"]["max"] == pytest.approx(0.005 * SPEED)


def test_ideal_joints_keep_the_outputs_that_they_have(system_of):
    head, tables = EVERYTHING.split("\n", 1)
    system = system_of(slider_crank(), f"{head}\n{DRIVEN.replace('0.1', '0.005')}{tables}")
    kept = [name for name in system.experiment.outputs if name != "B.ex"]
    assert system.replaced({"joints.B.model": "ideal"}).experiment.outputs == kept
    assert system.ideal().experiment.outputs == [name for name in kept if name != "q.O"]  # of another tree
    assert simulate(system.ideal(), "compiled")["O.rate"] == pytest.approx(SPEED)


def test_the_table_shows_outputs_of_drives_with_their_units(experiment_file, tmp_path, capsys):
    """A wheel, rad/s and N m; a block on a rail, m/s and N."""
    wheel, slide = joint("O", "world", "one"), joint("O", "world", "one", "prismatic", "1 0 0")
    for part, units in ((wheel, ("rad/s", "N m")), (slide, ("m/s", "N"))):
        text = "outputs = ['O.rate', 'O.torque', 'kinetic_energy']\nduration = 0.1\n[drives.O]\nspeed = 2.0\n"
        file = experiment_file(model("wheel", solid("one", 1.0, 0.2) + part), text)
        assert main(["simulate", str(file), "--out", str(tmp_path / "out"), "--force", "--no-plots"]) == 0
        shown = capsys.readouterr().out
        for label in (rf"O.rate \[{units[0]}\]", rf"O.torque \[{units[1]}\]", r"kinetic_energy \[m?J\]"):
            assert re.search(label, shown)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("B.exx", 'output "B.exx": is unknown; did you mean "B.ex"?'),
        ("push.force_x", 'output "push.force_x": is unknown; did you mean "push.force"?'),
        ("kinetic", 'output "kinetic": is unknown; did you mean "kinetic_energy"?'),
    ],
)
def test_unknown_outputs_of_other_elements_are_answered_before_the_run(system_of, name, problem):
    tables = EVERYTHING.split("\n", 1)[1]
    system = system_of(slider_crank(), f"outputs = ['{name}']\n{DRIVEN}{tables}")
    for ask in (simulate, linkages.ideal, linkages.assess):
        with pytest.raises(InputError) as caught:
            ask(system)
        assert problem in str(caught.value)


def test_a_described_machine_has_its_pins_by_name(tmp_path, capsys):
    (tmp_path / "m.machine.toml").write_text("""duration = 0.1
outputs = ["D.x", "C.vy"]
drives = { O = { speed = "60 r/min" } }
section = ["20 mm", "8 mm"]
density = "7850 kg/m3"
links = { ground = "O F", crank = "O D", coupler = "D C", rocker = "F C" }
points = { O = [0, 0], F = ["300 mm", 0], D = ["O", "100 mm", "0 deg"], C = ["D", "250 mm", "F", "200 mm"] }
""")
    assert main(["new", "--from", str(tmp_path / "m.machine.toml"), "--out", str(tmp_path)]) == 0
    words = ["simulate", str(tmp_path / "m.toml"), "--out", str(tmp_path / "out"), "--no-animation"]
    assert main(words) == 0
    capsys.readouterr()
    assert (tmp_path / "out" / "output_D.x.png").exists()
    run = linkages.load_trajectory(tmp_path / "out" / "trajectory.npz")
    assert run["D.x"] == pytest.approx(0.1 * np.cos(2.0 * np.pi * run.time), abs=1e-6)
    assert main(["draw", str(tmp_path / "m.toml"), "--out", str(tmp_path / "drawn")]) == 0
