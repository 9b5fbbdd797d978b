"""Figures for a paper: format, size, style; fonts embedded, text as text. Runs in one figure and one table."""

import json
import re
import shutil
import zlib
from itertools import pairwise

import numpy as np
import pytest
from matplotlib import image
from matplotlib.figure import Figure

import linkages
from linkages.cli.main import main
from linkages.plots import overlay_figure, presented, write_figures
from linkages.show.plots.style import stacked_axes

SLIDER = """<sdf version="1.9"><model name="p"><link name="block"><inertial><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link><joint name="guide" type="prismatic">
<parent>world</parent><child>block</child><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"""
HUNG = """mechanism = "p.sdf"
duration = 1.0
gravity = [0.0, -9.81, 0.0]
[springs.hook]
point = "block"
anchor = [0.0, 1.0]
stiffness = 400.0
free_length = 1.0
"""
POINT = 72.0 / 25.4  # points in a millimetre


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folders of two short runs of different machines."""
    root = tmp_path_factory.mktemp("runs")
    for name in ("slider_crank_dry", "seven_bar"):
        run = f"simulate {name}.toml --duration 0.004 --no-plots --no-animation --no-error-estimate --quiet"
        assert main([*run.split(), "--out", str(root / name)]) == 0
    return root


@pytest.fixture(scope="module")
def study():
    return linkages.assess(linkages.load(linkages.find_file("four_bar_dry.toml"), {"duration": 0.01}))


def _texts(pdf):
    """Strings shown in a PDF file, from its compressed streams: glyphs of matplotlib's fonts are their characters."""
    streams = re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.S)
    content = b"".join(zlib.decompress(one) for one in streams if one[:1] == b"\x78")
    return re.findall(rb"\((.*?)\) Tj|\[(.*?)\] TJ", content)


def test_figures_have_the_size_the_format_and_fonts_that_were_asked(study, tmp_path):
    with presented(format="pdf", size="85x60mm", style="print"):
        paths = write_figures(study, tmp_path)
    assert paths
    assert {path.suffix for path in paths} == {".pdf"}
    for path in paths:
        pdf = path.read_bytes()
        box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", pdf)
        width, height = (float(side) / POINT for side in box.groups())
        assert width == pytest.approx(85.0)
        fits = path.stem.startswith("output_")  # one panel; others grow where their panels need it
        assert height == pytest.approx(60.0) if fits else height >= 60.0 - 1e-6
        assert b"/FontFile2" in pdf
        assert b"/Type3" not in pdf
        assert _texts(pdf)
    again = tmp_path / "again"
    again.mkdir()
    with presented(format="pdf", size="85x60mm", style="print"):
        assert [path.read_bytes() for path in write_figures(study, again)] == [path.read_bytes() for path in paths]


def test_a_width_alone_keeps_the_proportions(study, tmp_path):
    with presented(style="print"):
        (own, *_) = write_figures(study, tmp_path)
        height, width, _ = image.imread(own).shape
        with presented(size="100 mm"):
            (asked, *_) = write_figures(study, tmp_path)
    assert image.imread(asked).shape[1] == int(300 * 100 / 25.4)
    assert image.imread(asked).shape[0] == pytest.approx(height / width * 300 * 100 / 25.4, abs=1.0)


@pytest.mark.parametrize("size", ["40x30mm", "40mm"])
def test_the_smallest_size_holds_every_figure(study, tmp_path, size):
    """Also the figure of many panels, which is as high as they need."""
    with presented(size=size):
        paths = write_figures(study, tmp_path)
    assert {image.imread(path).shape[1] for path in paths} == {int(300 * 40 / 25.4)}


def test_a_figure_grows_to_the_height_that_its_panels_need():
    """They stay in order inside the figure, and have more than half an inch each on average."""
    figure = Figure()
    with presented(size="40x30mm"):
        boxes = [axis.get_position() for axis in stacked_axes(figure, [3, 1] * 8)]
    assert all(0.0 < box.x0 < box.x1 < 1.0 and 0.0 < box.y0 < box.y1 < 1.0 for box in boxes)
    assert all(one.y0 > two.y1 for one, two in pairwise(boxes))
    width, height = figure.get_size_inches()
    assert width == pytest.approx(40.0 / 25.4)
    assert sum(box.height for box in boxes) * height > 0.5 * len(boxes)


