"""Costs of an optimisation: ``python benchmarks/optimisation.py [engine] [store] [cluster]``, default all.

engine: evaluations per second of the press against threads, and as a ratio to one thread; the best of three rounds;
store: microseconds that the store adds to an evaluation, populations of 30, against the same without a store;
cluster: microseconds that Dask adds to an evaluation, two worker processes on this computer, by designs per request.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from optim import Ending, Evaluations, Evaluator, Problem, Progress, Result, Values, find_study, load_study
from optim.search.recorder import recording

POPULATION = 30


def engine() -> None:
    """Print evaluations per second against threads."""
    study = load_study(find_study("sevenbar_force"))
    rng = np.random.default_rng(0)
    designs = rng.uniform(study.lower, study.upper, (4 * POPULATION, len(study.names)))
    Evaluator(study)(designs[:2])  # compiles
    counts = range(1, (os.cpu_count() or 1) + 1)
    rates = dict.fromkeys(counts, 0.0)
    for _ in range(3):  # rounds alternate, so that what else the machine does meets all alike
        for threads in counts:
            start = time.perf_counter()
            Evaluator(study, threads=threads)(designs)
            rates[threads] = max(rates[threads], len(designs) / (time.perf_counter() - start))
    print("engine: sevenbar_force\n threads   evaluations/s   ratio")
    for threads, rate in rates.items():
        print(f"{threads:8d}{rate:16.1f}{rate / rates[1]:8.2f}")


def sphere(designs: np.ndarray) -> Evaluations:
    """Evaluate in no time."""
    m = len(designs)
    return Evaluations((designs**2).sum(axis=1)[:, None], np.empty((m, 0)), ("ok",) * m, ("",) * m)


def walk(problem: Problem, progress, generations: int = 200) -> Result:
    """Ask for random populations."""
    rng = np.random.default_rng(0)
    for k in range(1, generations + 1):
        designs = rng.uniform(problem.lower, problem.upper, (POPULATION, problem.size))
        found = problem.evaluate(designs)
        progress(Progress(k, generations, designs[:1], found.take([0]), {"state": rng.bit_generator.state}))
    return Result(designs[:1], found.take([0]), Ending.BUDGET_USED, generations, generations * POPULATION)


def store() -> None:
    """Print the additional time of the store per evaluation."""
    n = 6
    identity = {"task": {}, "versions": {}, "objectives": ("f",), "constraints": ()}
    identity["variables"] = tuple(f"x{k}" for k in range(n))

    def problem(evaluate: Callable[[np.ndarray], Evaluations]) -> Problem:
        def all_feasible(designs: np.ndarray) -> Values:
            found, nothing = evaluate(designs), np.empty((len(designs), 0))
            return Values(found.objectives, nothing, nothing, found.failed)

        return Problem(-np.ones(n), np.ones(n), all_feasible)

    def stored(path: Path) -> float:
        start = time.perf_counter()
        with recording(path, identity, sphere, resume=True) as recorder:
            recorder.minimise(problem(recorder.evaluate), walk, lambda row: None)
        return time.perf_counter() - start

    start = time.perf_counter()
    count = walk(problem(sphere), lambda progress: None).evaluations
    bare = time.perf_counter() - start
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.sqlite"
        first, again = stored(path), stored(path)
        size = path.stat().st_size
    print("store: us per evaluation (bytes on disk)")
    print(f"  without {1e6 * bare / count:8.1f}\n  first   {1e6 * first / count:8.1f} ({size / count:.0f})")
    print(f"  replay  {1e6 * again / count:8.1f}")


def answer(designs: np.ndarray) -> list[float]:
    """Do next to nothing on a worker."""
    return [float(design[0]) for design in designs]


def cluster() -> None:
    """Print what Dask adds to an evaluation."""
    from distributed import Client, LocalCluster

    designs = np.random.default_rng(0).uniform(size=(20 * POPULATION, 6))
    print("cluster: us per evaluation")
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as local, Client(local) as client:
        executor = client.get_executor()
        list(executor.map(answer, [designs[:1], designs[1:2]]))
        for size in (1, 5, 15):
            start = time.perf_counter()
            for k in range(0, len(designs), POPULATION):
                population = designs[k : k + POPULATION]
                list(executor.map(answer, [population[i : i + size] for i in range(0, POPULATION, size)]))
            wall = time.perf_counter() - start
            print(f"  requests of {size:2d} {1e6 * wall / len(designs):8.1f}")


if __name__ == "__main__":
    for part in sys.argv[1:] or ("engine", "store", "cluster"):
        {"engine": engine, "store": store, "cluster": cluster}[part]()
