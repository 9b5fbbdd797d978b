"""Measure the first use of commands: ``python benchmarks/first_use.py [--python PYTHON] [--commands NAME ...]``.

Each command runs on an empty cache of compiled code, then again: processor time, wall time, kernels that the first run
compiled. With the Python of an environment in which a wheel with kernels is installed, that wheel is measured; this
checkout by default. Ratios of the two runs do not depend on the machine's other work, the times do.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RUN = "import sys; from linkages.cli.main import main; status = main(sys.argv[1:])"
#: Also writes how many kernels this process has compiled and loaded, and those that others have left in the cache.
COUNT = "from linkages.base.kernel.precompiled import counts; print('kernels:', *counts(), file=sys.stderr)"
FILES = (
    "import sys; from pathlib import Path; from linkages.cli import commands\n"
    "for one in commands().values():\n"
    "    for name, text in getattr(one, 'SHORT_FILES', {}).items():\n"
    "        Path(sys.argv[1], name).write_text(text)"
)
COMMANDS = {
    "simulate": "simulate seven_bar.toml",
    "sensitivity": "sensitivity seven_bar.toml --wrt joints.A.clearance joints.A.viscosity sdf.links.link6.mass",
    "identify": "identify short_film.toml",
    "tolerances": "tolerances short_tolerances.toml",
    "optimise": "optimise short_search.toml",
}


def first(python: str, words: list[str], folder: Path, cache: Path) -> tuple[float, float, str]:
    """Run a command: processor time and wall time [s], and its kernels, compiled and loaded."""
    settings = {"NUMBA_CACHE_DIR": str(cache), "LINKAGES_CACHE": str(cache / "maps"), "MPLBACKEND": "Agg"}
    if python == sys.executable:
        settings["PYTHONPATH"] = str(ROOT)
    before, began = os.times(), time.perf_counter()
    command = [python, "-c", f"{RUN}; {COUNT}; sys.exit(status)", *words]
    done = subprocess.run(command, cwd=folder, env=os.environ | settings, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"failed: {' '.join(words)}\n{done.stderr}")
    after, (kernels,) = os.times(), [line for line in done.stderr.splitlines() if line.startswith("kernels:")]
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return used, time.perf_counter() - began, kernels.removeprefix("kernels: ")


def main() -> None:
    """Print all numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--commands", nargs="+", choices=COMMANDS, default=list(COMMANDS))
    options = parser.parse_args()
    print(
        f"{'':14s} {'first use':>30s} {'again':>22s} {'compiled':>10s} {'loaded':>8s}   (load {os.getloadavg()[0]:.1f})"
    )
    for name in options.commands:
        with tempfile.TemporaryDirectory() as text:
            folder = Path(text)
            subprocess.run([options.python, "-c", FILES, text], cwd=text, check=True)
            (used, wall, kernels), (later, wall_later, _) = (
                first(options.python, [*COMMANDS[name].split(), "--out", f"out{k}"], folder, folder / "cache")
                for k in range(2)
            )
        compiled, loaded = kernels.split()
        again = f"{later:6.1f} s, {wall_later:6.1f} s"
        print(f"{name:14s} {used:8.1f} s processor, {wall:6.1f} s {again} {compiled:>10s} {loaded:>8s}", flush=True)


if __name__ == "__main__":
    main()
