"""Content of the report: numbers, sources, commands, missing files."""

import html
import json
import math
import random
import re
import shlex
import shutil
from copy import deepcopy as copy_of
from functools import reduce
from html.parser import HTMLParser
from operator import getitem

import numpy as np
import pytest
from engines import slow_on_drake
from flexible_machines import bent_machine
from machines import joint, model, solid

from linkages import InputError, assess, find_file, load, summarize
from linkages.cli.main import main
from linkages.input.files.writing import content_of
from linkages.input.model.experiment import load_experiment
from linkages.results.trajectory import load_trajectory
from linkages.show.plots.histories import links_figure
from linkages.show.report.answer import answer, question, remarks, tiles
from linkages.show.report.page import render
from linkages.show.report.result_folder import load_results
from linkages.show.report.words import change, commands, experiment_file, percent, smoothing_lines


class Reader(HTMLParser):
    """Collects the text of cells and list items, and checks that tags close."""

    VOID = ("meta", "img", "br", "link", "input", "hr")

    def __init__(self):
        super().__init__()
        self.open, self.cells, self.rows = [], [], []

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def rows(page: str) -> dict[str, list[str]]:
    """Rows of all tables by their first cell; of several alike, the first."""
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return {row[0]: row[1:] for row in reversed(reader.rows)}


@pytest.fixture(scope="module")
def page(results_folder):
    return render(load_results(results_folder))


@pytest.fixture
def copy(results_folder, tmp_path):
    """A copy of the results that a test may change."""
    return shutil.copytree(results_folder, tmp_path / "results")


def test_the_tables_hold_the_summary_beside_ideal_joints_with_errors(page, results_folder):
    summary = json.loads((results_folder / "summary.json").read_text())
    table = rows(page)

    def number(text):
        return float(text.replace("−", "-"))

    value, ideal = summary["outputs"]["coupler.ax"], summary["ideal"]["outputs"]["coupler.ax"]
    cells = table["Acceleration x of coupler [m/s²]"]
    for text, expected in zip(cells, (ideal["min"], ideal["max"], value["min"], value["max"]), strict=False):
        assert number(text) == pytest.approx(expected, rel=5e-3)  # three digits
        assert len(text.lstrip("−0.").replace(".", "").partition("e")[0].rstrip("0")) <= 3
    assert number(cells[5]) == pytest.approx(summary["error"]["coupler.ax.peak"], rel=0.05)  # two digits
    links, model, exact, force, time, _, error, ratio, _ = table["B"]
    assert links == "coupler, follower"
    assert model == "dry"
    run = load_trajectory(results_folder / "trajectory.npz")
    assert number(force) >= run["B.force"].max() * (1 - 5e-3)  # the peak of continuous time, to three digits
    assert number(exact) == pytest.approx(summary["ideal"]["joints"]["B"]["force"]["peak"], rel=5e-3)
    assert 0.0 < number(time) < 0.006
    assert number(error) >= 0.0
    assert number(ratio) == pytest.approx(run["B.eccentricity_ratio"].max(), rel=1e-2)


def test_the_machine_drawn_heads_the_page(page, results_folder, copy):
    drawing = (results_folder / "drawing.svg").read_text(encoding="utf-8")
    assert all(f">{name}</text>" in drawing for name in ("O", "A", "B", "Q", "crank", "coupler", "follower"))
    assert page.index("data:image/svg+xml;base64,") < page.index("Question and answer")
    (copy / "drawing.svg").unlink()
    assert "data:image/svg" not in render(load_results(copy))


def test_parameters_stand_with_meaning_unit_and_source(page):
    table = rows(page)
    assert table["joints.A.clearance"] == ["0.0001", "m", "radial clearance c", "radial, Table 7"]
    assert table["drives.O.speed"][:2] == ["15", "rad/s"]
    assert table["drives.O.speed"][3] == "assumed: <sources> & all"  # text, not markup
    assert table["joints.A.viscosity"][1] == "Pa s"
    assert table["joints.A.viscosity"][3] == "not given"
    assert table["joints.B.clearance"] == ["0.00015", "m", "radial clearance c", "command line"]


SLIDE = """mechanism = "slide.sdf"
duration = 0.1
outputs = ["block.x"]
[drives.O]
force = {}
speed = 0.5
[frictions.rub]
joint = "O"
constant = 0.1
viscous = 0.2
"""


