"""An environment without Drake: every command works, or says in one line what is missing."""

import importlib.metadata
import json
import subprocess
import sys

import pytest

from linkages.cli import commands, doctor
from optim.cli import identify, optimise, tolerances

NEEDS = "needs Drake, which is not installed: pip install drake (there is no Drake for Windows)"
PRESS = "seven_bar.toml"

# What `main` answers to commands, one after the other, in a process where Drake cannot be imported.
RUN = """
import contextlib, io, json, sys
sys.modules["pydrake"] = None
from linkages.cli import progress
from linkages.cli.main import main
progress._FIRST = progress._LATER = 1e6
answers = []
for words in json.loads(sys.argv[1]):
    told = io.StringIO()
    with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
        try:
            status = main(words)
        except BaseException as problem:
            status = repr(problem)
    lines = [line for line in told.getvalue().splitlines() if not line.startswith(("notice", "\\r"))]
    answers.append([status, lines])
print(json.dumps(answers))
"""


def answers(folder, commands):
    """Exit status and lines of standard error of each command."""
    words = [sys.executable, "-c", RUN, json.dumps([command.split() for command in commands])]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode == 0, done.stderr
    return dict(zip(commands, json.loads(done.stdout), strict=True))


URDF = (
    '<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j" type="continuous">'
    '<parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>'
)
WORK = [
    f"simulate {PRESS} --duration 0.02 --no-plots --out run",
    f"simulate {PRESS} --engine compiled --duration 0.02 --no-plots --no-animation --exaggerate 3 --out plain",
    "animate run --seconds 0.2",
    "report run",
    "export run --to csv",
    "overlay run plain --output slider7.x --no-plots --out over",
    "draw four_bar.sdf",
    "new mine",
    "modes slider_crank_flexible.toml",
    "linearise slider_crank_motor.toml --time 0 --output slider.x --out linear",
    f"sensitivity {PRESS} --wrt joints.A.clearance --duration 0.02 --out wrt",
    f"sweep {PRESS} --vary joints.A.clearance=1e-4:2e-4:2 --revolutions 1 --out swept",
    "bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000",
    "keys",
    "doctor",
    "completion bash",
    "import theirs.urdf --out ours.sdf",
    "continue slider_crank_lubricated.toml --vary drives.O.speed=510:515 --transient 1 --output B.force --no-plots",
    "wear slider_crank_wear.toml --cycles 2 --no-plots --no-animation --out worn",
    "tolerances short_tolerances.toml --no-plots --out scattered",
    "identify short_film.toml --no-plots --out found",
    "optimise short_search.toml --no-plots --out best",
    "study show best/study.sqlite",
]
REFUSED = {
    f"simulate {PRESS} --engine drake": "engine: drake",
    f"simulate {PRESS} --exaggerate 3": "--exaggerate",
    f"compare {PRESS}": "engine: drake",
    "modes three_rrr.toml --verify": "--verify",
    "optimise sevenbar_force.toml --verify": "--verify",
    "optimise slidercrank_flywheel.toml": "slidercrank_flywheel.toml: algorithm: snopt",
}


def test_all_commands_are_tried():
    """But the live page, which serves until Ctrl-C: its tests run where Drake is missing."""
    assert {words.split()[0] for words in (*WORK, *REFUSED)} == set(commands()) - {"play"}


@pytest.mark.processes
def test_commands_work_without_drake(tmp_path):
    for name, text in (tolerances.SHORT_FILES | identify.SHORT_FILES | optimise.SHORT_FILES).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "theirs.urdf").write_text(URDF)
    found = answers(tmp_path, WORK)
    assert {command: answer for command, answer in found.items() if answer[0] != 0} == {}
    page = (tmp_path / "run" / "animation.html").read_text()
    assert '"0.0000 s"' in page  # the slider is one of time
    assert "The run moves the links" in page


@pytest.mark.processes
def test_commands_that_need_drake_say_so_in_one_line(tmp_path):
    found = answers(tmp_path, REFUSED)
    assert found == {command: [2, [f"error: {where}: {NEEDS}"]] for command, where in REFUSED.items()}
    assert list(tmp_path.iterdir()) == []


def test_doctor_is_content_without_a_package_that_not_every_system_has(monkeypatch):
    """A missing package that every system has needs a remedy, Drake does not."""

    def version(name, known=importlib.metadata.version):
        if name in ("drake", "scipy"):
            raise importlib.metadata.PackageNotFoundError(name)
        return known(name)

    needs = ["scipy>=1.16", 'drake>=1.51; sys_platform != "win32"', 'mypy>=1; extra == "dev"']
    monkeypatch.setattr(importlib.metadata, "requires", lambda name: needs)
    monkeypatch.setattr(importlib.metadata, "version", version)
    found = {result.name: result for result in doctor.packages()}
    assert found["drake"].text.startswith("not on this system")
    assert not found["drake"].remedy
    assert found["scipy"].remedy.startswith("run `pip install")
    assert "mypy" not in found


def test_the_package_without_drake_offers_its_public_names():
    """Windows has no Drake: importing every public name must not need it."""
    code = "import sys; sys.modules['pydrake'] = None\nimport linkages, linkages.plots, optim\n"
    code += "for one in (linkages, linkages.plots, optim):\n    [getattr(one, name) for name in one.__all__]"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
