"""Identification: values from data of closed forms and twins, certainty, plans, refusals, resuming."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from machines import FLYWHEEL, written
from scipy.signal import lfilter

import linkages
import optim
from linkages.cli.main import main
from linkages.input.files.recorded import read_recording
from optim.identify import budget, curves
from optim.identify.batches import SumsOfSquares
from optim.identify.certainty import certainty
from optim.identify.correlation import coloured, correlation_of
from optim.identify.doubts import doubts
from optim.identify.fit import fit_from
from optim.identify.load import load_identification
from optim.identify.residuals import Residuals
from optim.identify.search import Search

SLIDER = """<sdf version="1.9"><model name="oscillator">
<link name="mass"><inertial><mass>0.5</mass><inertia><ixx>1e-3</ixx><iyy>1e-3</iyy><izz>1e-3</izz></inertia></inertial></link>
<joint name="O" type="prismatic"><parent>world</parent><child>mass</child><axis><xyz>1 0 0</xyz></axis></joint>
</model></sdf>"""
EXPERIMENT = """mechanism = "oscillator.sdf"
duration = 2.0
gravity = [0.0, 0.0, 0.0]
[drives.O]
torque = 0.0
angle = 0.1
[springs.S]
point = "mass"
anchor = [-1.0, 0.0]
stiffness = 200.0
free_length = 1.0
damping = 0.8
[solver]
integrator = "dormand_prince_5_4"
accuracy = 1e-10
"""
TASK = """experiment = "oscillator.toml"
[data.run]
file = "run.csv"
time = { column = "t", unit = "ms", shift = "fit" }
[data.run.columns.x]
output = "mass.x"
unit = "mm"
gain = "fit"
offset = "fit"
deviation = 0.5
[unknowns.stiffness]
path = "springs.S.stiffness"
lower = 100.0
upper = 500.0
start = 210.0
[unknowns.damping]
path = "springs.S.damping"
lower = 0.1
upper = 5.0
start = 1.0
"""
FLYWHEEL_TEXT = """duration = 1.0
outputs = ["wheel.omega"]
[values]
T_c = "{T_c}"
c = {c}
[drives.O]
torque = 0.0
speed = 3.0
[torques.T]
joint = "O"
formula = "-T_c - c*O.rate"
"""
MASS, STIFFNESS, DAMPING, GAIN, OFFSET, SHIFT = 0.5, 200.0, 0.8, 1.25, 0.004, 3.0e-3


def oscillation(times, stiffness=STIFFNESS, damping=DAMPING):
    """Position of the damped oscillator that is released at 0.1 m, in closed form [m]."""
    decay = damping / (2.0 * MASS)
    rate = np.sqrt(stiffness / MASS - decay**2)
    return 0.1 * np.exp(-decay * times) * (np.cos(rate * times) + decay / rate * np.sin(rate * times))


def reading(times, stiffness=STIFFNESS, damping=DAMPING, gain=GAIN, offset=OFFSET, shift=SHIFT):
    """Column of the file [m]: gain times the column plus offset is the position; the file's clock is late."""
    return (oscillation(times + shift, stiffness, damping) - offset) / gain


def oscillator(folder, seed=1, task=TASK, deviation=5e-4, header="t,x"):
    """Write machine, data with noise, and the identification; return its path."""
    (folder / "oscillator.sdf").write_text(SLIDER)
    (folder / "oscillator.toml").write_text(EXPERIMENT)
    times = np.linspace(0.01, 1.9, 400)
    noise = deviation * np.random.default_rng(seed).standard_normal(len(times))
    table = np.column_stack([1e3 * times, 1e3 * (reading(times) + noise)])
    np.savetxt(folder / "run.csv", table, delimiter=",", header=header, comments="")
    (folder / "task.toml").write_text(task)
    return folder / "task.toml"


def test_the_machine_has_the_closed_form(tmp_path):
    oscillator(tmp_path)
    run = linkages.simulate(linkages.load(tmp_path / "oscillator.toml"))
    times = np.linspace(0.0, 2.0, 50)
    np.testing.assert_allclose(run.evaluate(times)["mass.x"], oscillation(times), atol=1e-9)


@pytest.mark.parametrize("header", ["t,x (mm)", "T (ms),X [mm]"])
def test_a_deviation_is_in_the_unit_of_the_heading(tmp_path, header):
    """0.5 mm, also where parentheses state the unit."""
    task = TASK.replace('unit = "mm"\n', "")
    path = oscillator(tmp_path, task=task.replace(', unit = "ms"', "") if "(ms)" in header else task, header=header)
    (channel,) = load_identification(path).measurements[0].channels
    assert channel.deviation == pytest.approx(5e-4)
    assert channel.times[-1] == pytest.approx(1.9)


def test_values_gain_offset_and_clock_are_found_with_the_least_possible_deviation(tmp_path):
    found = optim.identify(load_identification(oscillator(tmp_path)))
    times, wanted = np.linspace(0.01, 1.9, 400), np.array([STIFFNESS, DAMPING, GAIN, OFFSET, SHIFT])
    columns = []
    for k, value in enumerate(wanted):  # the bound of Cramer and Rao, from differences of the closed form
        step = 1e-5 * value * np.eye(5)[k]
        columns.append((reading(times, *(wanted + step)) - reading(times, *(wanted - step))) / (2e-5 * value))
    information = np.array(columns) @ np.array(columns).T / 5e-4**2
    bounds = np.sqrt(np.diag(np.linalg.inv(information)))
    values, nuisance = found["parameters"], found["nuisance"]
    got = [values["stiffness"], values["damping"]]
    got += [nuisance["run.x.gain"], nuisance["run.x.offset"], nuisance["run.shift"]]
    for one, value, bound in zip(got, wanted, bounds, strict=True):
        assert one["value"] == pytest.approx(value, abs=3.5 * bound)
        assert one["deviation"] == pytest.approx(bound, rel=0.1)
    assert all(one["identifiable"] for one in values.values())
    assert found["warnings"] == []


def test_values_of_a_formula_are_found_with_the_least_possible_deviation(tmp_path):
    """A wheel that a torque -T - c w brakes: J w' = -T - c w from 3 rad/s."""
    times, inertia, noise, true = np.linspace(0.01, 0.99, 300), 0.02, 0.01, np.array([0.03, 0.02])

    def speed(torque, c):
        return (3.0 + torque / c) * np.exp(-c * times / inertia) - torque / c

    text = FLYWHEEL_TEXT.format(T_c="25 N mm", c=0.01)
    written(tmp_path, FLYWHEEL, text).rename(tmp_path / "wheel.toml")
    table = speed(*true) + noise * np.random.default_rng(1).standard_normal(len(times))
    np.savetxt(tmp_path / "run.csv", np.column_stack([times, table]), delimiter=",", header="t,w", comments="")
    task = 'experiment = "wheel.toml"\n[data.run]\nfile = "run.csv"\ntime = { column = "t" }\n'
    task += '[data.run.columns.w]\noutput = "wheel.omega"\ndeviation = 0.01\n'
    for name, limits in (("T_c", 'lower = "5 N mm"\nupper = 0.1\n'), ("c", "lower = 1e-3\nupper = 0.1\n")):
        task += f'[unknowns.{name}]\npath = "values.{name}"\n{limits}'
    (tmp_path / "task.toml").write_text(task)
    found = optim.identify(load_identification(tmp_path / "task.toml"))["parameters"]
    steps = 1e-5 * true * np.eye(2)
    slopes = [(speed(*(true + one)) - speed(*(true - one))) / (2.0 * one.sum()) for one in steps]
    bounds = noise * np.sqrt(np.diag(np.linalg.inv(np.array(slopes) @ np.array(slopes).T)))
    for name, value, bound in zip(("T_c", "c"), true, bounds, strict=True):
        assert found[name]["value"] == pytest.approx(value, abs=3.5 * bound)
        assert found[name]["deviation"] == pytest.approx(bound, rel=0.1)
    assert found["T_c"]["unit"] == "N m"


