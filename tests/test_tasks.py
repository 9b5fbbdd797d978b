"""The page "I want to ...": every command and every line of Python runs, with short runs."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from machines import ZERO, model

import linkages
from linkages.cli.main import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "tasks.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\| .* \| `(linkages .*?)`", PAGE, re.MULTILINE)
LINES = [re.findall(r"`([^`]*)`", row) for row in re.findall(r"^\| .*? \| (`(?!linkages ).*) \|$", PAGE, re.MULTILINE)]

#: Options that shorten a command.
SHORT = {
    "simulate": "--no-plots --no-animation --quiet",
    "animate": "--seconds 0.2",
    "sweep": "--revolutions 1 --transient 0 --no-plots",
    "continue": "--transient 1 --no-plots",
    "sensitivity": "--no-error-estimate --no-plots",
    "wear": "--no-plots",
    "modes": "--no-plots",
    "linearise": "--no-plots",
    "bearing": "--film short --no-plots",
    "compare": "--accuracy 1e-9",
    "optimise": "--no-verify",
    "identify": "--no-plots",
}
PENDULUM = f"""<link name="rod"><pose>{ZERO}</pose><inertial><pose>0 -0.5 0 0 0 0</pose><mass>1</mass><inertia>
<ixx>1</ixx><iyy>1</iyy><izz>0.1</izz></inertia></inertial></link><joint name="O" type="revolute"><parent>world</parent>
<child>rod</child><axis><xyz>0 0 1</xyz></axis></joint>"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files that the page names."""
    folder = tmp_path_factory.mktemp("tasks")

    def short(name, shipped_name, duration, more=""):
        text = linkages.find_file(f"{shipped_name}.toml").read_text(encoding="utf-8")
        text = re.sub(r"^duration .*", f"duration = {duration}", text, flags=re.MULTILINE)
        sdf = re.search(r'mechanism\s*=\s*"(.*?)"', text)[1]
        (folder / sdf).write_text(linkages.find_file(sdf).read_text(encoding="utf-8"), encoding="utf-8")
        (folder / f"{name}.toml").write_text(text + more, encoding="utf-8")

    short("my", "slider_crank_dry", 0.01)
    short("lubricated", "slider_crank_lubricated", 0.024)
    short("flexible", "slider_crank_flexible", 0.01)
    short("worn", "slider_crank_wear", 0.02)
    t = np.linspace(0.0, 1.0, 101)
    np.savetxt(folder / "encoder.csv", np.column_stack([t, 3.0 * t]), delimiter=",", header="t,phi", comments="")
    drive = 'file = "encoder.csv"\ntime = "t"\nangle = "phi"\nresolution = "4096/rev"'
    driven = f'mechanism = "four_bar.sdf"\nduration = 0.1\n[drives.O]\n{drive}\n'
    (folder / "four_bar.sdf").write_text(linkages.find_file("four_bar.sdf").read_text(encoding="utf-8"))
    (folder / "driven.toml").write_text(driven)
    np.savetxt(folder / "measured.csv", np.column_stack([t, t]), delimiter=",", header="time,O.torque", comments="")
    (folder / "pendulum.sdf").write_text(model("pendulum", PENDULUM))
    (folder / "hanging.toml").write_text('mechanism = "pendulum.sdf"\nduration = 1.0\ngravity = [0.0, -9.81, 0.0]\n')
    (folder / "robot.urdf").write_text(
        '<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j" type="continuous">'
        '<parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>'
    )
    curves = linkages.simulate(linkages.load(folder / "lubricated.toml", {"duration": 0.002}), outputs=["B.force"])
    table = np.column_stack([curves.time, curves["B.force"]])[1:]
    np.savetxt(folder / "force.csv", table, delimiter=",", header="time,force", comments="")
    column = '[data.run.columns.force]\noutput = "B.force"\ndeviation = 1.0'
    unknown = '[unknowns.viscosity]\npath = "joints.B.viscosity"\nlower = 0.1\nupper = 1.0'
    candidate = '[plan]\nrate = 1e5\nduration = 0.002\n[plan.candidates.force]\noutput = "B.force"\ndeviation = 1.0'
    (folder / "fit.toml").write_text(
        f'experiment = "lubricated.toml"\n[data.run]\nfile = "force.csv"\n{column}\n{unknown}\n{candidate}\n[fit]\nposterior_runs = 1000\n'
    )
    (folder / "study.toml").write_text((ROOT / ".ci" / "small_study.toml").read_text())
    return folder


def test_there_are_enough_tasks():
    assert len(COMMANDS) + len(LINES) >= 18


@pytest.mark.parametrize("command", COMMANDS, ids=lambda text: text.split()[1])
def test_command_of_a_task_runs(folder, command, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    words = shlex.split(command)[1:]
    if words[0] == "play":  # it serves a page until Ctrl-C
        with pytest.raises(SystemExit, match="0"):
            main([*words, "--help"])
        return
    for name in (word.removeprefix("results/") for word in words if word.startswith("results/")):
        if not (folder / "results" / name).is_dir():
            assert main(["simulate", f"{name}.toml", "--no-plots", "--no-animation", "--quiet"]) == 0
    assert main([*words, *SHORT.get(words[0], "").split()]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("lines", LINES, ids=lambda lines: lines[0][:40])
def test_lines_of_a_task_run(folder, lines, monkeypatch):
    monkeypatch.chdir(folder)
    assert main(["simulate", "my.toml", "--no-plots", "--no-animation", "--quiet"]) == 0
    names = {"np": np, "linkages": linkages}
    if any("add_linkage" in line for line in lines):
        exec("from linkages.engines.drake import add_linkage\nfrom pydrake.all import DiagramBuilder", names)
    exec("\n".join(lines).replace("(1000, 1)", "(5, 1)"), names)
