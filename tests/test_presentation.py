"""Figures for a paper: format, size, style; fonts embedded, text as text. Runs in one figure and one table."""

import json
import re
import zlib

import numpy as np
import pytest
from matplotlib import image

import linkages
from linkages.cli.main import main
from linkages.plots import overlay_figure, presented, write_figures

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
        assert np.allclose([float(side) for side in box.groups()], [85 * POINT, 60 * POINT], atol=1e-6)
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


def test_svg_figures_have_texts(study, tmp_path):
    with presented(format="svg"):
        names = {path.name: path.read_text() for path in write_figures(study, tmp_path)}
    assert ">time [s]<" in names["joint_forces.svg"]


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [("--size", "85", "write the width"), ("--size", "0x5mm", "85x60mm"), ("--size", "9e9mm", "85x60mm"),
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
    upper, lower = overlay_figure(trajectories, ["slider7.ax", "B.force"]).axes
    assert len(upper.lines) == 1
    assert len(lower.lines) == 2
    assert upper.get_legend()
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