def test_intervals_contain_the_true_values_as_often_as_they_say(tmp_path):
    inside = []
    for seed in range(40):
        values = optim.identify(load_identification(oscillator(tmp_path, seed)))["parameters"]
        for name, true in (("stiffness", STIFFNESS), ("damping", DAMPING)):
            low, high = values[name]["interval"]
            inside.append(low <= true <= high)
    assert 0.88 <= np.mean(inside) <= 1.0  # 80 of 95 %: 0.88 is 3 deviations below


def test_a_start_at_a_wrong_minimum_gets_further_ones(tmp_path):
    far = TASK.replace("upper = 500.0\nstart = 210.0", "upper = 5000.0\nstart = 4500.0")
    found = optim.identify(load_identification(oscillator(tmp_path, task=far)))
    assert found["starts"]["count"] > 1
    assert found["starts"]["chi_square"][0] > 100.0  # the given start ends where another period fits
    stiffness = found["parameters"]["stiffness"]
    assert stiffness["value"] == pytest.approx(STIFFNESS, abs=3.5 * stiffness["deviation"])
    assert found["warnings"] == []


def test_a_profile_agrees_with_the_linear_interval_and_costs_few_runs(tmp_path):
    values = optim.identify(load_identification(oscillator(tmp_path)), profiles=True)["parameters"]
    for one in values.values():
        assert one["profile_interval"] == pytest.approx(one["interval"], rel=2e-3)
        assert one["profile_runs"] <= 30


LINEAR = """experiment = "pushed.toml"
[data.run]
file = "run.csv"
time = "t"
[data.run.columns.x]
output = "mass.x"
offset = "fit"
deviation = 0.002
[unknowns.force]
path = "drives.O.torque"
lower = -10.0
upper = 10.0
[unknowns.speed]
path = "drives.O.speed"
lower = -5.0
upper = 5.0
[fit]
deviations = "white"
"""
PUSHED = """mechanism = "oscillator.sdf"
duration = 2.0
gravity = [0.0, 0.0, 0.0]
[drives.O]
torque = 1.0  # N: the joint is prismatic
speed = 0.1
"""


def pushed(folder, more=""):
    """Write the linear problem; return its path, the columns of its regression and the samples."""
    times = np.linspace(0.0, 1.5, 60)
    columns = np.column_stack([times**2 / (2 * MASS), times, -np.ones(60)])
    values = columns @ [0.7, 0.2, 0.01] + 0.002 * np.random.default_rng(3).standard_normal(60)
    (folder / "oscillator.sdf").write_text(SLIDER)
    (folder / "pushed.toml").write_text(PUSHED)
    (folder / "task.toml").write_text(LINEAR + more)
    np.savetxt(folder / "run.csv", np.column_stack([times, values]), delimiter=",", header="t,x", comments="")
    return folder / "task.toml", columns, values


def test_forces_and_friction_in_a_prismatic_joint_have_newtons(tmp_path):
    unknowns = ""
    for key in ("constant", "viscous"):
        unknowns += f'[unknowns.{key}]\npath = "frictions.rub.{key}"\nlower = 0.0\nupper = 1.0\n'
    path = pushed(tmp_path, unknowns)[0]
    (tmp_path / "pushed.toml").write_text(PUSHED + '[frictions.rub]\njoint = "O"\nconstant = 0.1\nviscous = 0.1\n')
    task = load_identification(path)
    units = {"force": "N", "speed": "m/s", "constant": "N", "viscous": "N s/m"}
    assert dict(zip(task.names, task.units(), strict=True)) == units


@pytest.mark.slow
def test_samples_of_a_linear_problem_have_its_normal_posterior(tmp_path):
    """x = v t + F t^2 / (2 m) + offset is linear in the values: mean and covariance are those of linear regression."""
    pytest.importorskip("emcee")
    path, columns, values = pushed(tmp_path)
    found = optim.identify(load_identification(path), samples=True)["posterior"]
    covariance = np.linalg.inv(columns.T @ columns) * 0.002**2
    mean = covariance @ columns.T @ values / 0.002**2
    samples = np.array(found["samples"])
    assert found["enough"]
    deviations = np.sqrt(np.diag(covariance))
    for k, one in enumerate(found["parameters"].values()):  # 16 walkers, 45 times: 700 independent samples
        assert one["median"] == pytest.approx(mean[k], abs=0.15 * deviations[k])
        assert one["deviation"] == pytest.approx(deviations[k], rel=0.1)
        reach = 1.96 * deviations[k]
        assert one["interval"] == pytest.approx([mean[k] - reach, mean[k] + reach], abs=0.3 * deviations[k])
    wanted = covariance[0, 1] / (deviations[0] * deviations[1])
    assert np.corrcoef(samples.T)[0, 1] == pytest.approx(wanted, abs=0.03)


def test_a_batch_has_the_sums_of_squares_of_single_runs_with_their_own_clocks_and_gains(tmp_path):
    task = TASK.replace("start = 210.0", "start = 210.0\nprior = [190.0, 5.0]")
    residuals = Residuals(load_identification(oscillator(tmp_path, task=task)))
    rng = np.random.default_rng(2)
    points = residuals.start + [0.02, 0.05, 1e-3, 0.02, 1e-3] * rng.uniform(-1.0, 1.0, (4, 5))
    sums = SumsOfSquares(residuals, 1.5, residuals.start, np.full(5, 1e-3))(points)
    assert sums == pytest.approx([np.sum(residuals(z, 1.5).residual ** 2) for z in points], rel=1e-6)


