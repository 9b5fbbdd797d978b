"""Compare wall time and orbit error of several codes on the seven-bar: ``python benchmarks/sevenbar_engines.py``.

The benchmark simulates the first second of ``seven_bar_fast.toml`` with several tolerances (or numbers of steps) of
each code, and prints the wall time per simulated second and the orbit error: the largest distance of a journal from its
position in a solution at 1e-10, over the code's output times (200 or more), relative to the largest eccentricity. A
table compares the codes at equal error; it interpolates between lines of a code on log-log axes and never extrapolates.

| code          | description                                                                              |
|---------------|------------------------------------------------------------------------------------------|
| compiled      | `linkages.engines.compiled`                                                              |
| drake         | `linkages.engines.drake`, radau3                                                         |
| paper         | 18 absolute coordinates, Baumgarte (tests/paper_formulation.py), SciPy's Radau and LSODA |
| kernels-lsoda | SciPy's LSODA (odeint) on this package's right-hand side, compiled, drives eliminated    |
| exudyn        | Exudyn, the film as user function in Python, see sevenbar_exudyn.py; optional            |

Times are medians of ``--repeat`` rounds. Each round runs every line once, so a disturbance of the machine affects all
codes alike. Timing covers the integration from the initial state, not the set-up (about a millisecond for `compiled`)
or the evaluation of outputs.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from scipy.integrate import odeint
from seven_bar_reference import free_motion, orbit_error, reference
from tqdm import tqdm

from linkages import load
from linkages.base.errors import Status
from linkages.engines.compiled.run.runner import STATUS, Runner, join
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS

TIMES = np.linspace(0.0, 1.0, 501)  # s, of codes with dense output
FEWEST = 200


class Line:
    """One line of the table: a code at one setting; `run` returns wall seconds, times, eccentricities (nt, nj, 2)."""

    def __init__(self, code: str, setting: str, run: Callable[[], tuple]) -> None:
        self.code, self.setting, self.run = code, setting, run
        self.walls: list[float] = []
        self.error = np.nan

    @property
    def wall(self) -> float:
        """Median of the rounds [s]."""
        return statistics.median(self.walls)

    def measure(self, exact) -> None:
        """Run once more."""
        wall, times, orbit = self.run()
        if len(times) < FEWEST:
            raise RuntimeError(f"{self.code} has {len(times)} output times: too few to see its largest error")
        self.walls.append(wall)
        self.error = orbit_error(orbit, exact(times))


def by_tolerance(code, run, tolerances):
    return [Line(code, f"{tolerance:.0e}", partial(run, tolerance)) for tolerance in tolerances]


def compiled_lines(system):
    ex, ey = CLEARANCE_OUTPUTS.index("ex"), CLEARANCE_OUTPUTS.index("ey")

    def run(accuracy):
        runner = Runner(system.replaced({"solver.accuracy": accuracy}))
        begun = time.perf_counter()
        record = runner.run(0.0, runner.start, 0.0, 10**7)
        wall = time.perf_counter() - begun
        if STATUS[record.status] is not Status.OK:
            raise RuntimeError(f"compiled: {STATUS[record.status].value} at accuracy {accuracy:g}")
        contacts = runner.evaluate(join([record]), TIMES)[3]
        return wall, TIMES, contacts[:, :, [ex, ey]]

    return by_tolerance("compiled", run, (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9))


def drake_lines(system):
    from sevenbar_drake import one_run

    def run(accuracy, step):
        changed = system.replaced({"solver.accuracy": accuracy, "solver.max_step": step})
        wall, _, times, orbit = one_run(changed)
        return wall, times, orbit

    settings = ((1e-5, 5e-3), (1e-5, 2e-3), (1e-6, 5e-3), (1e-6, 2e-3), (1e-7, 2e-3), (1e-8, 2e-3))
    return [Line("drake", f"{accuracy:.0e}, {step:.0e} s", partial(run, accuracy, step)) for accuracy, step in settings]


def paper_lines(system):
    sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))
    import paper_formulation

    def run(method, tolerance):
        begun = time.perf_counter()
        _, at = paper_formulation.solve(paper_formulation.Data(), TIMES[-1], tolerance, method)
        return time.perf_counter() - begun, TIMES, at(TIMES)[0]

    tolerances = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    radau, lsoda = (by_tolerance(f"paper-{m.lower()}", partial(run, m), tolerances) for m in ("Radau", "LSODA"))
    return radau + lsoda


def kernel_lines(system):
    motion = free_motion(system)

    def run(tolerance):
        begun = time.perf_counter()
        states = odeint(
            motion.rates, motion.start, TIMES, tfirst=True, rtol=tolerance, atol=1e-3 * tolerance, mxstep=100_000
        )  # fmt: skip
        wall = time.perf_counter() - begun
        return wall, TIMES, np.array(list(map(motion.eccentricities, TIMES, states)))

    return by_tolerance("kernels-lsoda", run, (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10))


def exudyn_lines(system):
    import exudyn  # noqa: F401  (raises the reason to skip it)
    from sevenbar_exudyn import Model

    def run(steps):
        return Model(system).run(system.experiment.duration, steps)

    return [Line("exudyn", f"{n} steps", partial(run, n)) for n in (1000, 2000, 4000, 8000, 16000, 64000)]


CODES = {
    "compiled": compiled_lines, "drake": drake_lines, "paper": paper_lines, "kernels-lsoda": kernel_lines,
    "exudyn": exudyn_lines,
}  # fmt: skip
EQUAL = (1e-2, 1e-3, 1e-4, 1e-5)


def wall_at(error, lines):
    """Wall time for this orbit error, on the log-log line through a code's best points; NaN beyond its points."""
    points = sorted((line.error, line.wall) for line in lines)
    best = [(e, w) for e, w in points if not any(f <= e and x < w for f, x in points)]
    if not points[0][0] <= error <= points[-1][0]:
        return np.nan
    errors, walls = np.log(np.array(best)).T  # a coarser run that took longer is no reason to take longer
    return float(np.exp(np.interp(np.log(error), errors, walls)))


