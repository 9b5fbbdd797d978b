"""Interrupts: SIGINT (Ctrl-C) and SIGTERM end a command alike, and can be deferred to the end of a short block.

Python handles a signal only between two of its own steps. So that compiled code is not silent until it returns, the
number of a signal also appears in `arrival` at once: integrators read it and pause, and a command whose compiled code
does not return is ended from another thread.
"""

from __future__ import annotations

import math
import mmap
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from types import FrameType, TracebackType
from typing import Any, NamedTuple, NoReturn

_NUMBERS = (signal.SIGINT, signal.SIGTERM)
_WORD = 8  # bytes of the mark
_LOOK = 0.1  # interval between two looks at the mark [s]
_PATIENCE = 0.8  # time that compiled code has to return after a signal [s]
_AGAIN, _SWALLOWED = 0.05, 0.5  # time after which a signal is sent again whose exception is, or may be, dropped [s]


class Interrupted(KeyboardInterrupt):
    """SIGINT or SIGTERM arrived while a command ran."""


class Received(list[int]):
    """The numbers of the signals that have arrived."""

    over = False  #: whether further signals are only counted, because the command ends


class _Mark(NamedTuple):
    """A file in memory into which Python writes the number of a signal the moment it arrives."""

    file: int
    memory: mmap.mmap

    def clear(self) -> None:
        """Remove the number: Python handles the signal."""
        if self.file >= 0:
            os.lseek(self.file, 0, os.SEEK_SET)
        self.memory[:_WORD] = bytes(_WORD)


@cache
def _mark() -> _Mark:
    try:
        if hasattr(os, "memfd_create"):
            file = os.memfd_create("signals")
        else:
            import tempfile

            with tempfile.TemporaryFile() as temporary:
                file = os.dup(temporary.fileno())
        os.write(file, bytes(_WORD))
        os.lseek(file, 0, os.SEEK_SET)
        os.set_blocking(file, False)  # which Python demands
    except (OSError, AttributeError):  # the disk is full, or Windows: signals wait until Python handles them
        return _Mark(-1, mmap.mmap(-1, _WORD))
    return _Mark(file, mmap.mmap(file, _WORD))


def arrival() -> mmap.mmap:
    """Return memory whose first 8 bytes are not zero from the arrival of a signal until Python handles it.

    A signal is noted there only within `interruptible` and `deferred`.
    """
    return _mark().memory


_noted = False  # whether signals are noted in `arrival`
_whole = 0  # blocks under way that must reach their end
_stopping = 0  # blocks under way that wait for other threads


@contextmanager
def _noting() -> Iterator[None]:
    """Note signals in `arrival` during the outermost of nested blocks."""
    global _noted
    if _noted:
        yield
        return
    mark = _mark()
    before, _noted = signal.set_wakeup_fd(mark.file, warn_on_full_buffer=False), True
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        mark.clear()
        _noted = False


@contextmanager
def interruptible(alone: bool = False) -> Iterator[Received]:
    """Raise `Interrupted` where SIGINT or SIGTERM arrives; yield the numbers that have arrived.

    A SIGINT that the process ignores, as a background job of a script does, stays ignored. Outside the main thread
    nothing changes. If this block runs `alone`, the process ends with one line and the status of the signal if compiled
    code does not return soon after a signal.
    """
    received = Received()

    def again(number: int, after: float) -> None:
        """Send a signal again unless the command ends before."""

        def send() -> None:
            with sending:
                if not received.over and not ended.is_set():
                    _send(main, number)

        timer = threading.Timer(after, send)
        timer.daemon = True
        timer.start()

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.append(number)
        if not _stopping:
            _mark().clear()
        if received.over:
            return
        if _importing(frame):  # packages take any exception for a missing module
            again(number, _SWALLOWED)
        raise Interrupted

    def dropped(unraisable: Any) -> None:
        """Send a signal again whose exception was dropped, where C code had called Python; print others before it."""
        if isinstance(unraisable.exc_value, Interrupted):
            again(received[-1], _AGAIN)
        elif not received:  # later ones follow from the interrupt, as of a file that is closed half-way
            hook(unraisable)

    def printed(kind: type[BaseException], problem: BaseException, trace: TracebackType | None) -> None:
        """Send a signal again whose exception C code prints and drops; print others."""
        if isinstance(problem, Interrupted):
            again(received[-1], _AGAIN)
        else:
            show(kind, problem, trace)

    if threading.current_thread() is not threading.main_thread():
        yield received
        return
    before = {number: signal.getsignal(number) for number in _NUMBERS}
    hook, show, ended = sys.unraisablehook, sys.excepthook, threading.Event()
    main, sending = threading.main_thread(), threading.Lock()  # held while a signal is sent again
    if alone:
        threading.Thread(target=_watch, args=(received, ended), daemon=True).start()
    with _noting():
        sys.unraisablehook, sys.excepthook = dropped, printed
        for number, handler in before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, interrupt)
        try:
            yield received
        finally:
            received.over = True
            with sending:
                ended.set()
            if hasattr(signal, "pthread_sigmask"):  # handles what was sent up to here: none outlives the block
                signal.pthread_sigmask(signal.SIG_BLOCK, ())
            for number, handler in before.items():
                signal.signal(number, handler)
            sys.unraisablehook, sys.excepthook = hook, show


