"""Ctrl-C and SIGTERM: held back where they would do harm, and alike where they end a command."""

from __future__ import annotations

import signal
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
    """Let SIGTERM act as Ctrl-C does, in the background too; gives a list that is empty until it comes."""
    came: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield came
        return

    def note(number: int, _: Any) -> None:
        came.append(number)
        signal.raise_signal(signal.SIGINT)

    def ignore(number: int, frame: Any) -> None:
        if came:
            signal.default_int_handler(number, frame)

    before = {signal.SIGTERM: signal.signal(signal.SIGTERM, note)}
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a script's background job, which Ctrl-C is not for
        before[signal.SIGINT] = signal.signal(signal.SIGINT, ignore)
    try:
        yield came
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
