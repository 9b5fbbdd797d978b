"""Several results as one table: for the terminal, and as CSV."""

from __future__ import annotations

import csv
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from linkages.files.writing import whole

Result = dict[str, Any]  # content of ``result.json``


def format_table(results: Sequence[Result]) -> str:
    """Format results as lines of text: a line for each run, and the spread over seeds for each study."""
    lines = []
    for study in dict.fromkeys(result["study"] for result in results):
        runs = [result for result in results if result["study"] == study]
        names = list(runs[0]["best"]["objectives"])
        head = f"{'seed':>8s}" + "".join(f"{name:>22s}" for name in names)
        lines += [study, head + f"{'feasible':>10s}{'evaluations':>13s}{'failed':>8s}{'time [s]':>10s}"]
        for run in runs:
            cells = "".join(_cell(run["best"]["objectives"][name]) for name in names)
            feasible = "yes" if run["best"]["feasible"] else "no"
            counts = f"{feasible:>10s}{run['evaluations']:13d}{run['failed']:8d}{run['wall_time']:10.1f}"
            lines.append(f"{run['seed']:8d}{cells}{counts}")
        good = [run["best"]["objectives"] for run in runs if run["best"]["feasible"]]
        if len(good) > 1:
            columns = [[run[name] for run in good] for name in names]
            for label, reduce in (("mean", statistics.fmean), ("std", statistics.stdev)):
                lines.append(f"{label:>8s}" + "".join(_cell(reduce(column)) for column in columns))
        lines.append("")
    return "\n".join(lines).rstrip()


def write_table(results: Sequence[Result], path: Path) -> None:
    """Write a CSV file: a line for each run."""
    rows = [
        {
            key: result[key]
            for key in ("study", "seed", "status", "evaluations", "failed", "iterations", "wall_time")
        }
        | {"feasible": result["best"]["feasible"]}
        | {f"objective:{name}": value for name, value in result["best"]["objectives"].items()}
        | {f"constraint:{name}": value for name, value in result["best"]["constraints"].items()}
        | {f"variable:{name}": value for name, value in result["best"]["variables"].items()}
        for result in results
    ]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with whole(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def _cell(value: float | None) -> str:
    return f"{'-':>22s}" if value is None else f"{value:22.6g}"
