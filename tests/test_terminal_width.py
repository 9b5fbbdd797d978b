"""Every command prints lines of at most 80 columns, and into a pipe no escape codes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from linkages.cli import commands
from linkages.cli.main import main
from linkages.cli.printing import WIDTH, narrowed

ROOT = Path(__file__).resolve().parents[1]
_QUICK = ("--no-plots", "--no-animation")
_WIDTH = 80  # columns
#: Words of each command; "{press}" is a folder of results, "{out}" a new one, "{study}" a folder of a study.
COMMANDS = {
    "simulate": ["simulate", "seven_bar_mixed.toml", "--duration", "0.02", *_QUICK, "--out", "{out}"],
    "sweep": "sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.4mm:3 --revolutions 1 --transient 0 --no-plots --out {out}",
    "map": "sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.5mm:2 --vary drives.O1.speed=2:6:2 --output A.force"
    " --revolutions 1 --transient 0 --limit A.force=10N --no-plots --out {out}",
    "wear": "wear slider_crank_wear.toml --cycles 20 --no-plots --no-animation --out {out}",
    "animate": "animate {press} --format gif --seconds 0.1",
    "overlay": "overlay {press} --output A.force --no-plots --out {out}",
    "report": "report {press}",
    "export": "export {press} --to csv",
    "loads": "export {press} --loads",
    "bearing": "bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000 --no-plots --out {out}",
    "draw": "draw six_bar_dry.toml --out {out}",
    "new": "new my",
    "import": "import {sdf} --out {out}/my.sdf",
    "modes": "modes slider_crank_flexible.toml --count 3 --no-plots --out {out}",
    "linearise": "linearise slider_crank_flywheel.toml --time 0.1 --output slider.x --no-plots --out {out}",
    "sensitivity": "sensitivity slider_crank_lubricated.toml --output B.force --wrt joints.B.clearance joints.B.viscosity"
    " --no-plots --out {out}",
    "keys": "keys",
    "doctor": "doctor",
    "optimise": "optimise {small} --no-verify --no-plots --out {out}",
    "study show": "study show {study}/study.sqlite",
    "study export": "study export {study}/study.sqlite --out {out}.csv",
    "study sensitivity": "study sensitivity {small} --samples 4 --no-plots --out {out}",
    "tolerances": "tolerances slidercrank_tolerances.toml --samples 8 --no-plots --out {out}",
}  # fmt: skip
_LONG = {"doctor", "sensitivity", "tolerances", "wear"}
_SLOW = {
    "compare": "compare slider_crank_lubricated.toml --duration 0.002 --out {out}",
    "continue": "continue slider_crank_lubricated.toml --vary drives.O.speed=520:524 --output B.force --transient 2 --no-plots"
    " --out {out}",
    "robot": "modes three_rrr.toml --no-plots --out {out}",
}  # fmt: skip


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """Folders with the results of a short run and of a small study."""
    root = tmp_path_factory.mktemp("results")
    press, study, small = root / "press", root / "study", ROOT / ".ci" / "small_study.toml"
    assert main(["simulate", "seven_bar.toml", "--duration", "0.1", *_QUICK, "--quiet", "--out", str(press)]) == 0
    assert main(["optimise", str(small), "--no-verify", "--no-plots", "--out", str(study)]) == 0
    return {"press": press, "study": study, "small": small, "sdf": ROOT / "sdf" / "four_bar.sdf"}


def _case(name):
    return pytest.param(name, marks=[pytest.mark.slow] if name in _LONG or name in _SLOW else [])


@pytest.mark.parametrize("name", [_case(name) for name in (*COMMANDS, *_SLOW)])
def test_a_command_prints_narrow_lines_without_escape_codes(name, places, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(_WIDTH))
    monkeypatch.chdir(tmp_path)  # so that paths are short
    capsys.readouterr()
    words = {**COMMANDS, **_SLOW}[name]
    words = words.split() if isinstance(words, str) else words
    known = {what: os.path.relpath(place) for what, place in places.items()} | {"out": "out"}
    assert main([word.format(**known) for word in words]) == 0
    printed = capsys.readouterr()
    lines = (printed.out + printed.err).splitlines()
    assert lines
    assert [line for line in lines if len(line) > _WIDTH] == []
    assert "\x1b" not in printed.out + printed.err


@pytest.mark.parametrize("name", ["", *commands()])
def test_the_help_of_a_command_fits_into_80_columns(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(_WIDTH))
    with pytest.raises(SystemExit):
        main([*name.split(), "--help"])
    assert [line for line in capsys.readouterr().out.splitlines() if len(line) > _WIDTH] == []


def test_a_pipe_gets_no_escape_codes_even_where_a_colour_terminal_is_named():
    """In a separate process, as a user's shell starts it."""
    words = [sys.executable, "-m", "linkages.cli.main", "keys", "friction"]
    found = subprocess.run(
        words, capture_output=True, env=os.environ | {"TERM": "xterm-256color", "COLORTERM": "truecolor"}
    )
    assert found.returncode == 0
    assert b"\x1b" not in found.stdout + found.stderr


def test_a_wide_table_becomes_narrow_and_then_several():
    """Its names stand before each part; every number is still there."""
    names = [f"column {k}" for k in range(6)]
    rows = [["value", *names]] + [[f"{k}", *[f"{1000 * k + n}" for n in range(6)]] for k in range(3)]
    wide = [f"{row[0]:20s}" + "".join(f"{cell:>30s}" for cell in row[1:]) for row in rows]
    assert max(map(len, narrowed(wide))) <= WIDTH
    assert len(narrowed(wide)) == len(wide)
    wider = [f"{row[0]:20s}" + "".join(f"{cell + '_' * 12:>30s}" for cell in row[1:]) for row in rows]
    lines = narrowed(wider)
    assert max(map(len, lines)) <= WIDTH
    assert sum(line.startswith("value") for line in lines) == 2
    assert {word for line in wider for word in line.split()} == {word for line in lines for word in line.split()}
