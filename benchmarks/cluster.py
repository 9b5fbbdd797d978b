"""Measure studies of tolerances on two workers: ``python benchmarks/cluster.py [--press N] [--dry N] [--rounds K]``.

A scheduler and two workers of one thread each run on this machine. Each round runs the same machines on one local
thread and then on the workers; small studies come first, so that all processes have loaded compiled code. Where all
rounds would take longer than ``--minutes``, they have fewer machines. Results must be equal to the last bit.

Parallelism is the time of all runs on the workers over the time of the study: it counts where the machine has other
work too, the ratio of the two times does not. Besides runs: processor time of client, scheduler and workers over that
of the local thread, minus 1.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, NamedTuple

import psutil
import tolerances as texts

import optim
from linkages.engines.cluster import cluster
from optim.evaluate import evaluator, remote

WARM = {"press": 1024, "dry": 64}  # machines of the small studies
SETTINGS = {
    "OPENBLAS_NUM_THREADS": "1",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "false",
}  # docs/million_machines.md
BOTH = 1.6  # time of a round, in times of its local thread
REQUESTS = 4  # as `linkages tolerances`
PRESS = texts.PRESS.replace("start = 1.0\nend = 2.0", "start = 0.0\nend = 0.1").replace(
    "[scatter.fit]", "[set]\nduration = 0.1\n[scatter.fit]"
)
TEXTS = {"press": PRESS, "dry": texts.DRY}


class Timed(remote.Dispatcher):
    """Adds up the time of all runs."""

    seconds = 0.0

    def receive(self, sent):
        """Wait for the answers."""
        for point in sent:
            Timed.seconds += sum(future.result().seconds for future in point)
        return super().receive(sent)


class Round(NamedTuple):
    """Numbers of a round."""

    alone: float  # time on one local thread [s]
    together: float  # on two workers [s]
    runs: float  # time of all runs on the workers [s]
    local: float  # processor time of the local thread [s]
    all: float  # of client, scheduler and workers [s]
    same: bool  # results, to the last bit

    def __str__(self) -> str:
        ratio, parallel, besides = self.together / self.alone, self.runs / self.together, self.all / self.local - 1.0
        times = f"{self.alone:.1f} s on one thread, {self.together:.1f} s on two workers"
        return f"{times}: ratio {ratio:.3f}, parallelism {parallel:.3f}, besides runs {besides:+.1%}"


def run(file: Path, samples: int, **settings: Any) -> tuple[str, float]:
    """Run the machines of a study; result and time [s]."""
    study = optim.load_study(file)
    began = time.perf_counter()
    result = optim.tolerances(study, samples=samples, evaluator=optim.Evaluator(study, threads=1, **settings))
    return result.model_dump_json(), time.perf_counter() - began


def processes(file: Path) -> list[psutil.Popen]:
    """Start a scheduler and two workers."""
    environment = os.environ | SETTINGS
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment}
    common = ["--no-dashboard", "--scheduler-file", str(file)]
    scheduler = ["distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", *common]
    worker = ["distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", *common]
    return [psutil.Popen([sys.executable, "-m", *words], **quiet) for words in (scheduler, worker, worker)]


def used(processes: list[psutil.Process]) -> float:
    """Add up processor times [s]."""
    return sum(sum(process.cpu_times()[:2]) for process in processes)


class Bench:
    """A client of two workers, and the files of the studies."""

    def __init__(self, folder: Path, started: list[psutil.Process], executor: Executor, count: Callable[[], int]):
        self.folder, self.executor, self.count = folder, executor, count
        self.processes = [psutil.Process(), *started]

    def round(self, kind: str, samples: int) -> Round:
        """Run the machines of a study here and there."""
        file, client = self.folder / f"{kind}.toml", self.processes[:1]
        before, Timed.seconds = used(client), 0.0
        here, alone = run(file, samples)
        local, before = used(client) - before, used(self.processes)
        there, together = run(file, samples, executor=self.executor, parts=lambda: REQUESTS * self.count())
        return Round(alone, together, Timed.seconds, local, used(self.processes) - before, here == there)

    def warm(self) -> dict[str, float]:
        """Run small studies twice; the time of a machine, by study [s]."""
        return {kind: [self.round(kind, n).alone / n for _ in range(2)][1] for kind, n in WARM.items()}


def main() -> None:
    """Print all numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--press", type=int, default=100_000, help="machines of the press")
    parser.add_argument("--dry", type=int, default=5_000, help="machines of the dry slider-crank")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--minutes", type=float, default=5.0, help="for all rounds")
    options = parser.parse_args()
    evaluator.Dispatcher = Timed
    with tempfile.TemporaryDirectory() as name:
        folder, address = Path(name), Path(name) / "scheduler.json"
        for kind, text in TEXTS.items():
            (folder / f"{kind}.toml").write_text(text)
        started = processes(address)
        try:
            with cluster(str(address), "repeat") as (executor, count):
                while count() < 2:
                    time.sleep(0.1)
                measure(Bench(folder, started, executor, count), options)
        finally:
            for process in started:
                process.kill()
                process.wait()


def measure(bench: Bench, options: argparse.Namespace) -> None:
    """Print the rounds of all studies, and their medians."""
    lasts, left = bench.warm(), 60.0 * options.minutes
    wanted = {kind: getattr(options, kind) for kind in TEXTS if getattr(options, kind)}
    for kind in sorted(wanted, key=lambda kind: wanted[kind] * lasts[kind]):
        share = left / (len(wanted) * options.rounds * BOTH * lasts[kind])
        samples, began = min(wanted.pop(kind), int(share)), time.perf_counter()
        rounds = []
        for k in range(options.rounds):
            rounds.append(bench.round(kind, samples))
            bits = "same" if rounds[-1].same else "OTHER"
            print(f"{kind} {k + 1}: {samples} machines, {rounds[-1]}, {bits} bits", flush=True)
        medians = (statistics.median(column) for column in list(zip(*rounds, strict=True))[:-1])
        ratio = statistics.median(one.together / one.alone for one in rounds)
        parallel = statistics.median(one.runs / one.together for one in rounds)
        besides = statistics.median(one.all / one.local - 1.0 for one in rounds)
        alone, together, *_ = medians
        print(
            f"{kind}, medians: {alone:.1f} s, {together:.1f} s, ratio {ratio:.3f}, parallelism {parallel:.3f},"
            f" besides runs {besides:+.1%}\n",
            flush=True,
        )
        left -= time.perf_counter() - began


if __name__ == "__main__":
    main()
