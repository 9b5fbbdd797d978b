"""Landscape of the patent's design problem: ``python benchmarks/fourbar_landscape.py [PART...]``, half an hour.

Compares its objective with the steady one, and finds the effect of the lost bounds and how well the ideal force
predicts the jitter. Writes docs/fourbar_landscape.md and its figure. Results are in docs/replication/computed/,
and are measured again only if named: rank, surrogate, bounds, line, nearby.
"""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from fourbar_methods import HEADINGS, cells, score, solve
from matplotlib.figure import Figure
from replication.claims import table
from replication.computed import keep, read
from replication.recorded import load_record
from scipy.stats import qmc, spearmanr

from optim import Evaluator, Screened, find_study, load_study, minimise, problem_of
from optim.search.optimise import settings_of

DOCS = Path(__file__).parents[1] / "docs"
PAGE, FIGURE = DOCS / "fourbar_landscape.md", DOCS / "figures" / "fourbar_way.png"
RESULTS = "fourbar_landscape"
STUDIES = ("fourbar_jitter", "fourbar_jitter_phases", "fourbar_jitter_steady")
BOUNDS = ((0.8, 1.25), (0.5, 2.0), (1.0 / 3.0, 3.0), (0.25, 4.0))
BUDGET = 400
POINTS = {"fourbar_jitter": 81, "fourbar_jitter_steady": 21}
DESIGNS, REVOLUTIONS = 24, 3
BESIDE, STARTS = 1e-7, 5


def bounds() -> list[dict[str, Any]]:
    """Solve the patent's problem by differential evolution within several bounds."""
    study = load_study(find_study("fourbar_jitter"))
    found = []
    for low, high in BOUNDS:
        other = dataclasses.replace(study, lower=low * study.nominal, upper=high * study.nominal)
        result = solve(other, "differential-evolution", 1, BUDGET)
        found.append({"low": low, "high": high, **result, "lengths": (result["x"] / study.nominal).tolist()})
    for row, *scores in zip(found, *score(study, np.array([row["x"] for row in found])), strict=True):
        row["unseen"], row["tighter"] = map(float, scores)
    return found


def nearby() -> list[float]:
    """Reductions by the shipped study from its nominal design, and from neighbouring starts."""
    study = load_study(find_study("fourbar_jitter"))
    algorithm, settings = settings_of(study)
    evaluate = Screened(study, Evaluator(study), settings.step)
    nominal = evaluate(study.nominal[None])
    offsets = BESIDE * np.random.default_rng(1).standard_normal((STARTS, study.nominal.size))
    found = []
    for offset in (np.zeros_like(study.nominal), *offsets):
        problem = problem_of(study, evaluate, nominal, study.nominal * (1.0 + offset))
        result = minimise(algorithm, problem, settings, study.file.seed)
        found.append(1.0 - float(result.values.objectives[0, 0]))
    return found


def line() -> dict[str, Any]:
    """Evaluate objectives on the way from the nominal design (0) to the recorded one (1), relative to the nominal's."""
    found = {}
    for name, count in POINTS.items():
        study = load_study(find_study(name))
        way = np.linspace(0.0, 1.0, count)
        end = load_record("fourbar_jitter").design(study)
        designs = study.nominal + way[:, None] * (end - study.nominal)
        values = Evaluator(study)(designs).objectives[:, 0]
        found[name] = {"way": way.tolist(), "value": (values / values[0]).tolist()}
    return found


def surrogate() -> dict[str, Any]:
    """Solve the shipped surrogate, and evaluate its solution by the objectives that it replaces."""
    study = load_study(find_study("fourbar_surrogate"))
    algorithm, settings = settings_of(study)
    problem = problem_of(study, Screened(study, Evaluator(study)))
    x = minimise(algorithm, problem, settings, study.file.seed).x[0]
    found: dict[str, Any] = {"x": x.tolist(), "lengths": (x / study.nominal).tolist()}
    for name in STUDIES:
        other = load_study(find_study(name))
        before, after = Evaluator(other)(np.array([other.nominal, x])).objectives[:, 0]
        found[name] = 1.0 - after / before
    return found


def rank() -> dict[str, Any]:
    """Compare the order of designs by the surrogate and by the steady jitter, of a shorter run from one start."""
    cheap, steady = load_study(find_study("fourbar_surrogate")), load_study(find_study(STUDIES[2]))
    point = steady.points[0]
    windows = {**point.windows, "steady": point.windows["steady"][:REVOLUTIONS]}
    short = point.system.replaced({"duration": float(windows["steady"][-1, 1])})
    steady = dataclasses.replace(steady, points=(dataclasses.replace(point, system=short, windows=windows),))
    sample = qmc.LatinHypercube(4, rng=np.random.default_rng(1)).random(1000)
    designs = cheap.lower + sample * (cheap.upper - cheap.lower)
    turning = Screened(cheap, Evaluator(cheap))(designs).objectives[:, 0]
    good = np.flatnonzero(np.isfinite(turning))[:DESIGNS]
    jitter = Evaluator(steady)(designs[good]).objectives[:, 0]
    return {"designs": len(good), "rank": float(spearmanr(turning[good], jitter).statistic)}


