"""Loads of links for finite elements: balanced, equal to the run's forces, and CalculiX finds the run's moment."""

import csv
import re
import shutil
import subprocess

import numpy as np
import pytest
from machines import bar, joint, model
from shipped import BENT, NAMES, shipped

import linkages
from linkages.cli.main import main
from linkages.results.link_loads import link_loads

SHORT = 0.02  # s
STOP = {"law": "hertz", "restitution": 1.0, "stiffness": 100.0}
ROUNDING = 1e-12  # of the largest load


def loads_at(system, run, time):
    return link_loads(system, time, tuple(part[0] for part in run.evaluate.function.states_at(np.array([time]))))


def assert_balanced(system, run):
    for time in run.time[-1] * np.array([0.0, 0.013, 0.771, 1.0]):
        for link in loads_at(system, run, time).values():
            assert link.imbalance < ROUNDING, (link.link, time)


@pytest.mark.parametrize("name", [*NAMES, *BENT, "three_rrr_clearance"])
def test_loads_of_every_link_of_every_shipped_machine_are_balanced(name):
    system = shipped(name, duration=SHORT)
    assert_balanced(system, linkages.simulate(system))


def test_loads_of_a_link_in_substructures_are_balanced():
    system = shipped("slider_crank_flexible", **{"duration": SHORT, "links.rod.pieces": 3})
    assert_balanced(system, linkages.simulate(system))


def test_loads_of_a_run_of_drake_are_balanced():
    system = shipped("four_bar_dry", duration=SHORT)
    assert_balanced(system, linkages.simulate(system, "drake"))


def test_applied_loads_stops_and_powered_drives_belong_to_the_balance():
    more = {
        "forces.push": {"point": "coupler", "force": [3.0, -2.0], "axes": "body"},
        "torques.motor": {"joint": "Q", "torque": 0.4},
        "springs.pull": {"point": "crank", "to": "follower", "stiffness": 90.0, "free_length": 0.05, "damping": 2.0},
        "torsion_springs.coil": {"joint": "Q", "stiffness": 0.5, "free_angle": 0.2},
        "stops.end": {"joint": "Q", "side": "upper", "limit": -0.1, "contact": STOP},
    }
    system = shipped("four_bar_dry", duration=SHORT, **more)
    run = linkages.simulate(system)
    assert_balanced(system, run)
    found = loads_at(system, run, SHORT)
    names = {load.name for link in found.values() for load in link.loads}
    assert names >= {"push", "motor", "pull", "coil", "end", "weight", "inertia"}


def test_the_teeth_of_a_gear_belong_to_the_balance(system_of):
    body = bar("carrier", 0.1, "__model__") + bar("planet", 0.1, "carrier_tip")
    sdf = model("cardan", body + joint("O", "world", "carrier") + joint("P", "carrier_tip", "planet"))
    text = "duration = 0.1\n[drives.O]\nformula = '4*sin(2*t)'\n[gears.mesh]\njoints = ['O', 'P']\nratio = -2.0\n"
    system = system_of(sdf, text)
    run = linkages.simulate(system)
    assert_balanced(system, run)
    planet = [load for load in loads_at(system, run, 0.05)["planet"].loads if load.name == "mesh"]
    torque = run.evaluate(np.array([0.05]))["mesh.torque"][0]
    assert sum(load.moment for load in planet) == pytest.approx(torque, rel=1e-9)


def test_the_field_of_a_rigid_link_is_gravity_less_the_acceleration_of_its_mass_centre():
    system = shipped("seven_bar", duration=SHORT)
    run, time = linkages.simulate(system), 0.7 * SHORT
    link = loads_at(system, run, time)["link2"]
    at = run.evaluate(np.array([time]))
    (inertia,) = (one for one in link.loads if one.name == "inertia")
    (weight,) = (one for one in link.loads if one.name == "weight")
    mass = system.mechanism.link["link2"].mass
    force = np.array([inertia.fx + weight.fx, inertia.fy + weight.fy])
    np.testing.assert_allclose((link.field.gx, link.field.gy), force / mass)
    assert link.field.square == pytest.approx(at["link2.omega"][0] ** 2, rel=1e-12)
    r, alpha = np.array([inertia.x, inertia.y]), at["link2.alpha"][0]
    c, s = np.cos(at["link2.angle"][0]), np.sin(at["link2.angle"][0])
    turn = np.array([[c, s], [-s, c]])
    origin = turn @ [at["link2.ax"][0], at["link2.ay"][0]]
    centre = origin + alpha * np.array([-r[1], r[0]]) - link.field.square * r
    np.testing.assert_allclose((link.field.gx, link.field.gy), turn @ system.gravity - centre, rtol=1e-9)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("flexible")
    words = ["slider_crank_flexible", "--out", str(out), "--no-plots", "--no-animation", "--no-error-estimate", "-q"]
    assert main(["simulate", *words]) == 0
    assert main(["export", str(out), "--loads", "--at", "peak:rod.bending", "--at", "20 ms"]) == 0
    return out