@pytest.mark.slow
def test_samples_follow_what_the_data_leave_open_up_to_the_limits(tmp_path):
    """Mass, stiffness and damping have a common factor that no position tells: its logarithm is uniform."""
    pytest.importorskip("emcee")
    task = TASK + '[unknowns.mass]\npath = "sdf.links.mass.mass"\nlower = 0.1\nupper = 2.0\n'
    for sensor in (', shift = "fit"', 'gain = "fit"\n', 'offset = "fit"\n'):
        task = task.replace(sensor, "")
    path, times = oscillator(tmp_path, task=task), np.linspace(0.01, 0.9, 60)
    (tmp_path / "oscillator.toml").write_text(EXPERIMENT.replace("1e-10", "1e-7"))
    values = 1e3 * oscillation(times) + 0.5 * np.random.default_rng(1).standard_normal(60)
    np.savetxt(tmp_path / "run.csv", np.column_stack([1e3 * times, values]), delimiter=",", header="t,x", comments="")
    found = optim.identify(load_identification(path), samples=True)
    assert not found["parameters"]["stiffness"]["identifiable"]
    sampled = found["posterior"]["parameters"]["stiffness"]  # between 100 and 500: the other limits are farther away
    ends = 100.0 * 5.0 ** np.array([0.5, 0.025, 0.975])
    assert [sampled["median"], *sampled["interval"]] == pytest.approx(ends.tolist(), rel=0.08)


def test_a_sampler_that_is_not_installed_is_named(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "emcee", None)
    path = oscillator(tmp_path)
    assert main(["identify", str(path), "--out", str(tmp_path / "out"), "--posterior"]) == 2
    assert capsys.readouterr().err == 'error: --posterior: needs emcee: pip install "linkages[posterior]"\n'


def test_deviations_that_the_file_leaves_open_come_from_the_residuals(tmp_path):
    found = optim.identify(load_identification(oscillator(tmp_path, task=TASK.replace("deviation = 0.5\n", ""))))
    assert found["residual"]["deviation"][0] == pytest.approx(5e-4, rel=0.1)


def test_a_wrong_model_is_not_silent(tmp_path):
    path = oscillator(tmp_path)
    times = np.linspace(0.01, 1.9, 400)
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    table[:, 1] += 4.0 * np.sin(40.0 * times)  # something acts that the model lacks [mm]
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    found = optim.identify(load_identification(path))
    assert "does not explain" in found["warnings"][0]
    assert any("not independent" in text for text in found["warnings"])


def test_mass_stiffness_and_damping_together_are_not_identifiable(tmp_path):
    more = TASK + '[unknowns.mass]\npath = "sdf.links.mass.mass"\nlower = 0.1\nupper = 2.0\n'
    found = optim.identify(load_identification(oscillator(tmp_path, task=more)))
    assert [one["identifiable"] for one in found["parameters"].values()] == [False, False, False]
    assert len(found["mixtures"]) == 1
    assert all(f"{name} (+1)" in found["mixtures"][0] for name in ("stiffness", "damping", "mass"))


@pytest.mark.parametrize("path", ["sdf.links.mass.inertia", "solver.accuracy"])  # no or hardly any derivative
def test_an_unknown_without_effect_is_named_and_disturbs_no_other(tmp_path, path):
    """SciPy's steps with derivatives of deficient rank are too long: the fit ended at a chi-square of 90."""
    more = TASK + f'[unknowns.idle]\npath = "{path}"\nlower = 1e-10\nupper = 1e-2\nstart = 1e-8\n'
    found = optim.identify(load_identification(oscillator(tmp_path, task=more)))
    assert [one["identifiable"] for one in found["parameters"].values()] == [True, True, False]
    assert found["residual"]["chi_square"][0] == pytest.approx(1.0, abs=0.25)  # 400 samples: 3.5 deviations
    assert found["runs"] < 15
    assert found["mixtures"] == ["idle (+1)"]


def test_an_output_that_is_zero_tells_no_gain(tmp_path):
    column = '[data.run.columns.y]\ncolumn = "x"\noutput = "mass.y"\nunit = "mm"\ngain = "fit"\ndeviation = 100.0\n'
    found = optim.identify(
        load_identification(
            oscillator(tmp_path, task=TASK.replace("[unknowns.stiffness]", f"{column}[unknowns.stiffness]"))
        )
    )
    assert found["nuisance"]["run.y.gain"]["deviation"] is None
    assert found["parameters"]["stiffness"]["identifiable"]


def test_a_fitted_experiment_has_the_values_that_the_file_sets_and_items_of_lists(tmp_path):
    task = TASK.replace("[data.run]", "[set]\nsprings.S.free_length = 0.9\n[data.run]")
    task += '[unknowns.anchor]\npath = "springs.S.anchor.0"\nlower = -1.1\nupper = -0.7\nstart = -0.9\n'
    assert main(["identify", str(oscillator(tmp_path, task=task)), "--out", str(tmp_path / "out"), "--no-plots"]) == 0
    fitted = linkages.load(tmp_path / "out" / "fitted.toml")
    found = json.loads((tmp_path / "out" / "result.json").read_text())["parameters"]["anchor"]["value"]
    assert fitted.value("springs.S.free_length") == 0.9
    assert fitted.value("springs.S.anchor.0") == found


def test_two_laws_are_compared_by_their_prediction(tmp_path):
    task = TASK + '[alternatives.undamped]\nset = { springs.S.damping = 0.0 }\nunknowns = ["stiffness"]\n'
    found = optim.identify(load_identification(oscillator(tmp_path, task=task)))
    assert found["best_alternative"] == "this"
    with_damping, without = (found["alternatives"][name]["prediction"]["rms"]["run.x"] for name in ("this", "undamped"))
    assert with_damping == pytest.approx(5e-4, rel=0.15)
    assert without > 10.0 * with_damping


def test_first_impacts_lead_from_a_factor_of_two_to_the_values_of_a_dry_joint(tmp_path):
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.002})
    outputs, times = ["slider.ax", "O.torque", "B.force"], np.arange(0.0, 0.002, 2e-5)
    curves = linkages.simulate(system, outputs=outputs).evaluate(times)
    sizes = [0.01 * np.std(curves[name]) for name in outputs]
    rng = np.random.default_rng(4)
    noisy = [curves[name] + size * rng.standard_normal(len(times)) for name, size in zip(outputs, sizes, strict=True)]
    np.savetxt(tmp_path / "run.csv", np.column_stack([times, *noisy]), delimiter=",", header="t,a,b,c", comments="")
    lines = ['experiment = "slider_crank_dry.toml"', "[data.run]", 'file = "run.csv"', 'time = "t"']
    for name, output, size in zip("abc", outputs, sizes, strict=True):
        lines += [f"[data.run.columns.{name}]", f'output = "{output}"', f"deviation = {size}"]
    values = {"joints.B.clearance": 5e-4, "joints.B.contact.restitution": 0.9}
    for k, (path, value) in enumerate(values.items()):
        lines += [f"[unknowns.u{k}]", f'path = "{path}"', f"lower = {value / 3}", f"upper = {min(3 * value, 0.99)}"]
        lines += [f"start = {value * (1.9, 0.52)[k]}"]
    (tmp_path / "task.toml").write_text("\n".join(lines))
    found = optim.identify(load_identification(tmp_path / "task.toml"))
    assert len(found["history"]) > 1
    assert found["fitted_until"] > 0.0019
    for one, value in zip(found["parameters"].values(), values.values(), strict=True):
        assert one["value"] == pytest.approx(value, abs=3.5 * one["deviation"])
        assert one["deviation"] < 1e-3 * value


