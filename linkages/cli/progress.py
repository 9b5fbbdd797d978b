"""How far a command has got, on standard error: bars, stages, a word on compilation."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import cache

#: Called with how much is done.
Advance = Callable[[float], None]


def progress_bar(name: str, total: float = 1.0, unit: str = "") -> Advance:
    """Make a progress bar, shown on a terminal after two seconds.

    Parameters
    ----------
    name : str
        Stands before the bar.
    total : float
        What there is to do.
    unit : str
        Unit of `total`; without one the bar shows no numbers.

    Returns
    -------
    callable
        To be called with what is done so far.
    """
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


def stages(options: argparse.Namespace, total: float, unit: str) -> Callable[[str], Advance]:
    """Return what makes the progress bar of a stage by its name.

    Nothing is shown with ``--quiet``; with ``--verbose`` each stage is named in a line of its own.
    """
    if not options.quiet and sys.stderr.isatty():
        announce_compilation()

    def begin(name: str) -> Advance:
        if options.quiet:
            return lambda done: None
        if options.verbose:
            print(f"{name} ...", file=sys.stderr)
        return progress_bar(name, total, unit)

    return begin


@cache
def announce_compilation() -> None:
    """From now on say when the first kernel is compiled: the first run would otherwise be silent for long."""
    from numba.core import event

    class Announcer(event.Listener):
        announced = False

        def on_start(self, event: event.Event) -> None:
            if not self.announced:
                self.announced = True
                print("compiling, once after an installation: up to a minute ...", file=sys.stderr)

        def on_end(self, event: event.Event) -> None:
            """Nothing: the run's own progress follows."""

    event.register("numba:compile", Announcer())
