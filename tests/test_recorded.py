"""Signals from data files: drives, torques and forces; synthetic encoder data of a known motion."""

import re

import numpy as np
import pytest
from machines import FLYWHEEL
from scipy.io import savemat

import linkages
from linkages.cli.main import main
from linkages.engines.assessment import assess
from linkages.input.files.recorded import read_recording
from linkages.results.outputs.columns import columns

COUNTS = 4096
PERIOD = 0.4973  # s, of a turn: no multiple of the sampling interval
OMEGA = 2.0 * np.pi / PERIOD
FLUCTUATION, PHASE = 0.15, 0.7
ANGLE = f"0.3 + {OMEGA!r}*t + {FLUCTUATION}*sin({OMEGA!r}*t + {PHASE})"
STEP = 2.0 * np.pi / COUNTS


def angle(t):
    """The known motion."""
    return 0.3 + OMEGA * t + FLUCTUATION * np.sin(OMEGA * t + PHASE)


def counted(t):
    """The angle that an encoder of `COUNTS` counts gives."""
    return STEP * np.round(angle(t) / STEP)


def written(path, **columns):
    """Write columns as comma-separated values."""
    np.savetxt(path, np.column_stack(list(columns.values())), "%.12g", ",", header=",".join(columns), comments="")
    return path


@pytest.fixture
def driven(tmp_path):
    """Make the ideal four-bar with a drive by the lines of its table."""

    def driven(lines, duration=PERIOD, more=""):
        path = tmp_path / "driven.toml"
        sdf = linkages.find_file("four_bar.sdf")
        path.write_text(f'mechanism = "{sdf}"\nduration = {duration!r}\n{more}\n[drives.O]\n{lines}\n')
        return linkages.load(path)

    return driven


def encoder(tmp_path, turns=2.0, rate=1000.0):
    t = np.arange(0.0, turns * PERIOD, 1.0 / rate)
    written(tmp_path / "encoder.csv", t=t, phi=counted(t))


FROM_FILE = f'file = "encoder.csv"\ntime = "t"\nangle = "phi"\nresolution = "{COUNTS}/rev"'


def torque_error(system, exact, ends=0.0):
    """Largest error of the drive torque over its peak, without parts of the run at its ends."""
    end = min(one.experiment.duration for one in (system, exact))
    times = np.linspace(ends * end, (1.0 - ends) * end, 2000)
    pair = [columns(one, times, *linkages.IdealMotion(one).states(times))["O.torque"] for one in (system, exact)]
    return np.abs(pair[0] - pair[1]).max() / np.abs(pair[1]).max()


def test_table_of_smoothing(driven, tmp_path):
    """Compare a series, a spline and raw data of 4096 counts at 1 kHz with the known motion.

    An independent trial had errors of 3e-4, 0.049 and 170 of the torque's peak; the bounds are twice these values.
    """
    exact = driven(f'formula = "{ANGLE}"')
    encoder(tmp_path, 5.0)
    assert torque_error(driven(f"{FROM_FILE}\nperiodic = true", 0.49), exact) < 6e-4
    encoder(tmp_path, 1.0)
    spline = torque_error(driven(f"{FROM_FILE}\nperiodic = false", 0.49), exact)
    assert 6e-4 < spline < 0.098
    raw = FROM_FILE.replace(f'resolution = "{COUNTS}/rev"', "deviation = 0.0\nperiodic = false")
    assert torque_error(driven(raw, 0.49), exact) > 10.0


@pytest.mark.parametrize("periodic", ["true", "false"])
def test_motion_within_the_resolution(driven, tmp_path, periodic):
    encoder(tmp_path)
    system, times = driven(f"{FROM_FILE}\nperiodic = {periodic}", 0.9), np.linspace(0.0, 0.9, 1001)
    assert np.abs(system.motions(times)[0][:, 0] - angle(times)).max() < STEP


def test_exact_samples_are_the_formula(driven, tmp_path):
    t = np.linspace(0.0, PERIOD, 401)
    written(tmp_path / "encoder.csv", t=t, phi=angle(t))
    drive = FROM_FILE.replace(f'resolution = "{COUNTS}/rev"', "deviation = 0.0")
    exact = driven(f'formula = "{ANGLE}"')
    assert torque_error(driven(f"{drive}\nperiodic = true"), exact) < 1e-6


