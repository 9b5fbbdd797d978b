"""``linkages bearing``: published tables, an independent solver, stability, the command."""

import json
import math

import numpy as np
import pytest
from machines import four_bar

import linkages
from linkages import InputError, RunError
from linkages.cli.main import main
from linkages.explore.bearing import BearingCase, chart
from linkages.laws.film.surface.equilibrium import stability
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.viscosity import density, iso_vg_viscosity

PAIR = [Groove(side * 0.5 * math.pi, math.radians(20.0)) for side in (1.0, -1.0)]

#: J. W. Lund and K. K. Thomsen, A calculation method and data for the dynamic coefficients of oil-lubricated journal
#: bearings, in: Topics in fluid film bearing and rotor bearing system design, ASME 1978: two axial grooves of 20 degrees.
#: L/D, S, eps, attitude [deg], Kxx, Kxy, Kyx, Kyy (c/W), Bxx, Bxy, Byy (c omega/W).
LUND_THOMSEN = [
    (0.5, 0.917, 0.372, 57.45, 2.12, 4.01, -1.30, 1.85, 7.70, 2.06, 3.23),
    (0.5, 0.379, 0.570, 45.43, 3.33, 3.64, -0.43, 1.68, 6.76, 1.87, 1.89),
    (0.5, 0.244, 0.655, 40.25, 4.21, 3.74, -0.13, 1.64, 6.87, 1.82, 1.54),
    (1.0, 0.991, 0.150, 70.58, 1.56, 7.29, -2.16, 1.52, 14.66, 1.58, 4.49),
    (1.0, 0.159, 0.559, 44.33, 2.73, 3.36, -0.48, 1.48, 6.94, 1.78, 1.74),
]


def loaded(slenderness, sommerfeld, grooves, cells=(160, 12), **options):
    """An operating point of a bearing of 0.1 m at this Sommerfeld number, and c/W."""
    diameter, clearance, mu, omega = 0.1, 1e-4, 0.03, 100.0
    load = mu * omega / (2.0 * math.pi) * diameter**2 * slenderness / sommerfeld * (0.5 * diameter / clearance) ** 2
    point = linkages.bearing(
        diameter, slenderness * diameter, clearance, mu, omega, load, grooves=grooves, cells=cells, **options
    )
    assert point.sommerfeld == pytest.approx(sommerfeld, rel=1e-12)
    return point, clearance / load


@pytest.mark.parametrize("row", LUND_THOMSEN)
def test_two_axial_grooves(row):
    """To 0.01 in eccentricity, 0.5 degrees, 6 % of a coefficient, and the table's last digit: Kyx is small."""
    slenderness, sommerfeld, eps, angle, *expected = row
    point, unit = loaded(slenderness, sommerfeld, PAIR, cavitation="mass-conserving")
    assert point.eccentricity_ratio == pytest.approx(eps, abs=0.01)
    assert math.degrees(point.attitude) == pytest.approx(angle, abs=0.5)
    stiffness, damping = point.coefficients
    found = [*(unit * stiffness).ravel(), *(100.0 * unit * damping).ravel()[[0, 1, 3]]]
    assert found == pytest.approx(expected, rel=0.06, abs=0.005)


def coupling_ratio(slenderness, half):
    """Kyx/Kxy of a full film between two axial grooves, on an arc of two halves [rad], for a light load; exact.

    The pressure of a unit displacement solves -(p_tt + p_zz) = cos t or sin t, zero at grooves and ends: a series of
    cosines over the length. Kxy is the integral of its product with cos t, Kyx that with sin t, of the opposite sign.
    """
    totals = np.zeros(2)
    for n in range(1, 400, 2):
        k = n * math.pi / (2.0 * slenderness)
        sine, cosine, edge = math.sin(half), math.cos(half), math.tanh(k * half)
        even = half + sine * cosine - 2.0 * cosine * (sine + k * cosine * edge) / (1.0 + k * k)
        odd = half - sine * cosine - 2.0 * sine * (k * sine / edge - cosine) / (1.0 + k * k)
        totals += np.array([even, odd]) * 8.0 / (n * math.pi) ** 2 / (1.0 + k * k)
    return -totals[1] / totals[0]