@pytest.mark.parametrize("force", [0.0, 1.0])
def test_tables_have_the_drives_that_act_and_the_units_of_prismatic_joints(force, tmp_path, capsys):
    """A force of zero gives the start of the block alone; with 1 N the drive is in the tables."""
    body = solid("block", 2.0) + joint("O", "world", "block", "prismatic", "1 0 0")
    (tmp_path / "slide.sdf").write_text(model("slide", body))
    (tmp_path / "slide.toml").write_text(SLIDE.format(force))
    out = tmp_path / "out"
    assert main(["simulate", str(tmp_path / "slide.toml"), "--no-plots", "--no-animation", "--out", str(out)]) == 0
    said, summary = capsys.readouterr().out, json.loads((out / "summary.json").read_text())
    found = rows(render(load_results(out)))
    assert bool(re.search(r"O force \[\w?N\]", said)) == ("O force [N]" in found) == bool(force)
    assert summary["drives"]["O"].get("acts", True) == bool(force)
    assert re.search(r"rub force \[\w?N\]", said)
    assert found["frictions.rub.constant"][:2] == ["0.1", "N"]
    assert found["frictions.rub.viscous"][:2] == ["0.2", "N s/m"]
    assert found["drives.O.speed"][:2] == ["0.5", "m/s"]


def test_the_question_names_each_clearance_and_its_joints(results_folder):
    text = question(load_results(results_folder))
    assert "0.1 mm of clearance in joint A (lubricated)" in text
    assert "0.15 mm of clearance in joint B (dry)" in text


def test_the_hardest_contacts_are_listed_in_the_order_of_time(copy):
    many = [f"B,{0.001 * k},1.0,0.1,1e-5,{100 + (k * 37) % 100},1e-6,0.9" for k in range(100)]
    head = "joint,start,approach_speed,tangential_speed,duration,peak_force,peak_penetration,separation_speed"
    (copy / "impacts.csv").write_text("\n".join([head, *many[:-1], many[-1].removesuffix("0.9")]) + "\n")
    (copy / "impacts_normal.csv").unlink()
    results = load_results(copy)  # a folder from before the normal forces were written
    assert math.isnan(results.impacts[-1].separation_speed)
    assert all(math.isnan(row.peak_normal_force) for row in results.impacts)
    page = render(results)
    assert "Contacts, 100 in all; the 40 hardest are shown" in page
    shown = [
        (float(start), float(force)) for start, force in re.findall(
            r'text">B</th><td>([\d.e-]+)</td><td>1</td><td>0.1</td><td>0.01</td><td>(\d+)</td>', page
        )
    ]  # fmt: skip
    assert [start for start, _ in shown] == sorted(start for start, _ in shown)
    assert sorted(force for _, force in shown) == list(range(160, 200))


def test_the_normal_part_of_the_peak_force_stands_in_file_and_page(results_folder, page):
    rows_of_file = load_results(results_folder).impacts
    assert rows_of_file
    for row in rows_of_file:  # without friction: all of it
        assert row.peak_normal_force == pytest.approx(row.peak_force, rel=1e-6)
    assert "<th>peak normal force [N]</th>" in re.sub(r"<th[^>]*>", "<th>", page)


@pytest.mark.slow
def test_the_commands_repeat_the_run(results_folder, tmp_path, monkeypatch, capsys):
    simulate, report = commands(load_results(results_folder))
    assert simulate == (
        "linkages simulate rocker.toml --engine compiled --set duration=0.006 --set joints.B.clearance=0.00015"
        " --out results/out"
    )
    shutil.copy(results_folder.parent / "machine.sdf", tmp_path)
    (tmp_path / "rocker.toml").write_text((results_folder.parent / "rocker.toml").read_text())
    monkeypatch.chdir(tmp_path)
    assert main([*simulate.split()[1:], "--no-plots", "--no-animation"]) == 0
    again = json.loads((tmp_path / "results" / "out" / "summary.json").read_text())
    before = json.loads((results_folder / "summary.json").read_text())
    for summary in (again, before):
        del summary["provenance"]["wall_time"], summary["provenance"]["folder"]
    assert again == before
    assert main(report.split()[1:]) == 0
    assert "needs no network" in capsys.readouterr().out
    text = (tmp_path / "results" / "out" / "report.html").read_text()
    assert "There is no animation in this folder" in text
    assert "There are no figures in this folder" in text