def test_statistics_of_a_record_tell_the_values(tmp_path):
    task = TASK.replace(', shift = "fit"', f", shift = {SHIFT}").replace('gain = "fit"', f"gain = {GAIN}")
    found = optim.identify(
        load_identification(oscillator(tmp_path, task=task + '[fit]\nwindows = "statistics"\n')), threads=1
    )
    for name, true in (("stiffness", STIFFNESS), ("damping", DAMPING)):
        low, high = found["parameters"][name]["interval"]
        assert 0.6 * true < low < true < high < 1.6 * true
    position = found["statistics"]["run.x"]["measured"]  # of the column as it is in the file
    times = np.linspace(0.01, 1.9, 400)
    assert position["deviation"] == pytest.approx(np.std(reading(times)), rel=0.02)
    assert found["residual"]["samples"] == [4]


def test_statistics_find_the_mass_beyond_the_horizon(tmp_path):
    mass, restitution, outputs = 0.15, 0.8, ["slider.ax", "B.force"]
    values = {"sdf.links.slider.mass": mass, "joints.B.contact.restitution": restitution, "duration": 0.03}
    times = np.arange(0.0, 0.03, 4e-5)
    curves = linkages.simulate(linkages.load(linkages.find_file("slider_crank_dry.toml"), values), outputs=outputs)
    table = np.column_stack([times, *(curves.evaluate(times)[name] for name in outputs)])
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,a,f", comments="")
    (tmp_path / "task.toml").write_text(
        'experiment = "slider_crank_dry.toml"\nfit.windows = "statistics"\n[data.run]\nfile = "run.csv"\ntime = "t"\n'
        '[data.run.columns]\na = { output = "slider.ax" }\nf = { output = "B.force" }\n[unknowns.mass]\n'
        'path = "sdf.links.slider.mass"\nlower = 0.05\nupper = 0.3\nstart = 0.12\n[unknowns.restitution]\n'
        'path = "joints.B.contact.restitution"\nlower = 0.4\nupper = 0.99\nstart = 0.9\n'
    )
    found = optim.identify(load_identification(tmp_path / "task.toml"))["parameters"]
    assert found["mass"]["value"] == pytest.approx(mass, abs=3.0 * found["mass"]["deviation"])
    assert found["mass"]["deviation"] < 0.03 * mass
    assert found["restitution"]["value"] == pytest.approx(restitution, abs=0.1)


def test_statistics_have_no_posterior(tmp_path):
    task = TASK.replace(', shift = "fit"', "") + '[fit]\nwindows = "statistics"\n'
    with pytest.raises(linkages.InputError, match=r"no posterior|needs emcee"):
        optim.identify(load_identification(oscillator(tmp_path, task=task)), samples=True)


PLAN = """
[plan]
rate = 200.0
duration = 1.0
[plan.candidates.position]
output = "mass.x"
deviation = "0.5 mm"
[plan.candidates.speed]
output = "mass.vx"
deviation = 20.0
"""


def test_a_plan_states_the_deviation_that_a_sensor_will_give(tmp_path, capsys):
    oscillator(
        tmp_path, task=TASK.replace("start = 210.0", "start = 200.0").replace("start = 1.0", "start = 0.8") + PLAN
    )
    found = optim.plan(load_identification(tmp_path / "task.toml"))
    times = np.arange(0.0, 1.0 + 1e-9, 1 / 200.0)
    columns = [
        (oscillation(times, 200.0 * (1 + s), 0.8 * (1 + d)) - oscillation(times, 200.0 * (1 - s), 0.8 * (1 - d))) / 2e-5
        for s, d in ((1e-5, 0.0), (0.0, 1e-5))
    ]
    expected = np.sqrt(np.diag(np.linalg.inv(np.array(columns) @ np.array(columns).T / 5e-4**2)))
    single = {entry["sensors"][0]: entry for entry in found["settings"][0]["single"]}
    assert single["position"]["deviations"] == pytest.approx(expected.tolist(), rel=1e-4)
    assert single["speed"]["identifiable"] < 2
    assert "best: position" in optim.format_plan(found)


def test_a_plan_counts_gain_offset_clock_and_priors_as_the_fit(tmp_path):
    """The values of the closed form have gain 1, offset 0 and shift 0 here: those of a plan."""
    sensor = PLAN.replace('deviation = "0.5 mm"\n', 'deviation = "0.5 mm"\ngain = "fit"\noffset = "fit"\n')
    text = TASK.replace("start = 210.0", "start = 200.0").replace("start = 1.0", "start = 0.8\nprior = [0.8, 0.001]")
    oscillator(tmp_path, task=text + sensor.replace("rate = 200.0", 'rate = 200.0\nshift = "fit"'))
    found = optim.plan(load_identification(tmp_path / "task.toml"))["settings"][0]["single"][0]
    times = np.arange(0.0, 1.0 + 1e-9, 1 / 200.0)
    values = np.array([STIFFNESS, DAMPING, 1.0, 0.0, 0.0])
    columns = []
    for k, step in enumerate(1e-5 * np.array([STIFFNESS, DAMPING, 1.0, 1e-3, 1e-3])):
        move = step * np.eye(5)[k]
        columns.append((reading(times, *(values + move)) - reading(times, *(values - move))) / (2.0 * step))
    information = np.array(columns) @ np.array(columns).T / 5e-4**2
    information[1, 1] += 1.0 / 0.001**2  # the prior
    wanted = np.sqrt(np.diag(np.linalg.inv(information)))[:2] / values[:2]
    assert found["deviations"] == pytest.approx(wanted.tolist(), rel=1e-3)


def test_an_interrupted_search_ends_with_the_same_numbers(tmp_path):
    task = load_identification(oscillator(tmp_path, task=TASK + "[fit]\nstarts = 3\n"))
    whole = optim.identify(task, tmp_path / "one.json")
    kept = json.loads((tmp_path / "one.json").read_text())
    del kept["starts"][""]["1"]
    (tmp_path / "two.json").write_text(json.dumps(kept))
    resumed = optim.identify(task, tmp_path / "two.json", resume=True)
    for key in set(whole) - {"wall_time"}:
        assert resumed[key] == whole[key], key


def test_a_search_of_other_data_or_another_machine_is_not_resumed(tmp_path):
    path, kept = oscillator(tmp_path), tmp_path / "starts.json"
    optim.identify(load_identification(path), kept)
    oscillator(tmp_path, seed=2)
    with pytest.raises(linkages.InputError, match="is of another file or other data"):
        optim.identify(load_identification(path), kept, resume=True)
    oscillator(tmp_path)
    (tmp_path / "oscillator.sdf").write_text(SLIDER.replace("<mass>0.5", "<mass>0.6"))
    with pytest.raises(linkages.InputError, match="is of another file or other data"):
        optim.identify(load_identification(path), kept, resume=True)


