"""Make all references again, in some twenty minutes: python clearance_benchmark/make.py [--accuracy 1e-12] [NAME ...]

Each problem is solved by the compiled engine and by the Drake engine of linkages, and by its `independent.py`. The
reference is the compiled engine's; the accuracy of a column is the largest difference of two solutions, in parts of its
largest magnitude. Beside the references: the drawings, and an archive with all that a user of another program needs.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import importlib.util
import json
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import ModuleType

import numpy as np

import linkages
from linkages import Trajectory

HERE = Path(__file__).resolve().parent
INDEX = HERE / "references.json"
ARCHIVE = HERE / "clearance_benchmark.zip"
PROBLEMS = "bouncing_journal", "dry_slider_crank", "main_bearing", "four_bar", "gear_pair", "press"
#: Owners of the contacts of a problem, in the order of their numbers; the other references are curves.
CONTACTS = {"bouncing_journal": ("O",), "dry_slider_crank": ("B",), "gear_pair": ("mesh.upper", "mesh.lower")}
STATISTICS = "dry_slider_crank"
RUNS, CHANGE = 24, 1e-9  # machines of the statistics, and the relative step of their clearances
TURN, FIRST, LAST = 0.012, 20, 60  # time of a turn [s], and turns between which they are taken
SHORT = 2e-5  # step where curves are compared [s]
LEAST = 1e-12  # accuracy that two equal solutions have, in parts of a column


def independent(name: str) -> ModuleType:
    """Import the independent solution of a problem."""
    spec = importlib.util.spec_from_file_location(f"independent_{name}", HERE / name / "independent.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def solved(name: str, engine: str, accuracy: float, columns: Iterable[str], like: np.ndarray) -> np.ndarray:
    """Solve a problem by an engine of linkages, in the rows and columns of another solution."""
    system = linkages.load(HERE / name / "machine.toml", {"solver.accuracy": accuracy})
    if name in CONTACTS:
        system = system.replaced({"duration": float(4.0 * like[-1, 3] - 3.0 * like[-1, 1])})
        return contact_rows(linkages.simulate(system, engine), CONTACTS[name])[: len(like)]
    system = system.replaced({"solver.max_step": SHORT})  # engines interpolate between the ends of steps
    outputs = [column for column in columns if column != "t"]
    run = linkages.simulate(system, engine, outputs=outputs if engine == "compiled" else None)
    curves = run.evaluate(like[:, 0])
    return np.column_stack([like[:, 0], *(curves[output] for output in outputs)])


def contact_rows(run: Trajectory, owners: tuple[str, ...]) -> np.ndarray:
    """Return the contacts of a run as rows."""
    return np.array([
        [owners.index(one.joint), one.start, one.approach_speed, one.start + one.duration, one.peak_force, one.peak_penetration,
         one.separation_speed] for one in linkages.impacts(run, list(owners))
    ])  # fmt: skip


def apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the largest difference of each column, in parts of its largest magnitude."""
    size = np.abs(one).max(axis=0)
    return np.asarray(np.abs(one - other).max(axis=0) / np.where(size > 0.0, size, 1.0))


def make(name: str, accuracy: float) -> dict:
    """Write a reference; return what `references.json` says of it."""
    other = independent(name)
    units: Mapping[str, str] = other.COLUMNS
    own = other.solution()
    reference, drake = (solved(name, engine, accuracy, units, own) for engine in ("compiled", "drake"))
    path = HERE / name / "reference.csv"
    write(
        path,
        [f"{column} [{unit}]" for column, unit in units.items()],
        [[f"{x:.15g}" for x in row] for row in reference],
    )
    differences = {"drake": apart(reference, drake), "independent": apart(reference, own)}
    print(
        f"{name}: {len(reference)} rows, " + ", ".join(f"{k} {v.max():.1e}" for k, v in differences.items()), flush=True
    )
    return {"sha256": digest(path), "columns": {
        column: {"unit": unit, "accuracy": max(LEAST, *(float(each[k]) for each in differences.values()))}
        | {engine: float(each[k]) for engine, each in differences.items()}
        for k, (column, unit) in enumerate(units.items())
    }}  # fmt: skip


def write(path: Path, head: list[str], rows: Iterable[list[str]]) -> None:
    """Write a table."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *rows])


def digest(path: Path) -> str:
    """Return the checksum of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def make_statistics(accuracy: float = 1e-8) -> dict:
    """Write the statistics of a long dry run, and how much single runs scatter about them."""
    system = linkages.load(HERE / STATISTICS / "machine.toml", {"solver.accuracy": accuracy})
    system = system.replaced({"duration": LAST * TURN})
    clearance = system.value("joints.B.clearance")
    found = []
    for k in range(RUNS):
        found.append(
            numbers(linkages.simulate(system.replaced({"joints.B.clearance": clearance * (1.0 + k * CHANGE)})))
        )
        print(f"\rstatistics: {k + 1} of {RUNS} runs", end="", flush=True)
    path = HERE / STATISTICS / "statistics.csv"
    table = zip(range(1, len(found[0]) + 1), np.mean(found, axis=0), np.std(found, axis=0, ddof=1), strict=True)
    write(
        path, ["number", "value", "scatter"], ([str(k), f"{mean:.6g}", f"{scatter:.3g}"] for k, mean, scatter in table)
    )
    print(f"\n{path.read_text(encoding='utf-8')}", flush=True)
    return {"sha256": digest(path), "runs": RUNS}


def numbers(run: Trajectory) -> list[float]:
    """Return contacts per turn, the mean of their peak forces and the root mean square of the force, in steady turns."""
    peaks = [one.peak_force for one in linkages.impacts(run, ["B"]) if one.start >= FIRST * TURN]
    steady = run.within(FIRST * TURN, LAST * TURN)
    square = np.trapezoid(steady["B.force"] ** 2, steady.time) / (steady.time[-1] - steady.time[0])
    return [len(peaks) / (LAST - FIRST), float(np.mean(peaks)), float(np.sqrt(square))]


def draw(name: str) -> None:
    """Write the drawing of a machine."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            str(Path(sys.executable).with_name("linkages")),
            "draw",
            str(HERE / name / "machine.toml"),
            "--out",
            folder,
        ]
        subprocess.run([*command, "--force"], check=True, stdout=subprocess.DEVNULL)
        shutil.copy(Path(folder, "drawing.svg"), HERE / name)


def packed() -> list[Path]:
    """List the files of the archive, which need nothing of this project."""
    shared = [HERE / name for name in ("README.md", "bodies.py", "compare.py", INDEX.name)]
    own = [
        path for name in PROBLEMS for path in (HERE / name).iterdir() if path.suffix in (".md", ".py", ".csv", ".svg")
    ]
    return sorted([*shared, *own])


def pack() -> None:
    """Write the archive."""
    with zipfile.ZipFile(ARCHIVE, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in packed():
            archive.write(path, path.relative_to(HERE.parent))


def main() -> None:
    """Make references."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PROBLEMS)}, statistics; default: all")
    parser.add_argument("--accuracy", type=float, default=1e-12, help="of both engines; default: %(default)g")
    given = parser.parse_args()
    known = json.loads(INDEX.read_text(encoding="utf-8")) if INDEX.exists() else {}
    for name in given.names or [*PROBLEMS, "statistics"]:
        known[name] = make_statistics() if name == "statistics" else make(name, given.accuracy)
        INDEX.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    for name in PROBLEMS:
        draw(name)
    pack()


if __name__ == "__main__":
    main()
