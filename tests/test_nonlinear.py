"""Nonlinear dynamics: sections, sweeps, Lyapunov exponents and spectra against closed forms and SciPy."""

import csv
import json

import numpy as np
import pytest
from machines import bar, joint, model, slider_crank
from scipy.integrate import solve_ivp, trapezoid
from shipped import shipped

from linkages import (
    InputError,
    Status,
    crossings,
    impacts,
    largest_exponent,
    simulate,
    simulate_batch,
    spectrum,
    stroboscopic,
    sweep,
)
from linkages.cli.main import main
from linkages.explore.flow import Flow, lasting, period_of
from linkages.explore.sections import horizon
from linkages.results.trajectory import sample
from linkages.show.plots import bifurcation_figure, exponent_figure, section_figure, spectrum_figure

# A bar that hangs on the tip of a turning crank, with a damper to the world. SI units.
CRANK, LENGTH, MASS, SPEED, GRAVITY = 0.2, 0.4, 0.5, 5.0, 9.81
INERTIA = MASS * LENGTH**2 / 3.0  # about the pin
PERIOD = 2.0 * np.pi / SPEED
START = (-np.pi / 2, SPEED)  # hanging, the pin at rest: the bar turns with the crank


@pytest.fixture
def pendulum(system_of):
    def make(damping):
        body = (
            bar("crank", CRANK, "__model__", mass=0.3)
            + bar("rod", LENGTH, "crank_tip", -np.pi / 2, mass=MASS)
            + joint("O", "world", "crank")
            + joint("A", "crank_tip", "rod")
        )
        text = f"""duration = 1.0
gravity = [0.0, {-GRAVITY}, 0.0]
outputs = ["rod.angle"]
[drives.O]
speed = {SPEED}
[torsion_springs.damper]
links = ["world", "rod"]
stiffness = 0.0
free_angle = 0.0
damping = {damping}
"""
        return system_of(model("pendulum", body), text)

    return make


def pendulum_rate(damping, t, angle, rate):
    """Angular acceleration of the bar and its derivative by the angle: moments about the pin, which accelerates."""
    arm, centripetal = MASS * LENGTH / 2.0, CRANK * SPEED**2
    moment = -arm * GRAVITY * np.cos(angle) + arm * centripetal * np.sin(SPEED * t - angle) - damping * rate
    slope = arm * GRAVITY * np.sin(angle) - arm * centripetal * np.cos(SPEED * t - angle)
    return moment / INERTIA, slope / INERTIA


def variational_exponent(damping, revolutions, transient):
    """Largest exponent of the pendulum and its standard error, from the variational equation [1/s]."""

    def rate(t, y):
        angle, speed, a, b = y
        acceleration, slope = pendulum_rate(damping, t, angle, speed)
        return [speed, acceleration, b, slope * a - damping / INERTIA * b]

    y, logarithms = np.array([*START, 1.0, 0.0]), []
    for turn in range(transient + revolutions):
        run = solve_ivp(rate, (turn * PERIOD, (turn + 1) * PERIOD), y, method="DOP853", rtol=1e-7, atol=1e-8)
        y = run.y[:, -1]
        logarithms.append(np.log(np.hypot(y[2], y[3])))
        y[2:] /= np.hypot(y[2], y[3])
    growth = np.array(logarithms[transient:]) / PERIOD
    blocks = [block.mean() for block in np.array_split(growth, 10)]
    return growth.mean(), np.std(blocks, ddof=1) / np.sqrt(10.0)


def test_exponent_of_a_damped_pendulum_that_swings_with_its_crank(pendulum):
    # two multipliers that are real and not equal: the larger one, from the variational equation
    expected, _ = variational_exponent(0.05, 100, 30)
    found = largest_exponent(pendulum(0.05), revolutions=100, transient=30)
    assert found.value == pytest.approx(expected, rel=1e-4)


