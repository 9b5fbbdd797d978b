"""Repeats the tests with signals, threads and processes on a machine that is quiet, busy, or has them in the background.

Run as a script: ``python tests/repeated.py --times 20`` (`-m ""` and further words go to pytest). They must pass
whatever the speed of the machine: no test sends a signal after a time, or expects something after one. That steps are
cheap or dear is part of the tests themselves.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

_BUSY = 8  # processes
_ROOT = Path(__file__).resolve().parents[1]


def _ignore_ctrl_c() -> None:
    """As a shell does for a background job of a script."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _busy() -> Iterator[None]:
    """Keep the processors busy with other processes."""
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(_BUSY)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


@contextmanager
def _quiet() -> Iterator[None]:
    yield


#: What else the machine does, and what is done before pytest starts, by condition.
CONDITIONS: dict[str, tuple[Callable, Callable[[], None] | None]] = {
    "quiet": (_quiet, None),
    "busy": (_busy, None),
    "background": (_quiet, _ignore_ctrl_c),
}


def passes(condition: str, words: list[str]) -> bool:
    """Run the tests once in a condition; print what they say if they fail."""
    around, before = CONDITIONS[condition]
    command = [sys.executable, "-m", "pytest", "-m", "processes", "-p", "no:cacheprovider", *words]
    with around():
        done = subprocess.run(command, cwd=_ROOT, capture_output=True, text=True, preexec_fn=before, check=False)
    if done.returncode:
        print(done.stdout[-5000:] + done.stderr[-1000:], flush=True)
    return done.returncode == 0


def main() -> int:
    """Repeat the tests in each condition; returns 1 if one fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=20, help="default: %(default)s")
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS), help="default: all")
    options, words = parser.parse_known_args()
    os.nice(10)
    failed = 0
    for condition in options.conditions:
        passed, begun = 0, time.monotonic()
        for _ in range(options.times):
            passed += passes(condition, words)
        failed += options.times - passed
        print(f"{condition}: {passed} of {options.times} passed in {time.monotonic() - begun:.0f} s", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
