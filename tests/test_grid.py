"""Sweeps over two values: a map against independent inverse dynamics, interrupted and resumed, refusals, figures."""

import csv
import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest
from machines import circle_intersection, four_bar, written
from matplotlib.colors import LogNorm

import linkages
from linkages import Status
from linkages.cli.main import main
from linkages.show.plots.swept import map_figure, peaks_figure
from linkages.system.identity import identity

GROUND, CRANK, COUPLER, FOLLOWER, MASS, GRAVITY = 0.3, 0.1, 0.25, 0.2, 0.2, 9.81
EXPERIMENT = f"duration = 1.0\ngravity = [0.0, {-GRAVITY}, 0.0]\n[drives.O]\nspeed = 10.0\n"
SPEEDS, MASSES = np.linspace(5.0, 45.0, 11), np.linspace(0.05, 0.85, 9)
VARY = ("--vary", "drives.O.speed=10:30:3", "--vary", "sdf.links.coupler.mass=0.1kg:0.3kg:4")
QUICK = ("--revolutions", "1", "--transient", "0", "--output", "O.torque")


def derivative(values):
    """Derivatives of periodic functions of the crank's angle, whose samples lie along the last axis."""
    n = values.shape[-1]
    return np.fft.irfft(1j * np.arange(n // 2 + 1) * np.fft.rfft(values), n)


def fine(values, times=32):
    """Samples of a periodic function by its Fourier series at closer angles."""
    return times * np.fft.irfft(np.fft.rfft(values), times * len(values))


def largest_torque(speed, mass):
    """Largest drive torque of the four-bar by inverse dynamics: from kinetic and potential energy over the angle."""
    angle = 2.0 * np.pi * np.arange(512) / 512
    a = CRANK * np.stack([np.cos(angle), np.sin(angle)])
    q = np.array([GROUND, 0.0])
    b = np.stack([circle_intersection(p, COUPLER, q, FOLLOWER) for p in a.T], axis=1)
    centres = np.stack([a / 2.0, (a + b) / 2.0, (q[:, None] + b) / 2.0])
    rod, rocker = b - a, b - q[:, None]
    turn = np.stack([np.ones(512), *(derivative(np.arctan2(arm[1], arm[0])) for arm in (rod, rocker))])
    masses = np.array([MASS, mass, MASS])
    inertias = MASS * np.array([CRANK, COUPLER, FOLLOWER]) ** 2 / 12.0
    twice = masses @ (derivative(centres) ** 2).sum(axis=1) + inertias @ turn**2
    potential = GRAVITY * masses @ centres[:, 1]
    return np.abs(fine(0.5 * speed**2 * derivative(twice) + derivative(potential))).max()


@pytest.fixture
def machine(tmp_path):
    return written(tmp_path, four_bar(), EXPERIMENT)


def files(folder):
    """Bytes of all files of a folder, the rows too."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_map_of_the_largest_torque_is_that_of_inverse_dynamics(machine):
    system = linkages.load(machine)
    names = ["O.torque", "coupler.omega"]
    grid = linkages.sweep_grid(system, "drives.O.speed", SPEEDS, "sdf.links.coupler.mass", MASSES, names, 1)
    assert grid.status is Status.OK
    expected = [[largest_torque(speed, mass) for mass in MASSES] for speed in SPEEDS]
    np.testing.assert_allclose(grid.peaks("O.torque"), expected, rtol=1e-6)
    turns = grid.peaks("coupler.omega") / SPEEDS[:, None]
    np.testing.assert_allclose(turns, turns[0, 0], rtol=1e-6)


def test_the_command_writes_tables_and_a_map(machine, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["sweep", str(machine), *VARY, *QUICK, "--limit", "O.torque=1.5N*m", "--out", str(out)]) == 0
    text = capsys.readouterr().out
    with open(out / "sweep.csv", newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    pairs = [(float(row["drives.O.speed"]), float(row["sdf.links.coupler.mass"])) for row in lines]
    np.testing.assert_allclose(pairs, [(a, b) for a in (10, 20, 30) for b in np.linspace(0.1, 0.3, 4)], rtol=1e-12)
    peaks = np.array([float(row["O.torque.peak_max"]) for row in lines])
    np.testing.assert_allclose(peaks, [largest_torque(*pair) for pair in pairs], rtol=1e-6)
    content = json.loads((out / "sweep.json").read_text())
    assert content["limits"] == {"O.torque": 1.5}
    assert [point["value"] for point in content["rows"][2]] == [pair[1] for pair in pairs[8:]]
    assert f"above the limit of 1.5: {(peaks > 1.5).sum()} of 12 pairs" in text
    assert f"largest: {peaks.max():.5g} at drives.O.speed = 30, sdf.links.coupler.mass = 0.3" in text
    parquet = pytest.importorskip("pyarrow.parquet").read_table(out / "sweep.parquet")
    assert parquet.column("O.torque.peak_max").to_pylist() == peaks.tolist()
    assert parquet.schema.field("O.torque.peak_max").metadata == {b"units": b"N m"}
    assert (out / "map_O.torque.png").stat().st_size > 10_000


def test_interrupted_and_resumed_it_has_the_same_bytes(machine, tmp_path, monkeypatch, capsys):
    from linkages.explore import grid

    words = ["sweep", str(machine), *VARY, *QUICK]
    assert main([*words, "--out", str(tmp_path / "whole")]) == 0
    compute, done = grid._row, []

    def struck(*arguments):
        if len(done) == 1:  # the second row ends after two of four values
            cut = (*arguments[:3], arguments[3][:2], *arguments[4:])
            done.append(cut)
            return compute(*cut)[0], True
        done.append(arguments)
        return compute(*arguments)

    monkeypatch.setattr(grid, "_row", struck)
    part = tmp_path / "part"
    assert main([*words, "--out", str(part)]) == 130
    assert "the sections of 6 of 12 pairs are written; the same command continues" in capsys.readouterr().err
    asked = []

    def watched(*arguments):
        asked.append((arguments[2], len(arguments[3])))
        return compute(*arguments)

    monkeypatch.setattr(grid, "_row", watched)
    assert main([*words, "--out", str(part)]) == 0
    assert asked == [(20.0, 2), (30.0, 4)]
    assert files(part) == files(tmp_path / "whole")
    damaged = next((part / "rows").glob("0002-*"))
    damaged.write_bytes(damaged.read_bytes()[:-1])
    assert main([*words, "--out", str(part)]) == 0
    assert asked[2:] == [(20.0, 4)]
    assert files(part) == files(tmp_path / "whole")
    assert main([*words, "--set", "gravity=[0,0,0]", "--out", str(part)]) == 0  # another machine: nothing is reused
    assert len(asked) == 6


def test_the_identity_of_a_system_has_the_contents_of_its_files(machine):
    data, text = machine.with_name("drive.csv"), EXPERIMENT.replace("speed = 10.0", 'file = "drive.csv"\nangle = "phi"')
    machine.write_text(f'mechanism = "machine.sdf"\n{text}deviation = 0\n')
    found = set()
    for slope in (1.0, 1.0, 2.0):
        data.write_text("time,phi\n" + "\n".join(f"{0.1 * k},{0.1 * k * slope}" for k in range(12)))
        found.add(identity(linkages.load(machine)))
    assert len(found) == 2
    sdf = machine.with_name("machine.sdf")
    sdf.write_text(sdf.read_text() + "\n")
    assert identity(linkages.load(machine)) not in found
    assert identity(linkages.load(machine).replaced({"sdf.links.coupler.mass": 1.0})) != identity(
        linkages.load(machine)
    )


def test_ctrl_c_keeps_the_values_that_are_finished(machine, monkeypatch):
    system = linkages.load(machine)
    axes = ("drives.O.speed", [10.0, 20.0], "sdf.links.coupler.mass", [0.1, 0.2])

    def look(done):
        if done > 0.6:
            raise KeyboardInterrupt

    found = linkages.sweep_grid(system, *axes, ["O.torque"], 1, threads=1, progress=look)
    assert found.status is Status.INTERRUPTED
    assert all(point.status is Status.OK for point in found.rows[0])
    monkeypatch.setattr("linkages.explore.grid._row", lambda *arguments: look(1.0))
    with pytest.raises(KeyboardInterrupt):
        linkages.sweep_grid(system, *axes, ["O.torque"], 1)


@pytest.mark.processes
def test_an_executor_computes_the_same_points(machine, tmp_path):
    system = linkages.load(machine)
    axes = ("drives.O.speed", [10.0, 20.0], "sdf.links.coupler.mass", [0.1, 0.2])
    here = linkages.sweep_grid(system, *axes, ["O.torque"], 1, folder=tmp_path / "here")
    with ThreadPoolExecutor(2) as pool:
        there = linkages.sweep_grid(system, *axes, ["O.torque"], 1, folder=tmp_path / "there", executor=pool)
    assert here.peaks("O.torque").tobytes() == there.peaks("O.torque").tobytes()
    assert files(tmp_path / "here") == files(tmp_path / "there")


def test_pairs_that_fail_have_no_peak(machine, tmp_path, capsys):
    """The journal leaves a film that is too thin."""
    out = tmp_path / "out"
    film = ["--set", 'joints.A.model="lubricated"', "--set", "joints.A.clearance=1e-4"]
    vary = ["--vary", "joints.A.viscosity=1e-5:0.2:2", "--vary", "drives.O.speed=10:20:2"]
    assert (
        main(["sweep", str(machine), *film, "--set", "joints.A.viscosity=0.1", *vary, *QUICK, "--out", str(out)]) == 1
    )
    printed = capsys.readouterr()
    assert "2 pairs, first joints.A.viscosity = 1e-05, drives.O.speed = 10: journal-left-bearing; " in printed.err
    with open(out / "sweep.csv", newline="", encoding="utf-8") as file:
        peaks = [row["O.torque.peak_mean"] for row in csv.DictReader(file)]
    assert peaks[:2] == ["", ""]
    assert all(peaks[2:])


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((*VARY, "--vary", "a=1:2:3"), "--vary: a=1:2:3: is number 3; vary one or two values"),
        ((*VARY[:2], *VARY[:2]), "linkages sweep: --vary drives.O.speed: is given twice"),
        ((*VARY[:2], "--vary", "drives.O.sped=1:2:2"), '--vary: drives.O.sped: unknown key; did you mean "speed"?'),
        ((*VARY, "--limit", "O.torque"), "--limit: O.torque: write NAME=VALUE, such as B.force=2kN"),
        ((*VARY, "--limit", "O.tork=1"), '--limit: O.tork: is no recorded output; did you mean "O.torque"?'),
        ((*VARY, "--limit", "O.torque=1m"), "--limit: "),
        ((*VARY[:2], "--limit", "O.torque=1"), "--limit: is for two values; give --vary twice"),
        ((*VARY[:2], "--cluster", "tcp://127.0.0.1:9"), "--cluster: is for two values; give --vary twice"),
    ],
)
def test_a_map_of_nonsense_is_refused_before_it_runs(machine, tmp_path, capsys, words, says):
    assert main(["sweep", str(machine), *words, *QUICK, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {says}")
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_coarse_map_has_values_in_its_cells_and_no_contours(machine):
    """Contours between few values contradict the cells; cells beyond the limit are hatched."""
    system, axes = linkages.load(machine), ("drives.O.speed", [10.0, 20.0, 30.0], "sdf.links.coupler.mass", [0.1, 0.2])
    grid = linkages.sweep_grid(system, *axes, ["O.torque", "crank.omega"], 1)
    peaks = grid.peaks("O.torque")
    figure = map_figure(grid, "O.torque", "N m", float(peaks.mean()))
    axis, bar = figure.axes
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("speed of O [rad/s]", "mass of coupler [g]")
    assert bar.get_ylabel() == "peak of the torque of O [N m]"
    (mesh,) = axis.collections
    np.testing.assert_array_equal(mesh.get_array(), peaks.T)
    assert [text.get_text() for text in axis.texts] == [f"{value:.3g}" for value in peaks.T.ravel()]
    hatched = [patch.get_center().tolist() for patch in axis.patches if patch.get_hatch()]
    beyond = [[x, 1e3 * y] for y, row in zip(axes[3], peaks.T, strict=True) for x, value in zip(axes[1], row, strict=True)
              if value > peaks.mean()]  # fmt: skip
    np.testing.assert_allclose(hatched, beyond)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [f"above {peaks.mean():.4g} N m"]
    assert not map_figure(grid, "O.torque", "N m", 1e9).axes[0].patches
    assert isinstance(mesh.norm, LogNorm) == (peaks.max() > 5.0 * peaks.min())
    last = replace(grid.rows[2][1], section=None, status=Status.JOURNAL_LEFT_BEARING)
    torn = replace(grid, rows=(*grid.rows[:2], (grid.rows[2][0], last)))
    figure = map_figure(torn, "O.torque", "N m", float(peaks.mean()))
    assert figure.legends[0].get_texts()[-1].get_text() == "no result"
    np.testing.assert_allclose(figure.axes[0].lines[0].get_xydata(), [[30.0, 200.0]])


@dataclass
class Plane:
    """A grid of a plane over two variables, from 0 to 4 by default."""

    count: int
    paths: tuple[str, str] = ("one", "other")
    units: tuple[str, str] = ("m", "kg")

    @property
    def values(self):
        return (np.linspace(1.0, 2.0, self.count).tolist(),) * 2

    def peaks(self, _):
        return np.add.outer(*self.values)


@pytest.mark.parametrize(("count", "has"), [(11, False), (12, True)])
def test_contours_begin_with_twelve_values_of_both_variables(count, has):
    axis = map_figure(Plane(count), "B.force", "N", 3.0).axes[0]
    assert (len(axis.collections) > 1) == has
    if has:
        _, contours, limit = axis.collections
        assert len(contours.get_paths()) > 2
        for x, y in limit.get_paths()[0].vertices:
            assert x + y == pytest.approx(3.0)


def test_figures_of_peaks(machine):
    """Panels for one variable."""
    system, axes = linkages.load(machine), ("drives.O.speed", [10.0, 20.0, 30.0])
    sweep = linkages.sweep(system, *axes, ["O.torque", "crank.omega", "coupler.omega"], 1)
    units = {"O.torque": "N m", "crank.omega": "rad/s", "coupler.omega": "rad/s"}
    figure = peaks_figure(sweep, units)
    assert len(figure.axes) == 3
    np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), axes[1], rtol=1e-6)
    assert figure.bbox.height < 1000


def test_the_unit_of_a_variable_is_that_of_a_prismatic_joint(tmp_path, capsys):
    """A block on a slide: the speed of its drive is in m/s, which r/min do not scale."""
    from machines import joint, model, solid, written

    body = solid("block", 2.0) + joint("O", "world", "block", "prismatic", "1 0 0")
    text = 'duration = 0.4\noutputs = ["block.x"]\n[drives.O]\nforce = 1.0\nspeed = 0.5\n[drives.Q]\nspeed = 20.0\n'
    body += solid("wheel", 1.0) + joint("Q", "world", "wheel")
    path = written(tmp_path, model("two", body), text)
    vary = ["--vary", "drives.O.speed=0.5:1.0:2", "--revolutions", "1", "--transient", "0", "--units", "r/min"]
    assert main(["sweep", str(path), *vary, "--no-plots", "--out", str(tmp_path / "out")]) == 0
    assert "drives.O.speed [m/s]" in capsys.readouterr().out
    first = (tmp_path / "out" / "sweep.csv").read_text().splitlines()
    assert first[0].startswith("drives.O.speed [m/s]")
    assert [float(line.split(",")[0]) for line in first[1:]] == [0.5, 1.0]