def test_exponent_of_a_damped_pendulum_that_spirals_in(pendulum):
    # the multipliers are a complex pair, each of a magnitude that the flow's divergence, -damping/inertia, gives
    found = largest_exponent(pendulum(0.2), revolutions=150, transient=30)
    assert found.value == pytest.approx(-0.5 * 0.2 / INERTIA, rel=0.01)


@pytest.mark.slow
def test_exponent_of_a_chaotic_pendulum(pendulum):
    damping, revolutions = 0.01, 300
    found = largest_exponent(pendulum(damping), revolutions=revolutions, transient=50)
    expected, error = variational_exponent(damping, revolutions, 50)
    assert expected > 5.0 * error
    assert found.value > 5.0 * found.error
    assert abs(found.value - expected) < 4.0 * np.hypot(error, found.error)
    assert found.running[-1] == pytest.approx(found.value)


def test_exponent_does_not_depend_on_how_it_is_computed(pendulum):
    system = pendulum(0.05)
    first = largest_exponent(system, 60, 30)
    other = largest_exponent(system, 60, 30, distance=1e-6, renormalisations=7)
    assert first.value == pytest.approx(other.value, rel=1e-3)


@pytest.mark.slow
def test_dry_joints_are_chaotic_without_friction_and_not_with_much():
    little, much = (
        largest_exponent(
            shipped("slider_crank_dry", **{"joints.B.friction.coefficient": mu}), 20, 10, renormalisations=40
        )
        for mu in (1e-9, 0.1)
    )
    assert little.value > 5.0 * little.error
    assert much.value < -5.0 * much.error


def test_section_is_what_scipy_gives(pendulum):
    tight = pendulum(0.05).replaced({"solver.accuracy": 1e-11})
    found = stroboscopic(tight, ["rod.angle", "rod.omega"], 5, 2)

    def rate(t, y):
        return [y[1], pendulum_rate(0.05, t, *y)[0]]

    ends = PERIOD * np.arange(3, 8)
    run = solve_ivp(rate, (0.0, ends[-1]), START, method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True)
    np.testing.assert_allclose(found.times, ends, rtol=1e-14)
    np.testing.assert_allclose(found.strobe["rod.angle"], run.sol(ends)[0], rtol=1e-8)
    np.testing.assert_allclose(found.strobe["rod.omega"], run.sol(ends)[1], rtol=1e-8)
    for k, end in enumerate(ends):
        fine = run.sol(np.linspace(end - PERIOD, end, 20001))[1]
        assert found.low["rod.omega"][k] == pytest.approx(fine.min(), rel=1e-6)
        assert found.high["rod.omega"][k] == pytest.approx(fine.max(), rel=1e-6)


def test_stopping_at_sections_does_not_change_a_dry_run():
    system = shipped("slider_crank_dry", **{"solver.accuracy": 1e-10})
    names = ["B.force", "B.ex", "B.eccentricity_ratio", "slider.ax", "O.torque"]
    found = stroboscopic(system, names, 1)
    run = simulate(lasting(system, 1.0), "compiled")
    for name in names:
        assert found.strobe[name][0] == pytest.approx(run[name][-1], rel=1e-9)
    hardest = max(row.peak_force for row in impacts(run, ["B"]))
    assert found.peaks("B.force")[0] == pytest.approx(hardest, rel=1e-6)


@pytest.mark.parametrize("rising", [True, False])
def test_crossings_of_a_known_signal(rising):
    def evaluate(times):
        return {"time": times, "x": np.sin(times), "y": times**2}

    run = sample(np.linspace(0.0, 40.0, 301), evaluate, Status.OK, {})
    found = crossings(run, "x", 0.5, rising, start=1.0)
    first = np.arcsin(0.5) if rising else np.pi - np.arcsin(0.5)
    expected = first + 2.0 * np.pi * np.arange(8)
    expected = expected[(expected > 1.0) & (expected < 40.0)]
    np.testing.assert_allclose(found["time"], expected, rtol=1e-12)
    np.testing.assert_allclose(found["y"], expected**2, rtol=1e-12)


