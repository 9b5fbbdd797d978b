"""Measure long runs: ``python benchmarks/long_run.py [--against CHECKOUT] [--repeat N] [--page FILE]``.

Processor time and largest memory of `linkages simulate` for a slider-crank of 3,000 revolutions (30 s; 188,499 steps),
with all its files, and of the exports of its trajectory. With `--against` in turns with another checkout of the package
that has its own environment in ``.venv``. Medians.
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
BEGIN = "\n## Long runs\n"
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
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    pythons = {"this checkout": Path(sys.executable)}
    if options.against:
        pythons[options.against.name] = options.against / ".venv" / "bin" / "python"
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    warm: set[str] = set()
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "long.machine.toml").write_text(MACHINE)
        used(Path(sys.executable), ("new", "long", "--from", "long.machine.toml"), folder)
        for _ in range(options.repeat):
            for whose, python in pythons.items():
                for name, command in COMMANDS.items():
                    if whose not in warm:  # kernels are compiled
                        used(python, command, folder)
                    found.setdefault((name, whose), []).append(used(python, command, folder))
                warm.add(whose)
    lines = ["| command | checkout | processor time | memory |", "|---|---|---|---|"]
    for (name, whose), numbers in found.items():
        time, memory = (statistics.median(part) for part in zip(*numbers, strict=True))
        lines.append(f"| `linkages {name}` | {whose} | {time:.1f} s | {memory:.0f} MB |")
    print("\n".join(lines))
    if options.page:
        page, _, rest = options.page.read_text(encoding="utf-8").partition(BEGIN)
        rest = "".join(rest.partition("\n## ")[1:])
        about = (__doc__ or "").partition("\n\n")[2].strip()
        text = "\n".join([about, "", *lines])
        options.page.write_text(f"{page.rstrip()}\n{BEGIN}\n{text}\n{rest}", encoding="utf-8")


if __name__ == "__main__":
    main()