def test_an_interrupted_posterior_goes_on_as_it_would_have(tmp_path, monkeypatch, capsys):
    pytest.importorskip("emcee")
    path, *_ = pushed(tmp_path, "posterior_runs = 1000\n")
    whole, parts = (tmp_path / name for name in ("whole", "parts"))
    arguments = ["identify", str(path), "--posterior", "--no-plots", "--out"]
    assert main([*arguments, str(whole)]) == 0
    calculate, counts = SumsOfSquares.__call__, []

    def counted(self, points, threads=None):
        counts.append(len(points))
        if len(counts) == 40:
            raise KeyboardInterrupt
        return calculate(self, points, threads)

    monkeypatch.setattr(SumsOfSquares, "__call__", counted)
    capsys.readouterr()
    assert main([*arguments, str(parts)]) == 130
    printed = capsys.readouterr()
    assert "interrupted" in printed.err
    assert "Traceback" not in printed.out + printed.err
    kept = parts / "posterior.bin"
    kept.write_bytes(kept.read_bytes()[:-3])  # a killed process may leave a part of a row
    assert main([*arguments, str(parts), "--resume"]) == 0
    one, two = (json.loads((folder / "result.json").read_text())["posterior"] for folder in (whole, parts))
    assert one == two
    assert kept.read_bytes() == (whole / "posterior.bin").read_bytes()
    again = counts[38] + counts[39]  # of the cut row, and of the interruption
    assert sum(counts) <= one["runs"] + one["walkers"] + again


def test_several_threads_find_the_same(tmp_path):
    task = load_identification(oscillator(tmp_path, task=TASK + "[fit]\nstarts = 3\n"))
    one, two = (optim.identify(task, threads=threads)["parameters"] for threads in (1, 2))
    assert one == two


@pytest.mark.slow
def test_the_press_of_the_tutorial_needs_a_probe_at_its_journal(tmp_path, monkeypatch):
    """The page's files and lines; the machine that was measured has the values `true`."""
    page = (Path(__file__).parents[2] / "docs" / "tutorial_identification.md").read_text(encoding="utf-8")
    machine, data, probe = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    names: dict = {}
    monkeypatch.chdir(tmp_path)
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], names)
    task = tmp_path / "press_fit.toml"
    task.write_text(machine + data)
    assert optim.plan(load_identification(task))["best"]["sensors"] == ["torque", "probe"]
    without = optim.identify(load_identification(task))
    assert [one["identifiable"] for one in without["parameters"].values()] == [True, False, True, True]
    relative = [one["deviation"] / one["value"] for one in without["parameters"].values()]
    assert relative[0] == pytest.approx(0.12, abs=0.03)  # as the page says
    assert relative[1] == pytest.approx(0.40, abs=0.08)
    for one in without["parameters"].values():
        assert one["interval"][0] < names["true"][one["path"]] < one["interval"][1]
    assert without["correlated"][0]["unknowns"] == ["clearance", "viscosity"]
    assert without["sensors"]  # further ones: the torque was measured
    assert not {"slider7.ax", "O1.torque"} & set(without["sensors"])
    task.write_text(machine + data + probe)
    found = optim.identify(load_identification(task))["parameters"]
    assert [one["path"] for one in found.values()] == list(names["true"])
    for one in found.values():
        assert one["value"] == pytest.approx(names["true"][one["path"]], abs=3.5 * one["deviation"])
        assert one["deviation"] < 0.003 * one["value"]