def test_the_experiment_in_the_page_is_the_one_that_was_run(page, results_folder, tmp_path):
    shown = html.unescape(re.findall(r"<pre>(.*?)</pre>", page, re.DOTALL)[-1])
    (tmp_path / "rocker.toml").write_text(shown)
    experiment = load_experiment(tmp_path / "rocker.toml")
    assert experiment.duration == 0.006
    assert experiment.joints["B"].clearance == 1.5e-4
    assert experiment.model_dump(exclude_unset=True) == load_results(results_folder).experiment
    assert experiment_file(load_results(results_folder)) == shown


def test_a_run_that_failed_says_so_and_what_to_try(copy):
    summary = json.loads((copy / "summary.json").read_text())
    summary |= {"status": "step-size-collapse", "duration": 0.0031, "error": {}}
    (copy / "summary.json").write_text(json.dumps(summary))
    page = render(load_results(copy))
    assert "ended early, at 0.0031 s of 0.006 s" in page
    assert "loosen the accuracy" in page
    assert "The errors of this run were not estimated" in page
    assert rows(page)["A"][6] == "not estimated"
    assert "--no-error-estimate" not in page  # it was not what left them out


@pytest.mark.parametrize(
    ("value", "reference", "text"),
    [(1.0, 1.0, "unchanged"), (1.1, 1.0, "+10 %"), (0.9, 1.0, "−10 %"), (5.0, 1.0, "5 times"), (0.0, 0.0, "unchanged"),
     (5e-5, 0.0, "there is none"), (5e-5, 2e-17, "there is none"), (0.0, 1.0, "0 times")],
)  # fmt: skip
def test_change(value, reference, text):
    assert change(value, reference) == text


