"""Interrupts: SIGINT (Ctrl-C) and SIGTERM end a command alike, and can be deferred to the end of a short block."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_NUMBERS = (signal.SIGINT, signal.SIGTERM)


class Interrupted(KeyboardInterrupt):
    """SIGINT or SIGTERM arrived while a command ran."""


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """Raise `Interrupted` where SIGINT or SIGTERM arrives; yield the list of the numbers that have arrived.

    A SIGINT that the process ignores, as a background job of a script does, stays ignored. Outside the main thread
    nothing changes.
    """
    received: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.append(number)
        raise Interrupted

    if threading.current_thread() is not threading.main_thread():
        yield received
        return
    before = {number: signal.getsignal(number) for number in _NUMBERS}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, interrupt)
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def deferred() -> Iterator[list[tuple[int, FrameType | None]]]:
    """Defer SIGINT and SIGTERM to the end of the block; yield the list of the signals that have arrived.

    Outside the main thread, which no signal reaches, do nothing.

    For blocks that must not end half-way: files that are moved into place, compiled code that allocates its results,
    and LLVM, which calls Python where an exception is dropped and then crashes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield []
        return
    found: dict[int, object] = {number: signal.getsignal(number) for number in _NUMBERS}
    handlers = {number: handler for number, handler in found.items() if callable(handler)}
    received: list[tuple[int, FrameType | None]] = []
    for number in handlers:
        signal.signal(number, lambda *arguments: received.append(arguments))
    try:
        yield received
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number, frame in received:
            handlers[number](number, frame)