def _send(thread: threading.Thread, number: int) -> None:
    """Send a signal to a thread; on Windows to the process, whose main thread handles it."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(thread.ident or 0, number)
    else:
        signal.raise_signal(number)


def _importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported at this frame."""
    while frame is not None and frame.f_code.co_filename != "<frozen importlib._bootstrap>":
        frame = frame.f_back
    return frame is not None


def _watch(received: Received, ended: threading.Event) -> None:
    """Until a command has ended: end it if it does not handle a signal, and print a line if it goes on after one."""
    pending = handled = None
    while not ended.wait(_LOOK):
        now = time.monotonic()
        pending = (pending or now) if any(arrival()[:_WORD]) and not _whole else None
        if pending is not None and now - pending > _PATIENCE:
            _give_up()
        if received and handled is None:
            handled = now
        if handled is not None and now - handled > _PATIENCE and not received.over:
            print("interrupted; writing what was computed, Ctrl-C again ends at once", file=sys.stderr, flush=True)
            handled = math.inf


def _give_up() -> NoReturn:
    """End the process with one line, whatever its main thread does."""
    number = arrival()[0] or signal.SIGINT
    with suppress(Exception):
        sys.stdout.flush()
    with suppress(OSError):
        os.write(2, b"interrupted\n")
    os._exit(128 + number)


@contextmanager
def stopping() -> Iterator[None]:
    """Pause the integrators of all threads during the block, which waits for them after an interrupt."""
    global _stopping
    arrival()[0] = signal.SIGINT
    _stopping += 1
    try:
        yield
    finally:
        _stopping -= 1
        _mark().clear()


def end_with_parent(end: Callable[[], object] = lambda: os.kill(os.getpid(), signal.SIGTERM)) -> None:
    """End this process when its parent ends, even if that is killed, by `end` (default: SIGTERM), called in a thread.

    The parent holds the other end of the pipe at standard input, and writes nothing into it.
    """

    def wait() -> None:
        while os.read(0, 1024):  # `sys.stdin` would be locked, which Python does not survive at its end
            pass
        end()

    threading.Thread(target=wait, daemon=True).start()


@contextmanager
def deferred(whole: bool = False) -> Iterator[list[tuple[int, FrameType | None]]]:
    """Defer SIGINT and SIGTERM to the end of the block; yield the list of the signals that have arrived.

    For blocks that must not end half-way: files that are moved into place, compiled code that allocates its results,
    and LLVM, which calls Python where an exception is dropped and then crashes. With `whole` nothing ends the block,
    however long it takes. Outside the main thread, which no signal reaches, do nothing.
    """
    global _whole
    if threading.current_thread() is not threading.main_thread():
        yield []
        return
    found: dict[int, object] = {number: signal.getsignal(number) for number in _NUMBERS}
    handlers = {number: handler for number, handler in found.items() if callable(handler)}
    received: list[tuple[int, FrameType | None]] = []
    for number in handlers:
        signal.signal(number, lambda *arguments: received.append(arguments))
    _whole += whole
    try:
        with _noting():
            yield received
    finally:
        _whole -= whole
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number, frame in received:
            handlers[number](number, frame)
