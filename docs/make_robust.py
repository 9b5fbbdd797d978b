"""Writes the table of the robust design in docs/optimisation.md: ``python docs/make_robust.py``, some minutes.

Solves the press's force problem at its one operating point and in the worst case over wear and temperature, and
evaluates each answer in both.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from optim import Evaluator, find_study, load_study, optimise

PAGE = Path(__file__).with_name("optimisation.md")
MARK = "| design | force, one point [N] | force, worst case [N] | least film, worst case [um] |\n|---|---|---|---|\n"


def table() -> str:
    """Rows of the table."""
    one, worst = (load_study(find_study(name)) for name in ("sevenbar_force", "sevenbar_robust"))
    assert one.paths == worst.paths
    best = [np.array([*optimise(study)["best"]["variables"].values()]) for study in (one, worst)]
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
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(MARK)
    after = "\n" + rest.partition("\n\n")[2] if rest.startswith("|") else rest
    PAGE.write_text(head + MARK + table() + after, encoding="utf-8")
