"""Times of the first runs after an installation: ``python benchmarks/first_run.py [--repeat N]``.

The press by two commands with an empty cache of compiled code, also in a single process, the next run, and two that
fill a cache at once; a script with a user-defined law after this law was edited. Wall time and time of all processors,
medians.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
LINKAGES = [sys.executable, "-c", "from linkages.cli.main import main; main()"]
COMMANDS = {
    "compiled engine, table only": [
        *LINKAGES, "simulate", "seven_bar.toml", "--engine", "compiled", "--no-plots", "--no-animation",
    ],
    "run_sevenbar.py": [sys.executable, str(ROOT / "run_sevenbar.py")],
}  # fmt: skip
LAW = """
import linkages
from linkages import laws

def edited(delta, ddelta, ddelta0, joint):
    return {} * joint.stiffness * delta

laws.register_contact("edited", edited)
changed = {{"joints.B.contact.law": "edited", "duration": 0.002}}
linkages.simulate(linkages.load(linkages.find_file("slider_crank_dry.toml"), changed), "compiled")
"""


def run(command: list[str], cache: Path, together: int = 1, alone: bool = False) -> tuple[float, float]:
    """Run a command, so many times at once: wall time, and processors' time of one [s]; alone: on one processor."""
    on = (lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})) if alone else None
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)}
    before, started = os.times(), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment, "cwd": ROOT}
        outs = [["--out", str(Path(folder) / str(k))] if command in COMMANDS.values() else [] for k in range(together)]
        processes = [subprocess.Popen(command + out, preexec_fn=on, **quiet) for out in outs]
        if sum(process.wait() for process in processes):
            raise SystemExit(f"failed: {' '.join(command)}")
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return time.perf_counter() - started, used / together


def show(what: str, times: list[tuple[float, float]]) -> None:
    """Print medians."""
    wall, used = (statistics.median(part) for part in zip(*times, strict=True))
    print(f"{what:60} {wall:6.1f} s   {used:6.1f} s of processors", flush=True)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=3, help="runs of each")
    repeat = range(parser.parse_args().repeat)
    for what, command in COMMANDS.items():
        with tempfile.TemporaryDirectory() as folder:
            show(f"{what}: first ever", [run(command, Path(folder) / str(k)) for k in repeat])
            show(
                f"{what}: first ever, one process", [run(command, Path(folder) / f"one{k}", alone=True) for k in repeat]
            )
            show(f"{what}: the next", [run(command, Path(folder) / "0") for _ in repeat])
            show(f"{what}: two at once", [run(command, Path(folder) / f"two{k}", 2) for k in repeat])
    with tempfile.TemporaryDirectory() as folder:
        script, times = Path(folder) / "script.py", []
        for factor in range(1, 2 + len(repeat)):
            script.write_text(LAW.format(float(factor)), encoding="utf-8")
            times.append(run([sys.executable, str(script)], Path(folder) / "cache"))
            script.unlink()
        show("a law edited: the next run", times[1:])


if __name__ == "__main__":
    main()