def test_speed_is_integrated(driven, tmp_path):
    t = np.arange(0.0, 1.02, 1e-3)
    speed = OMEGA * (1.0 + FLUCTUATION * np.cos(OMEGA * t + PHASE))
    noise = np.random.default_rng(1).normal(0.0, 0.01, t.shape)
    written(tmp_path / "speed.csv", t=1e3 * t, n=(speed + noise) * 30.0 / np.pi)
    lines = 'file = "speed.csv"\ntime = "t"\nspeed = "n"\nunits = { time = "ms", speed = "r/min" }\ndeviation = 0.01'
    for periodic in "true", "false":
        system = driven(f"{lines}\nangle = 0.4\nperiodic = {periodic}", 1.0)
        value, rate, _ = (found[:, 0] for found in system.motions(t[:1000]))
        assert value[0] == pytest.approx(0.4, abs=1e-12)
        assert np.abs(value - 0.4 - (angle(t[:1000]) - angle(0.0))).max() < 2e-3
        assert np.abs(rate - speed[:1000]).max() < 0.02


@pytest.mark.parametrize("periodic", ["true", "false"])
def test_unit_of_time_does_not_matter(driven, tmp_path, periodic):
    t = np.arange(0.0, 1.0, 1e-3)
    results = []
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("h", 1.0 / 3600.0)):
        written(tmp_path / "encoder.csv", t=factor * t, phi=counted(t))
        system = driven(f'{FROM_FILE}\nunits = {{ time = "{unit}" }}\nperiodic = {periodic}', 0.9)
        results.append(system.motions(t[:900])[2])
    for other in results[1:]:
        assert np.abs(other - results[0]).max() < 1e-6 * np.abs(results[0]).max()


@pytest.mark.parametrize("periodic", ["true", "false"])
def test_uneven_times_gaps_and_wrap(driven, tmp_path, periodic):
    """Times with jitter, missing rows, an unreadable row, and degrees that wrap while rows are missing."""
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 2.0 * PERIOD, 1e-3)
    t[1:] += rng.uniform(0.0, 5e-4, len(t) - 1)
    t = t[(np.abs(t - 0.45) > 0.02) & (rng.random(len(t)) > 0.05)]
    rows = [f"{a:.9f},{b:.9f}" for a, b in zip(t, np.degrees(counted(t) % (2.0 * np.pi)), strict=True)]
    rows[100] = rows[100].replace(",", ",error ")
    (tmp_path / "encoder.csv").write_text("\n".join(["# bench 3", "t [s],phi [deg]", *rows]))
    system, times = driven(f"{FROM_FILE}\nunwrap = true\nperiodic = {periodic}", 0.95), np.linspace(0.0, 0.95, 999)
    assert np.abs(system.motions(times)[0][:, 0] - angle(times)).max() < STEP


def test_formats(tmp_path):
    """All formats have the same columns; units of our own exports are read back."""
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    t, x = np.linspace(0.0, 1.0, 11), np.linspace(3.0, 5.0, 11)
    (tmp_path / "a.csv").write_text("t;x [mm]\n" + "\n".join(f"{a};{b}".replace(".", ",") for a, b in zip(t, x)))  # noqa: B905
    (tmp_path / "a.txt").write_text("t\tx [mm]\n" + "\n".join(f"{a}\t{b}" for a, b in zip(t, x)))  # noqa: B905
    savemat(tmp_path / "a.mat", {"t": t, "x": x, "units": {"x": "mm"}})
    np.savez(tmp_path / "a.npz", t=t, x=1e-3 * x)
    fields = [pa.field("t", pa.float64()), pa.field("x", pa.float64(), metadata={"units": "mm"})]
    pq.write_table(pa.table([t, x], schema=pa.schema(fields)), tmp_path / "a.parquet")
    for kind in "csv", "txt", "mat", "npz", "parquet":
        found = read_recording(tmp_path / f"a.{kind}")
        assert found.column("t", "s") == pytest.approx(t)
        assert found.column("x", "m") == pytest.approx(1e-3 * x), kind


