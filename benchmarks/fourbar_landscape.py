"""Landscape of the patent's design problem: ``python benchmarks/fourbar_landscape.py [PART...]``, half an hour.

Compares its objective with the steady one, and finds the effect of the lost bounds and how well the ideal force
predicts the jitter. Writes the results into docs/replication/computed/, and the figure; `docs/make_replication.py`
shows them. Results are measured again only if named: rank, surrogate, bounds, line, nearby.
"""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from fourbar_methods import score, solve
from matplotlib.figure import Figure
from replication.computed import keep, read
from replication.patent_searches import BESIDE, OBJECTIVES, POINTS, REVOLUTIONS, STARTS
from replication.recorded import load_record
from scipy.stats import qmc, spearmanr

from optim import Evaluator, Screened, find_study, load_study, minimise, problem_of
from optim.search.task import settings_of

FIGURE = Path(__file__).parents[1] / "docs" / "figures" / "fourbar_way.png"
RESULTS = "fourbar_landscape"
STUDIES = tuple(objective.study for objective in OBJECTIVES)
BOUNDS = ((0.8, 1.25), (0.5, 2.0), (1.0 / 3.0, 3.0), (0.25, 4.0))
DESIGNS = 24


def bounds() -> list[dict[str, Any]]:
    """Solve the patent's problem by differential evolution within several bounds."""
    study = load_study(find_study("fourbar_jitter"))
    found = []
    for low, high in BOUNDS:
        other = dataclasses.replace(study, lower=low * study.nominal, upper=high * study.nominal)
        result = solve(other, "differential-evolution", 1, OBJECTIVES[0].budget)
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
    draw(data)
