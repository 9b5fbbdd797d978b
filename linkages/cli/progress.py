"""How far a command has got, on standard error: bars, stages, a word on compilation."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import cache

#: Called with how much is done.
Advance = Callable[[float], None]

_FIRST_LINE = 10.0  # s until the first line of progress, where there is no terminal
_COMPILING = 5.0  # s between two lines on compilation
_TELLING = 0.01  # part done from which on the pace tells how long the rest takes


def progress_bar(name: str, total: float = 1.0, unit: str = "") -> Advance:
    """Make a progress bar, shown on a terminal after two seconds; elsewhere a line after ten, and each twice as late.

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
    if not sys.stderr.isatty():
        return _lines(name, total)
    from tqdm import tqdm

    numbers = "{n:.3f}/{total:.3f} " + unit if unit else ""
    bar = tqdm(
        total=total,
        desc=name,
        delay=2.0,
        leave=False,
        bar_format="{desc}: {percentage:3.0f}% |{bar}| " + numbers + " [{elapsed}<{remaining}]",
    )

    def advance(done: float) -> None:
        bar.update(min(done, total) - bar.n)
        if done >= total:
            bar.close()

    return advance


def _lines(name: str, total: float) -> Advance:
    """Say in a line of its own now and then how much is done, and how long the rest will take at this pace."""
    begun, due = 0.0, _FIRST_LINE

    def advance(done: float) -> None:
        nonlocal begun, due
        begun = begun or time.monotonic()  # from the first call on: what was compiled before says nothing
        passed = time.monotonic() - begun
        if passed >= due and 0.0 < done < total:
            due = 2.0 * passed
            rest = (
                f", the rest takes {float(f'{passed * (total - done) / done:.2g}'):g} s"
                if done >= _TELLING * total
                else ""
            )
            print(f"{name}: {done / total:.2%} in {passed:.0f} s{rest}", file=sys.stderr, flush=True)

    return advance


def stages(options: argparse.Namespace, total: float, unit: str) -> Callable[[str], Advance]:
    """Return what makes the progress bar of a stage by its name.

    Nothing is shown with ``--quiet``; with ``--verbose`` each stage is named in a line of its own.
    """
    if not options.quiet:
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
    """From now on say that kernels are compiled, and how many are ready: the first run would otherwise be silent."""
    from linkages.kernel.ahead import tell

    due = 0.0

    def say(ready: int, known: int) -> None:
        nonlocal due
        now = time.monotonic()
        if not due:
            print("compiling, once after an installation: a quarter of a minute or so ...", file=sys.stderr, flush=True)
        elif now > due:
            print(f"compiling: {ready} of at most {known} kernels", file=sys.stderr, flush=True)
        if now > due:
            due = now + _COMPILING

    tell(say)
