"""Methods on the patent's design problem: ``python benchmarks/fourbar_methods.py [--anew]`` (two hours).

Every method solves `fourbar_jitter` with three objectives, each within the same number of evaluations.
The optima are scored again where they were not searched: ten other start angles, and the search's own at a ten times
tighter tolerance. Writes the results into docs/replication/computed/ and the best design by the patent's objective into
docs/replication/designs/; `docs/make_replication.py` shows them. Stored runs are repeated only with the option.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from typing import Any

import numpy as np
from replication.computed import keep, read
from replication.patent_designs import UNSEEN, started_at
from replication.patent_searches import OBJECTIVES
from replication.recorded import write_record

from optim import Evaluations, Evaluator, Progress, Screened, Study, find_study, load_study, minimise, problem_of
from optim.algorithms.registry import read_settings

RESULTS = "fourbar_methods"
TIGHTER = 0.1
SEEDS = (1, 2)
ALONE = "grg, one start"
#: Starts and generations are more than the budget allows.
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    ALONE: ("grg", {}),
    "grg": ("grg", {"starts": 100, "iterations": 8}),
    "snopt": ("snopt", {"starts": 100, "iterations": 8}),
    "ga": ("ga", {"population": 12, "elites": 12, "generations": 100}),
    "differential-evolution": ("differential-evolution", {"population": 12, "generations": 100}),
}


def settings(method: str, step: float) -> tuple[str, dict[str, Any]]:
    """Name of a method's algorithm, and its settings."""
    name, given = METHODS[method]
    return name, given | ({"step": step} if name in ("grg", "snopt") else {})


def solve(study: Study, method: str, seed: int, budget: int, step: float = 0.0) -> dict:
    """Search until the budget of evaluations is used (the iteration in which that happens is finished)."""
    spent, run = 0, Evaluator(study)
    name, given = settings(method, step)

    def counted(designs: np.ndarray) -> Evaluations:
        nonlocal spent
        spent += len(designs)
        return run(designs)

    problem = problem_of(study, Screened(study, counted, given.get("step")))

    def stop(_: Progress) -> None:
        if spent >= budget:
            raise KeyboardInterrupt

    began = time.perf_counter()
    result = minimise(name, problem, given, seed, stop)
    return {
        "x": result.x[0].tolist(),
        "value": float(result.values.objectives[0, 0]),
        "feasible": bool(result.values.feasible(1e-6)[0]),
        "evaluations": spent,
        "seconds": time.perf_counter() - began,
    }


def score(study: Study, designs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reductions of the mean over the unseen start angles, and at the tighter tolerance; (m,) each."""
    everything = np.vstack([study.nominal, designs])

    def reductions(*variants: Study) -> np.ndarray:
        means = np.mean([Evaluator(variant)(everything).objectives[:, 0] for variant in variants], axis=0)
        return 1.0 - means[1:] / means[0]

    alone = dataclasses.replace(study, points=study.points[:1])
    tight = study.replaced(lambda system: {"solver.accuracy": TIGHTER * system.experiment.solver.accuracy})
    return reductions(*(started_at(alone, angle) for angle in UNSEEN)), reductions(tight)


def measure(found: dict[str, dict]) -> None:
    """Make the missing runs, then score all results; by "study/method/seed"."""
    for objective in OBJECTIVES:
        study = load_study(find_study(objective.study))
        keys = []
        for seed in SEEDS:
            for method in METHODS:
                if method == ALONE and (seed != SEEDS[0] or objective is not OBJECTIVES[0]):
                    continue  # it draws no random numbers
                key = f"{objective.study}/{method}/{seed}"
                keys.append(key)
                if key not in found:
                    found[key] = solve(study, method, seed, objective.budget, objective.step)
                    keep(RESULTS, found)
                    print(f"{key}: {found[key]}", flush=True)
        if any("unseen" not in found[key] for key in keys):
            unseen, tighter = score(study, np.array([found[key]["x"] for key in keys]))
            for key, *scores in zip(keys, unseen, tighter, strict=True):
                found[key] |= dict(zip(("unseen", "tighter"), map(float, scores), strict=True))
            keep(RESULTS, found)
            if objective is OBJECTIVES[0]:
                record(study, found, keys)


def record(study: Study, found: dict[str, dict], keys: list[str]) -> None:
    """Keep the best design that was found."""
    key = min((key for key in keys if found[key]["feasible"]), key=lambda key: found[key]["value"])
    _, method, seed = key.split("/")
    name, given = settings(method, OBJECTIVES[0].step)
    best = found[key]
    result = {
        "best": {
            "variables": dict(zip(study.paths, best["x"], strict=True)),
            "objectives": dict.fromkeys(study.file.objectives, best["value"]),
        },
        "algorithm": {"name": name, **read_settings(name, given).model_dump(mode="json")},
        "seed": int(seed),
        "evaluations": best["evaluations"],
    }
    write_record(study, result, "python benchmarks/fourbar_methods.py")


if __name__ == "__main__":
    measure({} if "--anew" in sys.argv else read(RESULTS))