@pytest.mark.slow
def test_friction_lengthens_the_horizon_and_so_does_accuracy():
    def turns(friction, accuracy):
        changed = {"joints.B.friction.coefficient": friction, "solver.accuracy": accuracy}
        return horizon(shipped("slider_crank_dry", **changed), 12.0)

    assert turns(0.1, 1e-11) == 12.0
    assert turns(1e-9, 1e-11) < 5.0
    assert turns(0.03, 1e-8) < turns(0.03, 1e-12) < 12.0


def test_stops_have_no_part_in_the_horizon():
    """One that nothing reaches changes a horizon as another accuracy does; without other freedom nothing diverges.

    Errors of a run are a part of its least clearance or depth of contact, here a third with the stop.
    """
    law = {"law": "flores", "restitution": 0.6, "stiffness": 1e9}
    stop = {"joint": "guide", "side": "upper", "limit": 1.0, "contact": law}
    with_stop, alone = (horizon(shipped("slider_crank_dry", **one), 1.0) for one in ({"stops.end": stop}, {}))
    assert with_stop == pytest.approx(alone, abs=0.1)
    assert horizon(shipped("slider_crank_dry", **{"stops.end": stop, "joints": {}}), 1.0) == 1.0


def test_a_motion_that_the_drives_determine_has_no_exponent():
    with pytest.raises(InputError, match=r"drives: they determine the whole motion, so nothing can diverge"):
        largest_exponent(shipped("slider_crank_dry", joints={}), 2)


def test_spectrum_of_two_tones_and_its_integral():
    def evaluate(times):
        return {"time": times, "x": 5.0 + 3.0 * np.sin(2 * np.pi * 12.0 * times) + np.cos(2 * np.pi * 40.0 * times)}

    run = sample(np.linspace(0.0, 4.0, 101), evaluate, Status.OK, {})
    found = spectrum(run, "x", 1.0, 3000, segments=5)
    assert found.frequency[np.argmax(found.density)] == pytest.approx(12.0, abs=0.6)
    power = trapezoid(found.density, found.frequency)
    assert power == pytest.approx(3.0**2 / 2 + 1.0 / 2, rel=0.02)  # variances of the tones; the mean is gone
    for window in ("zz", "kaiser"):  # the second one needs a parameter
        with pytest.raises(InputError, match=rf'argument: window: "{window}" is unknown or needs parameters'):
            spectrum(run, "x", window=window)


def test_sweep_does_not_depend_on_the_number_of_threads():
    system, speeds = shipped("slider_crank_dry"), [200.0, 400.0, 600.0]
    one, three = (sweep(system, "drives.O.speed", speeds, ["B.force"], 3, 1, threads=n) for n in (1, 3))
    for a, b, speed in zip(one.points, three.points, speeds, strict=True):
        assert a.value == speed
        assert a.section.period == pytest.approx(2.0 * np.pi / speed)
        np.testing.assert_array_equal(a.section.strobe["B.force"], b.section.strobe["B.force"])
        np.testing.assert_array_equal(a.section.peaks("B.force"), b.section.peaks("B.force"))
    assert one.points[0].section.peaks("B.force").max() < one.points[2].section.peaks("B.force").min()


def test_sections_of_a_sweep_are_those_of_single_runs_and_the_windows_of_a_batch():
    """To the last bit; a run that fails keeps the revolutions before."""
    system, path, names = shipped("slider_crank_dry"), "joints.B.clearance", ["B.force", "slider.ax"]
    values = [1e-4, 3e-4]
    found = sweep(system, path, values, names, 3, 1, threads=2)
    period = period_of(system)
    windows = period * np.array([[1.0, 2.0], [2.0, 3.0], [3.0, 4.0]])
    batch = simulate_batch(lasting(system, 4), [path], np.array(values)[:, None], names, windows)
    for k, (value, point) in enumerate(zip(values, found.points, strict=True)):
        alone = stroboscopic(system.replaced({path: value}), names, 3, 1)
        for i, name in enumerate(names):
            for what, table in (("strobe", batch.last), ("low", batch.minimum), ("high", batch.maximum)):
                section = getattr(point.section, what)[name]
                np.testing.assert_array_equal(section, getattr(alone, what)[name])
                np.testing.assert_array_equal(section, table[k, :, i])