@pytest.mark.parametrize("text", [
    "t\tx [mm]\n0\t3\n0,5\t4,5\n1\t5", "t x\n0 3e-3\n0,5 4,5e-3\n1 5e-3", "t;x [mm];\n0;3;\n0,5;4,5;\n1;5;",
    "\ufefft,x [mm]\n0,3\n0.5,4.5\n1,5", "t (s),x [mm]\n0,3\n0.5,4.5\n1,5",
])  # fmt: skip
def test_notations_of_text(tmp_path, text):
    """Decimal commas keep all rows, as beside whole numbers and tabs."""
    (tmp_path / "a.txt").write_text(text, encoding="utf-8")
    found = read_recording(tmp_path / "a.txt")
    assert found.column("t (s)" if "(s)" in text else "t", "s").tolist() == [0.0, 0.5, 1.0]
    assert found.column("x", "m").tolist() == pytest.approx([0.003, 0.0045, 0.005])


@pytest.mark.parametrize(("text", "problem"), [
    ("t,x\n0,1,2,5\n0,2,2,6", "row 1 has more cells than the 2 headings; decimal commas need semicolons or tabs"),
    ("t,x\nms,N\n1,2\n2,3", 'row 1 is "ms,N", without numbers; write units into the headings, as t [ms]'),
    ("t,x\n1_0,2_0\n1_1,2_1", "has no numbers"),
])  # fmt: skip
def test_text_with_another_meaning_is_refused(tmp_path, text, problem):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(linkages.InputError, match=re.escape(problem)) as refused:
        read_recording(tmp_path / "a.csv")
    assert "\n" not in str(refused.value)


def test_units_of_columns(tmp_path):
    """Units with another zero, and units in parentheses, if they are of the kind that is asked for."""
    (tmp_path / "a.csv").write_text("t (ms),T [K],U [degF]\n0,293.15,68\n1,303.15,86")
    found = read_recording(tmp_path / "a.csv")
    assert found.column("T", "degC") == pytest.approx([20.0, 30.0])
    assert found.column("U", "degC") == pytest.approx([20.0, 30.0])
    assert found.column("t (ms)", "s", "ms").tolist() == [0.0, 0.001]
    assert found.column("t (ms)", "s").tolist() == [0.0, 0.001]
    assert found.column("t (ms)", "m").tolist() == [0.0, 1.0]  # not a length: part of the name


@pytest.mark.parametrize("heading", ["Time (ms)", "Time [ms]", "time (ms)", " time  [ms] ", "TIME [ms]"])
@pytest.mark.parametrize("name", ["time", "Time", "Time (ms)", "time [ms]"])
def test_a_column_is_found_with_and_without_its_unit(tmp_path, heading, name):
    (tmp_path / "a.csv").write_text(f"{heading},x\n0,1\n500,2\n")
    assert read_recording(tmp_path / "a.csv").column(name, "s").tolist() == [0.0, 0.5]


@pytest.mark.parametrize(("headings", "name", "said"), [
    ("x (mm),x (deg)", "x", 'a.csv has several columns "x"; give one of x (mm), x (deg)'),
    ("X [mm],x (N)", "x [m]", 'a.csv has no column "x [m]"'),
    ("F(1),F(2)", "F", 'a.csv has no column "F"; known are: F(1), F(2)'),
])  # fmt: skip
def test_a_name_of_no_column_or_of_several_is_refused(tmp_path, headings, name, said):
    """Numbers in parentheses are no units, and another unit is another column."""
    (tmp_path / "a.csv").write_text(f"{headings}\n0,1\n1,2\n")
    with pytest.raises(ValueError, match=re.escape(said)):
        read_recording(tmp_path / "a.csv").column(name, "m")


def test_headings_of_their_own_come_first(tmp_path):
    (tmp_path / "a.csv").write_text("X [m],x [m],x (N)\n0,1,2\n3,4,5\n")
    found = read_recording(tmp_path / "a.csv")
    assert [found.column(name, "m")[0] for name in ("X", "X [m]", "x (N)", "x [m]")] == [0.0, 0.0, 2.0, 1.0]