@pytest.mark.parametrize("extent", [10.0, 20.0])
@pytest.mark.parametrize(("slenderness", "sommerfeld"), [(0.5, 60.0), (1.0, 20.0)])
def test_cross_coupling_at_small_eccentricity(extent, slenderness, sommerfeld):
    """The linear theory of a light load; eccentricity ratio 0.008."""
    pair = [groove._replace(extent=math.radians(extent)) for groove in PAIR]
    stiffness, _ = loaded(slenderness, sommerfeld, pair, cavitation="mass-conserving")[0].coefficients
    expected = coupling_ratio(slenderness, math.radians(90.0 - 0.5 * extent))
    assert stiffness[1, 0] / stiffness[0, 1] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(("mils", "eps"), [(1.8, 0.03), (2.0, 0.04)])
def test_threshold_of_two_axial_grooves(mils, eps):
    """Nicholas, Barrett and Leader 1980, table 6, set A: 1 inch, 29.8 lbf on two bearings, 8000 r/min, S = 5.3, 4.3.

    The paper does not give the viscosity; all Sommerfeld numbers of its table follow from 7.60 microreyn. To the last
    digit printed.
    """
    clearance, viscosity = mils * 25.4e-6, 7.60e-6 * 6894.757
    point = linkages.bearing(
        0.0254, 0.0254, clearance, viscosity, 8000.0 * math.pi / 30.0, 66.278,
        grooves=PAIR, cells=(160, 12), cavitation="mass-conserving",
    )  # fmt: skip
    assert point.eccentricity_ratio == pytest.approx(eps, abs=0.005)
    assert point.content["threshold_speed"] * math.sqrt(clearance / 9.80665) == pytest.approx(2.1, abs=0.05)


@pytest.mark.parametrize(
    ("ratio", "sommerfeld", "eps", "attitude"),
    [(0.5, 1.24, 0.3, 64.1), (0.5, 0.323, 0.6, 44.7), (1.0, 0.194, 0.5, 49.1)],
)
def test_a_printed_table_of_bearings_with_two_grooves(ratio, sommerfeld, eps, attitude):
    """Someya 1989, two axial grooves of 10 degrees: S has three digits; attitudes of the whole table differ by up to 1.3."""
    grooves = [groove._replace(extent=math.radians(10.0)) for groove in PAIR]
    viscosity, clearance, omega = 0.03, 50e-6, 100.0
    load = viscosity * omega / (2.0 * math.pi) * 0.1 * 0.1 * ratio * (0.05 / clearance) ** 2 / sommerfeld
    point = linkages.bearing(0.1, 0.1 * ratio, clearance, viscosity, omega, load, grooves=grooves, cells=(160, 12))
    assert point.eccentricity_ratio == pytest.approx(eps, abs=0.002)
    assert math.degrees(point.attitude) == pytest.approx(attitude, abs=1.0)


def test_coefficients_of_an_independent_solver():
    """Mass-conserving, grid-converged: L/D 1, c 50 um, 24087 N, two grooves 80 % long with 1e5 Pa; to 2 %."""
    grooves = [groove._replace(length=0.8, pressure=1e5) for groove in PAIR]
    point = linkages.bearing(0.1, 0.1, 50e-6, 0.03, 100.0, 24087.0, grooves=grooves, cells=(200, 14))
    assert point.eccentricity_ratio == pytest.approx(0.5, abs=0.0025)
    assert math.degrees(point.attitude) == pytest.approx(47.695, abs=0.1)
    content, unit = point.content, 50e-6 / 24087.0
    assert content["flow"] == pytest.approx(5.2982e-6, rel=5e-3)
    assert content["friction_torque"] == pytest.approx(4.9933, rel=5e-3)
    assert content["largest_pressure"] == pytest.approx(5.6462e6, rel=5e-3)
    assert sum(content["groove_flow"]) == pytest.approx(content["flow"], rel=1e-9)
    assert content["mass_imbalance"] < 1e-10
    film = point.film  # the cavity fills at what the grooves give
    lacking = (
        (1.0 - film.content)
        * film.mesh.width[:, None]
        * film.mesh.height
        * (1.0 - film.thickness.x * np.cos(film.mesh.theta) - film.thickness.y * np.sin(film.mesh.theta))[:, None]
    )
    inflow = sum(flow for flow in content["groove_flow"] if flow > 0.0)
    assert content["filling_time"] == pytest.approx(2.0 * lacking.sum() * 50e-6 * 0.05**2 / inflow, rel=0.01)
    stiffness, damping = point.coefficients
    assert (unit * stiffness).ravel() == pytest.approx([2.351, 3.423, -0.655, 1.511], rel=0.02)
    assert (100.0 * unit * damping).ravel() == pytest.approx([7.034, 1.845, 1.852, 1.989], rel=0.02)


