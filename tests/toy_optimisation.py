"""A small optimisation with an analytic objective: a task that tests kill, resume, and send to workers.

Run as a script: ``python toy_optimisation.py STORE RESULT POPULATION AT`` solves it, resuming STORE, and writes RESULT;
it kills itself at a call of a function, counted from the evaluation of a population, and prints the number of calls.
"""

import json
import signal
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import strikes

from optim import Evaluations, Stopped
from optim.algorithms import nlp
from optim.search.recorder import recording

GENERATIONS, POPULATION = 30, 6
NOMINAL = np.array([-1.2, 1.0]) / 2.0


def worth(design):
    """Rosenbrock's function; there is no value in a corner of the box."""
    x, y = map(float, design)
    if x + y > 3.0:
        return float("nan"), float("nan"), "no-assembly", f"x + y = {x + y:.3f}"
    return (1.0 - x) ** 2 + 100.0 * (y - x * x) ** 2, x * x + y * y, "ok", ""


def evaluate(designs):
    f, g, status, reason = zip(*map(worth, designs), strict=True)
    return Evaluations(np.array(f)[:, None], np.array(g)[:, None], status, reason)


def values(found, nominal):
    """Rosenbrock's function over its nominal value, in a disc of radius sqrt(2)."""
    failed = found.failed
    f = np.where(failed[:, None], np.inf, found.objectives / nominal.objectives)
    g = np.where(failed[:, None], np.inf, found.constraints - 2.0)
    return nlp.Values(f, g, np.empty((len(found), 0)), failed)


def problem_of(evaluate, nominal):
    return nlp.Problem(
        np.array([-2.0, -2.0]), np.array([2.0, 2.0]), lambda designs: values(evaluate(designs), nominal),
        ("valley",), ("radius.at_most",), (), NOMINAL,
    )  # fmt: skip


def evolve(problem, seed, progress, generations=GENERATIONS):
    """Mutate the best design so far: deterministic for a seed, and its state is the generator's."""
    rng = np.random.default_rng(seed)
    best = problem.start
    kept = problem.evaluate(best[None])
    for k in range(1, generations + 1):
        scatter = (problem.upper - problem.lower) * 0.3 / k
        designs = np.clip(
            best + scatter * rng.standard_normal((POPULATION, problem.size)), problem.lower, problem.upper
        )
        found = problem.evaluate(designs)
        i = int(np.argmin(np.where(found.violation > 0.0, np.inf, found.objectives[:, 0])))
        if found.violation[i] == 0.0 and found.objectives[i, 0] < kept.objectives[0, 0]:
            best, kept = designs[i], problem.evaluate(designs[i][None])
        progress(nlp.Progress(k, generations, best[None], kept, {"generator": rng.bit_generator.state}))
    return nlp.Result(best[None], kept, "budget-used", generations, generations * POPULATION)


def make_task(seed=1, evaluate=evaluate, generations=GENERATIONS, **changed):
    arguments = {
        "task": {"algorithm": {"name": "evolve"}, "seed": seed, "problem": {"name": "Rosenbrock"}},
        "versions": {"numpy": np.__version__},
        "variables": ("x", "y"),
        "objectives": ("valley",),
        "constraints": ("radius",),
        "evaluate": evaluate,
        "minimise": lambda problem, progress: evolve(problem, seed, progress, generations),
    }
    return arguments | changed


def run(task, path, resume=False, observe=lambda row: None, stop=lambda: False):
    """Solve a task through a store, as `optim.optimise` solves a study."""
    identity = dict(task)
    evaluate, minimise = identity.pop("evaluate"), identity.pop("minimise")

    def observed(row):
        observe(row)
        if stop():
            raise Stopped(row.iteration)

    with recording(path, identity, evaluate, resume) as recorder:
        nominal = recorder.evaluate(NOMINAL[None])
        result = recorder.minimise(problem_of(recorder.evaluate, nominal), minimise, observed)
        found = recorder.evaluate(np.atleast_2d(result.x))
        count, failures = recorder.store.count()
        return SimpleNamespace(result=result, found=found, evaluations=count, failures=failures)


def main(store, result, population, at):
    strike, left = strikes.Strike(int(at), signal.SIGKILL), [int(population)]

    def counted(designs):
        left[0] -= 1
        if left[0] == 0:
            strikes.at_calls(strike)
        return evaluate(designs)

    outcome = run(make_task(evaluate=counted), Path(store), resume=True)
    sys.setprofile(None)
    print(f"calls: {strike.calls}")
    found = {
        "x": outcome.result.x.tolist(),
        "objectives": outcome.found.objectives.tolist(),
        "evaluations": outcome.evaluations,
        "failures": outcome.failures,
        "iterations": outcome.result.iterations,
    }
    Path(result).write_text(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
