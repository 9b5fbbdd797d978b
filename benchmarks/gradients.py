"""Optimisation with derivatives from sensitivities and from differences: ``python benchmarks/gradients.py [PART]``.

The reduced gradient method solves two shipped studies, each from ten starts: ``force``, the press's joint forces, and
``kept``, the four-bar's jitter with constraints, over a duration within its horizon of predictability. For both sources
of derivatives: CPU time, designs evaluated, gradients by sensitivities, and the best objectives over the nominal
design's. Compilation is not counted.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import optim

#: Study, replaced text, and settings of the reduced gradient method.
CASES = {"force": ("sevenbar_force", {}), "kept": ("fourbar_kept", {"duration = 0.21": "duration = 0.015"})}
ACCURACIES = {"force": (1e-6, 1e-8), "kept": (1e-6,)}
STARTS = 10
SETTINGS = {"starts": STARTS, "iterations": 15, "tolerance": 1e-5}


def study_of(name: str, replaced: dict[str, str], accuracy: float) -> optim.Study:
    """Load a shipped study with replaced text, at an accuracy of its runs."""
    text = optim.find_study(name).read_text(encoding="utf-8")
    for old, new in replaced.items():
        assert old in text
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{name}.toml"
        file.write_text(text, encoding="utf-8")
        return optim.load_study(file).replaced(lambda system: {"solver.accuracy": accuracy})


def solve(study: optim.Study, source: str, step: float) -> str:
    """Solve a study with derivatives from a source; return the numbers as text."""
    evaluate = optim.Screened(study, optim.Evaluator(study), step)  # of the problem and of its gradients
    nominal = evaluate(study.nominal[None])
    problem = optim.problem_of(study, evaluate, nominal)
    gradients, count = optim.Gradients(study, evaluate, nominal), [0]

    def jacobian(design: np.ndarray) -> np.ndarray:
        count[0] += 1
        return gradients(design)

    if source == "sensitivities":
        jacobian(study.nominal)  # compiles
        count[0] = 0
        problem = optim.Problem(**(vars(problem) | {"jacobian": jacobian}))
    start = time.process_time()
    found = optim.minimise("grg", problem, {**SETTINGS, "step": step}, seed=1)
    elapsed = time.process_time() - start
    unit = nominal.objectives[0, 0] if not next(iter(study.file.objectives.values())).relative else 1.0
    ends = np.sort([float(run.values.objectives[0, 0]) for run in found.runs if run.values.feasible(1e-6)[0]]) / unit
    best, middle = (ends[0], np.median(ends)) if len(ends) else (np.nan, np.nan)
    row = f"{found.evaluations:13d}{count[0]:11d}{found.iterations:12d}{elapsed:10.1f}"
    return f"{row}{best:10.5f}{middle:10.5f}{len(ends):10d}"


def main() -> None:
    """Print a line for each study, accuracy and source."""
    parts = sys.argv[1:] or list(CASES)
    head = f"{'study':16s}{'accuracy':>9s}{'derivatives':>15s}{'step':>8s}{'evaluations':>13s}{'gradients':>11s}"
    print(f"{head}{'iterations':>12s}{'CPU [s]':>10s}{'best':>10s}{'median':>10s}{'feasible':>10s}")
    for part in parts:
        name, replaced = CASES[part]
        for accuracy in ACCURACIES[part]:
            study = study_of(name, replaced, accuracy)
            for source, step in (("sensitivities", 1e-4), ("differences", 1e-4), ("differences", 1e-2)):
                label = f"{name:16s}{accuracy:9.0e}{source:>15s}{step:8.0e}"
                print(label + solve(study, source, step), flush=True)


if __name__ == "__main__":
    main()
