"""Options of several commands, and the experiment that they define."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from linkages.cli.folders import add_out
from linkages.errors import InputError
from linkages.files.unit_conversion import is_quantity, si

if TYPE_CHECKING:
    from linkages.model.experiment import Experiment
    from linkages.system import System


def add_file(parser: argparse.ArgumentParser) -> None:
    """Add the experiment's file."""
    parser.add_argument("file", help="experiment: a path, or the name of a shipped file; .toml is optional")


def add_set(parser: argparse.ArgumentParser) -> None:
    """Add ``--set``."""
    parser.add_argument(
        "--set", action="append", default=[], metavar="PATH=VALUE", help="replace a value; may be repeated"
    )


def add_settings(parser: argparse.ArgumentParser, lasting: bool = True) -> None:
    """Add ``--set``, ``--out``, ``--quiet`` and ``--verbose``, and ``--duration`` to a command whose runs have one."""
    add_set(parser)
    parser.set_defaults(duration=None)
    if lasting:
        parser.add_argument("--duration", type=seconds, metavar="SECONDS", help="replace the experiment's duration")
    add_out(parser)
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--quiet", "-q", action="store_true", help="print nothing but errors")
    group.add_argument("--verbose", "-v", action="store_true", help="print the stages, the methods and the times")


def add_outputs(parser: argparse.ArgumentParser) -> None:
    """Add ``--output``."""
    parser.add_argument(
        "--output",
        action="append",
        metavar="NAME",
        help="recorded output, see `linkages keys`; may be repeated; default: the experiment's outputs and the forces"
        " in clearance joints",
    )


def output_names(options: argparse.Namespace, experiment: Experiment) -> list[str]:
    """Return the names of ``--output``, by default the experiment's outputs and the forces in clearance joints.

    Raises
    ------
    InputError
        If there are none.
    """
    names = options.output or [*experiment.outputs, *(f"{name}.force" for name in experiment.play)]
    if not names:
        raise InputError(experiment.source, "outputs", "are none; name one with --output")
    return names


def seconds(text: str) -> float:
    """Read a time, such as ``0.02`` or ``20 ms`` [s]; invalid text gives the ValueError that argparse expects."""
    return si(text, "s") if is_quantity(text) else float(text)


def load_system(options: argparse.Namespace, defaults: Mapping[str, float] | None = None) -> System:
    """Load the experiment and its mechanism with the values of ``--set`` and ``--duration``.

    Parameters
    ----------
    options : Namespace
        Parsed options of `add_file` and `add_settings`.
    defaults : mapping of str to float, optional
        Values by dotted path that override the file, unless the command line does.

    Raises
    ------
    InputError
        If a file or a value is not valid, or an item of ``--set`` is not ``PATH=VALUE``.
    """
    from linkages.files.shipped import find_file
    from linkages.model.experiment import COMMAND_LINE
    from linkages.system import load

    values = {**(defaults or {}), **set_values(options)}
    if options.duration is not None:
        values["duration"] = options.duration
    system = load(find_file(options.file, ".toml"), values, COMMAND_LINE)
    if getattr(options, "ideal", False):
        return system.replaced(
            {f"joints.{name}": {"model": "ideal"} for name in system.experiment.joints}, COMMAND_LINE
        )
    return system


def set_values(options: argparse.Namespace) -> dict[str, str | float]:
    """Return the values of ``--set`` by their dotted paths.

    Raises
    ------
    InputError
        If an item is not ``PATH=VALUE``.
    """
    values: dict[str, str | float] = {}
    for item in options.set:
        path, equals, value = item.partition("=")
        if not equals or not path or not value:
            raise InputError("--set", item, "write PATH=VALUE, such as joints.A.clearance=2e-4")
        values[path.strip()] = value.strip()
    return values


def written(out: Path, names: Iterable[str]) -> str:
    """List the files written into the folder of results."""
    return f"written to {out}{os.sep}: {', '.join(names)}"
