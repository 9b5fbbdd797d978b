"""Ctrl-C and SIGTERM: held back where they would do harm, and alike where they end a command."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def held() -> Iterator[None]:
    """Hold Ctrl-C back to the end of what must not be struck: compiled code that hands over what it made, renaming."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    pressed: list[tuple[Any, ...]] = []
    signal.signal(signal.SIGINT, lambda *arguments: pressed.append(arguments))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        before(*pressed[0])


@contextmanager
def terminable() -> Iterator[list[int]]:
    """Let SIGTERM act as Ctrl-C does, in the background too; gives a list to which each signal that ends is added.

    Python drops a KeyboardInterrupt that strikes a callback (of a weak reference, of a compiler) with an "Exception
    ignored" and goes on, and C code that imports something may print it and go on; here it is raised again soon after,
    without a word.
    """
    came: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield came
        return
    foreground = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN  # a script's background job ignores Ctrl-C
    again: list[threading.Timer] = []

    def terminate(number: int, _: Any) -> None:
        came.append(number)
        signal.raise_signal(signal.SIGINT)

    def interrupt(number: int, frame: Any) -> None:
        if foreground or came:
            came.append(number)
            signal.default_int_handler(number, frame)

    def raised_again(problem: BaseException | None) -> bool:
        if not isinstance(problem, KeyboardInterrupt):
            return False
        again.append(threading.Timer(0.01, _thread.interrupt_main))
        again[-1].start()
        return True

    hooks = sys.unraisablehook, sys.excepthook
    sys.unraisablehook = lambda what: raised_again(what.exc_value) or hooks[0](what)
    sys.excepthook = lambda *what: raised_again(what[1]) or hooks[1](*what)
    before = {
        number: signal.signal(number, act) for number, act in ((signal.SIGTERM, terminate), (signal.SIGINT, interrupt))
    }
    try:
        yield came
    finally:
        for timer in again:
            timer.cancel()
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook, sys.excepthook = hooks
