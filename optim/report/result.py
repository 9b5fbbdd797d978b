"""What an optimisation found: ``result.json``, and a table for the terminal."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.files.whole import whole
from optim.algorithms import pareto
from optim.evaluate.evaluations import INFEASIBLE, Evaluations
from optim.evaluate.limits import in_units, values_of
from optim.problem.study import Study, label
from optim.search.run import FEASIBLE, Outcome

Array = NDArray[np.float64]


def compromise(objectives: Array) -> int:
    """Index of one design to name first in a front (k, no), all to be minimised.

    The knee, or, of a front without one, the design nearest to the ideal point, each objective measured by its range.
    """
    if not np.isfinite(objectives).all():
        return 0
    found = pareto.knee(objectives)
    if found is not None:
        return found
    span = np.ptp(objectives, axis=0)
    scaled = (objectives - objectives.min(axis=0)) / np.where(span > 0.0, span, 1.0)
    return int(np.argmin(np.linalg.norm(scaled, axis=1)))


def summarize(
    study: Study,
    outcome: Outcome,
    algorithm: dict[str, Any],
    seed: int,
    versions: dict[str, str],
    references: Evaluations | None = None,
    start: Array | None = None,
) -> dict[str, Any]:
    """Make the content of ``result.json``, SI units; relative quantities are multiples of the nominal design's.

    `references` are the evaluations of the study's reference designs, if it has any; `start` (n,) is where the search
    began, if not at the nominal design.
    """
    designs = np.atleast_2d(outcome.result.x)
    values = values_of(study, outcome.found, outcome.nominal)
    several = len(study.file.objectives) > 1
    entries = [_entry(study, designs, outcome.found, outcome.nominal, k) for k in range(len(designs))]
    best = compromise(values.objectives) if several else 0
    failures = {status: n for status, n in outcome.failures.items() if status != INFEASIBLE}
    return {
        "study": study.source.stem,
        "title": study.title,
        "algorithm": algorithm,
        "seed": seed,
        "start": None if start is None else dict(zip(study.paths, map(float, start), strict=True)),
        "status": outcome.result.status,
        "best": entries[best],
        "front": entries if several else [],
        "nominal": _entry(study, study.nominal[None], outcome.nominal, outcome.nominal, 0),
        "designs": {}
        if references is None
        else {
            name: _entry(study, np.array([*study.designs.values()]), references, outcome.nominal, k)
            for k, name in enumerate(study.designs)
        },
        "iterations": outcome.result.iterations,
        "evaluations": outcome.evaluations,
        "unrun": outcome.failures.get(INFEASIBLE, 0),
        "failed": sum(failures.values()),
        "failures": failures,
        "versions": versions,
        "wall_time": outcome.elapsed,
    }


def _entry(study: Study, designs: Array, found: Evaluations, nominal: Evaluations, k: int) -> dict[str, Any]:
    """Design k as JSON types; None where it failed."""
    objectives, constraints = in_units(study, found, nominal)
    design = designs[k]
    linked = {
        path: link(study.named(design))
        for point in study.points[:1]
        for path, link in zip(point.paths[len(study.paths) :], point.links, strict=True)
    }
    violation = float(values_of(study, found, nominal).violation[k])
    entry: dict[str, Any] = {
        "variables": dict(zip(study.paths, map(float, design), strict=True)),
        "linked": linked,
        "objectives": dict(zip(study.file.objectives, map(_number, objectives[k]), strict=True)),
        "constraints": dict(zip(study.file.constraints, map(_number, constraints[k]), strict=True)),
        "feasible": violation <= FEASIBLE,
        "status": found.status[k],
    }
    return entry | ({"reason": found.reason[k]} if found.reason[k] else {})


def _number(value: float) -> float | None:
    """Return a number as JSON knows it: no NaN."""
    return float(value) if math.isfinite(value) else None


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file, whole or not at all."""
    with whole(path) as partial:
        partial.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def format_result(study: Study, result: dict[str, Any]) -> str:
    """Format a result as lines of text: nominal design beside the best one."""
    best, nominal = result["best"], result["nominal"]
    which = "compromise" if result["front"] else "best"
    unrun = f", {result['unrun']} infeasible and not run" if result["unrun"] else ""
    lines = [
        study.title,
        f"{result['algorithm']['name']}, seed {result['seed']}, {result['status']}: {result['evaluations']} evaluations"
        f" ({result['failed']} failed{unrun}), {result['wall_time']:.1f} s",
        "",
        f"{'variable':34s}{'nominal':>13s}{which:>18s}{'lower':>13s}{'upper':>13s}",
    ]
    for k, path in enumerate(study.paths):
        at = f"{nominal['variables'][path]:13.5g}{best['variables'][path]:18.5g}"
        lines.append(f"{path:34s}{at}{study.lower[k]:13.5g}{study.upper[k]:13.5g}")
    for kind in ("objectives", "constraints"):
        if result["best"][kind]:
            lines += ["", f"{kind[:-1]:34s}{'nominal':>13s}{which:>18s}{'change':>13s}"]
        for name, value in best[kind].items():
            before = nominal[kind][name]
            lines.append(
                f"{label(study, name):34s}{_cell(before, 13)}{_cell(value, 18)}{_change(before, value)}"
            )
    if result["designs"]:
        lines += ["", f"{'reference design':34s}" + "".join(f"{name:>18s}" for name in result["designs"])]
        for name in best["objectives"]:
            cells = [_cell(entry["objectives"][name], 18) for entry in result["designs"].values()]
            lines.append(f"{label(study, name):34s}{''.join(cells)}")
    if result["front"]:
        lines += ["", f"the front has {len(result['front'])} designs"]
    if not best["feasible"]:
        lines += ["", "no design satisfies all constraints; this one violates them least"]
    return "\n".join(lines)


def _cell(value: float | None, width: int) -> str:
    return f"{'-':>{width}s}" if value is None else f"{value:{width}.5g}"


def _change(before: float | None, after: float | None) -> str:
    if before is None or after is None or before == 0.0:
        return f"{'-':>13s}"
    return f"{100.0 * (after - before) / abs(before):+12.1f}%"