PARTS = (rank, surrogate, bounds, line, nearby)


def minima(values: list[float]) -> int:
    """Count local minima inside."""
    v = np.array(values)
    return int(np.sum((v[1:-1] < v[:-2]) & (v[1:-1] < v[2:])))


def page(found: dict[str, Any]) -> str:
    """Write the page."""
    many, few = POINTS.values()
    every = (many - 1) // (few - 1)
    values, means = (found["line"][name]["value"] for name in POINTS)
    first, coarse, steady = minima(values), minima(values[::every]), minima(means)
    reductions = [100.0 * part for part in found["nearby"]]
    others = ", ".join(f"{part:.1f}" for part in sorted(reductions[1:]))
    rows = [[f"{row['low']:.3g} to {row['high']:.3g}", *cells(row, row["lengths"])] for row in found["bounds"]]
    part, order = found["surrogate"], found["rank"]
    lengths = ", ".join(f"{x:.2f}" for x in part["lengths"])
    scores = [f"{100 * part[name]:.1f} %" for name in STUDIES]
    return f"""# Landscape of the patent's design problem

For readers of [the comparison of methods](fourbar_methods.md): the shape of its objectives, and the influence of the
start and of the lost bounds.
`python benchmarks/fourbar_landscape.py` writes this page from its stored results.

## Two objectives along one line

![Both objectives on the straight line from the nominal design to the recorded one](figures/fourbar_way.png)

On the straight line from the nominal design to the recorded one (`docs/replication/designs/fourbar_jitter.toml`):

- The patent's objective, the largest [jitter](glossary.md#jitter) in two revolutions from one start, has {first}
  local minima at {many} points ({coarse} at every {every}th point). It is one [impact](glossary.md#impact) after a
  flight across the clearance. It changes smoothly with the lengths, so gradients are useful, except at jumps: there
  another impact becomes the largest, or a flight ends at another place.
- The steady objective, a mean over forty revolutions, has {steady} local minimum at {few} points. It depends on many
  impacts, each influenced by those before.

## Influence of the start

The shipped study reduces the objective by {reductions[0]:.1f} % from the nominal design. {STARTS} starts whose
lengths differ by {BESIDE:g} of themselves give {others} %: a step of the line search just meets, or just misses, a
jump. Use several starts (`starts = 10` in `[algorithm]`).

## Influence of the lost bounds

The patent's ranges of the lengths are lost with its table 1. Differential evolution, seed 1, {BUDGET} designs:

{table(("bounds, of the nominal lengths", *HEADINGS), rows)}
The printed 77.5 % depends on the bounds as much as on the method: a longer, heavier follower turns less under an
impact. Within the widest bounds this number of designs is too small to find the result of the third row.

## A substitute without contacts

`fourbar_surrogate` minimises the largest rate at which the force in the clearance joint changes its direction, in
the linkage *without* clearance. The force presses the journal against the wall; the journal loses contact where the
direction changes fast. Over {order["designs"]} random designs the rank correlation (Spearman) with the steady jitter
({REVOLUTIONS} revolutions, one start) is {order["rank"]:.2f}. Its optimum has {lengths} of the nominal lengths,
needs no run, and reduces

- the patent's objective by {scores[0]},
- its mean over four starts by {scores[1]},
- the steady objective by {scores[2]}.
"""


def draw(found: dict[str, Any]) -> None:
    """Draw the objectives on the way."""
    looks = {
        "fourbar_jitter": ("patent's: one start, two revolutions", "#D55E00", "-"),
        "fourbar_jitter_steady": ("steady: four starts, ten revolutions each", "#0072B2", "--"),
    }
    with mpl.rc_context({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 150}):
        figure = Figure(figsize=(6.0, 3.4), layout="constrained")
        ax = figure.subplots()
        for name, (label, colour, style) in looks.items():
            part = found["line"][name]
            ax.plot(part["way"], part["value"], style, marker=".", color=colour, label=label)
        ax.set(
            xlabel="position between the nominal design (0) and the recorded one (1)",
            ylabel="objective, of the nominal design's", ylim=(0.0, None),
        )  # fmt: skip
        ax.legend(frameon=False)
        figure.savefig(FIGURE, format="png")


if __name__ == "__main__":
    data = read(RESULTS)
    for compute in PARTS:
        if (key := compute.__name__) not in data or key in sys.argv[1:]:
            data[key] = compute()
            keep(RESULTS, data)
            print(f"{key}: {data[key]}", flush=True)
    PAGE.write_text(page(data), encoding="utf-8")
    draw(data)