BAD = {
    "no folder": (lambda folder: shutil.rmtree(folder), "is not a folder"),
    "no summary": (lambda folder: (folder / "summary.json").unlink(), "summary.json: is missing"),
    "no JSON": (lambda folder: (folder / "summary.json").write_text("{"), "cannot be read"),
    "another summary": (lambda folder: (folder / "summary.json").write_text("{}"), "is missing"),
    "a list": (lambda folder: (folder / "summary.json").write_text("[]"), "is not a JSON object"),
    "half a character": (lambda folder: (folder / "summary.json").write_text(r'{"title": "\ud800"}'), "cannot be read"),
    "no text": (lambda folder: (folder / "animation.html").write_bytes(b"<html>\xff"), "animation.html: cannot be read"),
    "half a page": (lambda folder: (folder / "animation.html").write_text("<html><body>"), "ends before </html>"),
    "endless contact": (lambda folder: (folder / "impacts.csv").write_text('joint\n"' + 200_000 * "x"), "list of contacts"),
    "broken contacts": (lambda folder: (folder / "impacts.csv").write_text("joint,start\nB,1\n"), "list of contacts"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_folder_of_results_is_bad_input(copy, capsys, case):
    spoil, reason = BAD[case]
    spoil(copy)
    assert main(["report", str(copy)]) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith("error: ")
    assert reason in error
    assert "\n" not in error
    assert not (copy / "report.html").exists()


def places(part, path=()):
    """Paths of everything in nested tables and lists."""
    yield path
    items = part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ()
    for key, value in items:
        yield from places(value, (*path, key))


def damaged(summary, path, value):
    """A summary with another value at a path, or with nothing there."""
    if not path:
        return value
    spoilt = copy_of(summary)
    *way, last = path
    part = reduce(getitem, way, spoilt)
    if value is ...:
        del part[last]
    else:
        part[last] = value
    return spoilt


@pytest.mark.parametrize(
    ("replaced", "path", "again"),
    [("gravity.y=-1", "gravity", "gravity=[0.0, -1.0, 0.0]"), ('joints.A={model = "ideal"}', "joints.A", "")],
)
def test_a_replaced_table_or_component_is_in_the_report_and_its_command(tmp_path, replaced, path, again):
    out, quick = tmp_path / "out", ["--no-plots", "--no-animation", "--no-error-estimate", "--duration", "0.01"]
    assert main(["simulate", "seven_bar.toml", "--set", replaced, *quick, "--out", str(out)]) == 0
    assert main(["report", str(out)]) == 0
    results = load_results(out)
    assert results.source_of(f"{path}.model") == results.sources[path] == "command line"
    assert not any(one.startswith(f"{path}.") for one in results.sources)  # of values that are no longer there
    assert f"--set {shlex.quote(again or replaced)}" in commands(results)[0]


def test_a_damaged_summary_is_told_or_refused_in_one_line(copy):
    """Any value replaced or removed: no page, or a page of the remaining data; never another error."""
    summary, tried, refused, told = load_results(copy).summary, 0, 0, 0
    sample = random.Random(14)
    for path in sample.sample(sorted(places(summary), key=str), 60):
        for value in sample.sample([None, "x", 3, -1.5, [], {}, [1], math.nan, ...], 2):
            if (path, value) == ((), ...):
                continue
            tried += 1
            (copy / "summary.json").write_text(json.dumps(damaged(summary, path, value)))
            try:
                results = load_results(copy)
            except InputError as problem:
                refused += bool(re.fullmatch(r".*summary\.json: .+", str(problem)))
            else:
                told += bool(render(results))
    assert told > 10
    assert refused + told == tried


def test_a_number_of_a_run_may_be_tiny(copy):
    summary = json.loads((copy / "summary.json").read_text())
    name = next(iter(summary["outputs"]))
    summary["outputs"][name]["min"] = 6.3e-53
    (copy / "summary.json").write_text(json.dumps(summary))
    assert load_results(copy).summary["outputs"][name]["min"] == 0.0


def test_a_page_that_cannot_be_written_is_bad_input(copy, capsys):
    assert main(["report", str(copy), "--out", str(copy / "none" / "page.html")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_a_folder_is_no_page(results_folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for out in (".", str(tmp_path)):
        assert main(["report", str(results_folder), "--out", out]) == 2
        assert capsys.readouterr().err.endswith(f"error: --out: {out}: cannot be written (Is a directory)\n")
    assert not list(tmp_path.iterdir())


def test_shares_near_one_and_above_are_written_without_powers_of_ten():
    written = {0.9997: "100 %", 1.5: "150 %", 0.0123: "1.2 %", 3.0: "3 times", None: "-"}
    assert {part: percent(part) for part in written} == written


def test_the_answer_says_what_the_joints_do_what_it_changes_and_what_to_try(results_folder, copy):
    summary = load_results(results_folder).summary
    action, effect, trial = answer(summary, "rocker.toml")
    oil, touching = summary["joints"]["A"], summary["joints"]["B"]
    assert action.startswith("An oil film carries joint A: a journal moves up to ")
    assert f"{100.0 * oil['eccentricity_ratio']['peak']:.2g} % of the clearance from the centre" in action
    assert f"joint B touches {touching['impacts']} times and is in contact for " in action
    name, joint = max(summary["joints"].items(), key=lambda item: item[1]["force"]["peak"])
    ratio = joint["force"]["peak"] / summary["ideal"]["joints"][name]["force"]["peak"]
    assert effect.startswith("Compared with ideal joints, follower.omega differs by up to ")
    assert effect.endswith(f" N, in {name}, {ratio:.3g} times as large.")
    half = 0.5 * summary["provenance"]["experiment"]["joints"]["B"]["clearance"]
    trial = trial.removeprefix("Try half of this clearance: linkages simulate rocker.toml --engine compiled ")
    assert trial == f"--set duration=0.006 --set joints.B.clearance={half:g}"
    assert remarks(summary)[0].startswith("A film law is used at an L/D outside its validity: 1 in A (long: L/D > 8")
    for joint in summary["joints"].values():
        for key in ("eccentricity_ratio", "contact_fraction", "impacts", "film_thickness"):
            joint.pop(key, None)
        joint["model"] = "ideal"
    del summary["difference"]
    (copy / "summary.json").write_text(json.dumps(summary))
    action, effect, trial = answer(load_results(copy).summary, "rocker.toml")
    assert action == "All joints are ideal."
    assert "with ideal joints" not in effect
    assert "linkages keys joints" in trial


def test_a_machine_without_joint_forces_is_answered_by_its_torques():
    """The wheels of a gear pair turn about their centres; the peaks are those of the summary."""
    overrides = {"duration": 0.08, "gears.mesh.backlash.normal": 4e-5}
    found = assess(load(find_file("gear_rattle.toml"), overrides), "compiled", error_estimate=False)
    summary = content_of(summarize(found))
    mesh, drive = summary["loads"]["mesh"]["torque"]["peak"], summary["drives"]["A"]["torque"]["peak"]
    action, effect, trial = answer(summary, "gear_rattle.toml")
    assert f"the flanks of mesh touch {summary['loads']['mesh']['impacts']} times" in action
    assert effect.startswith("The joints carry no force but those of teeth or belts, which are not computed; ")
    assert f"the largest torque of the loads is {mesh:.3g} N m, of mesh, " in effect
    assert f"the largest torque of the drives is {drive:.3g} N m, of A, " in effect
    assert trial.endswith(" --set gears.mesh.backlash.normal=2e-05")
    shown = {meaning.partition(";")[0]: number for number, meaning in tiles(summary)}
    assert shown["largest torque, of mesh"] == f"{mesh:.4g} N m"
    assert "of the time in contact, flanks of mesh" in shown


def test_a_machine_that_nothing_loads_is_answered_by_its_motion():
    summary = content_of(
        summarize(assess(load(find_file("gear_rattle.toml"), {"duration": 0.01}), "compiled", error_estimate=False))
    )
    summary |= {"loads": {}, "drives": {}, "warnings": []}
    _, effect, _ = answer(summary, "gear_rattle.toml")
    said = "No force passes through the joints, and no load or drive acts; wheel.omega reaches "
    assert effect.startswith(said)
    assert float(effect.removeprefix(said).split()[0]) == pytest.approx(
        summary["outputs"]["wheel.omega"]["peak"], rel=5e-3
    )


def test_links_that_bend_have_numbers_a_table_and_a_figure(tmp_path):
    """Largest deflection and stress of the columns, with time and place; the figure's marks are there too."""
    found = assess(bent_machine(tmp_path, "slider_crank"), "compiled", error_estimate=False)
    link, run = summarize(found)["links"]["rod"], found.run
    for column, entry in {"rod.deflection": "deflection", "rod.bending": "bending", "rod.stress": "stress"}.items():
        assert link[entry]["peak"] == pytest.approx(np.abs(run[column]).max(), rel=1e-3)
        assert link[entry]["time"] == pytest.approx(run.time[np.abs(run[column]).argmax()], abs=2e-4)
    for entry in ("deflection", "stress"):
        assert link[entry]["place"] in run[f"rod.{entry}_place"]
    # the beam's edges: M height / (2 I), and N / A of the largest force at its ends
    bending = link["bending"]["peak"] * 0.004 / (0.008**4 / 12.0)
    assert bending <= link["stress"]["peak"] <= bending + 1100.0 / 6.4e-5
    figure = links_figure(found)
    marks = [line for axis in figure.axes for line in axis.lines if line.get_marker() == "o"]
    assert [line.axes.get_xlabel()[-4:] for line in marks][1] == "[mm]"
    assert [line.get_xdata()[0] for line in marks] == pytest.approx(
        [link["stress"]["time"], 1e3 * link["stress"]["place"]], 0.02
    )


@slow_on_drake
def test_outputs_of_bending_without_a_prescribed_motion(tmp_path, engine):
    """The ideal linkage is then a run of rigid links, which has none; the run has, in numbers, figures and report."""
    path = bent_machine(tmp_path, "slider_crank", duration=1e-3).experiment.source
    torque = '[torques.push]\nlink = "crank"\ntorque = 20.0\n'
    path.write_text(path.read_text().replace("[drives.O]\nspeed = 150\n", torque))
    options = ["--engine", engine, "--no-error-estimate", "--no-animation", "--out", str(tmp_path / "out")]
    assert main(["simulate", str(path), "--set", "links.rod.segments=4", *options]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["ideal"]["outputs"]["middle.deflection"]["peak"] is None
    assert summary["outputs"]["middle.deflection"]["peak"] == pytest.approx(3e-4, rel=0.1)
    assert (tmp_path / "out" / "output_middle.deflection.png").exists()
    assert "middle.deflection" in render(load_results(tmp_path / "out"))


def test_the_table_of_links_that_bend(tmp_path):
    """Table of the command, with errors of peaks; none for a run without flexible links."""
    system = bent_machine(tmp_path, "slider_crank", duration=2e-3)
    options = ["--engine", "compiled", "--no-plots", "--no-animation", "--out", str(tmp_path / "out")]
    assert main(["simulate", str(system.experiment.source), *options]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    cells = rows(render(load_results(tmp_path / "out")))["rod.stress [Pa]"]
    exact, peak, time, place, error = (float(text.replace("−", "-")) for text in cells)
    link = summary["links"]["rod"]["stress"]
    assert (peak, time, place) == pytest.approx((link["peak"], link["time"], link["place"]), rel=5e-3)
    assert exact == pytest.approx(summary["ideal"]["links"]["rod"]["stress"]["peak"], rel=5e-3)
    assert error == pytest.approx(summary["error"]["rod.stress.peak"], rel=0.05)


def test_smoothing_says_nothing_about_forces_without_a_value():
    summary = {"smoothing": {"half": {}, "double": {"A.force.peak": 1.5}}}
    assert smoothing_lines(summary) == ["double smoothing changes the peaks of forces by at most 50 % (A.force.peak)"]
