"""What the subcommands share: overrides, the output folder, progress bars."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

from linkages.errors import InputError


def add_overrides(parser: argparse.ArgumentParser) -> None:
    """Add ``--set`` and ``--duration``."""
    parser.add_argument(
        "--set", action="append", default=[], metavar="PATH=VALUE", help="replace a value; may be repeated"
    )
    parser.add_argument("--duration", type=float, metavar="SECONDS", help="replace the experiment's duration")


def overrides(options: argparse.Namespace) -> dict[str, str | float]:
    """Values by dotted path from ``--set`` and ``--duration``.

    Raises
    ------
    InputError
        If an item is not ``PATH=VALUE``.
    """
    result: dict[str, str | float] = {}
    for item in options.set:
        path, equals, value = item.partition("=")
        if not equals or not path or not value:
            raise InputError("--set", item, "write PATH=VALUE, for instance joints.A.clearance=2e-4")
        result[path.strip()] = value.strip()
    if options.duration is not None:
        result["duration"] = options.duration
    return result


def add_verbosity(parser: argparse.ArgumentParser) -> None:
    """Add ``--quiet`` and ``--verbose``."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--quiet", "-q", action="store_true", help="print nothing but errors")
    group.add_argument(
        "--verbose", "-v", action="store_true", help="say what is done, how, and how long it takes"
    )


def stages(options: argparse.Namespace, total: float, unit: str) -> Callable[[str], Callable[[float], None]]:
    """Make the progress of stages by name: nothing if quiet, else a bar, if verbose with a line for each stage."""
    if not options.quiet and sys.stderr.isatty():
        tell_of_compiling()

    def begin(name: str) -> Callable[[float], None]:
        if options.quiet:
            return lambda done: None
        if options.verbose:
            print(f"{name} ...", file=sys.stderr)
        return progress_bar(name, total, unit)

    return begin


@cache
def tell_of_compiling() -> None:
    """From now on say when the first kernel is compiled: the first run after an installation would be long silent."""
    from numba.core import event

    class Teller(event.Listener):
        told = False

        def on_start(self, event: event.Event) -> None:
            if not self.told:
                self.told = True
                print("compiling, once after an installation: up to a minute ...", file=sys.stderr)

        def on_end(self, event: event.Event) -> None:
            """Nothing: the run's own progress follows."""

    event.register("numba:compile", Teller())


def add_out(parser: argparse.ArgumentParser) -> None:
    """Add ``--out``."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: results/NAME")


def output_folder(options: argparse.Namespace, name: str) -> Path:
    """Folder for the results.

    Raises
    ------
    InputError
        If there is a file of that name.
    """
    out: Path = options.out or Path("results") / name
    if out.exists() and not out.is_dir():
        raise InputError("--out", str(out), "is a file; give a folder")
    return out


def written(out: Path) -> str:
    """Say what is in the folder of results."""
    names = sorted(p.name for p in out.iterdir() if p.name[0] != "." and p.suffix != ".lock")
    return f"written to {out}{os.sep}: {', '.join(names)}"


def progress_bar(name: str, total: float = 1.0, unit: str = "") -> Callable[[float], None]:
    """Make a progress bar, shown on a terminal after two seconds; the result is called with what is done so far."""
    from tqdm import tqdm

    numbers = "{n:.3f}/{total:.3f} " + unit if unit else ""
    bar = tqdm(
        total=total,
        desc=name,
        delay=2.0,
        disable=None,
        leave=False,
        bar_format="{desc}: {percentage:3.0f}% |{bar}| " + numbers + " [{elapsed}<{remaining}]",
    )

    def advance(done: float) -> None:
        bar.update(min(done, total) - bar.n)
        if done >= total:
            bar.close()

    return advance
