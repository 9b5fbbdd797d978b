"""Text of commands: at most 78 columns, the same on a terminal and in a pipe."""

import io
import re
import subprocess
import sys

import pytest

from linkages.cli.main import main
from linkages.cli.printing import WIDTH, show, wrapped

TEXT = """Title                    ok, 2 s
  An answer whose sentence is longer than the width of the terminal, so that it must be broken into two lines.
joint      ideal      now
A          1.234    5.678
warning (rough): the run and its repetition differ from the third revolution on; compare statistics, not peaks
Try half of this clearance: linkages simulate slider_crank_dry.toml --engine compiled --set joints.B.clearance=0.00025"""


class Terminal(io.StringIO):
    def isatty(self):
        return True


def printed(monkeypatch, stream):
    monkeypatch.setattr(sys, "stdout", stream)
    show(TEXT)
    return stream.getvalue()


def test_a_terminal_and_a_pipe_show_the_same_text(monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    plain, coloured = printed(monkeypatch, io.StringIO()), printed(monkeypatch, Terminal())
    assert "\x1b[" in coloured
    assert re.sub(r"\x1b\[[\d;]*m", "", coloured) == plain
    assert "\x1b" not in plain
    monkeypatch.setenv("NO_COLOR", "1")
    assert printed(monkeypatch, Terminal()) == plain


def test_no_line_is_wider_than_78_columns_and_tables_keep_their_lines(monkeypatch):
    lines = printed(monkeypatch, io.StringIO()).splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert "A          1.234    5.678" in lines
    assert any(line.startswith("! warning (rough)") for line in lines)


def test_a_command_that_is_broken_is_taken_by_a_shell():
    first, *command = wrapped(TEXT.splitlines()[-1])
    assert first == "Try half of this clearance:"
    echoed = subprocess.run(["sh", "-c", "echo " + "\n".join(command)], capture_output=True, text=True, check=True)
    assert echoed.stdout.strip() == TEXT.splitlines()[-1].partition(": ")[2]


@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_dry", "gear_rattle", "slider_crank_motor"])
def test_a_run_answers_within_78_columns(name, tmp_path, capsys):
    words = ["simulate", f"{name}.toml", "--duration", "0.01", "--no-plots", "--no-animation"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    lines = capsys.readouterr().out.splitlines()
    long = [line for line in lines if len(line) > WIDTH and str(tmp_path) not in line]
    assert long == []
    assert lines[2].endswith("ok, 0.01 s, compiled")  # below the engine: what was run, and then the answer
    assert lines[3].startswith("  ")
