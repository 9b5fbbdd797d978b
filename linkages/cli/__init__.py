"""The subcommands of ``linkages``, one module each.

| module   | command                                                            |
|----------|--------------------------------------------------------------------|
| simulate | ``linkages simulate``: run an experiment                           |
| report   | ``linkages report``: one HTML page of a folder of results           |
| keys     | ``linkages keys``: the keys of an experiment file                  |
| compare  | ``linkages compare``: both engines on one experiment                |
| sweep    | ``linkages sweep``: over the values of one variable                 |
| modes    | ``linkages modes``: the flexible 3-RRR robot                       |
| new      | ``linkages new``: files of a linkage to begin with                 |
| doctor   | ``linkages doctor``: is the installation sound                     |
| completion | ``linkages completion``: a script for the shell                  |
| common   | what they share: overrides, output folder, progress bars           |

A module has ``HELP`` (one line), ``add_options(parser)`` and ``run(options) -> exit status``, and imports what is heavy
inside `run`. Other packages add commands through entry points of the group ``linkages.commands``; one that cannot be
loaded is left out, and said so.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from importlib.metadata import EntryPoint, entry_points
from typing import Protocol, cast

_OWN = ("simulate", "compare", "sweep", "report", "new", "modes", "keys", "doctor", "completion")


class Command(Protocol):
    """What a module of a subcommand holds."""

    HELP: str

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add the command's arguments."""

    @staticmethod
    def run(options: argparse.Namespace) -> int:
        """Run with parsed options; returns the exit status."""


def commands() -> dict[str, Command]:
    """Every subcommand by name; one line on standard error for each of another package that cannot be used."""
    found: dict[str, object] = {name: importlib.import_module(f"{__name__}.{name}") for name in _OWN}
    for point in entry_points(group="linkages.commands"):
        try:
            if point.name in found:
                raise ValueError("the name is taken")
            found[point.name] = _load(point)
        except Exception as problem:  # what another package raises must not take every command away
            reason = " ".join(f"{type(problem).__name__}: {problem}".split())
            print(f"warning: command {point.name} ({point.value}) is left out: {reason}", file=sys.stderr)
    return cast(dict[str, Command], found)


def _load(point: EntryPoint) -> object:
    """Import another package's command and check that it is one."""
    command = point.load()
    missing = [part for part in ("HELP", "add_options", "run") if not hasattr(command, part)]
    if missing:
        raise TypeError(f"it has no {missing[0]}")
    return command