def test_the_command_takes_the_located_peak_and_repeats_the_run_exactly(folder):
    with open(folder / "loads.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    run = linkages.simulate(linkages.load(linkages.find_file("slider_crank_flexible.toml")))
    peak = linkages.extremes(run, ["rod.bending"])["rod.bending"]
    first = [row for row in rows if row["case"] == "peak:rod.bending"]
    assert {float(row["time [s]"]) for row in first} == {peak.time}
    assert {float(row["time [s]"]) for row in rows} == {peak.time, 0.02}
    force = run.evaluate(np.array([peak.time]))["B.force"][0]
    both = [row for row in first if row["load"] == "B"]
    assert [row["link"] for row in both] == ["rod", "slider"]
    for row in both:
        assert np.hypot(float(row["fx [N]"]), float(row["fy [N]"])) == pytest.approx(force, rel=1e-9)


def test_statics_of_the_exported_forces_give_the_bending_moment_of_the_run(folder):
    """Moments about each node of all forces before it: no model, only the numbers of loads.csv."""
    with open(folder / "loads.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if (row["case"], row["link"]) == ("peak:rod.bending", "rod")]
    x, y, fx, fy, moment = np.array([[float(value) for value in list(row.values())[4:]] for row in rows]).T
    found = [
        np.sum(((x - a) * fy - (y - b) * fx + moment)[x <= a + 1e-12])
        for a, b, name in zip(x, y, (row["load"] for row in rows), strict=True)
        if name == "node"
    ]
    run = linkages.simulate(linkages.load(linkages.find_file("slider_crank_flexible.toml")))
    wanted = linkages.extremes(run, ["rod.bending"])["rod.bending"].peak
    assert np.abs(found).max() == pytest.approx(wanted, rel=1e-3)  # 33 nodes


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_finds_the_bending_moment_of_the_run(folder, tmp_path):
    asked = "*EL FILE, OUTPUT=2D, SECTION FORCES\nS, NOE\n*NODE PRINT, NSET=ALL, TOTALS=ONLY\nRF\n*END STEP"
    text = (folder / "rod.inp").read_text()
    (tmp_path / "rod.inp").write_text(text.replace("*END STEP", asked))
    subprocess.run(["ccx", "rod"], cwd=tmp_path, check=True, capture_output=True, timeout=300)
    lines = (tmp_path / "rod.frd").read_text().split("-4  STRESS")[1].splitlines()
    values = [[float(line[at : at + 12]) for at in range(13, 85, 12)] for line in lines if line.startswith(" -1")]
    run = linkages.simulate(linkages.load(linkages.find_file("slider_crank_flexible.toml")))
    wanted = linkages.extremes(run, ["rod.bending"])["rod.bending"].peak
    assert np.abs(values)[:, 4].max() == pytest.approx(wanted, rel=0.01)


def test_numbers_of_a_model_fit_the_fields_of_calculix(folder):
    for path in folder.glob("*.inp"):
        for line in path.read_text().splitlines():
            if not line.startswith("*"):
                assert all(len(field.strip()) <= 20 for field in line.split(",")), line


def test_a_step_of_a_rigid_link_names_its_sets_and_has_gravity_and_rotation(folder):
    text = (folder / "crank.inp").read_text()
    assert re.search(r"^crank, GRAV, ", text, re.MULTILINE)
    assert re.search(r"^crank, CENTRIF, 2\.25\d*e\+04, ", text, re.MULTILINE)  # 150 rad/s
    assert re.search(r"^A, 1, ", text, re.MULTILINE)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--loads", "--link", "rood"], 'did you mean "rod"'),
        (["--loads", "--at", "peak:B.farce"], "B.force"),
        (["--loads", "--at", "7"], "lies outside the run"),
        (["--loads", "--at", "noon"], "write a time"),
        (["--to", "csv", "--at", "0.1"], "goes with --loads"),
    ],
)
def test_bad_input_gives_one_line(folder, capsys, words, said):
    assert main(["export", str(folder), *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_folder_whose_experiment_is_gone_is_refused(folder, tmp_path, capsys):
    own = tmp_path / "own"
    shutil.copytree(folder, own)
    summary = own / "summary.json"
    summary.write_text(re.sub(r'"folder": "[^"]*"', f'"folder": "{tmp_path}"', summary.read_text()))
    assert main(["export", str(own), "--loads"]) == 2
    assert "cannot be repeated without it" in capsys.readouterr().err
