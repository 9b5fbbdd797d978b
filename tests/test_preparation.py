"""Short runs that compile the code of all commands: `linkages doctor --compile`, and the build of a wheel."""

import subprocess

import pytest

from linkages.cli import commands, preparation
from linkages.cli.main import main, parser

#: Commands that compute nothing of their own: they read results or files, or serve a page of runs.
WITHOUT = {"animate", "compare", "completion", "doctor", "draw", "export", "import", "keys", "new", "overlay", "play"}
WITHOUT |= {"report", "study"}


def test_every_command_that_computes_says_what_compiles_its_code():
    assert {name for name, one in commands().items() if getattr(one, "SHORT_RUNS", ())} == set(commands()) - WITHOUT
    for words in preparation.short_runs():
        assert parser(commands()).parse_args([*words, "--out", "x"]).command == words[0]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("words", preparation.short_runs(), ids=" ".join)
def test_a_short_run_succeeds(words, tmp_path, monkeypatch):
    """Its files are found in its folder."""
    monkeypatch.chdir(tmp_path)
    for name, text in getattr(commands()[words[0]], "SHORT_FILES", {}).items():
        (tmp_path / name).write_text(text)
    assert main([*words, "--out", "out"]) == 0


@pytest.mark.processes
def test_runs_have_processes_of_their_own_and_failures_are_returned(monkeypatch):
    monkeypatch.setattr(preparation, "short_runs", lambda: [["draw", "four_bar.sdf"], ["draw", "nothing.sdf"]])
    said = []
    assert preparation.prepare(said.append) == [["draw", "nothing.sdf"]]
    assert said == ["1 of 2: linkages draw four_bar.sdf", "2 of 2: linkages draw nothing.sdf"]


def test_the_doctor_compiles_in_a_process_that_outlives_it(monkeypatch, capsys):
    started = []
    monkeypatch.setattr(preparation, "prepare_beside", lambda: started.append(True))
    assert main(["doctor", "--compile"]) == 0
    assert started == [True]
    assert capsys.readouterr().out.startswith("compiling in the background: ")


def test_the_process_beside_has_its_own_session_and_no_input(monkeypatch):
    asked = {}

    class Started:
        def __init__(self, words, **settings):
            asked.update(settings, words=words)
            self.pid = 0

    monkeypatch.setattr(subprocess, "Popen", Started)
    monkeypatch.setattr(preparation.os, "setpriority", lambda which, pid, level: asked.update(level=level))
    preparation.prepare_beside()
    assert asked["start_new_session"]
    assert asked["stdin"] == subprocess.DEVNULL
    assert asked["level"] == preparation._NICE
    assert "prepare(lambda line: None)" in asked["words"][-1]
