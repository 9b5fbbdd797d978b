"""`Observer`: a progress bar and the figure of the convergence while an algorithm runs."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from tqdm import tqdm

from linkages.cli.progress import silence
from optim.algorithms.nlp import Values
from optim.problem.study import Study
from optim.store.store import Iteration

_EVERY = 30.0  # seconds between two drawings of the figure, at least; a short run is drawn at its end alone
_SHARE = 0.05  # of the time that drawings take, at most


class Observer:
    """Called after every iteration; draws the convergence to the path `figure`, if there is one."""

    def __init__(self, study: Study, seed: int, figure: Path | None) -> None:
        self.title = f"{study.source.stem}, seed {seed}"
        self.study, self.figure, self._stage = study, figure, self.title
        self._next = time.monotonic() + _EVERY
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
        silence.stage = self.title
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()
        self._draw()

    def __call__(self, row: Iteration, nominal: Values) -> None:
        """Show an iteration."""
        self._rows.append(row)
        self._nominal = nominal
        self._bar.total = max(row.iterations, 1)
        self._bar.set_postfix_str(self._best(row), refresh=False)
        self._bar.update(row.iteration - self._bar.n)
        self._stage = f"{self.title}, iteration {row.iteration} of {row.iterations}, {self._best(row)}"
        silence.stage = self._stage
        if not self._bar.disable:
            silence.broken()
        if (begun := time.monotonic()) > self._next:
            self._draw()
            ended = time.monotonic()
            self._next = ended + max(_EVERY, (ended - begun) / _SHARE)

    def runs(self, part: float) -> None:
        """Show the finished fraction of the designs that are being evaluated."""
        silence.stage = f"{self._stage}; next designs: {part:.0%}"

    def _best(self, row: Iteration) -> str:
        if np.isnan(row.best_feasible).all():
            return "no design satisfies the constraints yet"
        best = zip(self.study.file.objectives, self.study.signs, row.best_feasible, strict=True)
        return "best " + ", ".join(f"{self.study.label(name)} {sign * x:.5g}" for name, sign, x in best)

    def _draw(self) -> None:
        if self.figure is None or not self._rows:
            return
        from optim.report.figures import write_convergence

        write_convergence(self.study, self.title, self._rows, self._nominal, self.figure)
