"""Grade the results of a program against a reference: python compare.py NAME FILE.csv [--statistics]

NAME is a problem, and FILE has the columns of `NAME/reference.csv`, in any order, one row for each of its rows. The
error of a column is the largest difference, in parts of its largest magnitude. Grades: A up to 1e-6, B up to 1e-4, C up
to 1e-2, else failed; the grade of a file is its worst one. A column whose reference is less accurate than a tenth of a
grade cannot have this grade. With --statistics, FILE has the columns number and value of `NAME/statistics.csv`: A
within two standard deviations of a single run, B within three, C within five. Exit status 0 for a grade, 1 if the file
has failed, 2 if it cannot be read. Python's standard library is sufficient.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
GRADES = {"A": 1e-6, "B": 1e-4, "C": 1e-2}  # largest error, in parts of the column's largest magnitude
SCATTERS = {"A": 2.0, "B": 3.0, "C": 5.0}  # largest error of a statistic, in deviations of a single run
FAILED = "failed"


class UnreadableError(Exception):
    """The file is no table with the reference's columns and rows."""


def columns(path: Path) -> dict[str, list[float]]:
    """Read the columns of a CSV file; units in brackets are no part of their names."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            head, *rows = [row for row in csv.reader(file) if row]
        names = [name.partition("[")[0].strip() for name in head]
        return {name: [float(row[k]) for row in rows] for k, name in enumerate(names)}
    except OSError as problem:
        raise UnreadableError(f"{path}: {problem.strerror}") from None
    except (ValueError, IndexError) as problem:
        raise UnreadableError(f"{path}: is no table of numbers with a row of names: {problem}") from None


def grade(error: float, least: float, limits: dict[str, float]) -> str:
    """Return the best grade with a limit that is not below the error and ten times `least`."""
    known = (name for name, limit in limits.items() if error <= limit and 10.0 * least <= limit)
    return next(known, FAILED) if math.isfinite(error) else FAILED


def graded(path: Path, name: str) -> list[tuple[str, float, str]]:
    """Return name, error and grade of each column."""
    known = about(name)["columns"]
    own, reference = tables(path, FOLDER / name / "reference.csv")
    found = []
    for column, wanted in reference.items():
        size = max(map(abs, wanted)) or 1.0
        pairs = zip(own[column], wanted, strict=False)
        error = max(abs(a - b) for a, b in pairs) / size if len(own[column]) >= len(wanted) else math.inf
        found.append((column, error, grade(error, known[column]["accuracy"], GRADES)))
    return found


def graded_statistics(path: Path, name: str) -> list[tuple[str, float, str]]:
    """Compare each value with the mean and the scatter of single runs; return name, error and grade."""
    about(name)
    if not (FOLDER / name / "statistics.csv").exists():
        raise UnreadableError(f"{name}: has no statistics")
    own, reference = tables(path, FOLDER / name / "statistics.csv", known={"scatter"})
    found = []
    for k, (number, mean, scatter) in enumerate(
        zip(*(reference[x] for x in ("number", "value", "scatter")), strict=True)
    ):
        error = abs(own["value"][k] - mean) / scatter if k < len(own["value"]) else math.inf
        found.append((f"number {number:g}", error, grade(error, 0.0, SCATTERS)))
    return found


def about(name: str) -> dict:
    """Return what is known of a reference."""
    known = json.loads((FOLDER / "references.json").read_text(encoding="utf-8"))
    problems = [each for each in known if "columns" in known[each]]
    if name not in problems:
        raise UnreadableError(f"{name}: is no problem; there are {', '.join(problems)}")
    return known[name]


def tables(path: Path, reference: Path, known: frozenset[str] | set[str] = frozenset()) -> tuple[dict, dict]:
    """Read a file and its reference; all columns of the reference but the known ones are needed."""
    own, wanted = columns(path), columns(reference)
    if missing := [column for column in wanted if column not in own and column not in known]:
        raise UnreadableError(f"{path}: has no column {', '.join(missing)}; the reference has {', '.join(wanted)}")
    return own, wanted


def worst(grades: list[str]) -> str:
    """Return the worst grade."""
    return max(grades, key=[*GRADES, FAILED].index)


def main() -> int:
    """Print a line for each column, and the grade."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", help="a problem: the name of its folder")
    parser.add_argument("file", type=Path)
    parser.add_argument("--statistics", action="store_true", help="the file has statistics")
    given = parser.parse_args()
    try:
        found = (graded_statistics if given.statistics else graded)(given.file, given.name)
    except UnreadableError as problem:
        print(f"compare.py: {problem}", file=sys.stderr)
        return 2
    for column, error, letter in found:
        print(f"{column:20s} {error:10.2e}  {letter}")
    result = worst([letter for *_, letter in found])
    print(f"{given.name}: {result}")
    return int(result == FAILED)


if __name__ == "__main__":
    sys.exit(main())
