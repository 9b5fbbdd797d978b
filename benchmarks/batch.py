"""Compare batches with single runs: ``python benchmarks/batch.py [--runs N] [--large N] [--exudyn N] [--page FILE]``.

Times and processor times of batches with one and two threads, and the part of their processor time in compiled code;
of single runs with `linkages.simulate`; of a whole design study. The memory of a run, and how soon a large batch ends
at Ctrl-C; not with ``--large 0``. With ``--exudyn`` the same designs in Exudyn (``pip install exudyn``), by its
``ParameterVariation`` with two processes, at an equal error of the orbit: see sevenbar_engines.py for the steps per
second.

The press is ``seven_bar_fast.toml`` over 2 s with statistics of the second one; dry is ``slider_crank_dry.toml`` over
0.05 s. The integration alone is the mean of ten of the same designs. Processor times count where other programs use
the machine: with N threads on N idle processors a batch takes the processor time over N.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

import linkages
from linkages.engines.compiled.batch import designs
from linkages.engines.compiled.run.runner import Runner

OUTPUTS = ("A.force", "B.force", "slider7.ax")
MASS, OIL = "sdf.links.link2.mass", "joints.A.viscosity"
PLAY, LENGTH = "joints.A.clearance", "sdf.frames.link2_C.pose.x"
LIMITS = {
    MASS: (0.2, 0.3),
    OIL: (0.2, 0.5),
    PLAY: (2e-4, 4e-4),
    LENGTH: (0.178, 0.182),
    "sdf.links.rod.mass": (0.1, 0.3),
}
EXUDYN_STEPS, ACCURACY = 8000, 1e-5  # steps each second; both have an orbit error of 5e-4
BEGIN, MARK = "\n## Batches\n", "<!-- batches: benchmarks/batch.py -->"
PRESS = Path(__file__).with_name("seven_bar_fast.toml")
LARGE = """
import sys, time, tracemalloc, numpy as np, linkages
system = linkages.load(sys.argv[2], {"duration": 0.01})
values = np.random.default_rng(0).uniform(0.2, 0.3, (int(sys.argv[1]), 1))
say = lambda part: print(part, flush=True)
job = system, ["sdf.links.link2.mass"]
try:
    linkages.simulate_batch(*job, values[:64], ["A.force"])  # loads compiled code
    tracemalloc.start()
    batch = linkages.simulate_batch(*job, values, ["A.force"], progress=say)
    tables = *batch.statistics.values(), batch.values, batch.steps
    print(sum(one.nbytes for one in tables) + sys.getsizeof(batch.status) + sys.getsizeof(batch.reason))
    print(tracemalloc.get_traced_memory()[1])
except KeyboardInterrupt:
    print("stopped", time.monotonic())
