"""Files of the run that a page shows: experiments, folders of results, notebooks."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from linkages.base.errors import InputError
from linkages.input.files.writing import errors_of_writing, whole
from linkages.input.model.editing import edited
from linkages.input.model.experiment import Experiment

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_EXPORT = 600.0  # longest time of an export [s]

#: Runs a command that ends with this process.
_BELOW = """import sys
from linkages.base.signals import end_with_parent
from linkages.cli.main import main
end_with_parent()
sys.exit(main())
"""

_CODE = """import linkages

system = linkages.load(
    {file!r},
    {values},
)
run = linkages.simulate(system, "compiled")
shown = run.within({start!r}, {end!r})  # the part of the live page
peaks = linkages.extremes(shown, {outputs!r})
for name, found in peaks.items():
    print(f"{{name:24s}} {{found.peak:.6g}}")
"""


def target_of(folder: Path, name: Any, suffix: str = ".toml") -> Path:
    """Return the file of a name from outside in a folder; InputError if it is the name of none."""
    if not isinstance(name, str) or not _NAME.fullmatch(name.removesuffix(suffix)):
        problem = "is no name of a file here; use letters, digits, '_', '-' and '.', without a folder"
        raise InputError("page", repr(name)[:60], problem)
    return folder / f"{name.removesuffix(suffix)}{suffix}"


def save(experiment: Experiment, values: Mapping[str, Any], target: Path, replace: bool = False) -> None:
    """Write an experiment's file with other values, whole or not at all; see `edited`.

    InputError if the file exists and is not to be replaced, or cannot be written.
    """
    write(target, lambda: edited(experiment, values, target, "live page"), replace)


def write(target: Path, text: Callable[[], str], replace: bool) -> None:
    """Write a file, whole or not at all; InputError if it exists and is not to be replaced."""
    if target.exists() and not replace:
        raise InputError("page", target.name, f"exists in {target.parent.resolve()}; choose another name")
    content = text()
    with errors_of_writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
    with whole(target) as file:
        file.write_text(content, encoding="utf-8")


def export(target: Path) -> Path:
    """Let ``linkages simulate`` write the folder of a saved file; return the folder."""
    out = target.with_suffix("")
    words = ["simulate", str(target), "--out", str(out), "--quiet"]
    command = [sys.executable, "-c", _BELOW, *words]
    watched, held = os.pipe()
    try:
        done = subprocess.run(command, stdin=watched, capture_output=True, text=True, timeout=_EXPORT, check=False)
    except subprocess.TimeoutExpired:
        problem = f"takes longer than {_EXPORT:g} s; run: linkages {' '.join(words)}"
        raise InputError("export", target.name, problem) from None
    finally:
        os.close(watched)
        os.close(held)
    if done.returncode not in (0, 1):
        raise InputError("export", target.name, done.stderr.strip().rpartition("\n")[2] or "failed")
    return out


def code(file: Path, values: Mapping[str, Any], part: tuple[float, float], outputs: list[str]) -> str:
    """Return Python code that repeats a run, and prints the peaks of outputs over a part of it [s]."""
    listed = "{" + "".join(f"\n        {path!r}: {value!r}," for path, value in values.items()) + "\n    }"
    shown = {"start": part[0], "end": part[1], "outputs": outputs}
    return _CODE.format(file=str(file.resolve()), values=listed, **shown)


def notebook(text: str) -> str:
    """Return a Jupyter notebook with one cell of code."""
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    cell: dict[str, Any] = {"cell_type": "code", "id": "run", "metadata": {}, "execution_count": None, "outputs": []}
    cell["source"] = text.splitlines(keepends=True)
    return json.dumps({"cells": [cell], "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}, indent=1)