@pytest.mark.parametrize("mapped", [
    "", "[data.columns.'O.torque']\noutput = 'O.torque'\n", "[data.columns.'O.torque (N mm)']\noutput = 'O.torque'\n",
])  # fmt: skip
def test_measured_curves_have_headings_of_laboratories(system_of, tmp_path, mapped):
    """A flywheel of 0.02 kg m2 under 0.1 N m; the file is 50 N mm higher."""
    (tmp_path / "d.csv").write_text("Time (ms),O.torque (N mm)\n0,150\n400,150\n1000,150\n")
    system = system_of(FLYWHEEL, f"duration = 1.0\n[drives.O]\ntorque = 0.1\n[data]\nfile = 'd.csv'\n{mapped}")
    (curve,) = linkages.summarize(assess(system, error_estimate=False))["measured"].values()
    assert curve["rms"] == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("keys", "gain", "offset"), [("", 1.0, 0.0), ("gain = -1.0\n", -1.0, 0.0), ("gain = 0.5\noffset = 0.2\n", 0.5, 0.2)]
)
def test_headings_of_laboratories_a_gain_and_an_offset(system_of, tmp_path, keys, gain, offset):
    """The angle is gain times 30 sin(t) degrees plus the offset, and J times its second derivative the torque."""
    t = np.linspace(0.0, 2.0, 201)
    table = np.column_stack([t, 30.0 * np.sin(t)])
    np.savetxt(tmp_path / "d.csv", table, delimiter=",", header="Time (s),Angle (deg)", comments="")
    text = "duration = 2.0\n[drives.O]\nfile = 'd.csv'\ntime = 'Time (s)'\nangle = 'Angle (deg)'\ndeviation = 0\n"
    found = linkages.simulate(system_of(FLYWHEEL, text + keys))
    times, angle = np.linspace(0.2, 1.8, 9), gain * np.pi / 6.0
    columns = found.evaluate(times)
    np.testing.assert_allclose(columns["q.O"], angle * np.sin(times) + offset, atol=1e-8)
    np.testing.assert_allclose(columns["O.torque"], -0.02 * angle * np.sin(times), atol=1e-6)


def test_a_gain_acts_after_jumps_of_a_turn_and_on_the_deviation(system_of, tmp_path):
    """An encoder on a shaft that turns ten times as fast as the joint, 4096 counts per turn."""
    t = np.linspace(0.0, 1.0, 1001)
    count = np.floor(np.mod(20.0 * t + 0.3 * np.sin(9.0 * t), 2.0 * np.pi) / (2.0 * np.pi) * 4096)
    np.savetxt(
        tmp_path / "d.csv", np.column_stack([t, count * 360.0 / 4096]), delimiter=",", header="t,phi (deg)", comments=""
    )
    text = "duration = 1.0\n[drives.O]\nfile = 'd.csv'\ntime = 't'\nangle = 'phi (deg)'\nresolution = '4096/rev'\n"
    system = system_of(FLYWHEEL, text + "unwrap = true\ngain = 0.1\n")
    fit = system.experiment.drives["O"].fitted[0]
    assert fit.deviation == pytest.approx(0.1 * 2.0 * np.pi / 4096 / np.sqrt(12.0))
    angle = linkages.ideal(system).evaluate(t[100:900])["q.O"]
    half = 0.1 * 0.5 * 2.0 * np.pi / 4096  # counts are rounded down
    np.testing.assert_allclose(angle + half, 2.0 * t[100:900] + 0.03 * np.sin(9.0 * t[100:900]), atol=half)


def test_a_gain_of_zero_and_one_without_a_file_are_refused(experiment_file, tmp_path):
    (tmp_path / "d.csv").write_text("t,phi\n" + "".join(f"{k},{k}\n" for k in range(20)))
    of_file = "file = 'd.csv'\ntime = 't'\nangle = 'phi'\ndeviation = 0\ngain = 0.0\n"
    cases = (of_file, "drives.O: gain is 0; the signal would"), ("speed = 1.0\ngain = 2.0\n", "gain belongs to file")
    for keys, problem in cases:
        with pytest.raises(linkages.InputError, match=problem):
            linkages.load(experiment_file(FLYWHEEL, f"duration = 1.0\n[drives.O]\n{keys}"))


