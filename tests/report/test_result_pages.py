"""Pages of the folders of other commands than ``simulate``: question, answer, table, figures, how to repeat."""

import html
import json
import shlex

import numpy as np
import pytest

from linkages.cli.main import main
from linkages.cli.printing import show

BEARING = "--diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000 --film short"
COMMANDS = {
    "sweep": "slider_crank_dry.toml --vary joints.B.clearance=1e-4:2e-4:2 --revolutions 1 --transient 0",
    "linearise": "hanging.toml --equilibrium",
    "bearing": f"{BEARING} --no-plots",
    "draw": "hanging.toml",
    "modes": "slider_crank_flexible.toml --count 2",
    "wear": "slider_crank_wear.toml --cycles 2 --no-animation",
}
PENDULUM = """<sdf version="1.9"><model name="p"><link name="rod"><pose>0 -0.5 0 0 0 0</pose><inertial><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link><joint name="O" type="revolute">
<parent>world</parent><child>rod</child><pose>0 0.5 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"""
HANGING = 'mechanism = "p.sdf"\nduration = 1.0\ngravity = [0.0, -9.81, 0.0]\n'


@pytest.fixture
def here(tmp_path, monkeypatch):
    (tmp_path / "p.sdf").write_text(PENDULUM)
    (tmp_path / "hanging.toml").write_text(HANGING)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("command", COMMANDS)
def test_a_page_has_question_answer_numbers_figures_and_the_command(command, here, capsys):
    words = [command, *COMMANDS[command].split(), "--out", "out"]
    assert main(words) == 0
    table = capsys.readouterr().out.rpartition("\n\nwritten to")[0]
    record = json.loads((here / "out" / "record.json").read_text())
    show(record["table"])  # printed, long sentences are broken and wide tables divided
    assert capsys.readouterr().out.replace("\n! ", "\n").split() == table.replace("\n! ", "\n").split()
    assert main(["report", "out"]) == 0
    page = html.unescape((here / "out" / "report.html").read_text(encoding="utf-8"))
    assert record["question"] in page
    assert record["answer"]
    assert all(sentence in page for sentence in record["answer"])
    assert f"<pre>{shlex.join(['linkages', *words[:-1], 'results/out'])}\nlinkages report results/out\n</pre>" in page
    assert f"numpy {np.__version__}" in page
    assert page.count("<figure>") == len([*(here / "out").glob("*.png")])
    assert ("<caption>Worn joints" in page) if command == "wear" else (f"<pre>{record['table']}</pre>" in page)


def test_the_answer_of_a_linear_model(here):
    """A rod of mass m hung l from its centre with inertia I swings with the square root of m g l / (I + m l²)."""
    assert main(["linearise", "hanging.toml", "--equilibrium", "--out", "out", "--no-plots", "--quiet"]) == 0
    frequency = np.sqrt(2.0 * 9.81 * 0.5 / (0.1 + 2.0 * 0.5**2)) / (2.0 * np.pi)
    assert f"natural frequency is {frequency:.4g} Hz." in (here / "out" / "record.json").read_text()


def test_a_later_command_removes_the_page_of_an_earlier_one(here):
    assert main(["linearise", "hanging.toml", "--equilibrium", "--out", "out", "--quiet"]) == 0
    assert main(["report", "out"]) == 0
    assert main(["bearing", *BEARING.split(), "--no-plots", "--out", "out", "--force"]) == 0
    assert {path.name for path in (here / "out").iterdir()} == {"bearing.json", "record.json"}


def test_vector_figures_are_part_of_the_page(here):
    assert main(["modes", "slider_crank_flexible.toml", "--count", "1", "--out", "out", "--format", "svg"]) == 0
    assert main(["report", "out"]) == 0
    assert "data:image/svg+xml;base64," in (here / "out" / "report.html").read_text()


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"title": 1}'])
def test_a_damaged_record_is_refused_in_one_line(content, here, capsys):
    (here / "out").mkdir()
    (here / "out" / "record.json").write_text(content)
    assert main(["report", "out"]) == 2
    error = capsys.readouterr().err
    assert "record.json" in error
    assert error.count("\n") == 1