def test_the_threshold_is_where_an_eigenvalue_crosses():
    """The matrix of the free journal has a purely imaginary pair at the critical mass, at the whirl frequency."""
    stiffness, damping = np.array([[2.35, 3.42], [-0.65, 1.51]]), np.array([[7.03, 1.85], [1.85, 1.99]])
    mass, ratio = stability(stiffness, damping)
    for factor, sign in ((0.9, -1.0), (1.0, 0.0), (1.1, 1.0)):
        m = factor * mass
        matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness / m, -damping / m]])
        values = np.linalg.eigvals(matrix)
        growth = values.real.max()
        assert np.sign(growth) == sign if sign else abs(growth) < 1e-12
        if not sign:
            assert abs(values[np.argmax(values.real)].imag) == pytest.approx(ratio)
    assert math.isinf(stability(np.eye(2), np.eye(2)).critical_mass)  # without cross-coupling nothing whirls


def test_a_short_film_meets_its_closed_forms():
    """Ocvirk: tan(attitude) = pi sqrt(1 - eps^2)/(4 eps); the solver of the surface agrees for L/D = 0.1."""
    closed, _ = loaded(0.1, 20.0, [], film="short")
    eps = closed.eccentricity_ratio
    assert math.tan(closed.attitude) == pytest.approx(math.pi * math.sqrt(1.0 - eps**2) / (4.0 * eps), rel=1e-6)
    solved, _ = loaded(0.1, 20.0, [], cavitation="guembel")
    assert solved.eccentricity_ratio == pytest.approx(eps, rel=0.02)
    assert solved.attitude == pytest.approx(closed.attitude, rel=0.02)


def test_the_sense_of_the_groove_angle():
    """A groove in the converging gap ahead of the pressure feeds it; the same one mirrored cuts into the pressure."""
    ahead, behind = (loaded(0.5, 0.5, [Groove(math.radians(angle), 0.3)])[0] for angle in (-110.0, 110.0))
    assert ahead.eccentricity_ratio != pytest.approx(behind.eccentricity_ratio, rel=0.05)
    assert ahead.content["flow"] > 0.0


def test_a_chart_passes_through_the_operating_point():
    grooves = (Groove(math.pi, 0.35),)
    point, _ = loaded(0.5, 0.3, grooves, cells=(72, 6))
    curves = chart(BearingCase(0.1, 0.05, 1e-4, 0.03, 100.0, 1.0, grooves=grooves))
    found = np.interp(math.log(0.3), np.log(curves["sommerfeld"][::-1]), curves["eccentricity_ratio"][::-1])
    assert found == pytest.approx(point.eccentricity_ratio, abs=0.01)


WORDS = [
    "bearing",
    "--diameter",
    "0.1",
    "--length",
    "0.05",
    "--clearance",
    "1e-4",
    "--viscosity",
    "0.03",
    "--speed",
    "100",
    "--load",
    "1000",
]
KEYS = {
    "eccentricity_ratio", "attitude", "sommerfeld", "flow", "groove_flow", "friction_torque", "largest_pressure",
    "stiffness", "damping", "threshold_speed", "status",
}  # fmt: skip


