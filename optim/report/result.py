"""``result.json`` and its content as text; several results as one table, for the terminal and as CSV."""

from __future__ import annotations

import csv
import statistics
from collections.abc import Sequence
from pathlib import Path

from linkages.base.brief import cell, counted
from linkages.input.files.writing import whole
from linkages.show.plots.names import name_of_value
from linkages.show.plots.quantities import change, quantity
from optim.algorithms.nlp import Ending
from optim.problem.study import Study
from optim.search.result import StudyResult

_AT = 1e-3  # distance from a bound over the range of a variable up to which it is at its bound
_COLUMNS = ("study", "seed", "status", "evaluations", "failed", "iterations", "wall_time")


def format_result(study: Study, result: StudyResult) -> str:
    """Format a result as lines of text: nominal and best design side by side.

    Parameters
    ----------
    study : Study
    result : StudyResult
        From `optim.optimise`.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> result = optim.optimise(study, algorithm={"name": "ga", "population": 4, "generations": 1})
    >>> optim.format_result(study, result).splitlines()[0]
    'Seven-bar press: least joint forces'
    """
    best, nominal = result.best, result.nominal
    which = "compromise" if result.front else "best"
    first = max(34, *(2 + len(study.variable_label(path)) for path in study.paths))
    unrun = f", {result.unrun} infeasible and not run" if result.unrun else ""
    ending = Ending(result.status).words
    lines = [
        study.title,
        f"{result.algorithm['name']}, seed {result.seed}, {ending}:"
        f" {counted(result.evaluations, 'evaluation')} ({result.failed} failed{unrun}),"
        f" {result.wall_time:.1f} s",
        "",
        f"{'variable':{first}s}{'nominal':>13s}{which:>18s}{'lower':>13s}{'upper':>13s}",
    ]
    for k, path in enumerate(study.paths):
        at = f"{nominal.variables[path]:13.5g}{best.variables[path]:18.5g}"
        low, high = study.lower[k], study.upper[k]
        ends = [
            end
            for end, bound in (("lower", low), ("upper", high))
            if abs(best.variables[path] - bound) <= _AT * (high - low)
        ]
        note = f"  at its {ends[0]} bound" if ends else ""
        lines.append(f"{study.variable_label(path):{first}s}{at}{low:13.5g}{high:13.5g}{note}")
    for kind in ("objectives", "constraints"):
        if result.best[kind]:
            lines += ["", f"{kind[:-1]:{first}s}{'nominal':>13s}{which:>18s}{'change':>13s}"]
        for name, value in best[kind].items():
            before = nominal[kind][name]
            lines.append(f"{study.label(name):{first}s}{cell(before, 13)}{cell(value, 18)}{_change(before, value)}")
    if result.designs:
        lines += ["", f"{'reference design':{first}s}" + "".join(f"{name:>18s}" for name in result.designs)]
        for name in best.objectives:
            cells = [cell(entry.objectives[name], 18) for entry in result.designs.values()]
            lines.append(f"{study.label(name):{first}s}{''.join(cells)}")
    if result.front:
        lines += ["", f"the front has {counted(len(result.front), 'design')}"]
    if not nominal.feasible:
        lines += ["", "the nominal design is not feasible: it violates constraints or failed"]
    if not best.feasible:
        lines += ["", "no design satisfies all constraints; this one violates them least"]
    return "\n".join(lines)


def result_answer(study: Study, result: StudyResult) -> list[str]:
    """Tell in sentences how the best design changes the objectives, and which variables are at their bounds."""
    best, nominal = result.best, result.nominal
    said = []
    for name, value in best.objectives.items():
        before = nominal.objectives[name]
        if value is not None:
            told = "" if before is None else change(value, before, "the nominal design")
            said.append(f"{name} becomes {quantity(value, study.unit(name))}{', ' * bool(told)}{told}.")
    bounds = zip(study.paths, study.lower, study.upper, strict=True)
    ends = [name_of_value(path) for path, low, high in bounds if not low < best.variables[path] < high]
    if ends:
        said.append(f"At a bound: {', '.join(ends)}.")
    if not best.feasible:
        said.append("No design satisfies all constraints; this one violates them least.")
    return said


def format_table(results: Sequence[StudyResult]) -> str:
    """Format results as lines of text: a line for each run, and the spread over seeds for each study."""
    lines = []
    for study in dict.fromkeys(result.study for result in results):
        runs = [result for result in results if result.study == study]
        names = list(runs[0].best.objectives)
        labels = runs[0].labels
        head = f"{'seed':>8s}" + "".join(f"{labels.get(name, name):>22s}" for name in names)
        lines += [study, head + f"{'feasible':>10s}{'evaluations':>13s}{'failed':>8s}{'time [s]':>10s}"]
        for run in runs:
            cells = "".join(cell(run.best.objectives[name], 22, ".6g") for name in names)
            feasible = "yes" if run.best.feasible else "no"
            counts = f"{feasible:>10s}{run.evaluations:13d}{run.failed:8d}{run.wall_time:10.1f}"
            lines.append(f"{run.seed:8d}{cells}{counts}")
        good = [run.best.objectives for run in runs if run.best.feasible]
        if len(good) > 1:
            columns = [[x for run in good if (x := run[name]) is not None] for name in names]
            for label, reduce in (("mean", statistics.fmean), ("std", statistics.stdev)):
                lines.append(f"{label:>8s}" + "".join(cell(reduce(column), 22, ".6g") for column in columns))
        lines.append("")
    return "\n".join(lines).rstrip()


def write_table(results: Sequence[StudyResult], path: Path) -> None:
    """Write a CSV file: a line for each run."""
    rows = []
    for result in results:
        best = result.best
        row = {key: result[key] for key in _COLUMNS} | {"feasible": best.feasible}
        for kind in ("objective", "constraint", "variable"):
            row |= {f"{kind}:{name}": value for name, value in best[f"{kind}s"].items()}
        rows.append(row)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with whole(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def _change(before: float | None, after: float | None) -> str:
    if before is None or after is None or before == 0.0:
        return f"{'-':>13s}"
    return f"{100.0 * (after - before) / abs(before):+12.1f}%"
