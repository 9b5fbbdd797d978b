"""Searches for the patent's design problem, for the appendix: methods with equal budgets, and the landscape of the objectives.

``python benchmarks/fourbar_methods.py`` and ``python benchmarks/fourbar_landscape.py`` compute the numbers.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from replication.claims import table
from replication.computed import read


class Objective(NamedTuple):
    """A study, its objective, the number of designs of a method, and the step of its differences."""

    study: str
    meaning: str
    budget: int
    step: float


OBJECTIVES = (
    Objective("fourbar_jitter", "the patent's: peak of two revolutions, one start", 400, 1e-5),
    Objective("fourbar_jitter_phases", "the same, mean over four starts", 250, 1e-5),
    Objective("fourbar_jitter_steady", "steady: ten revolutions after the second, four starts", 40, 0.02),
)
HEADINGS = ("reduction", "at unseen starts", "ground, crank, coupler, follower")
#: Designs on the way from the nominal design to the recorded one.
POINTS = {"fourbar_jitter": 81, "fourbar_jitter_steady": 21}
#: Neighbouring starts, and the part by which their lengths differ.
STARTS, BESIDE = 5, 1e-7
#: Revolutions of the steady jitter that the surrogate is compared with.
REVOLUTIONS = 3


def methods() -> str:
    """Write the comparison of methods: a row for each method and seed, two columns for each objective."""
    found: dict[str, dict[str, Any]] = read("fourbar_methods")
    text, heads, rows = "", ["method", "seed"], {}
    for objective in OBJECTIVES:
        text += f"- `{objective.study}`: {objective.meaning}; {objective.budget} designs, step of differences"
        text += f" {objective.step:g} of the bounds\n"
        heads += [objective.study, "unseen"]
        for key, row in found.items():
            study, method, seed = key.split("/")
            if study == objective.study:
                rows.setdefault((method, seed), {})[study] = cells(row, ())[:2]
    lines = [
        [*key, *(cell for objective in OBJECTIVES for cell in row.get(objective.study, ("", "")))]
        for key, row in rows.items()
    ]
    apart = max(abs(1.0 - row["value"] - row["tighter"]) for row in found.values())
    return f"""Reductions by five methods with equal budgets (`python benchmarks/fourbar_methods.py`), and *unseen*: at ten start angles that were not searched. The rows
`ga` are from revision 1 of the genetic algorithm, before it took over the operators of pygad.

{text}
A tenth of the tolerance changes no reduction by more than {100.0 * apart:.1g} %.

{table(heads, lines)}"""


def cells(row: dict[str, Any], lengths: Iterable[float]) -> list[str]:
    """Write results below `HEADINGS`."""
    scores = (f"{100 * x:.1f} %" for x in (1.0 - row["value"], row["unseen"]))
    return [*scores, ", ".join(f"{x:.2f}" for x in lengths)]


def minima(values: list[float]) -> int:
    """Count local minima inside."""
    v = np.array(values)
    return int(np.sum((v[1:-1] < v[:-2]) & (v[1:-1] < v[2:])))


def landscape() -> str:
    """Write the shape of the objectives, and the influence of the start and of the lost bounds."""
    found = read("fourbar_landscape")
    many, few = POINTS.values()
    every = (many - 1) // (few - 1)
    values, means = (found["line"][name]["value"] for name in POINTS)
    first, coarse, steady = minima(values), minima(values[::every]), minima(means)
    reductions = [100.0 * part for part in found["nearby"]]
    others = ", ".join(f"{part:.1f}" for part in sorted(reductions[1:]))
    rows = [[f"{row['low']:.3g} to {row['high']:.3g}", *cells(row, row["lengths"])] for row in found["bounds"]]
    part, order = found["surrogate"], found["rank"]
    lengths = ", ".join(f"{x:.2f}" for x in part["lengths"])
    scores = ", ".join(f"`{one.study}` by {100 * part[one.study]:.1f} %" for one in OBJECTIVES)
    return f"""![Both objectives on the straight line from the nominal design to the recorded one](figures/fourbar_way.png)

*Two objectives from the nominal design to the recorded one (`docs/replication/designs/fourbar_jitter.toml`; `python benchmarks/fourbar_landscape.py`).*

- The patent's objective, the largest [jitter](glossary.md#jitter) in two revolutions from one start, has {first} local minima at {many} points ({coarse} at every {every}th point). It is one
  impact after a flight across the clearance. It changes smoothly with the lengths, so gradients are useful, except at jumps: there another impact becomes the largest, or a
  flight ends at another place. The steady objective, a mean over forty revolutions, has {steady} local minimum at {few} points.
- **Start.** The shipped study reduces the objective by {reductions[0]:.1f} % from the nominal design. {STARTS} starts whose lengths differ by {BESIDE:g} of themselves give {others} %: a step of the
  line search just meets, or just misses, a jump. Use several starts (`starts = 10` in `[algorithm]`).
- **Substitute without contacts.** `fourbar_surrogate` minimises the largest rate at which the force in the clearance joint changes its direction, in the linkage *without* clearance: a journal loses
  contact where the direction changes fast. Over {order["designs"]} random designs the rank correlation (Spearman) with the steady jitter ({REVOLUTIONS} revolutions, one start) is {order["rank"]:.2f}. Its optimum, {lengths}
  of the nominal lengths, reduces {scores}.
- **Lost bounds.** Differential evolution, seed 1, {OBJECTIVES[0].budget} designs. The printed 77.5 % depends on the bounds as much as on the method: a longer, heavier follower turns less under an impact.

{table(("bounds, of the nominal lengths", *HEADINGS), rows)}"""