def test_the_command_writes_numbers_and_figures(tmp_path, capsys):
    groove = ["--groove", "angle = 180 deg, extent = 20 deg, length = 0.8", "--supply-pressure", "1 bar"]
    assert main([*WORDS, *groove, "--out", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "bearing.json").read_text())
    assert set(found) >= KEYS
    point = linkages.bearing(
        0.1, 0.05, 1e-4, 0.03, 100.0, 1000.0, grooves=[Groove(math.pi, math.radians(20.0), 0.8, 1e5)]
    )
    assert found["eccentricity_ratio"] == pytest.approx(point.eccentricity_ratio, rel=1e-9)
    assert found["status"] == "ok"
    assert {file.name for file in (tmp_path / "out").iterdir()} >= {"bearing_chart.png", "bearing_pressure.png"}
    assert "attitude" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--groove", "angle=0, extent=1, length=2"], "at most 1, the length of the bearing"),
        (["--groove", "angle=180 deg, extent=0"], "groove 1: extent 0 rad: must be above 0"),
        (["--groove", "angle=0, extent=1, length=0"], "groove 1: length 0: must be above 0"),
        (["--groove", "angle=0, extent=1", "--supply-pressure=-1e4"], "must not be below the cavity pressure"),
        (["--supply-pressure", "1e5"], "--supply-pressure: 1e5: is the pressure of grooves; give --groove"),
        (["--tilt", "0.1, 0"], "the journal touches the bearing"),
        (["--cavitation", "mass-conserving"], "add a groove, set a cavity pressure below 0, or choose"),
        (["--groove", "angle=0"], "extent: is missing"),
        (["--groove", "angle=180, extent=20 deg"], 'must be within a turn; give degrees with their unit: "180 deg"'),
        (["--groove", "angle=0, extent=1 kg"], "must be measured in rad"),
        (["--film", "short", "--groove", "angle=0, extent=1"], "choose film finite"),
        (["--speed", "quick"], 'is "quick"; give a number'),
        (["--load=-1"], "must be positive"),
        (["--grade", "46"], "give the viscosity, or --grade with --inlet"),
        (["--inlet", "40"], "--inlet: 40: is for a heat balance; give --grade"),
    ],
)
def test_bad_input_is_one_line(words, text, tmp_path, capsys):
    right = list(WORDS)
    if words[0].partition("=")[0] in right:  # an option is given once
        del right[(k := right.index(words[0].partition("=")[0])) : k + 2]
    assert main([*right, *words, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert text in said[0]
    assert not (tmp_path / "out").exists()


def test_a_vanishing_tilt_is_the_untilted_bearing():
    """The whole length is solved instead of its half: eccentricity and stiffness to 0.1 %."""
    tilted, plain = (linkages.bearing(0.1, 0.05, 1e-4, 0.03, 100.0, 1000.0, tilt=(t, 0.0)) for t in (1e-9, 0.0))
    assert tilted.eccentricity_ratio == pytest.approx(plain.eccentricity_ratio, rel=1e-3)
    np.testing.assert_allclose(tilted.coefficients.stiffness, plain.coefficients.stiffness, rtol=1e-3)


def test_the_heat_balance_closes():
    """Power equals removed heat; without flow to carry it, conduction alone gives T = T_surroundings + P/G."""
    heat = linkages.Heat(46, 40.0, conductance=2.0, surroundings=20.0)
    groove = [Groove(math.pi, math.radians(20.0), 0.8)]
    warm = linkages.warm_bearing(heat, 0.1, 0.05, 1e-4, speed=100.0, load=1000.0, grooves=groove, cells=(72, 6))
    content, rho = warm.content, density(warm.temperature)
    assert content["heat"]["by_flow"] == pytest.approx(
        rho * 2000.0 * content["flow"] * (warm.temperature - 40.0), rel=1e-9
    )
    assert content["heat"]["by_conduction"] == pytest.approx(2.0 * (warm.temperature - 20.0))
    assert content["power"] == pytest.approx(sum(content["heat"][k] for k in ("by_flow", "by_conduction")), rel=0.02)
    assert content["viscosity"] == pytest.approx(iso_vg_viscosity(46, warm.temperature))
    cooled = linkages.warm_bearing(
        linkages.Heat(46, 40.0, conductance=1e3), 0.1, 0.05, 1e-4, 100.0, 1000.0, grooves=groove, cells=(72, 6)
    )
    assert cooled.temperature == pytest.approx(40.0, abs=0.3)


def test_an_unknown_grade_is_refused(tmp_path, capsys, experiment_file):
    words = [word for word in WORDS if word not in ("--viscosity", "0.03")]
    assert main([*words, "--grade", "33", "--inlet", "40", "--out", str(tmp_path / "out")]) == 2
    assert "ISO VG 33: must be one of 10, 15" in capsys.readouterr().err
    oil = 'duration = 1.0\n[joints.A]\nmodel = "lubricated"\nclearance = 1e-4\n'
    path = experiment_file(four_bar(), oil + "oil = {grade = 33, temperature = 40.0}\n")
    assert main(["simulate", str(path), "--out", str(tmp_path / "run")]) == 2
    assert "joints.A.oil.grade: ISO VG 33 is no grade; one of 10, 15" in capsys.readouterr().err


def test_a_load_beyond_the_film_fails_with_a_remedy():
    with pytest.raises(RunError, match="lower the load"):
        linkages.bearing(0.1, 0.05, 1e-4, 0.03, 100.0, 1e12)
    with pytest.raises(InputError, match="clearance"):
        linkages.bearing(0.1, 0.05, 0.06, 0.03, 100.0, 1.0)
