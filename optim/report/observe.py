"""`Observer`: a progress bar and the figure of the convergence while an algorithm runs."""

from __future__ import annotations

import time
from pathlib import Path

from tqdm import tqdm

from optim.algorithms.nlp import Values
from optim.evaluate.limits import FEASIBLE
from optim.problem.study import Study
from optim.store.store import Iteration

_EVERY = 5.0  # seconds between two drawings of the figure


class Observer:
    """Called after every iteration.

    Parameters
    ----------
    study : Study
    seed : int
    figure : Path or None
        Where to draw the convergence.
    """

    def __init__(self, study: Study, seed: int, figure: Path | None) -> None:
        self.title = f"{study.source.stem}, seed {seed}"
        objectives = study.file.objectives
        self.signs = [-1.0 if objective.maximise else 1.0 for objective in objectives.values()]
        self.labels = [study.label(name) for name in objectives]
        self.figure = figure
        self._drawn = time.monotonic()
        self._rows: list[Iteration] = []

    def __enter__(self) -> Observer:
        self._bar = tqdm(
            desc=self.title,
            delay=2.0,
            disable=None,
            leave=False,
            bar_format="{desc}: {percentage:3.0f}% |{bar}| [{elapsed}<{remaining}]{postfix}",
            total=1,
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()
        self._draw()

    def __call__(self, row: Iteration, nominal: Values) -> None:
        """Show an iteration."""
        self._rows.append(row)
        self._nominal = nominal.objectives[0]
        self._bar.total = max(row.iterations, 1)
        self._bar.set_postfix_str(self._best(row), refresh=False)
        self._bar.update(row.iteration - self._bar.n)
        if time.monotonic() - self._drawn > _EVERY:
            self._draw()
            self._drawn = time.monotonic()

    def _best(self, row: Iteration) -> str:
        feasible = row.objectives[row.violation <= FEASIBLE]
        if len(feasible) == 0:
            return "no design satisfies the constraints yet"
        best = zip(self.labels, self.signs, feasible.min(axis=0), strict=True)
        return "best " + ", ".join(f"{name} {sign * value:.5g}" for name, sign, value in best)

    def _draw(self) -> None:
        if self.figure is None or not self._rows:
            return
        from optim.report.figures import Panel, write_convergence

        panels = [
            Panel(name, sign, float(x))
            for name, sign, x in zip(self.labels, self.signs, self._nominal, strict=True)
        ]
        write_convergence(self.title, panels, self._rows, self.figure)