"""


def table(paths, count):
    """Random designs."""
    low, high = np.array([LIMITS[path] for path in paths]).T
    return np.random.default_rng(0).uniform(low, high, (count, len(paths)))


class InCompiledCode:
    """Adds up the processor time that threads spend in compiled code."""

    def __init__(self):
        self.spent, self._run, self._lock = 0.0, designs.run_rows, threading.Lock()

    def __enter__(self):
        designs.run_rows = self._measured
        return self

    def __exit__(self, *_):
        designs.run_rows = self._run

    def _measured(self, *arguments):
        begun = time.thread_time()
        self._run(*arguments)
        with self._lock:
            self.spent += time.thread_time() - begun


def batch(system, paths, count, threads, outputs=OUTPUTS, windows=((1.0, 2.0),)):
    """Wall and processor time of each run [ms], and the part of the latter in compiled code."""
    values = table(paths, count)
    linkages.simulate_batch(system, paths, values[:2], outputs, windows)
    wall, spent = time.perf_counter(), time.process_time()
    with InCompiledCode() as compiled:
        linkages.simulate_batch(system, paths, values, outputs, windows, threads)
    wall, spent = time.perf_counter() - wall, time.process_time() - spent
    return 1e3 * wall / count, 1e3 * spent / count, compiled.spent / spent


def integration(system, paths, count):
    """Mean processor time of the integration alone, over the first designs [ms]."""
    spent = []
    for row in table(paths, count)[:10].tolist():
        runner = Runner(system.replaced(dict(zip(paths, row, strict=True))))

        def run(_, runner=runner):
            runner.memory[:], runner.modes[:] = 0.0, -1
            runner.run(0.0, runner.start, 0.0, 10**7)

        spent.append(each(run, 10))
    return statistics.mean(spent)


def each(run, repeat=40):
    """Median processor time of a call with 0, 1, ... [ms]."""
    spent = []
    for k in range(repeat + 2):
        begun = time.process_time()
        run(k)
        spent.append(time.process_time() - begun)
    return 1e3 * statistics.median(spent[2:])


def batches(runs):
    """Rows of the table of batches."""
    press = linkages.load(PRESS)
    dry = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.05})
    few = max(runs // 20, 10)
    cases = {
        "press, mass and viscosity": (press, [MASS, OIL], runs, OUTPUTS, ((1.0, 2.0),)),
        "press, clearance": (press, [PLAY], runs, OUTPUTS, ((1.0, 2.0),)),
        "press, length and viscosity": (press, [LENGTH, OIL], runs, OUTPUTS, ((1.0, 2.0),)),
        "dry slider-crank, mass": (dry, ["sdf.links.rod.mass"], few, ("B.force", "slider.ax"), None),
    }
    rows = [["batch", "runs", "integration alone", "processor time", "wall, 1 thread", "wall, 2 threads", "compiled"]]
    for name, (system, paths, count, outputs, windows) in cases.items():
        one, two = (batch(system, paths, count, threads, outputs, windows) for threads in (1, 2))
        numbers = [f"{x:.2f} ms" for x in (integration(system, paths, count), one[1], one[0], two[0])]
        rows.append([name, str(count), *numbers, f"{two[2]:.0%}"])
    return rows


def singles():
    """Rows of the table of single runs and of the whole command."""
    press = linkages.load(PRESS, {"duration": 1.0})

    def run(system):
        linkages.simulate(system, "compiled", outputs=OUTPUTS)

    def changed(path, value, unit):
        return each(lambda k: run(press.replaced({path: value + unit * k})))

    rows = [["one after the other", "processor time"]]
    rows.append(["`simulate` with three outputs, press, 1 s", f"{each(lambda k: run(press)):.2f} ms"])
    rows.append(["the same after `replaced` of a clearance", f"{changed('joints.A.clearance', 3e-4, 1e-7):.2f} ms"])
    rows.append(["the same after `replaced` of a length", f"{changed(LENGTH, 0.18, 1e-5):.2f} ms"])
    with tempfile.TemporaryDirectory() as folder:
        before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        command = [Path(sys.executable).with_name("linkages"), "optimise", "sevenbar_force.toml", "--out", folder]
        subprocess.run(command, check=True, capture_output=True)
        wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime - before.ru_utime
    rows.append(["`linkages optimise sevenbar_force.toml`", f"{spent:.1f} s (wall {wall:.1f} s)"])
    return rows


def large(count):
    """Rows about a large batch: memory of a run, bytes that all of it takes, end at Ctrl-C."""
    done = subprocess.run([sys.executable, "-c", LARGE, str(count), str(PRESS)], check=True, capture_output=True)
    *_, results, peak = map(float, done.stdout.split())
    process = subprocess.Popen(
        [sys.executable, "-c", LARGE, "100000", str(PRESS)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    while not float(process.stdout.readline()) > 0.0:
        pass
    begun = time.monotonic()
    os.kill(process.pid, signal.SIGINT)
    stopped = float(process.communicate()[0].split()[-1]) - begun
    return [
        ["large batch", ""],
        [f"memory that {count:,} runs take, at most", f"{peak / count:.0f} bytes a run"],
        ["of it the results: statistics, values, steps, status, reason", f"{results / count:.0f} bytes a run"],
        ["from Ctrl-C to `KeyboardInterrupt` in a batch of 100,000 runs", f"{stopped:.2f} s"],
    ]


def exudyn_rows(count):
    """Rows of the table of Exudyn's variation."""
    from exudyn.processing import ParameterVariation
    from sevenbar_exudyn import Model

    system = linkages.load(PRESS, {"solver.accuracy": ACCURACY})
    Model(system).run(0.01, 10)  # compiles
    batch(system, [MASS, OIL], 2, 1)
    begun = time.perf_counter()
    number = {"parameters": {"number": (0, count - 1, count)}, "useMultiProcessing": True, "numberOfThreads": 2}
    ParameterVariation(parameterFunction=exudyn_run, showProgress=False, **number)
    theirs = time.perf_counter() - begun
    ours = statistics.median(1e-3 * count * batch(system, [MASS, OIL], count, 2)[0] for _ in range(5))
    return [
        [f"{count} designs of the press, wall, two processors", ""],
        ["compiled engine, `simulate_batch`, two threads", f"{ours:.2f} s"],
        ["Exudyn, `ParameterVariation`, two processes", f"{theirs:.1f} s ({theirs / ours:.0f} x)"],
    ]


def exudyn_run(parameters):
    """Run one design in Exudyn; returns the largest eccentricity."""
    from sevenbar_exudyn import Model

    row = table([MASS, OIL], 1 + int(parameters["number"]))[int(parameters["number"])]
    system = linkages.load(PRESS, dict(zip([MASS, OIL], map(float, row), strict=True)))
    orbit = Model(system).run(2.0, 2 * EXUDYN_STEPS)[2]
    return float(np.abs(orbit).max())


def markdown(rows):
    """Text of a table."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([lines[0], "|---" * len(rows[0]) + "|", *lines[1:]]) + "\n"


def main() -> None:
    """Print the tables; write them into the page, if there is one."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in background jobs
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--runs", type=int, default=1500)
    parser.add_argument("--large", type=int, default=100_000, help="runs of the large batch; 0: none")
    parser.add_argument("--exudyn", type=int, default=0)
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    tables = [batches(options.runs), singles()]
    if options.large:
        tables.append(large(options.large))
    if options.exudyn:
        tables.append(exudyn_rows(options.exudyn))
    text = "\n".join(map(markdown, tables))
    print(text)
    if options.page:
        page, _, rest = options.page.read_text(encoding="utf-8").partition(BEGIN)
        rest = "".join(rest.partition("\n## ")[1:])  # of other benchmarks
        about = __doc__.partition("\n\n")[2].replace("``", "`")
        options.page.write_text(f"{page.rstrip()}\n{BEGIN}\n{MARK}\n\n{about}\n{text}{rest}", encoding="utf-8")


if __name__ == "__main__":
    main()
