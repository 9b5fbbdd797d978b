"""Processor time and memory of long runs: ``python benchmarks/long_run.py [--against CHECKOUT] [--repeat N]``.

A slider-crank of 3,000 revolutions: the whole command, and the export of its trajectory; in turns with another checkout
of the package that has its own environment in ``.venv``. Medians.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
MACHINE = """
duration = "30 s"
outputs = ["slider.x"]
drives = {O = {speed = "6000 r/min"}}
section = ["20 mm", "10 mm"]
density = "7850 kg/m3"
links = {ground = "O", crank = "O A", rod = "A B", slider = "B along ground"}
[points]
O = [0, 0]
A = ["O", "50 mm", "0 deg"]
B = ["200 mm", 0]
"""
COMMANDS = {
    "simulate": ("simulate", "long.toml", "--out", "results"),
    "export --to csv": ("export", "results", "--to", "csv"),
    "export --to netcdf": ("export", "results", "--to", "netcdf"),
}


def used(python: Path, command: tuple[str, ...], folder: Path) -> tuple[float, float]:
    """Run a command in a folder: time of processors [s], and largest memory [MB]."""
    called = [python, "-c", "from linkages.cli.main import main; raise SystemExit(main())", *command]
    process = subprocess.Popen(called, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"failed: {' '.join(command)}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e3


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--against", type=Path, help="another checkout")
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    pythons = {"this checkout": Path(sys.executable)}
    if options.against:
        pythons[str(options.against)] = options.against / ".venv" / "bin" / "python"
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "long.machine.toml").write_text(MACHINE)
        used(Path(sys.executable), ("new", "long", "--from", "long.machine.toml"), folder)
        for _ in range(options.repeat):
            for whose, python in pythons.items():
                for name, command in COMMANDS.items():
                    found.setdefault((name, whose), []).append(used(python, command, folder))
    for (name, whose), numbers in sorted(found.items()):
        time, memory = (statistics.median(part) for part in zip(*numbers, strict=True))
        print(f"{name:20} {whose:30} {time:6.1f} s of processors {memory:6.0f} MB")


if __name__ == "__main__":
    main()
