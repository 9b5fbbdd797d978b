"""Heat balance of the oil in joints of a machine: closed forms, the static bearing, limits, invalid input."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from machines import rotor_in_block, written

import linkages
from linkages.cli.main import main
from linkages.laws.heat import NEAR, Heat
from linkages.laws.viscosity import density, iso_vg_viscosity
from linkages.results.films import heat_warnings

RADIUS, LENGTH, CLEARANCE, SPEED, LOAD = 0.01, 0.02, 5e-5, 1000.0, 500.0
TOML = f"""duration = 0.0630
drives.O = {{speed = {SPEED}}}
forces.F = {{point = "block", force = [0.0, {LOAD}]}}
start = "equilibrium"
[joints.A]
model = "lubricated"
clearance = {CLEARANCE}
oil = {{grade = "ISO VG 46", temperature = 60.0}}
heat = {{inlet = 40.0, conductance = 0.5, surroundings = 20.0}}
"""


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """Study of the rotor with other values of its heat balance; each is computed once."""

    @cache
    def make(engine="compiled", sdf=None, **values):
        path = written(tmp_path_factory.mktemp("rotor"), sdf or rotor_in_block(), TOML)
        overrides = {f"joints.A.heat.{key}": value for key, value in values.items()}
        return linkages.assess(linkages.load(path, overrides), engine, error_estimate=False)

    return make


@pytest.mark.parametrize("engine", ["compiled", pytest.param("drake", marks=pytest.mark.slow)])
def test_a_rotor_has_the_temperature_of_the_static_bearing(warm, engine):
    """The cycle's equilibrium is the operating point of `linkages.warm_bearing`, which solves for it directly."""
    found = linkages.summarize(warm(engine=engine))["joints"]["A"]
    heat = found["heat"]
    expected = linkages.warm_bearing(
        Heat(46, 40.0, conductance=0.5, surroundings=20.0),
        2.0 * RADIUS,
        LENGTH,
        CLEARANCE,
        SPEED,
        LOAD,
        cells=(120, 10),
    )
    assert heat["temperature"] == pytest.approx(expected.temperature, abs=0.1)
    assert expected.temperature > 45.0
    assert found["eccentricity_ratio"]["peak"] == pytest.approx(expected.bearing.eccentricity_ratio, rel=5e-3)
    assert heat["power"] == pytest.approx(expected.content["power"], rel=5e-3)
    assert heat["flow"] == pytest.approx(expected.content["flow"], rel=1e-2)
    assert heat["viscosity"] == pytest.approx(iso_vg_viscosity(46, heat["temperature"]))
    assert heat["model"] == "lumped"


def test_power_equals_the_removed_heat(warm):
    """The balance closes to the accuracy of the temperature; each part is its closed form."""
    heat = warm().heat["A"]
    t, rho = heat.temperature, density(heat.temperature)
    assert heat.by_flow == pytest.approx(rho * 2000.0 * heat.flow * (t - 40.0), rel=1e-12)
    assert heat.by_conduction == pytest.approx(0.5 * (t - 20.0), rel=1e-12)
    assert abs(heat.change) < NEAR
    falls = heat.power * 0.05 + rho * 2000.0 * heat.flow + 0.5  # W/K: power falls by less than 5 % per kelvin
    assert abs(heat.power - heat.by_flow - heat.by_conduction) < NEAR * falls


def test_without_fresh_oil_conduction_removes_all(warm):
    """T = T_surroundings + P/G."""
    sealed = warm(fresh=0.0, conductance=2.0).heat["A"]
    assert sealed.by_flow == 0.0
    assert sealed.temperature == pytest.approx(20.0 + sealed.power / 2.0, abs=0.1)


def test_infinite_conduction_is_the_supply_temperature(warm):
    held = warm(conductance=1e7, surroundings=40.0)
    assert held.heat["A"].temperature == pytest.approx(40.0, abs=1e-4)
    plain = held.system.replaced({"joints.A.oil.temperature": 40.0})
    cold = linkages.simulate(plain)["A.eccentricity_ratio"][-1]
    assert held.run["A.eccentricity_ratio"][-1] == pytest.approx(cold, rel=1e-4)