def test_svg_figures_have_texts(study, tmp_path):
    with presented(format="svg"):
        names = {path.name: path.read_text() for path in write_figures(study, tmp_path)}
    assert ">time [s]<" in names["joint_forces.svg"]


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [("--size", "85", "write the width"), ("--size", "0x5mm", "85x60mm"),
     ("--size", "30x20mm", "too small for the texts at the axes; write 40 mm wide and 30 mm high"),
     ("--size", "1in", "too small"), ("--size", "9e9mm", "85x60mm"),
     ("--format", "eps", "invalid choice"), ("--style", "web", "invalid choice")],
)  # fmt: skip
def test_wrong_presentations_are_refused_in_one_line(option, value, said, runs, capsys):
    assert main(["overlay", str(runs / "seven_bar"), "--output", "A.force", option, value]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error
    assert option in error
    with pytest.raises(linkages.InputError, match=option.strip("-")), presented(**{option.strip("-"): value}):
        pass


def test_an_overlay_of_different_machines_is_one_figure_and_one_table(runs, tmp_path, capsys):
    names = ["seven_bar", "slider_crank_dry"]
    folders = [str(runs / name) for name in names]
    outputs = ["--output", "slider7.ax", "--output", "B.force"]
    assert main(["overlay", *folders, *outputs, "--out", str(tmp_path)]) == 0
    written = json.loads((tmp_path / "overlay.json").read_text())
    assert written["units"] == {"slider7.ax": "m/s2", "B.force": "N"}
    assert [[*found] for found in written["peaks"].values()] == [["seven_bar"], names]  # one machine has no slider7
    table = capsys.readouterr().out
    for name in names:
        summary = json.loads((runs / name / "summary.json").read_text())
        peak = summary["joints"]["B"]["force"]
        found = written["peaks"]["B.force"][name]
        assert found["peak"] == pytest.approx(peak["peak"], rel=1e-3)  # stored steps, and continuous time
        assert found["time"] == pytest.approx(peak["time"], abs=1e-5)
        assert f"{found['peak']:.6g}" in table
    trajectories = {name: linkages.load_trajectory(runs / name / "trajectory.npz") for name in names}
    figure = overlay_figure(trajectories, ["slider7.ax", "B.force"])
    upper, lower = figure.axes
    assert len(upper.lines) == 1
    assert len(lower.lines) == 2
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == names
    assert (tmp_path / "overlay.png").is_file()


def test_a_window_of_an_overlay(runs, tmp_path):
    window = ["--from", "1 ms", "--to", "0.002", "--out", str(tmp_path), "--no-plots"]
    assert main(["overlay", str(runs / "slider_crank_dry"), "--output", "B.force", *window]) == 0
    run = linkages.load_trajectory(runs / "slider_crank_dry" / "trajectory.npz")
    peak = json.loads((tmp_path / "overlay.json").read_text())["peaks"]["B.force"]["slider_crank_dry"]
    inside = run["B.force"][(run.time >= 1e-3) & (run.time <= 2e-3)]
    assert 1e-3 <= peak["time"] <= 2e-3
    assert peak["peak"] == pytest.approx(inside.max(), rel=1e-2)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["seven_bar"], "--output: is missing"),
        (["seven_bar", "--output", "A.forse"], 'did you mean "A.force"?'),
        (["seven_bar", "seven_bar", "--output", "A.force"], "a folder is given twice"),
        (["seven_bar", "--output", "A.force", "--from", "1"], "leave nothing of"),
        (["nothing", "--output", "A.force"], "is not a folder"),
    ],
)
def test_wrong_overlays_are_refused_in_one_line(arguments, said, runs, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(runs)
    assert main(["overlay", *arguments, "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error


UNITS = "mm, deg, r/min, kN, mm/s2"


def _row(table, name):
    """Numbers of the first line of a table that begins with a name."""
    line = next(line for line in table.splitlines() if line.startswith(name))
    words = line.removeprefix(name).replace("−", "-").split()
    return [float(word) for word in words if re.fullmatch(r"[-+\d.e]+", word)]


def test_tables_figures_and_pages_have_the_units_of_the_option(study, tmp_path, capsys):
    run = ["simulate", "slider_crank_dry.toml", "--duration", "0.004", "--no-animation", "--no-error-estimate"]
    assert main([*run, "--out", str(tmp_path / "si"), "--no-plots"]) == 0
    si = capsys.readouterr().out
    assert main([*run, "--out", str(tmp_path / "mm"), "--units", UNITS, "--format", "svg"]) == 0
    other = capsys.readouterr().out
    names = {"slider.x [mm]": ("slider.x [mm]", 1.0), "slider.ax [km/s²]": ("slider.ax [mm/s²]", 1e6)}
    for name, (shown, factor) in names.items():
        assert _row(other, shown) == pytest.approx(np.multiply(_row(si, name), factor), rel=2e-4)
    assert "joint force [kN]" in other
    assert re.search(r"the largest joint force is [\d.]+ kN", " ".join(other.split()))
    summaries = [json.loads((tmp_path / name / "summary.json").read_text()) for name in ("si", "mm")]
    assert summaries[0]["outputs"] == summaries[1]["outputs"]
    assert ">[mm]<" in (tmp_path / "mm" / "output_slider.x.svg").read_text()
    assert main(["report", str(tmp_path / "mm"), "--units", UNITS]) == 0
    page = (tmp_path / "mm" / "report.html").read_text(encoding="utf-8")
    assert "Acceleration x of slider [mm/s²]" in page
    assert re.search(r'"name": "slider.x"[^}\[]*"unit": "mm"', page)
    assert main(["export", str(tmp_path / "mm"), "--to", "csv", "--units", UNITS]) == 0
    head, first, *_ = (tmp_path / "mm" / "trajectory.csv").read_text().splitlines()
    column = head.split(",").index("slider.x [mm]")
    run = linkages.load_trajectory(tmp_path / "mm" / "trajectory.npz")
    assert float(first.split(",")[column]) == pytest.approx(1e3 * run["slider.x"][0], rel=1e-15)


def test_the_units_of_an_experiment(tmp_path, capsys):
    text = linkages.find_file("four_bar_dry.toml").read_text(encoding="utf-8")
    shutil.copy(linkages.find_file("four_bar.sdf"), tmp_path)
    (tmp_path / "mine.toml").write_text(f'units = "mm/s2, r/min"\n{text}')
    words = ["simulate", str(tmp_path / "mine.toml"), "--duration", "1e-3", "--no-plots", "--no-animation"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    assert "[mm/s²]" in capsys.readouterr().out
    (tmp_path / "mine.toml").write_text(f'units = "mm/s2, apples"\n{text}')
    assert main([*words, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.startswith('error: mine.toml: units: has "apples"; give units of')


def test_a_sweep_in_other_units(tmp_path, capsys):
    vary = ["--vary", "joints.B.clearance=1e-4:2e-4:2", "--revolutions", "1", "--transient", "0", "--no-plots"]
    words = ["sweep", "slider_crank_dry.toml", *vary, "--output", "B.force", "--units", "mm,kN", "--out", str(tmp_path)]
    assert main(words) == 0
    table = capsys.readouterr().out
    written = json.loads((tmp_path / "sweep.json").read_text())
    peaks = [max(point["outputs"]["B.force"]["max"]) for point in written["points"]]
    assert _row(table, "0.1 ") == pytest.approx([1e-3 * peaks[0]], rel=1e-4)
    head, line, *_ = (tmp_path / "sweep.csv").read_text().splitlines()
    row = dict(zip(head.split(","), line.split(","), strict=True))
    assert float(row["joints.B.clearance [mm]"]) == pytest.approx(0.1, rel=1e-15)
    assert float(row["B.force.max [kN]"]) == pytest.approx(1e-3 * peaks[0], rel=1e-15)


def test_the_operating_point_is_in_the_table_of_a_linear_model(tmp_path, capsys):
    """A slider hangs from a spring: its deflection at rest is m g / k."""
    (tmp_path / "p.sdf").write_text(SLIDER)
    (tmp_path / "p.toml").write_text(HUNG)
    words = ["linearise", str(tmp_path / "p.toml"), "--equilibrium", "--output", "block.y", "--units", "mm"]
    assert main([*words, "--no-plots", "--out", str(tmp_path / "out")]) == 0
    assert _row(capsys.readouterr().out, "block.y [mm]") == pytest.approx([-1e3 * 2.0 * 9.81 / 400.0], rel=1e-5)


@pytest.mark.parametrize("units", ["mm, um", "apples", "mm,", "m m", "1"])
def test_wrong_units_are_refused_in_one_line(units, runs, capsys):
    assert main(["report", str(runs / "seven_bar"), "--units", units]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("error: --units: ")
