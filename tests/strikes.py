"""Signals that a run sends to its own process at a step that the test chooses; no clock decides, and no timer is left.

- In this process: `Strike` counts calls and sends the signal at one of them, within the caller. `registered_film` lets
  compiled code count, which the signal strikes between two of its steps.
- In another process: `command` is a command of the package in which a named function counts, or every call of a
  Python function. Run as a script: ``python -m strikes PLACE AT SIGNAL WORD ...``.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import signal
import sys
from pathlib import Path

#: Place of a strike: at a call of any Python function, or of C code by one, in the main thread.
ANY_CALL = "any call"

_NEVER = 0


class Strike:
    """Sends a signal to this process at a call, once; the first call has number 1, and 0 is none.

    Attributes
    ----------
    calls : int
        Number of the calls so far.
    """

    def __init__(self, at: int = _NEVER, number: int = signal.SIGINT) -> None:
        self.calls, self._at, self._number = 0, at, number

    def __call__(self, *_: object) -> None:
        """Count a call; the handler of the signal has run when this returns, unless it raises."""
        self.calls += 1
        if self.calls == self._at:
            self._send()

    def _send(self) -> None:
        if self._number == signal.SIGKILL:
            os.kill(os.getpid(), self._number)
        else:
            signal.raise_signal(self._number)

    def arm(self, at: int) -> None:
        """Count from 0 again, and strike at another call."""
        self.calls, self._at = 0, at

    def before(self, function):
        """Return a function that counts, and then does what the given one does."""

        def counted(*arguments, **named):
            self()
            return function(*arguments, **named)

        return counted


def registered_film(name: str, strike: Strike) -> None:
    """Register a film, the one of short bearings, each evaluation of which counts; runs evaluate it in compiled code."""
    from linkages import laws  # numba's import takes a second, which other struck processes need not wait for

    tick = ctypes.CFUNCTYPE(None)(strike)
    film = laws.FILMS["short"].force

    def counting(eps, deps, ew, slenderness):
        tick()
        return film(eps, deps, ew, slenderness)

    laws.register_film(name, counting)


def at_calls(strike: Strike) -> None:
    """Count the calls of all functions by the main thread from here on."""
    sys.setprofile(lambda frame, event, _: strike() if event in ("call", "c_call") else None)


def command(place: str, at: int, number: int, *words: object) -> list[str]:
    """Return the words of a command that is struck; at 0 it is not, and prints its number of any calls at its end.

    `place` is ``module:function``, of which a call counts before the function does anything, or `ANY_CALL`.
    """
    return [sys.executable, str(Path(__file__).resolve()), place, str(at), str(int(number)), *map(str, words)]


def calls_in(errors: str) -> int:
    """Return the number of calls that a command printed at its end."""
    return int(errors.splitlines()[-1].removeprefix("calls: "))


def _main(place: str, at: str, number: str, *words: str) -> int:
    from linkages.cli.main import main

    strike = Strike(int(at), int(number))
    sys.argv[1:] = words
    if place != ANY_CALL:
        module, _, name = place.partition(":")
        owner = importlib.import_module(module)
        setattr(owner, name, strike.before(getattr(owner, name)))
    else:
        at_calls(strike)
    try:
        status = main()
    finally:
        sys.setprofile(None)
    if place == ANY_CALL and int(at) == _NEVER:
        print(f"calls: {strike.calls}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(_main(*sys.argv[1:]))