def test_a_section_keeps_the_revolutions_before_a_failure():
    """A force that begins in the third revolution tears the journal out of its film."""
    push = {"point": "slider", "times": [0.0, 0.03, 0.031, 1.0], "forces": [[0.0, 0.0]] * 2 + [[-1e9, 0.0]] * 2}
    torn = shipped("slider_crank_lubricated", **{"forces.push": push})
    section = stroboscopic(torn, ["B.force"], 3, 1)
    assert section.status is not Status.OK
    assert section.times == pytest.approx([2.0 * section.period])
    whole = stroboscopic(shipped("slider_crank_lubricated"), ["B.force"], 1, 1)
    for what in ("strobe", "low", "high"):
        assert getattr(section, what)["B.force"] == pytest.approx(getattr(whole, what)["B.force"], rel=1e-3)


def test_sweep_over_a_value_of_the_machine():
    system = shipped("slider_crank_lubricated")
    mass = system.mechanism.link["slider"].mass
    found = sweep(system, "sdf.links.slider.mass", [mass, 2.0 * mass], ["B.force"], 1)
    light, heavy = (point.section.peaks("B.force")[0] for point in found.points)
    assert heavy > 1.5 * light


@pytest.mark.parametrize("duration", [0.5, 10.0], ids=["shorter than a period", "of many periods"])
def test_a_sweep_of_a_drive_that_oscillates_goes_by_its_periods(system_of, duration):
    """The crank of a slider-crank swings by 0.4 rad at 7 rad/s: so do its angle and its speed in every period."""
    text = f'duration = {duration}\n[drives.O]\nformula = "0.4*sin(7*t)"\n'
    system = system_of(slider_crank(), text)
    assert period_of(system) == period_of(system, "O") == pytest.approx(2.0 * np.pi / 7.0, rel=1e-9)
    names = ["crank.angle", "crank.omega", "slider.x"]
    found = sweep(system, "sdf.links.slider.mass", [0.1, 0.2], names, 3, 1)
    for point in found.points:
        assert point.section.times == pytest.approx(2.0 * np.pi / 7.0 * np.arange(2, 5))
        assert point.section.high["crank.angle"] == pytest.approx(0.4, rel=1e-6)
        assert point.section.low["crank.angle"] == pytest.approx(-0.4, rel=1e-6)
        assert point.section.peaks("crank.omega") == pytest.approx(2.8, rel=1e-6)
        assert point.section.strobe["slider.x"] == pytest.approx(0.17, abs=1e-7)


def test_a_sweep_of_a_drive_by_a_table_ends_with_the_table(system_of):
    times = np.linspace(0.0, 4.0, 1601)
    drive = f"times = {times.tolist()}\nangles = {(0.3 * np.cos(np.pi * times)).tolist()}\n"
    system = system_of(slider_crank(), f"duration = 4.0\n[drives.O]\n{drive}")
    assert period_of(system) == pytest.approx(2.0, rel=1e-6)
    assert stroboscopic(system, ["crank.omega"], 2).peaks("crank.omega") == pytest.approx(0.3 * np.pi, rel=1e-4)
    with pytest.raises(InputError, match=r"drives\.O\.times: end at 4 s, before the duration of 6 s"):
        stroboscopic(system, ["crank.omega"], 3)


def test_a_drive_that_never_repeats_its_motion_has_no_revolution(system_of):
    system = system_of(slider_crank(), 'duration = 1.0\n[drives.O]\nformula = "0.1*t**2"\n')
    with pytest.raises(InputError, match="no drive has constant speed or is periodic"):
        period_of(system)
    with pytest.raises(InputError, match=r"drives\.O: does not repeat its motion"):
        period_of(system, "O")


def test_every_value_of_vary_is_checked_under_its_own_name(tmp_path, capsys):
    words = ["sweep", "slider_crank_dry.toml", "--vary", "joints.B.clearance=1e-4:-1e-4:3", "--out", str(tmp_path)]
    assert main(words) == 2
    assert capsys.readouterr().err.startswith("error: --vary: joints.B.clearance: is ")


