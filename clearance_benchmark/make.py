"""Make all references again, in some ten minutes: python clearance_benchmark/make.py [--accuracy 1e-12] [NAME ...]

Each problem is solved by the compiled engine and by the Drake engine of linkages, and by `independent.py`. The reference
is the compiled engine's; the accuracy of a column is the largest difference of two solutions, in parts of its largest
magnitude. Beside the references: the drawings, and an archive with everything that a user of another program needs.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import sys
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

import linkages
from linkages import Trajectory

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import machines  # noqa: E402

REFERENCES = HERE / "references"
CONTACT = {
    "contact": "1", "start": "s", "approach_speed": "m/s", "end": "s", "peak_load": "N", "peak_penetration": "m",
    "separation_speed": "m/s",
}  # fmt: skip
STATISTICS = "dry_slider_crank_statistics"
RUNS, CHANGE = 24, 1e-9  # machines of the statistics, and the relative step of their clearances
TURN, FIRST, LAST = 0.012, 20, 60  # time of a turn [s], and turns between which they are taken
LEAST = 1e-12  # accuracy that two equal solutions have, in parts of a column
#: Files for users of other programs.
SHIPPED = "README.md", "statements.md", "compare.py", "independent.py", "machines.py"


class Problem(NamedTuple):
    """What a reference holds: contacts by their owners, or outputs over time."""

    contacts: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()


def journal(name: str) -> tuple[str, ...]:
    """Return the outputs of a journal."""
    return tuple(f"{name}.{what}" for what in ("ex", "ey", "fx", "fy"))


PROBLEMS = {
    "bouncing_journal": Problem(contacts=("O",)),
    "dry_slider_crank": Problem(contacts=("B",)),
    "main_bearing": Problem(outputs=("crank.angle", "crank.omega", "slider.x", "slider.ax", *journal("O"))),
    "four_bar": Problem(outputs=("follower.angle", "follower.omega", "follower.alpha", *journal("A"), *journal("B"))),
    "gear_pair": Problem(contacts=("mesh.upper", "mesh.lower")),
    "press": Problem(outputs=("slider7.x", "slider7.vx", "slider7.ax", *journal("A"), *journal("B"))),
}


def solved(name: str, engine: str, accuracy: float, like: np.ndarray) -> np.ndarray:
    """Solve a problem by an engine of linkages, in the rows and columns of another solution."""
    problem = PROBLEMS[name]
    system = linkages.load(HERE / "experiments" / f"{name}.toml", {"solver.accuracy": accuracy})
    if problem.contacts:
        system = system.replaced({"duration": float(4.0 * like[-1, 3] - 3.0 * like[-1, 1])})
        return contact_rows(linkages.simulate(system, engine), problem.contacts)[: len(like)]
    wanted = list(problem.outputs) if engine == "compiled" else None
    run = linkages.simulate(system, engine, outputs=wanted)
    return over_time(run, problem.outputs, like[:, 0])


def contact_rows(run: Trajectory, owners: tuple[str, ...]) -> np.ndarray:
    """Return the contacts of a run as rows."""
    return np.array([
        [owners.index(one.joint), one.start, one.approach_speed, one.start + one.duration, one.peak_force, one.peak_penetration,
         one.separation_speed] for one in linkages.impacts(run, list(owners))
    ])  # fmt: skip


def over_time(run: Trajectory, outputs: tuple[str, ...], times: np.ndarray) -> np.ndarray:
    """Return outputs at times as columns after the times."""
    curves = run.evaluate(times)
    return np.column_stack([times, *(curves[name] for name in outputs)])


def units_of(name: str) -> dict[str, str]:
    """Return the units of a reference's columns."""
    problem = PROBLEMS[name]
    if problem.contacts:
        return CONTACT
    system = linkages.load(HERE / "experiments" / f"{name}.toml")
    return {"t": "s"} | {output: linkages.output_unit(system, output) for output in problem.outputs}


def apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the largest difference of each column, in parts of its largest magnitude."""
    size = np.abs(one).max(axis=0)
    return np.asarray(np.abs(one - other).max(axis=0) / np.where(size > 0.0, size, 1.0))


def make(name: str, accuracy: float) -> dict:
    """Write a reference; return what `references.json` says of it."""
    independent = machines.PROBLEMS[name]()
    reference, drake = (solved(name, engine, accuracy, independent) for engine in ("compiled", "drake"))
    units = units_of(name)
    path = REFERENCES / f"{name}.csv"
    with open(path, "w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(f"{column} [{unit}]" for column, unit in units.items())
        lines.writerows([f"{x:.15g}" for x in row] for row in reference)
    differences = {"drake": apart(reference, drake), "independent": apart(reference, independent)}
    print(f"{name}: {len(reference)} rows, " + ", ".join(f"{k} {v.max():.1e}" for k, v in differences.items()), flush=True)
    return {"sha256": hashlib.sha256(path.read_bytes()).hexdigest(), "columns": {
        column: {"unit": unit, "accuracy": max(LEAST, *(float(each[k]) for each in differences.values()))}
        | {engine: float(each[k]) for engine, each in differences.items()}
        for k, (column, unit) in enumerate(units.items())
    }}  # fmt: skip


def make_statistics(accuracy: float = 1e-8) -> dict:
    """Write the statistics of a long dry run, and how much single runs scatter about them."""
    system = linkages.load(HERE / "experiments" / "dry_slider_crank.toml", {"solver.accuracy": accuracy})
    system = system.replaced({"duration": LAST * TURN})
    clearance = system.value("joints.B.clearance")
    rows = [
        numbers(linkages.simulate(system.replaced({"joints.B.clearance": clearance * (1.0 + k * CHANGE)})))
        for k in range(RUNS)
    ]
    path = REFERENCES / f"{STATISTICS}.csv"
    table = zip(range(1, len(rows[0]) + 1), np.mean(rows, axis=0), np.std(rows, axis=0, ddof=1), strict=True)
    with open(path, "w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(["number", "value", "scatter"])
        lines.writerows([k, f"{mean:.6g}", f"{scatter:.3g}"] for k, mean, scatter in table)
    print(f"{STATISTICS}: {path.read_text(encoding='utf-8')}", flush=True)
    return {"sha256": hashlib.sha256(path.read_bytes()).hexdigest(), "runs": RUNS}


def numbers(run: Trajectory) -> list[float]:
    """Return contacts per turn, the mean of their peak forces and the root mean square of the force, in steady turns."""
    peaks = [one.peak_force for one in linkages.impacts(run, ["B"]) if one.start >= FIRST * TURN]
    means = run.within(FIRST * TURN, LAST * TURN)
    square = np.trapezoid(means["B.force"] ** 2, means.time) / (means.time[-1] - means.time[0])
    return [len(peaks) / (LAST - FIRST), float(np.mean(peaks)), float(np.sqrt(square))]


def main() -> None:
    """Make references."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join([*PROBLEMS, STATISTICS])}; default: all")
    parser.add_argument("--accuracy", type=float, default=1e-12, help="of both engines; default: %(default)g")
    given = parser.parse_args()
    REFERENCES.mkdir(exist_ok=True)
    index = REFERENCES / "references.json"
    known = json.loads(index.read_text(encoding="utf-8")) if index.exists() else {}
    for name in given.names or [*PROBLEMS, STATISTICS]:
        known[name] = make_statistics() if name == STATISTICS else make(name, given.accuracy)
        index.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    with zipfile.ZipFile(HERE / "clearance_benchmark.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path in [*(HERE / each for each in SHIPPED), *sorted(REFERENCES.iterdir())]:
            if path.exists():
                archive.write(path, path.relative_to(HERE.parent))


if __name__ == "__main__":
    main()
