"""Command lines with something wrong in them, for all commands and options; and commands that Ctrl-C strikes.

A command line is made of valid words, and of options of the command's own parser with values that are mostly valid.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import time
from contextlib import chdir, contextmanager
from functools import cache
from pathlib import Path

import pytest
from machines import four_bar
from mutant_trials import DESCRIPTIONS, URDF, command, put, results, undamaged
from mutants import VALUES, Mutator
from processes import COMMAND, begun, processor_time, without_progress

from linkages.cli import commands
from linkages.cli.main import parser
from linkages.input.files.shipped import data_folder

STUDY = """experiment = "slider_crank_dry.toml"
set = { duration = 2e-3 }
[variables.clearance]
path = "joints.B.clearance"
lower = 5e-5
upper = 2e-4
[objectives.force]
terms = [{ functional = "peak", output = "B.force" }]
[algorithm]
name = "ga"
population = 4
generations = 2
"""
DRY, QUIET = "slider_crank_dry.toml", ("--no-plots", "--no-animation")
#: Valid words of each command, of little work.
LINES = {
    "simulate": (DRY, "--duration", "2e-3", *QUIET),
    "compare": (DRY, "--duration", "2e-4"),
    "sweep": (DRY, "--vary", "joints.B.clearance=1e-4:2e-4:2", "--revolutions", "1", "--transient", "0", "--no-plots"),
    "continue": ("slider_crank_lubricated.toml", "--vary", "drives.O.speed=100:101", "--transient", "1", "--no-plots"),
    "wear": ("slider_crank_wear.toml", "--cycles", "3", *QUIET),
    "report": ("results",),
    "overlay": ("results", "--output", "B.force", "--no-plots"),
    "animate": ("results", "--seconds", "0.1"),
    "export": ("results", "--to", "csv"),
    "bearing": (
        *("--diameter", "0.1", "--length", "0.05", "--clearance", "1e-4", "--viscosity", "0.03", "--speed", "100"),
        *("--load", "1000", "--film", "short", "--no-plots"),
    ),
    "draw": ("four_bar.sdf",),
    "new": ("mine",),
    "import": ("theirs.urdf", "--out", "ours.sdf"),
    "modes": ("slider_crank_flexible.toml", "--count", "2", *QUIET),
    "linearise": ("hanging.toml", "--equilibrium", "--no-plots"),
    "sensitivity": (DRY, "--wrt", "joints.B.clearance", "--duration", "1e-3", "--no-plots"),
    "play": (DRY, "--no-browser"),
    "keys": ("joints.A",),
    "completion": ("bash",),
    "optimise": ("study.toml", "--no-plots"),
    "study show": ("study.sqlite",),
    "study export": ("study.sqlite", "--out", "designs.csv"),
    "study sensitivity": ("study.toml", "--samples", "2", "--no-plots"),
    "doctor": ("--no-such-option",),
}
#: Valid values of options.
GOOD = {
    "set": ("joints.B.clearance=2e-4", "duration=1e-3", "gravity.y=-1", "title=x"),
    "vary": ("joints.B.clearance=1e-4:2e-4:2", "joints.B.clearance=0.1mm:0.2mm", "drives.O.speed=100:101"),
    "duration": ("1e-3", "1 ms"),
    "output": ("B.force", "slider.x"),
    "wrt": ("joints.B.clearance", "drives.O.speed"),
    "input": ("O.torque",),
    "drive": ("O",),
    "engine": ("compiled",),
    "out": ("out",),
    "threads": ("1", "2"),
    "seed": ("3",),
    "seeds": ("1:2",),
    "start": ("100",),
    "source": ("mine.machine.toml",),
    "frequencies": ("1:100:5",),
    "groove": ("angle = 90 deg, extent = 20 deg, length = 0.8", "angle = 200 deg, extent = 9 deg"),
    "cavitation": ("reynolds", "mass-conserving"),
    "film": ("finite", "long"),
    "tilt": ("1e-5, 0",),
    "grade": ("46",),
    "inlet": ("40",),
    "branch": ("30",),
    "dynamic": ("quasi-static",),
}
BAD = [
    "",
    " ",
    "é",
    "名",
    "\udcff",
    "a" * 2000,
    "é" * 300,
    "-1",
    "-",
    "--",
    "-0.0",
    "1e400",
    "x=1",
    "=1",
    "x=",
    "=",
    "1:2",
]
BAD += [
    "a:b:c",
    "1:2:3:4",
    "a\nb",
    "\t",
    "0.1 mm",
    "1 parsec",
    "10e3 kg",
    "/dev/null",
    "/proc/none/x",
    "$HOME",
    "*",
    "'",
]
BAD += ["A.force", "joints.A.clearance=1e-4", "joints.A.clearance=", "joints=1", "99999999999999999999", "0.5", "1e9"]
NOT = ("/", "../../..")  # places that no mutant may write to
ANSWER = "interrupted; writing what was computed"  # of a command that keeps it, such as a long run
LIMIT = 1.0  # s from Ctrl-C to the end of a command, of the clock or of the processor


@cache
def subparsers() -> dict[str, argparse.ArgumentParser]:
    """Return the parser of each command; nested commands have both names."""
    found: dict[str, argparse.ArgumentParser] = {}

    def collect(name: str, one: argparse.ArgumentParser) -> None:
        nested = [action for action in one._actions if isinstance(action, argparse._SubParsersAction)]
        if not nested:
            found[name] = one
        for action in nested:
            for inner, part in action.choices.items():
                collect(f"{name} {inner}".strip(), part)

    collect("", parser(commands()))
    return found


def options_of(name: str) -> list[argparse.Action]:
    """Return the options of a command but ``--help``."""
    return [action for action in subparsers()[name]._actions if action.option_strings and action.dest != "help"]


def option(mutator: Mutator, action: argparse.Action, valid: float = 0.8) -> list[str]:
    """Return the words of an option; its value is valid with this probability."""
    dice = mutator.dice
    name = dice.choice(action.option_strings)
    if action.nargs == 0 or isinstance(action, argparse.BooleanOptionalAction):
        return [name]
    good = GOOD.get(action.dest) or action.choices or ("1", "0.5", "2")
    value = dice.choice(list(good) if dice.random() < valid else [*BAD, *VALUES])
    return [f"{name}={value}"] if dice.random() < 0.1 else [name, value]


def line(mutator: Mutator, name: str) -> list[str]:
    """Return a valid command line with some options more."""
    words = [*name.split(), *LINES[name]]
    known = options_of(name)
    for action in mutator.dice.sample(known, min(mutator.dice.choice((0, 0, 1, 2)), len(known))):
        if not set(action.option_strings) & set(words):
            words += option(mutator, action)
    return words


def damaged(mutator: Mutator, name: str) -> list[str]:
    """Return a command line with up to two faults."""
    dice, words = mutator.dice, line(mutator, name)
    others = options_of(dice.choice(list(LINES)))
    for _ in range(dice.choice((0, 1, 1, 2))):
        at = dice.randrange(len(words))
        flags = [k for k, word in enumerate(words) if word.startswith("--")] or [at]
        match dice.randrange(9):
            case 0:
                del words[at]  # a value, an option, the command
            case 1:
                words.insert(at, dice.choice([*BAD, *VALUES]))
            case 2:
                k = dice.choice(flags)
                words += words[k : k + 2]  # given twice
            case 3 if others:
                words += option(mutator, dice.choice(others), 0.5)
            case 4:
                words.append(dice.choice(("--" + "x" * dice.choice((3, 2000)), "--é", "-z", "--out", "--set")))
            case 5:
                k = dice.choice(flags)
                words[k] = words[k][: dice.randrange(len(words[k]) + 1)]  # an abbreviation, a cut word
            case _:
                words[at] = dice.choice([*BAD, *VALUES])
        words = words or [""]
    return [word.replace("\0", "") for word in words if word not in NOT and not word.endswith("=/")]


@contextmanager
def inputs(folder: Path):
    """Make a folder with the files of the command lines, and work in it."""
    place = folder / "commands" / "here" / "work"
    shutil.rmtree(folder / "commands", ignore_errors=True)
    place.mkdir(parents=True)
    for path in (*data_folder().glob("slider_crank*"), data_folder() / "four_bar.sdf"):
        shutil.copy(path, place)
    (place / "hanging.sdf").write_text(four_bar())
    (place / "hanging.toml").write_text('mechanism = "hanging.sdf"\nduration = 0.01\n[drives.O]\ntorque = 0.0\n')
    (place / "study.toml").write_text(STUDY)
    (place / "theirs.urdf").write_bytes(URDF)
    (place / "mine.machine.toml").write_text(DESCRIPTIONS[0], encoding="utf-8")
    (place / "study.sqlite").write_bytes(undamaged())
    put(place, results("simulate"))
    with chdir(place):
        yield place


def mutated(mutator: Mutator, folder: Path) -> str:
    """Run a command with a damaged command line in this process; the live page begins, and ends at once."""
    name = mutator.dice.choice(list(LINES))
    words = damaged(mutator, name)
    with inputs(folder), pytest.MonkeyPatch.context() as patch:
        patch.setattr("linkages.show.live.server.LiveServer.serve_forever", lambda self, **_: None)
        patch.setattr("webbrowser.open", lambda address: True)
        try:
            status, _, errors = command(*words)
        except SystemExit:  # --help, --version
            return "help"
    assert len(max(errors.splitlines(), key=len, default="")) < 3000, "a message without end"
    return "refused" if status == 2 else f"ended with {status}"


def struck(mutator: Mutator, folder: Path) -> str:
    """Press Ctrl-C at a random time of a command in a process: one line, no traceback, another status than 0, soon."""
    dice = mutator.dice
    name = dice.choice([name for name in LINES if name not in ("doctor", "keys", "completion", "new")])
    words = line(mutator, name)
    if name == "simulate" and dice.random() < 0.5:
        words[words.index("--duration") + 1] = "100"
    if name == "simulate" and dice.random() < 0.3:
        words[1] = "slider_crank_flexible.toml"
    after = dice.choice((0.5, 1.0, 3.0, 8.0)) * dice.random()
    with inputs(folder):
        pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True, "errors": "replace"}
        process = subprocess.Popen([*COMMAND, *words], **pipes)
        begun(process)
        latest = time.monotonic() + 5.0 * after  # a server waits
        while process.poll() is None and processor_time(process) < after and time.monotonic() < latest:
            time.sleep(0.005)
        if process.poll() is not None:
            process.communicate()
            return "ended before"
        used, pressed = processor_time(process), time.monotonic()
        process.send_signal(signal.SIGINT)
        errors = process.stderr.read()
        _, code, usage = os.wait4(process.pid, 0)
        took = min(time.monotonic() - pressed, usage.ru_utime + usage.ru_stime - used)
        status = process.returncode = os.waitstatus_to_exitcode(code)
        process.stderr.close()
    said = f"{' '.join(words)} after {after:.2f} s: {errors[-300:]}"
    assert "Traceback" not in errors, said
    assert took <= LIMIT or ANSWER in errors, f"{took:.1f} s, {said}"
    if status == 2:
        return "refused"
    if status == 0:
        assert "interrupted" not in errors, said
        assert time.monotonic() - pressed < LIMIT, said
        return "ended as it was struck"
    assert status in (130, -signal.SIGINT, 1), f"{status}, {said}"
    lines = [text for text in without_progress(errors).splitlines() if not text.startswith("compiling")]
    assert sum("interrupted" in text for text in lines) <= 2, said
    return "interrupted"
