"""Commands in separate processes, which tests interrupt at any step, or give little disk space."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import strikes

PROGRESS = re.compile(r".*, \d+ s so far$|.*: [\d.]+%( in \d+ s.*)?$")
COMMAND = [sys.executable, "-m", "linkages.cli.main"]


def start(
    *words: object, room: int | None = None, struck: tuple[str, int, int] | None = None, **settings
) -> subprocess.Popen:
    """Start a command; no file of it can grow beyond `room` bytes, as on a disk that is full.

    It is `struck` by a signal at a call: place, number of the call and of the signal, see `strikes.command`.
    """

    def limit() -> None:
        import resource

        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    words = strikes.command(*struck, *words) if struck else [*COMMAND, *map(str, words)]
    return subprocess.Popen(words, **pipes | settings, preexec_fn=limit if room is not None else None)


def finish(process: subprocess.Popen) -> tuple[int, str]:
    """Wait for a command; returns its exit status as a shell has it, and its standard error without progress."""
    _, errors = process.communicate(timeout=300)
    code = process.returncode
    return (code if code >= 0 else 128 - code), without_progress(errors)


def without_progress(errors: str) -> str:
    """Leave out the lines of progress, which depend on how busy the machine is."""
    return "".join(line for line in errors.splitlines(keepends=True) if not PROGRESS.match(line))


def child(process: subprocess.Popen, word: str) -> int:
    """Wait until a process has started another one with a word in its command; returns its id."""
    while process.poll() is None:
        for children in Path(f"/proc/{process.pid}/task").glob("*/children"):
            for pid in children.read_text().split():
                if word.encode() in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0"):
                    return int(pid)
        time.sleep(0.01)
    raise AssertionError(f"the process has ended, and started nothing with {word}")


def begun(process: subprocess.Popen) -> None:
    """Wait until a command catches SIGTERM: before, it is Python that starts."""
    status = Path("/proc") / str(process.pid) / "status"
    while process.poll() is None:
        caught = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        if int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1:
            return
        time.sleep(0.01)


def processor_time(process: subprocess.Popen) -> float:
    """Time the processor has spent on a process [s], which does not depend on what else the machine does."""
    fields = (Path("/proc") / str(process.pid) / "stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