def all_lines(lines) -> list[list[str]]:
    """Rows of the table of all lines."""
    rows = [["code", "tolerance or steps", "wall [ms/s]", "orbit error"]]
    return rows + [[line.code, line.setting, f"{1e3 * line.wall:.2f}", f"{line.error:.1e}"] for line in lines]


def equal_errors(lines) -> list[list[str]]:
    """Return the rows of wall times at equal error, with ratios to the first code."""
    codes = {line.code: [other for other in lines if other.code == line.code] for line in lines}
    walls = {code: np.array([wall_at(error, own) for error in EQUAL]) for code, own in codes.items()}
    first = next(iter(walls.values()))
    rows = [["wall [ms/s] at an orbit error of", *(f"{error:.0e}" for error in EQUAL)]]
    for code, wall in walls.items():
        pairs = zip(1e3 * wall, wall / first, strict=True)
        rows.append([code, *(f"{ms:.2f} ({ratio:.3g} x)" if np.isfinite(ratio) else "-" for ms, ratio in pairs)])
    return rows


def in_columns(rows) -> str:
    """Return the rows as text."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.rjust(n) for cell, n in zip(row, widths, strict=True)) for row in rows)


def markdown(rows) -> str:
    """Return the rows as a table of a page."""
    head, *rest = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([head, "|" + "---|" * len(rows[0]), *rest]) + "\n"


def page(lines, rounds) -> str:
    """Return docs/benchmarks.md."""
    packages = ("drake", "exudyn", "numba", "numpy", "scipy")
    versions = ", ".join(f"{name} {version(name)}" for name in packages if find_spec(name))
    about = __doc__.partition("\n\n")[2]
    return f"""# Benchmarks

For readers who compare simulation codes: computing time of several codes at equal error, in one run.
`python benchmarks/sevenbar_engines.py --page docs/benchmarks.md` wrote this page on
{os.cpu_count()} processors ({platform.machine()}, Python {platform.python_version()}, {versions};
{rounds} rounds). Ratios within one run are more reliable than times, because machines differ.

{about}
## At equal error

{markdown(equal_errors(lines))}"""


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=3, help="rounds (default 3)")
    parser.add_argument("--codes", nargs="+", choices=CODES, default=list(CODES), help="default: all")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the page of the documentation too")
    options = parser.parse_args()
    system = load(Path(__file__).with_name("seven_bar_fast.toml"), {"duration": float(TIMES[-1])})
    exact = reference(system)
    lines = []
    for code in options.codes:
        try:
            own = CODES[code](system)
        except ImportError as problem:
            print(f"{code}: skipped, {problem}")
            continue
        own[0].run()  # compiles
        lines += own
    for _ in tqdm(range(options.repeat), desc="rounds", disable=None):
        for line in lines:
            line.measure(exact)
    if lines:
        print(in_columns(all_lines(lines)), in_columns(equal_errors(lines)), sep="\n\n")
        if options.page is not None:
            own = options.page.read_text(encoding="utf-8").partition("\n## At equal error\n")[2]
            rest = "".join(own.partition("\n## ")[1:])  # of other benchmarks
            options.page.write_text(page(lines, options.repeat) + rest, encoding="utf-8")


if __name__ == "__main__":
    main()