def test_the_body_with_the_bearing_does_not_matter(warm):
    """A bearing that turns about a journal at rest is the same film seen from a turning frame."""
    still, turning = warm().heat["A"], warm(sdf=rotor_in_block("rotor", "block")).heat["A"]
    for name in ("temperature", "power", "flow"):
        assert getattr(turning, name) == pytest.approx(getattr(still, name), rel=2e-4)


def test_a_short_bearing_loses_the_difference_of_its_shear_flows(system_of):
    """Ocvirk: the film brings U L h_max/2 to the pressure and takes U L h_min/2 away; out of the ends flow U L c eps."""
    system = system_of(
        rotor_in_block(length=0.001), TOML, {"forces.F.force": [0.0, 0.2], "joints.A.oil.temperature": 40.0}
    )
    run = linkages.simulate(system)
    flows = run["A.flow"][run.time > 0.03]
    eps = float(run["A.eccentricity_ratio"][-1])
    assert 0.1 < eps < 0.9
    assert flows == pytest.approx(np.full(len(flows), SPEED * RADIUS * 0.001 * CLEARANCE * eps), rel=0.01)


def test_warnings_of_a_balance(warm):
    heat = warm().heat["A"]
    assert heat_warnings({"A": heat}) == []
    restless, wandering = heat_warnings({"A": replace(heat, balanced=heat.temperature + 3.0, cyclic=False)})
    assert "3 K in A" in restless["what"]
    assert "does not repeat" in wandering["what"]


def test_a_simulation_reports_the_temperature(experiment_file, tmp_path, capsys):
    path = experiment_file(rotor_in_block(), TOML)
    assert main(["simulate", str(path), "--no-plots", "--no-animation", "--out", str(tmp_path / "run")]) == 0
    text = capsys.readouterr().out
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    heat = summary["joints"]["A"]["heat"]
    assert "oil (lumped heat balance)" in text
    assert f"{heat['temperature']:.4g}" in text
    assert summary["provenance"]["experiment"]["joints"]["A"]["oil"]["temperature"] == heat["temperature"]
    assert summary["provenance"]["sources"]["joints.A.oil.temperature"] == "heat balance"
    assert main(["report", str(tmp_path / "run")]) == 0
    page = (tmp_path / "run" / "report.html").read_text()
    assert "lumped heat balance" in page


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"joints.A.oil.grade": 33}, "joints.A.oil.grade: ISO VG 33 is no grade; one of 10, 15"),
        ({"joints.A.oil.grade": "ISO VG 33"}, "joints.A.oil.grade: ISO VG 33 is no grade; one of 10, 15"),
        ({"joints.A.heat.conductance": -1.0}, "joints.A.heat.conductance"),
        ({"joints.A.heat.fresh": 1.5}, "joints.A.heat.fresh"),
        ({"joints.A.heat.inlet": 300.0}, "joints.A.heat.inlet"),
        ({"joints.A.film": "long"}, 'heat needs film "finite"'),
        ({"joints.A.shear_torque": False}, "heat needs shear_torque"),
    ],
)
def test_invalid_values_are_refused(experiment_file, tmp_path, capsys, change, text):
    """One line and status 2, nothing written."""
    path, ((key, value),) = experiment_file(rotor_in_block(), TOML), change.items()
    given = f'{key}="{value}"' if isinstance(value, str) else f"{key}={str(value).lower()}"
    assert main(["simulate", str(path), "--set", given, "--out", str(tmp_path / "run")]) == 2
    said = capsys.readouterr().err.strip()
    assert text in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "run").exists()


def test_heat_that_nothing_removes_ends_in_one_line(warm):
    with pytest.raises(linkages.RunError, match="no heat balance below 250 degC"):
        warm(fresh=0.0, conductance=1e-3)


def test_a_heat_balance_needs_an_oil(system_of):
    oil = 'oil = {grade = "ISO VG 46", temperature = 60.0}'
    with pytest.raises(linkages.InputError, match="heat needs oil"):
        system_of(rotor_in_block(), TOML.replace(oil, "viscosity = 0.03"))