def test_torque_from_a_file_in_both_engines(driven, tmp_path):
    """A brake torque from a file is the brake torque by a formula; both engines agree."""
    t = np.linspace(0.0, 0.3, 301)
    written(tmp_path / "load.csv", t=t, T=1e3 * np.sin(20.0 * t))
    table = '[torques.brake]\nlink = "follower"\nfile = "load.csv"\ntime = "t"\ntorque = "T"\n'
    table += 'units = { torque = "N mm" }\ndeviation = "1 N mm"'
    drive = "speed = 10.0"
    known = driven(drive, 0.25, '[torques.brake]\nlink = "follower"\nformula = "sin(20*t)"')
    system = driven(drive, 0.25, table)
    assert torque_error(system, known) < 3e-3  # three deviations
    runs = [linkages.simulate(system, engine)["O.torque"] for engine in ("compiled", "drake")]
    assert runs[0].max() == pytest.approx(runs[1].max(), rel=1e-4)


def test_force_over_a_position(driven, tmp_path):
    """Two components over a position: the table keeps its end values, as one in the experiment."""
    x = np.linspace(-1.0, 1.0, 41)
    written(tmp_path / "load.csv", x=1e3 * x, Fx=2.0 * x, Fy=3.0 * x**2)
    table = '[forces.push]\npoint = "follower_B"\nover = "follower_B.x"\nfile = "load.csv"\nat = "x"\n'
    table += 'force = ["Fx", "Fy"]\nunits = { at = "mm" }\ndeviation = 0.0'
    formula = '[forces.push]\npoint = "follower_B"\nformula = ["2*follower_B.x", "3*follower_B.x**2"]'
    assert torque_error(driven("speed = 10.0", 0.5, table), driven("speed = 10.0", 0.5, formula)) < 1e-3


def test_more_and_less_smoothing_are_reported(driven, tmp_path, capsys):
    encoder(tmp_path)
    system = driven(f"{FROM_FILE}\nperiodic = false", 0.9)
    summary = linkages.summarize(assess(system))
    assert summary["smoothing"].keys() == {"half", "double"}
    assert summary["smoothing"]["half"]["O.torque.peak"] == pytest.approx(1.0, abs=0.1)
    text = linkages.format_summary(summary)
    assert re.search(r"drives\.O: encoder\.csv, 995 rows, quintic smoothing spline", text)
    assert "double smoothing changes the peaks of forces by at most" in text
    out = tmp_path / "out"
    assert main(["simulate", str(system.experiment.source), "--no-animation", "--quiet", "--out", str(out)]) == 0
    assert main(["report", str(out)]) == 0
    page = (out / "report.html").read_text()
    assert "Signal of drives.O: encoder.csv, 995 rows" in page
    assert "Half smoothing changes the peaks of forces" in page


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        ('file = "encoder.csv"\ntime = "t"\nangle = "phi"', "give resolution"),
        (f'{FROM_FILE}\ndeviation = "1 deg"', "not both"),
        (FROM_FILE.replace("phi", "psi"), 'no column "psi"'),
        (FROM_FILE.replace("encoder", "encoded"), "cannot be read"),
        (FROM_FILE.replace(".csv", ".xls"), "is no data file"),
        (f'{FROM_FILE}\nunits = {{ phi = "deg" }}', 'units has "phi"'),
        (f'{FROM_FILE}\nunits = {{ angle = "mm" }}', "is one of angles"),
        (f'{FROM_FILE}\nunits = {{ angle = "kg" }}', "must be measured in rad"),
        (f'{FROM_FILE}\nunits = {{ angle = "deg" }}\nperiodic = true', "shorter than a turn"),
        (f"{FROM_FILE}\nshift = 5.0", "the run from 0 to"),
        (f"{FROM_FILE}\nspeed = 3.0", "prescribes the complete motion"),
        (FROM_FILE.replace('angle = "phi"', "speed = 3.0"), "needs the name of a column"),
        ('speed = 3.0\nresolution = "4096/rev"', "belongs to file"),
        (FROM_FILE.replace("4096/rev", "fine"), 'resolution is "fine"'),
    ],
)
def test_refusals(driven, tmp_path, lines, problem):
    encoder(tmp_path, 1.4)
    with pytest.raises(linkages.InputError, match=re.escape(problem)) as refused:
        driven(lines)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith("driven.toml: drives.O")


DATA = '[data]\nfile = "measured.csv"\ntime = "clock"\ntime_unit = "ms"\nshift = 0.05\n'
NOISE = 0.1  # rad/s2