def test_an_interrupted_sweep_keeps_the_values_that_are_finished(monkeypatch):
    monkeypatch.setattr("linkages.engines.threads._LOOK", 1e-3)
    system, speeds = shipped("slider_crank_dry"), np.linspace(100.0, 300.0, 12)

    def interrupted_at(part):
        def look(done):
            if done >= part:
                raise KeyboardInterrupt

        settings = {"horizons": True, "threads": 1, "progress": look}
        return sweep(system, "drives.O.speed", speeds, ["B.force"], 1, **settings)

    whole = interrupted_at(2.0)
    assert whole.status is Status.OK
    assert all(point.horizon is not None for point in whole.points)
    among_sections, among_horizons = interrupted_at(0.3), interrupted_at(0.75)
    assert among_sections.status is among_horizons.status is Status.INTERRUPTED
    assert all(point.horizon is None for point in among_sections.points)
    assert any(point.section is not None for point in among_sections.points)
    for found in (among_sections, among_horizons):
        for one, other in zip(found.points, whole.points, strict=True):
            if one.status is not Status.INTERRUPTED:
                assert one.section.strobe["B.force"].tobytes() == other.section.strobe["B.force"].tobytes()
                assert one.horizon in (None, other.horizon)
    with pytest.raises(KeyboardInterrupt):
        interrupted_at(0.0)


def test_sweep_keeps_the_runs_that_fail():
    system = shipped("slider_crank_lubricated")
    viscosity = system.value("joints.B.viscosity")
    found = sweep(system, "joints.B.viscosity", [1e-4 * viscosity, viscosity], ["B.force"], 1)
    assert [point.status for point in found.points] == [Status.JOURNAL_LEFT_BEARING, Status.OK]
    assert [len(point.section.times) for point in found.points] == [0, 1]


@pytest.mark.parametrize(
    ("path", "value", "name", "says"),
    [
        ("drives.O.sped", 1.0, "B.force", "speed"),
        ("drives.O.speed", 0.0, "B.force", "no drive has constant speed or is periodic"),
        ("joints.B.clearance", -1.0, "B.force", "greater than 0"),
        ("drives.O.speed", 1.0, "B.farce", "B.force"),
    ],
)
def test_a_sweep_of_nonsense_is_refused_before_it_runs(path, value, name, says):
    with pytest.raises(InputError, match=says):
        sweep(shipped("slider_crank_dry"), path, [value], [name], 1)


def test_named_columns_are_those_of_all_columns():
    flow = Flow(lasting(shipped("seven_bar_mixed"), 1.0))
    piece = flow.advance(1e-3)
    times = np.linspace(0.0, 1e-3, 7)
    everything = flow.columns(piece, times)
    names = [
        *(f"A.{what}" for what in ("ex", "ey", "force", "eccentricity_ratio", "penetration", "sliding")),
        *("slider7.x", "slider7.vx", "slider7.alpha", "O1.torque"),
    ]
    for name in names:
        np.testing.assert_allclose(flow.columns(piece, times, [name])[name], everything[name], rtol=1e-12, atol=1e-18)
    run = simulate(shipped("seven_bar_mixed", duration=1e-3), "compiled")
    np.testing.assert_allclose(everything["A.force"][-1], run["A.force"][-1], rtol=1e-4)


