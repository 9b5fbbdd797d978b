"""Ctrl-C once stops after the current iteration, twice at once."""

from __future__ import annotations

import signal
import sys
from types import FrameType


class Interrupt:
    """A context in which the first Ctrl-C sets `wanted` and the second raises KeyboardInterrupt."""

    def __init__(self) -> None:
        self.wanted = False

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self.wanted

    def __enter__(self) -> Interrupt:
        self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self.wanted:
            raise KeyboardInterrupt
        self.wanted = True
        print("\nstopping after this iteration; Ctrl-C again to stop now", file=sys.stderr, flush=True)