@pytest.fixture
def measured(driven, tmp_path):
    """A machine with measured curves: its own run with another clock, units, gain, offset and seeded noise."""

    def measured(data=DATA):
        columns = '[data.columns.alpha]\noutput = "follower.alpha"\n[data.columns.M]\noutput = "O.torque"\n'
        columns += "gain = 2.0\noffset = -2.0\n"
        return driven("speed = 10.0", 0.5, f'outputs = ["follower.alpha"]\n{data}{columns}' if data else "")

    run = linkages.simulate(driven("speed = 10.0", 0.5, 'outputs = ["follower.alpha"]'))
    t = np.arange(0.101, 0.7, 2e-3)
    known = run.evaluate(np.minimum(t, 0.5))
    noise = np.random.default_rng(3).normal(0.0, NOISE, t.shape)
    noise[100] = 8.0 * NOISE
    alpha = np.degrees(known["follower.alpha"] + noise)
    heads, values = "clock,alpha [deg/s2],M", np.column_stack([1e3 * t - 50.0, alpha, known["O.torque"] / 2.0 + 1.0])
    np.savetxt(tmp_path / "measured.csv", values, "%.12g", ",", header=heads, comments="")
    measured.noise = noise[t <= 0.5]
    return measured


def test_measured_beside_computed(measured):
    found = linkages.summarize(linkages.assess(measured()))["measured"]
    alpha, torque = found["follower.alpha"], found["O.torque"]
    assert alpha["rows"] == len(measured.noise) == 200
    assert alpha["rms"] == pytest.approx(np.sqrt(np.mean(measured.noise**2)), rel=1e-6)
    assert (alpha["largest"], alpha["time"]) == (pytest.approx(8.0 * NOISE, rel=1e-6), pytest.approx(0.301))
    assert torque["rms"] < 1e-9 * torque["peak"]


def test_measured_in_table_figure_and_report(measured, tmp_path, capsys):
    source, out = measured().experiment.source, tmp_path / "out"
    assert main(["simulate", str(source), "--no-animation", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert re.search(r"measured less computed +peak +rms +largest +at\nfollower\.alpha .* 301 ms\n", text)
    assert (out / "measured.png").is_file()
    assert main(["report", str(out)]) == 0
    page = (out / "report.html").read_text()
    assert "Measured less computed" in page
    assert '"measured":{"time":[' in page.replace(" ", "").replace("\n", "")


def test_data_from_the_command_line(measured, tmp_path, capsys):
    """A file whose headings are names of outputs needs no table."""
    source = measured("").experiment.source
    run = linkages.simulate(linkages.load(source))
    written(tmp_path / "plain.csv", time=run.time, **{"O.torque": run["O.torque"]})
    options = ["--no-animation", "--no-plots", "--out", str(tmp_path / "out")]
    assert main(["simulate", str(source), "--data", str(tmp_path / "plain.csv"), *options]) == 0
    text = capsys.readouterr().out
    assert re.search(r"\nO\.torque \[m?N m\] .*e-1\d", text)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (DATA.replace("clock", "time"), 'no column "time"'),
        (DATA.replace("0.05", "50.0"), "has no number at a time within the run"),
        (DATA.replace('"ms"', '"mm"'), "must be measured in s"),
        (f'{DATA}[data.columns.beta]\noutput = "O.torque"\n', 'no column "beta"'),
        (DATA.replace("measured.csv", "lost.csv"), "cannot be read"),
    ],
)
def test_refused_data(measured, data, problem):
    with pytest.raises(linkages.InputError, match=re.escape(problem)):
        linkages.summarize(linkages.assess(measured(data)))


def test_batches_and_derivatives_with_a_drive_from_a_file(driven, tmp_path):
    """The same peaks and derivatives as with the drive by a formula."""
    encoder(tmp_path, 5.0)
    systems = driven(f"{FROM_FILE}\nperiodic = true", 0.4), driven(f'formula = "{ANGLE}"', 0.4)
    path = "sdf.links.coupler.mass"
    values = np.array([[0.9], [1.1]]) * systems[0].value(path)
    peaks = [linkages.simulate_batch(one, [path], values, ["O.torque"]).peak for one in systems]
    np.testing.assert_allclose(*peaks, rtol=2e-3)
    slopes = [linkages.simulate(one, wrt=[path]).sensitivity[path]["O.torque"] for one in systems]
    assert np.abs(slopes[0]).max() == pytest.approx(np.abs(slopes[1]).max(), rel=2e-3)
