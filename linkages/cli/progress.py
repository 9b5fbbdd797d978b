"""Tell on standard error how far a command is: progress bars, lines, a sign of life wherever nothing else is shown."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

#: Called with how much is done.
Advance = Callable[[float], None]

_FIRST, _LATER = 1.2, 9.0  # s of silence after which a first line, and a later one, is printed
_GRACE = 0.5  # s more, for a line that tells how much is done
_COMPILING = 5.0  # s between two lines on compilation
_TELLING = 1e-3  # part done from which on the pace tells how long the rest takes


class _Silence:
    """The time since the last message of a command, and the stage that the command is in."""

    def __init__(self) -> None:
        self.quiet = True  # outside of `heartbeat`
        self.begin(True)

    def begin(self, quiet: bool) -> None:
        """Start to count the silence of a command."""
        self.quiet, self.stage = quiet, "at work"
        self.started = self.last = time.monotonic()
        self.patience = _FIRST

    def rest(self) -> float:
        """Return how much longer the silence may last [s]."""
        return self.last + self.patience - time.monotonic()

    def broken(self) -> None:
        """Note that a message was shown."""
        self.last, self.patience = time.monotonic(), _LATER

    def say(self, text: str) -> None:
        """Print a line, above the progress bar if there is one."""
        self.broken()
        if sys.stderr.isatty():
            from tqdm import tqdm

            tqdm.write(text, file=sys.stderr)
        else:
            print(text, file=sys.stderr, flush=True)


_silence = _Silence()


@contextmanager
def heartbeat() -> Iterator[None]:
    """Print the stage of a command and its time so far wherever the command is silent for long, in a thread."""
    ended = threading.Event()

    def beat() -> None:
        while not ended.wait(max(_silence.rest() + _GRACE, 0.05)):
            if _silence.rest() <= -_GRACE and not _silence.quiet:
                _silence.say(f"{_silence.stage}, {time.monotonic() - _silence.started:.0f} s so far")

    _silence.begin(False)
    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        _silence.quiet = True


def begin_stage(name: str) -> None:
    """Name what the command does from now on."""
    _silence.stage = name


def message_shown() -> None:
    """Note that the command has shown a message by other means than this module's."""
    _silence.broken()


def be_quiet(options: argparse.Namespace) -> None:
    """Print no progress if the options include ``--quiet``."""
    if getattr(options, "quiet", False):
        _silence.quiet = True


def progress_bar(name: str, total: float = 1.0, unit: str = "") -> Advance:
    """Make the progress bar of a stage, shown on a terminal after a second; elsewhere a line now and then.

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
    begin_stage(name)
    if not sys.stderr.isatty():
        return _lines(name, total)
    from tqdm import tqdm

    numbers = "{n:.3f}/{total:.3f} " + unit if unit else ""
    bar = tqdm(
        total=total,
        desc=name,
        delay=1.0,
        leave=False,
        bar_format="{desc}: {percentage:3.0f}% |{bar}| " + numbers + " [{elapsed}<{remaining}]",
    )

    def advance(done: float) -> None:
        bar.update(min(done, total) - bar.n)
        _silence.broken()
        if done >= total:
            bar.close()
            begin_stage("results")

    return advance


def _lines(name: str, total: float) -> Advance:
    """Print now and then a line that says how much is done, and how long the rest will take at this pace."""
    begun = 0.0

    def advance(done: float) -> None:
        nonlocal begun
        begun = begun or time.monotonic()  # from the first call on: what was compiled before says nothing
        passed = time.monotonic() - begun
        if done >= total:
            begin_stage("results")
        elif done > 0.0 and _silence.rest() <= 0.0:
            rest = (
                f", the rest takes {float(f'{passed * (total - done) / done:.2g}'):g} s"
                if done >= _TELLING * total
                else ""
            )
            _silence.say(f"{name}: {done / total:.2%} in {passed:.0f} s{rest}")

    return advance


def stages(options: argparse.Namespace, total: float, unit: str) -> Callable[[str], Advance]:
    """Return what makes the progress bar of a stage by its name.

    Nothing is shown with ``--quiet``; with ``--verbose`` each stage is named in a line of its own.
    """
    be_quiet(options)
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
    from linkages.kernel.precompiled import tell

    due = 0.0

    def say(ready: int, known: int) -> None:
        nonlocal due
        now = time.monotonic()
        if not due:
            _silence.say("compiling, once after an installation: a quarter of a minute or so ...")
        elif now > due:
            _silence.say(f"compiling: {ready} of at most {known} kernels")
        if now > due:
            due = now + _COMPILING

    tell(say)
