"""Code of all commands, compiled before it is needed: by ``linkages doctor --compile``, and for wheels.

A command's module says by ``SHORT_RUNS`` what compiles the code that its usual runs need, as words of command lines,
and by ``SHORT_FILES`` which files these read. Each run has a process and a folder of its own.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from linkages.base.packages import installed
from linkages.cli import commands
from linkages.engines import PACKAGES

_MAIN = "import sys; from linkages.cli.main import main; sys.exit(main(sys.argv[1:]))"
_NICE = 10  # priority of a process in the background: the user works beside it


def short_runs() -> list[list[str]]:
    """Return the command lines of all commands that need no missing package, each as its words."""
    found = [[name, *run.split()] for name, command in commands().items() for run in getattr(command, "SHORT_RUNS", ())]
    missing = {engine for engine, package in PACKAGES.items() if not installed(package)}
    return [words for words in found if not missing.intersection(words)]


def prepare(say: Callable[[str], object] = print) -> list[list[str]]:
    """Compile the code of all commands; `say` gets a line before each run. Returns the runs that failed."""
    runs, failed = short_runs(), []
    files = {name: text for one in commands().values() for name, text in getattr(one, "SHORT_FILES", {}).items()}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for k, words in enumerate(runs):
            say(f"{k + 1} of {len(runs)}: linkages {' '.join(words)}")
            if _run([*words, "--out", str(Path(folder) / str(k))], folder):
                failed.append(words)
    return failed


def prepare_beside() -> None:
    """Compile the code of all commands in a process of its own, which outlives this one."""
    code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import prepare; prepare(lambda line: None)"
    quiet = subprocess.DEVNULL
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=quiet, stdout=quiet, stderr=quiet, env=environment, start_new_session=True
    )
    if hasattr(os, "setpriority"):
        os.setpriority(os.PRIO_PROCESS, process.pid, _NICE)


def _run(words: list[str], folder: str) -> int:
    """Run a command in a folder; return its status."""
    quiet, path = subprocess.DEVNULL, os.pathsep.join(filter(None, sys.path))
    environment = os.environ | {"PYTHONPATH": path, "MPLBACKEND": "Agg"}
    return subprocess.run(
        [sys.executable, "-c", _MAIN, *words], cwd=folder, env=environment, stdout=quiet, stderr=quiet
    ).returncode