WRONG = {
    "no column": (TASK.replace("[data.run.columns.x]", "[data.run.columns.z]"), 'has no column "z"'),
    "wrong unit": (TASK.replace('unit = "mm"', 'unit = "kg"'), "unit of column"),
    "unknown output": (TASK.replace("mass.x", "mass.z"), '"mass.z"'),
    "unknown path": (TASK.replace("springs.S.damping", "springs.S.dumping"), "dumping"),
    "limits reversed": (TASK.replace("lower = 100.0", "lower = 600.0"), "must be below upper"),
    "start outside": (TASK.replace("start = 210.0", "start = 10.0"), "is not between"),
    "no data": ('experiment = "oscillator.toml"\n' + TASK[TASK.index("[unknowns.stiffness]") :], "data: is missing"),
    "a clock in statistics": (TASK + '[fit]\nwindows = "statistics"\n', "time.shift: is not in statistics"),
    "prediction of statistics": (TASK + '[fit]\nwindows = "statistics"\npredict = 0.5\n', "predicts no samples"),
    "a path twice": (TASK.replace("springs.S.damping", "springs.S.stiffness"), "have the same path"),
    "a cutoff of no period": (
        TASK.replace("deviation = 0.5", "deviation = 0.5\nfilter.cutoff = 1e-12"),
        "filter.cutoff, 1e-12 Hz, must be at least 0.529 Hz",
    ),
    "no gain": (TASK.replace('gain = "fit"', "gain = 0.0"), "gain is 0"),
    "nothing to vary": (
        TASK + "[plan]\nrate = 9.0\nvalues = [1.0]\ncandidates.a = {output='mass.x', deviation=1}",
        "both",
    ),
    "no plan": (TASK, "plan: is missing", "--plan"),
    "no noise": (TASK + PLAN.replace("0.5 mm", "-0.5 mm"), "must be positive", "--plan"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_files_are_refused_in_one_line(tmp_path, capsys, case):
    text, said, *options = WRONG[case]
    path = oscillator(tmp_path, task=text)
    arguments = ["identify", str(path), "--out", str(tmp_path / "out"), *options]
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


SPOILT = {
    "not a number": (lambda table: table[:, 1].__setitem__(5, np.nan), "row 6"),
    "not increasing": (lambda table: table[:, 0].__setitem__(5, 0.0), "do not increase"),
    "before the run": (lambda table: table[:, 0].__isub__(500.0), "is before the start of the run"),
    "wrong unit of times": (lambda table: table[:, 0].__imul__(1000.0), "beyond 100 times the duration"),
    "a huge cell": (lambda table: table[:, 1].__setitem__(5, 1e307), "1e+304 in row 6; at most 1e+100"),
    "all equal": (lambda table: table[:, 1].__setitem__(slice(None), 1.0), "say nothing"),
}


@pytest.mark.parametrize("case", SPOILT)
def test_spoilt_data_are_refused_in_one_line(tmp_path, capsys, case):
    path = oscillator(tmp_path)
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    spoil, said = SPOILT[case]
    spoil(table)
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    assert main(["identify", str(path), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_the_command_writes_result_experiment_and_figures(tmp_path, capsys):
    path = oscillator(tmp_path)
    assert main(["identify", str(path), "--out", str(tmp_path / "out"), "--profile"]) == 0
    written = {file.name for file in (tmp_path / "out").iterdir()}
    assert {"result.json", "starts.json", "fitted.toml", "fit.png", "correlation.png", "profiles.png"} <= written
    found = json.loads((tmp_path / "out" / "result.json").read_text())["parameters"]["stiffness"]
    assert linkages.load(tmp_path / "out" / "fitted.toml").value("springs.S.stiffness") == found["value"]
    assert "stiffness" in capsys.readouterr().out
    assert main(["identify", str(path), "--out", str(tmp_path / "out")]) == 2
    assert main(["identify", str(path), "--out", str(tmp_path / "out"), "--resume", "--no-plots"]) == 0


def test_a_filter_acts_on_data_and_run_alike(tmp_path):
    line = 'deviation = 0.5\nfilter = { kind = "butterworth", order = 3, cutoff = 30.0 }\n'
    found = optim.identify(load_identification(oscillator(tmp_path, task=TASK.replace("deviation = 0.5\n", line))))
    for name, true in (("stiffness", STIFFNESS), ("damping", DAMPING)):
        assert found["parameters"][name]["value"] == pytest.approx(true, abs=4 * found["parameters"][name]["deviation"])
    assert found["residual"]["autocorrelation_time"][0] > 2.0


def of_first_order(rng, count, rho):
    """Noise of variance 1 of which neighbours correlate by rho."""
    noise = np.sqrt(1.0 - rho**2) * rng.standard_normal(count)
    noise[0] = rng.standard_normal()
    return lfilter([1.0], [1.0, -rho], noise)


def test_the_autocorrelation_time_is_that_of_the_process():
    rng, rho = np.random.default_rng(0), 0.9
    assert correlation_of(of_first_order(rng, 200_000, rho)).time == pytest.approx((1 + rho) / (1 - rho), rel=0.1)
    assert correlation_of(rng.standard_normal(200_000)).time == 1.0


def test_the_covariance_of_correlated_residuals_is_that_of_their_process():
    rng, rho, count = np.random.default_rng(1), 0.9, 2000
    rows = np.column_stack([np.ones(count), np.sin(0.05 * np.arange(count)), np.sin(0.5 * np.arange(count))])
    sums = rows.T @ np.array([of_first_order(rng, count, rho) for _ in range(4000)]).T
    found = np.mean(
        [np.diag(coloured(rows, correlation_of(of_first_order(rng, count, rho)))) for _ in range(50)], axis=0
    )
    np.testing.assert_allclose(found, np.var(sums, axis=1), rtol=0.15)  # 50 estimates, 4000 sums


def test_intervals_hold_where_neighbouring_samples_have_nearly_the_same_noise(tmp_path):
    path, inside = oscillator(tmp_path), []
    times = np.linspace(0.01, 1.9, 400)
    for seed in range(40):
        noise = 5e-4 * of_first_order(np.random.default_rng(seed), 400, 0.99)
        table = np.column_stack([1e3 * times, 1e3 * (reading(times) + noise)])
        np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
        found = optim.identify(load_identification(path))
        for name, true in (("stiffness", STIFFNESS), ("damping", DAMPING)):
            low, high = found["parameters"][name]["interval"]
            inside.append(low <= true <= high)
    assert 0.88 <= np.mean(inside) <= 1.0


def test_samples_of_a_batch_are_those_of_the_run_and_end_where_it_ends():
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.004})
    times, outputs, path = np.linspace(0.0, 0.004, 9), ["B.force", "slider.x"], "joints.B.clearance"
    batch = linkages.simulate_batch(system, [path], [[5e-4], [4e-4]], outputs, samples=times)
    expected = linkages.simulate(system, outputs=outputs).evaluate(times)
    for k, output in enumerate(outputs):
        np.testing.assert_array_equal(batch.samples[0, :, k], expected[output])
    few = linkages.simulate_batch(system.replaced({"solver.max_steps": 60}), [path], [[5e-4]], outputs, samples=times)
    assert few.status[0] is linkages.Status.TOO_MANY_STEPS
    assert few.steps[0] == 60
    assert np.isfinite(few.samples[0, 0]).all()
    assert np.isnan(few.samples[0, -1]).all()


@pytest.mark.parametrize("samples", [[0.1, 0.05], [-1.0], [0.0, 10.0]])
def test_times_of_samples_are_checked(samples):
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    with pytest.raises(linkages.InputError, match="increasing times within the run"):
        linkages.simulate_batch(system, outputs=["A.force"], samples=samples)


def test_an_offset_far_from_zero_does_not_pull_the_other_values_away(tmp_path):
    """The zero of the sensor is 30 m away, 60,000 deviations; the offset is linear, so it is regressed at each design."""
    path = oscillator(tmp_path)
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    table[:, 1] += 3e4
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    found = optim.identify(load_identification(path))
    assert found["starts"]["count"] == 1
    assert found["runs"] < 15
    offset, gain = found["nuisance"]["run.x.offset"], found["nuisance"]["run.x.gain"]
    assert offset["value"] == pytest.approx(OFFSET - 30.0 * gain["value"], abs=1e-3)
    for name, true in (("stiffness", STIFFNESS), ("damping", DAMPING)):
        one = found["parameters"][name]
        assert one["value"] == pytest.approx(true, abs=3.5 * one["deviation"])


def test_regressed_gain_and_offset_are_the_best_of_their_design(tmp_path):
    residuals = Residuals(load_identification(oscillator(tmp_path)))
    best = residuals(residuals.start, 1.9, residuals.linear)
    sides = best.jacobian[:, residuals.linear]
    assert np.abs(sides.T @ best.residual).max() < 1e-9 * np.linalg.norm(sides) * np.linalg.norm(best.residual)
    np.testing.assert_allclose(residuals(best.z, 1.9).residual, best.residual, rtol=1e-9, atol=1e-9)


def test_a_design_that_does_not_run_shortens_the_step(tmp_path, monkeypatch):
    """Residuals are 20,000 deviations at the start: a constant of 1000 for the failed design would be a descent."""
    task = TASK.replace("start = 210.0", "start = 150.0").replace("deviation = 0.5", "deviation = 0.0005")
    residuals = Residuals(load_identification(oscillator(tmp_path, task=task, deviation=5e-7)))
    true, designs = Residuals._measurement, []

    def once(self, m, one, z, *others):
        designs.append(z.copy())
        if len(designs) == 2:
            raise linkages.RunError("it locks")
        return true(self, m, one, z, *others)

    monkeypatch.setattr(Residuals, "_measurement", once)
    found = Search(residuals, residuals.start, 0.4).solve()
    steps = [np.linalg.norm(z[:2] - designs[0][:2]) for z in designs[1:3]]
    assert steps[1] < 0.5 * steps[0]
    assert residuals.values(found.z)[0] == pytest.approx(STIFFNESS, rel=1e-3)


def test_the_error_of_the_runs_shifts_no_value(tmp_path):
    """Accuracy 1e-3 in the file: its errors are larger than the noise, so that the fit must choose a finer one."""
    path = oscillator(tmp_path, deviation=5e-6, task=TASK.replace("deviation = 0.5", "deviation = 0.005"))
    (tmp_path / "oscillator.toml").write_text(EXPERIMENT.replace("accuracy = 1e-10", "accuracy = 1e-3"))
    found = optim.identify(load_identification(path))
    assert found["accuracy"]["given"] == 1e-3
    assert found["accuracy"]["used"] < 1e-6
    assert found["accuracy"]["largest_shift"] < 0.1
    assert found["residual"]["chi_square"][0] == pytest.approx(1.0, abs=0.25)
    for name, true in (("stiffness", STIFFNESS), ("damping", DAMPING)):
        one = found["parameters"][name]
        assert one["value"] == pytest.approx(true, abs=3.5 * one["deviation"])
    assert "solver.accuracy is" in optim.format_identification(found)


def test_what_the_error_of_the_runs_leaves_is_in_the_intervals(tmp_path):
    residuals = Residuals(load_identification(oscillator(tmp_path)))
    found = fit_from(residuals, residuals.start, 1.9, "all")
    alone, shift = certainty(residuals, found, "white"), np.array([1e-3, 2e-3, 0.0, 0.0, 0.0])
    wider = certainty(residuals, found, "white", shift)
    np.testing.assert_allclose(wider.deviations**2, alone.deviations**2 + shift**2, rtol=1e-9)


def test_values_that_do_not_explain_the_data_have_no_deviation(tmp_path):
    """Another frequency than the data have: locally the offset seems known to a part in ten thousand."""
    far = TASK.replace("lower = 100.0\nupper = 500.0\nstart = 210.0", "lower = 2000.0\nupper = 5000.0\nstart = 4500.0")
    residuals = Residuals(load_identification(oscillator(tmp_path, task=far)))
    judged = certainty(residuals, found := fit_from(residuals, residuals.start, 1.9, "all"), "autocorrelated")
    assert np.isnan(judged.deviations).all()
    assert not judged.identifiable.any()
    assert "do not explain the data" in doubts(residuals, found, judged)[0]


def test_sensors_that_change_with_an_unknown_value_have_no_deviation(tmp_path):
    """The mass of a free slider with a known force and an unknown gain: only their product is told."""
    path, *_ = pushed(tmp_path)
    text = LINEAR.replace('offset = "fit"', 'gain = "fit"').replace("lower = -10.0", "lower = 0.1")
    path.write_text(text.replace("lower = -5.0", "lower = 0.01"))
    found = optim.identify(load_identification(path))
    assert found["parameters"]["force"]["deviation"] is None
    assert found["nuisance"]["run.x.gain"]["deviation"] is None


def test_correlated_values_keep_their_deviations(tmp_path):
    """Force and speed of the slider over a short time: they correlate by 0.97, each is known to some per cent."""
    path, columns, _ = pushed(tmp_path)
    path.write_text(LINEAR.replace('offset = "fit"\n', "").replace("deviation = 0.002", "deviation = 0.02"))
    columns = columns[:, :2]
    noise = 0.02 * np.random.default_rng(5).standard_normal(60)
    table = np.column_stack([np.linspace(0.0, 1.5, 60), columns @ [0.7, 0.2] + noise])
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    found = optim.identify(load_identification(path))
    covariance = 0.02**2 * np.linalg.inv(columns.T @ columns)
    deviations = np.sqrt(np.diag(covariance))
    for one, deviation in zip(found["parameters"].values(), deviations, strict=True):
        assert one["deviation"] == pytest.approx(deviation, rel=1e-3)
    (pair,) = found["correlated"]
    wanted = covariance[0, 1] / np.prod(deviations)
    assert pair["unknowns"] == ["force", "speed"]
    assert pair["correlation"] == pytest.approx(wanted, abs=1e-6)
    assert pair["apart"] == pytest.approx(np.sqrt(1.0 - wanted**2), abs=1e-6)


def test_a_value_without_deviation_has_no_interval(tmp_path):
    """Stiffness correlates with damping, damping with an angle that the data do not tell: no number, not NaN."""
    angle = '[unknowns.angle]\npath = "drives.O.angle"\nlower = 0.05\nupper = 0.2\n'
    residuals = Residuals(load_identification(oscillator(tmp_path, task=TASK + angle)))
    found = fit_from(residuals, residuals.start, 1.9, "all")
    room = (residuals.upper - residuals.lower)[:3]
    scale = np.diag(room * [0.01, 0.01, 1.0])
    covariance = scale @ [[1.0, 0.95, 0.85], [0.95, 1.0, 0.95], [0.85, 0.95, 1.0]] @ scale
    jacobian = np.zeros_like(found.evaluated.jacobian)
    jacobian[:3, :3], jacobian[3:6, 3:] = np.linalg.cholesky(np.linalg.inv(covariance)).T, 1e3 * np.eye(3)
    found = replace(found, evaluated=replace(found.evaluated, jacobian=jacobian))
    judged = certainty(residuals, found, "white")
    assert np.isnan(judged.deviations[:3]).all()
    assert not judged.told.any()
    assert not judged.identifiable.any()


def test_all_residuals_count_as_one_at_most():
    """A random walk of 300 residuals: its memory is longer than the record."""
    walk = np.cumsum(np.random.default_rng(1).standard_normal(300))
    assert correlation_of(walk).time <= 300.0


def test_a_posterior_of_filtered_data_with_a_fitted_clock_has_the_residuals_of_the_fit(tmp_path):
    """The first samples may lie before the run's start: the filter's transient needs them in batches, too."""
    line = 'deviation = 0.5\nfilter = { kind = "butterworth", order = 2, cutoff = 20.0 }\n'
    path = oscillator(tmp_path, task=TASK.replace("deviation = 0.5\n", line))
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    table[:, 0] -= 10.0 + 1e3 * SHIFT  # the first sample is taken at the start of the run, as far as is known
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    residuals = Residuals(load_identification(path))
    points = np.tile(residuals.start, (4, 1))
    points[:, residuals.of_kind("shift")] = np.array([[-2e-3], [-5e-4], [0.0], [1e-3]])
    sums = SumsOfSquares(residuals, 1.5, residuals.start, np.full(5, 2e-3))(points)
    assert sums == pytest.approx([np.sum(residuals(z, 1.5).residual ** 2) for z in points], rel=1e-5)


def test_a_limit_of_time_ends_the_search_with_its_best_values(tmp_path):
    far = TASK.replace("upper = 500.0\nstart = 210.0", "upper = 5000.0\nstart = 4500.0") + "[fit]\ntime = 1e-9\n"
    found = optim.identify(load_identification(oscillator(tmp_path, task=far)))
    assert found["runs"] < 10
    assert any("limit of time" in text for text in found["warnings"])
    assert "stiffness" in optim.format_identification(found)


@pytest.mark.parametrize(
    ("limit", "of_a_run"), [("", 30.0), ("[fit]\ntime = 7.0\n", 1.0), ("[fit]\ntime = 7.0\n", 20.0)]
)
def test_a_fit_ends_at_its_limit_of_time_and_the_present_run_however_slow_runs_are(
    tmp_path, monkeypatch, limit, of_a_run
):
    """The clock goes on with each run, as on a busy machine; the default limit is 50 s."""
    now, run = [0.0], curves.differentiated

    def slow(*given):
        now[0] += of_a_run
        return run(*given)

    monkeypatch.setattr(curves, "differentiated", slow)
    monkeypatch.setattr(budget, "clock", lambda: now[0])
    far = TASK.replace("upper = 500.0\nstart = 210.0", "upper = 5000.0\nstart = 4500.0") + limit
    found = optim.identify(load_identification(oscillator(tmp_path, task=far)))
    assert now[0] <= (7.0 if limit else 50.0) + of_a_run
    assert found.time_over
    assert any("ended the fit" in text for text in found.warnings)


def test_a_fit_that_converges_within_its_limit_is_not_said_to_be_ended_by_it(tmp_path, monkeypatch):
    monkeypatch.setattr(budget, "clock", lambda: 0.0)
    found = optim.identify(load_identification(oscillator(tmp_path)))
    assert not found.time_over
    assert not any("limit of time" in text for text in found.warnings)


def test_many_samples_within_a_step_have_the_values_and_derivatives_of_single_ones():
    """Polynomials through ten nodes: 4000 samples in steps of some hundred, at their starts too."""
    system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"), {"duration": 0.004})
    paths, outputs = ["joints.B.clearance", "sdf.links.slider.mass"], ["slider.ax", "B.force"]
    run = linkages.simulate(system, outputs=outputs, wrt=paths)
    times = np.union1d(np.linspace(0.0, 0.004, 4000), run.time[:-1])
    values = np.array([system.value(path) for path in paths])
    found = curves.Curves(system, paths, values, [(output, times) for output in outputs], moved=False)
    for output in outputs:
        computed, rates, _ = found(output, times)
        exact = run.evaluate(times)[output]
        assert np.max(np.abs(computed - exact)) < 1e-5 * np.sqrt(np.mean(exact**2))
        for k, path in enumerate(paths):
            exact = run.sensitivity.evaluate(times)[path][output]
            assert np.max(np.abs(rates[:, k] - exact)) < 1e-5 * np.sqrt(np.mean(exact**2))


def test_every_result_says_what_its_intervals_assume(tmp_path):
    found = optim.identify(load_identification(oscillator(tmp_path)))
    assert "only if the laws of the model are those of the machine" in optim.format_identification(found)
    assert found["residual"]["model_error"] == [None]


def test_the_error_of_the_model_is_estimated_from_the_residuals(tmp_path):
    """A force that the model lacks moves the mass by 4 mm sin(40 t): an rms of 2.8 mm beside noise of 0.5 mm."""
    path, times = oscillator(tmp_path), np.linspace(0.01, 1.9, 400)
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    table[:, 1] += 4.0 * np.sin(40.0 * times)
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    found = optim.identify(load_identification(path))
    assert found["residual"]["model_error"][0] == pytest.approx(4e-3 / np.sqrt(2.0), rel=0.1)


def test_a_poor_fit_that_may_be_no_minimum_states_no_deviation(tmp_path):
    """Residuals of 5.7 deviations: a model with an error if all starts agree and end, else a wrong minimum."""
    path, times = oscillator(tmp_path), np.linspace(0.01, 1.9, 400)
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    table[:, 1] += 4.0 * np.sin(40.0 * times)
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,x", comments="")
    residuals = Residuals(load_identification(path))
    found = fit_from(residuals, residuals.start, 1.9, "all")
    assert np.isfinite(certainty(residuals, found, "autocorrelated").deviations).all()
    assert np.isnan(certainty(residuals, found, "autocorrelated", unsure=True).deviations).all()


def test_a_poor_fit_that_the_limit_of_time_has_ended_states_no_deviation(tmp_path):
    """One run at a start 2 % away: the spread of its residuals gives 0.5 N/m, but the start is 4 N/m off."""
    task = TASK.replace("start = 210.0", f"start = {1.02 * STIFFNESS}").replace("start = 1.0", f"start = {DAMPING}")
    found = optim.identify(load_identification(oscillator(tmp_path, task=task + "[fit]\ntime = 1e-9\n")))
    assert all(row["deviation"] is None for row in found["parameters"].values())
    assert any("the limit of time" in line for line in found["warnings"])


def test_other_laws_that_predict_as_well_tell_the_error_of_a_value(tmp_path):
    task = TASK + "[alternatives.thicker]\nset = { sdf.links.mass.mass = 0.5005 }\n"
    found = optim.identify(load_identification(oscillator(tmp_path, task=task)))
    away = STIFFNESS * 0.001  # the frequency tells the ratio of stiffness and mass
    assert found["other_laws"]["stiffness"] == pytest.approx(away, rel=0.05)


def test_integrals_find_a_dry_joint_with_an_unknown_clock_gain_and_offset(tmp_path):
    values = {"joints.B.clearance": 3e-4, "joints.B.contact.restitution": 0.7, "duration": 0.003}
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), values)
    outputs, times, shift = ["slider.ax", "B.force"], np.arange(0.0, 0.0025, 2e-5), 5e-5
    curves = linkages.simulate(system, outputs=outputs).evaluate(times + shift)
    rng, columns, lines = np.random.default_rng(2), [], ['experiment = "slider_crank_dry.toml"', "[data.run]"]
    lines += ['file = "run.csv"', 'time = { column = "t", shift = "fit" }']
    for name, output, gain in zip("ab", outputs, (0.85, 1.0), strict=True):
        size = 0.01 * np.std(curves[output])
        offset = 20.0 * size
        columns.append((curves[output] + size * rng.standard_normal(len(times)) - offset) / gain)
        lines += [f"[data.run.columns.{name}]", f'output = "{output}"', f"deviation = {size / gain}", 'offset = "fit"']
        lines += ['gain = "fit"'] if gain != 1.0 else []
    for k, (path, lower, upper, start) in enumerate(
        [("joints.B.clearance", 1e-4, 1e-3, 5.5e-4), ("joints.B.contact.restitution", 0.3, 0.98, 0.9)]
    ):
        lines += [f"[unknowns.u{k}]", f'path = "{path}"', f"lower = {lower}", f"upper = {upper}", f"start = {start}"]
    np.savetxt(tmp_path / "run.csv", np.column_stack([times, *columns]), delimiter=",", header="t,a,b", comments="")
    (tmp_path / "task.toml").write_text("\n".join(lines))
    found = optim.identify(load_identification(tmp_path / "task.toml"))
    rows = [*found["parameters"].values(), found["nuisance"]["run.shift"], found["nuisance"]["run.a.gain"]]
    for one, true in zip(rows, [3e-4, 0.7, shift, 0.85], strict=True):
        assert one["value"] == pytest.approx(true, abs=4.0 * one["deviation"])


def test_a_cell_that_overflows_in_its_unit_is_named(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("t [s],f [kN]\n0,1\n1,1e307\n2,3\n")
    with pytest.raises(ValueError, match=r'column "f" has 1e\+307 kN in row 2, too large in N'):
        read_recording(path).column("f", "N")


def test_the_fitted_experiment_finds_the_data_files_of_its_drives(tmp_path):
    """It is written into another folder than the experiment."""
    path = oscillator(tmp_path)
    text = EXPERIMENT.replace("torque = 0.0\n", 'file = "push.csv"\ntorque = "push"\ndeviation = 0.0\n')
    (tmp_path / "oscillator.toml").write_text(text)
    push = np.column_stack([np.linspace(0.0, 2.5, 20), np.zeros(20)])
    np.savetxt(tmp_path / "push.csv", push, delimiter=",", header="time,push", comments="")
    assert main(["identify", str(path), "--out", str(tmp_path / "out" / "result"), "--no-plots"]) == 0
    fitted = linkages.load(tmp_path / "out" / "result" / "fitted.toml")
    assert linkages.simulate(fitted, "compiled").time[-1] == 2.0
