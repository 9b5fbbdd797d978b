"""Progress of a command on standard error: bars, lines, and a heartbeat during silent stages."""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

#: Function called with the finished amount.
Advance = Callable[[float], None]

_FIRST, _LATER = 1.2, 9.0  # silence before the first line, and before later ones [s]
_GRACE = 0.5  # additional silence before a heartbeat, in favour of a line with numbers [s]
_COMPILING = 5.0  # interval between two lines on compilation [s]
_MEASURED = 0.5  # shortest time from which a speed is known [s]
_TELLING = 1e-3  # finished fraction from which the remaining time is estimated


class _Silence:
    """The time since the last message of a command, and the stage that the command is in."""

    def __init__(self) -> None:
        self.quiet = True  # outside of `heartbeat`
        self.begin(True)

    def begin(self, quiet: bool) -> None:
        """Start to count the silence of a command."""
        self.quiet, self.muted, self.stage = quiet, False, "at work"
        self.started = self.last = time.monotonic()
        self.patience = _FIRST

    def rest(self) -> float:
        """Return the remaining allowed silence [s]."""
        return self.last + self.patience - time.monotonic()

    def broken(self) -> None:
        """Record that a message was shown."""
        self.last, self.patience = time.monotonic(), _LATER

    def say(self, text: str) -> None:
        """Print a line, above the progress bar if there is one."""
        self.broken()
        if sys.stderr.isatty():
            from tqdm import tqdm

            tqdm.write(text, file=sys.stderr)
        else:
            print(text, file=sys.stderr, flush=True)


silence = _Silence()


@contextmanager
def heartbeat() -> Iterator[None]:
    """Print stage and elapsed time of a command after long silence, from a thread."""
    ended, counted = threading.Event(), [0]

    def beat() -> None:
        while not ended.wait(max(silence.rest() + _GRACE, 0.05)):
            if silence.rest() <= -_GRACE and not silence.quiet:
                stage = _compilation(counted) or silence.stage
                silence.say(f"{stage}, {time.monotonic() - silence.started:.0f} s so far")

    silence.begin(False)
    _compilation(counted)
    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        silence.quiet = True


def _compilation(counted: list[int]) -> str:
    """Return the stage of a command that has compiled kernels since the last call; its count is kept in the list."""
    counts = getattr(sys.modules.get("linkages.base.kernel.precompiled"), "counts", None)
    if counts is None:  # nothing computes, or the module is being imported
        return ""
    compiled, _ = counts()
    before, counted[0] = counted[0], compiled
    return "compiling, once after an installation" if compiled > before else ""


def be_quiet(options: argparse.Namespace) -> None:
    """Print no progress if the options include ``--quiet``."""
    if getattr(options, "quiet", False):
        silence.quiet = silence.muted = True


def progress_bar(name: str, total: float = 1.0, unit: str = "") -> Advance:
    """Make the progress bar of a stage, shown on a terminal after a second; elsewhere lines at intervals.

    Without the unit of the total amount the bar shows no numbers. The result is called with the finished amount.
    """
    silence.stage = name
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
        silence.broken()
        if done >= total:
            bar.close()
            silence.stage = "results"

    return advance


def _lines(name: str, total: float) -> Advance:
    """Print lines with the finished amount and the estimated remaining time at intervals."""
    first: tuple[float, float] | None = None  # time and amount of the first call, without the time of compilation

    def advance(done: float) -> None:
        nonlocal first
        first = first or (time.monotonic(), done)
        passed, gained = time.monotonic() - first[0], done - first[1]
        silence.stage = f"{name}: {done / total:.2%}"  # which the heartbeat repeats while an amount takes long
        if done >= total:
            silence.stage = "results"
        elif done > 0.0 and silence.rest() <= 0.0:
            said = f"{name}: {done / total:.2%}"
            if passed >= _MEASURED:
                said += f" in {passed:.0f} s"
                if gained >= _TELLING * total:
                    said += f", the rest takes {float(f'{passed * (total - done) / gained:.2g}'):g} s"
            silence.say(said)

    return advance


def stages(options: argparse.Namespace, total: float, unit: str) -> Callable[[str], Advance]:
    """Return a function that makes the progress bar of a stage by its name.

    ``--quiet`` shows nothing; ``--verbose`` names each stage in a separate line.
    """
    be_quiet(options)
    if not options.quiet:
        announce_compilation()
        announce_maps()

    def begin(name: str) -> Advance:
        if options.quiet:
            return lambda done: None
        if options.verbose:
            print(f"{name} ...", file=sys.stderr)
        return progress_bar(name, total, unit)

    return begin


@cache
def announce_compilation() -> None:
    """Report compilation and the number of compiled kernels, because the first run would be silent."""
    from linkages.base.kernel.precompiled import tell

    due = 0.0

    def say(ready: int, known: int) -> None:
        nonlocal due
        now = time.monotonic()
        if silence.muted:  # an earlier command of the process has asked for this report
            return
        if not due:
            silence.say("compiling, once after an installation: up to a minute ...")
        elif now > due:
            silence.say(f"compiling, once after an installation: {ready} of at most {known} kernels are ready")
        if now > due:
            due = now + _COMPILING

    tell(say)


@cache
def announce_maps() -> None:
    """Show the progress of film maps that are built: the first run with a groove takes ten seconds more."""
    from linkages.laws.film.film_map import tell

    tell(lambda case: progress_bar(f"film map of L/D {case.slenderness:.3g}, stored for later runs"))
