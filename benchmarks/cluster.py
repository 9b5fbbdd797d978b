"""Measure studies of tolerances on two workers: ``python benchmarks/cluster.py [--press N] [--dry N] [--rounds K]``.

A scheduler and two workers of one thread each run on this machine. Each round runs the same machines on one local
thread and then on the workers. Parallelism is the time of all runs on the workers over the time of the study; it counts
where the machine has other work too, the ratio of the two times does not. Results must be equal to the last bit.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import tolerances as texts

import optim
from linkages.engines.cluster import cluster
from optim.evaluate import remote

PRESS = texts.PRESS.replace("start = 1.0\nend = 2.0", "start = 0.0\nend = 0.1").replace(
    "[scatter.fit]", "[set]\nduration = 0.1\n[scatter.fit]"
)


class Timed(remote.Dispatcher):
    """Adds up the time of all runs."""

    seconds = 0.0

    def receive(self, sent):
        """Wait for the answers."""
        for point in sent:
            Timed.seconds += sum(future.result().seconds for future in point)
        return super().receive(sent)


def run(file: Path, samples: int, **settings) -> tuple[str, float, float]:
    """Run the machines of a study; result, time and processor time of this process [s]."""
    study = optim.load_study(file)
    began, used = time.perf_counter(), time.process_time()
    result = optim.tolerances(study, samples=samples, evaluator=optim.Evaluator(study, **settings))
    return json.dumps(result), time.perf_counter() - began, time.process_time() - used


def processes(file: Path) -> list[subprocess.Popen]:
    """Start a scheduler and two workers."""
    quiet = {
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
        "env": os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    }
    dask = [
        sys.executable,
        "-m",
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
    ]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file), "--nthreads", "1"]
    words = [[*dask, "--scheduler-file", str(file)], *[[*worker, "--no-nanny", "--no-dashboard"]] * 2]
    return [subprocess.Popen(command, **quiet) for command in words]


def main() -> None:
    """Print all numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--press", type=int, default=100_000)
    parser.add_argument("--dry", type=int, default=5_000)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    from optim.evaluate import evaluator

    evaluator.Dispatcher = Timed
    with tempfile.TemporaryDirectory() as name:
        folder, address = Path(name), Path(name) / "scheduler.json"
        started = processes(address)
        try:
            for kind, text in (("press", PRESS), ("dry", texts.DRY)):
                (folder / f"{kind}.toml").write_text(text)
                samples = getattr(options, kind)
                for k in range(options.rounds if samples else 0):
                    measure(folder / f"{kind}.toml", samples, str(address), k)
        finally:
            for process in started:
                process.kill()
                process.wait()


def measure(file: Path, samples: int, address: str, k: int) -> None:
    """Print the numbers of a round; the first one also loads compiled code."""
    here, alone, used = run(file, samples, threads=1)
    with cluster(address, "repeat") as (executor, count):
        while count() < 2:
            time.sleep(0.1)
        Timed.seconds = 0.0
        there, together, client = run(file, samples, executor=executor, parts=lambda: 4 * count(), threads=1)
    line = f"{file.stem} {k + 1}: {samples} machines, {alone:.1f} s on one thread ({used:.1f} s of its processor)"
    line += f", {together:.1f} s on two workers ({client:.1f} s of the client), ratio {together / alone:.2f}"
    print(
        f"{line}, parallelism {Timed.seconds / together:.2f}, {'same' if here == there else 'OTHER'} bits", flush=True
    )


if __name__ == "__main__":
    main()
