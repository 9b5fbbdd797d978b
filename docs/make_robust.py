"""Writes the table of the robust design in docs/check_optimum.md: ``python docs/make_robust.py``.

Evaluates the recorded answers to the press's force problem, at its one operating point and in the worst case over wear and
temperature (``python docs/make_designs.py sevenbar_force sevenbar_robust`` searches for them), each in both.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from replication.recorded import load_record

from optim import Evaluator, find_study, load_study

PAGE = Path(__file__).with_name("check_optimum.md")
MARK = "| design | force, one point [N] | force, worst case [N] | least film, worst case [um] |\n|---|---|---|---|\n"


def page(text: str) -> str:
    """Return the page with its table written anew."""
    head, rest = text.split(MARK)
    return head + MARK + _rows() + "\n" + rest.partition("\n\n")[2]


def _rows() -> str:
    one, worst = (load_study(find_study(name)) for name in ("sevenbar_force", "sevenbar_robust"))
    assert one.paths == worst.paths
    best = [load_record(study.source.stem).design(study) for study in (one, worst)]
    paper = load_study(find_study("sevenbar_pareto")).designs["paper's design 2"]
    designs = {
        "nominal": one.nominal,
        "the paper's design 2 (Table 6)": paper,
        "best at one point (`sevenbar_force`)": best[0],
        "best in the worst case (`sevenbar_robust`)": best[1],
    }
    at_one, at_worst = (Evaluator(study)(np.array([*designs.values()])) for study in (one, worst))
    columns = at_one.objectives[:, 0], at_worst.objectives[:, 0], 1e6 * at_worst.constraints[:, 0]
    rows = zip(designs, *columns, strict=True)
    return "".join(f"| {name} | {single:.3f} | {most:.3f} | {film:.1f} |\n" for name, single, most, film in rows)


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
