"""``result.json``, and what it holds as a table for the terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from linkages.files.writing import whole
from optim.problem.study import Study


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file, whole or not at all."""
    with whole(path) as partial:
        partial.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def format_result(study: Study, result: dict[str, Any]) -> str:
    """Format a result as lines of text: nominal design beside the best one.

    Parameters
    ----------
    study : Study
    result : dict
        Content of ``result.json``, from `optim.optimise`.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> result = optim.optimise(study, algorithm={"name": "ga", "population": 4, "generations": 1})
    >>> optim.format_result(study, result).splitlines()[0]
    'Seven-bar press: least joint forces'
    """
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
                f"{study.label(name):34s}{_cell(before, 13)}{_cell(value, 18)}{_change(before, value)}"
            )
    if result["designs"]:
        lines += ["", f"{'reference design':34s}" + "".join(f"{name:>18s}" for name in result["designs"])]
        for name in best["objectives"]:
            cells = [_cell(entry["objectives"][name], 18) for entry in result["designs"].values()]
            lines.append(f"{study.label(name):34s}{''.join(cells)}")
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