def test_command_writes_tables_and_a_figure(tmp_path, capsys):
    arguments = ["--vary", "drives.O.speed=200:600:3", "--revolutions", "4", "--transient", "1", "--output"]
    assert main(["sweep", "slider_crank_dry.toml", *arguments, "B.force", "--out", str(tmp_path)]) == 0
    assert "looser accuracy agree for" in capsys.readouterr().out
    with open(tmp_path / "sweep.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["drives.O.speed"]) for row in rows] == [200.0, 400.0, 600.0]
    content = json.loads((tmp_path / "sweep.json").read_text())
    for row, point in zip(rows, content["points"], strict=True):
        highest = np.array(point["outputs"]["B.force"]["max"])
        assert float(row["B.force.peak_mean"]) == pytest.approx(highest.mean())
        assert float(row["B.force.peak_std"]) == pytest.approx(np.std(highest, ddof=1))
        assert 0.0 < float(row["horizon"]) < 5.0
    assert (tmp_path / "sweep.png").stat().st_size > 10_000


def test_a_sweep_over_friction_begins_without_any(tmp_path):
    arguments = ["--vary", "joints.B.friction.coefficient=0:0.1:2", "--revolutions", "1", "--transient", "0"]
    words = ["sweep", "slider_crank_dry.toml", *arguments, "--output", "B.force", "--no-plots"]
    assert main([*words, "--out", str(tmp_path)]) == 0
    points = json.loads((tmp_path / "sweep.json").read_text())["points"]
    smooth, rough = (np.array(point["outputs"]["B.force"]["max"]) for point in points)
    free = stroboscopic(shipped("slider_crank_dry", **{"joints.B.friction.law": "none"}), ["B.force"], 1, 0)
    np.testing.assert_array_equal(smooth, free.high["B.force"])
    assert (rough != smooth).all()


@pytest.mark.parametrize(
    "vary", ["drives.O.speed", "drives.O.speed=1:2", "drives.O.speed=1:2:1", "drives.O.speed=1:2:1e9", "=1:2:3"]
)
def test_a_range_that_is_none_is_refused(vary, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["sweep", "slider_crank_dry.toml", "--vary", vary, "--out", str(out)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(("command", "vary"), [("sweep", "200:400:2"), ("continue", "200:400")])
def test_a_study_of_no_outputs_is_refused(command, vary, tmp_path, capsys):
    none = ["--set", "outputs=[]", "--set", "joints={}"]
    words = [command, "slider_crank_dry.toml", *none, "--vary", f"drives.O.speed={vary}"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 2
    assert "outputs: are none; name one with --output" in capsys.readouterr().err


def test_one_revolution_has_no_spread_and_a_wrong_path_is_told_at_once(tmp_path, capsys):
    words = ["sweep", "slider_crank_dry.toml", "--revolutions", "1", "--transient", "0", "--output", "B.force"]
    words.append("--no-plots")
    assert main([*words, "--vary", "drives.O.speed=200:400:2", "--out", str(tmp_path)]) == 0
    assert "±" not in capsys.readouterr().out
    with open(tmp_path / "sweep.csv", newline="", encoding="utf-8") as file:
        assert [row["B.force.peak_std"] for row in csv.DictReader(file)] == ["", ""]
    assert main([*words, "--vary", "drives.O.sped=1:2:2", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == 'error: --vary: drives.O.sped: unknown key; did you mean "speed"?\n'


def test_figures_say_what_they_show(pendulum):
    system = pendulum(0.05)
    found = sweep(system, "drives.O.speed", [4.0, 5.0], ["rod.angle"], 3)
    exponent = largest_exponent(system, 10)
    run = simulate(lasting(system, 4.0), "compiled")
    strobe = found.points[0].section.strobe
    frequency = 1.0 / period_of(system)
    figures = {
        "angle of rod [rad]": section_figure(strobe, "rod.angle", "rod.angle", ("rad", "rad")),
        "angle of rod [rad]\npeak of each revolution": bifurcation_figure(found, {"rod.angle": "rad"}),
        "largest Lyapunov exponent\n[1/revolution]": exponent_figure({"damped": exponent}),
        "angle of rod:\npower spectral density [(rad)²/Hz]": spectrum_figure(
            {"damped": spectrum(run, "rod.angle")}, "rad", frequency
        ),
    }
    for label, figure in figures.items():
        assert figure.axes[-1].get_ylabel() == label
        assert figure.axes[-1].get_xlabel()
    wide = bifurcation_figure(found, {"rod.angle": "rad"}, logarithmic=["rod.angle"])
    assert wide.axes[-1].get_yscale() == "log"
