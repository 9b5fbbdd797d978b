"""`Observer`: a progress bar and the figure of the convergence while an algorithm runs."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from tqdm import tqdm

from linkages.cli.progress import silence
from optim.algorithms.nlp import Values
from optim.evaluate.limits import FEASIBLE
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
        self._parts: list[Values] = []
        self._best = np.full(len(study.file.objectives), np.inf)  # least value of each objective of a feasible design

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

    def __call__(self, row: Iteration, fresh: Values) -> None:
        """Show an iteration, and the best of all designs; `fresh` has the values of those since the last call."""
        self._parts.append(fresh)
        feasible = fresh.objectives[fresh.violation <= FEASIBLE]
        self._best = np.minimum(self._best, feasible.min(axis=0, initial=np.inf))
        self._bar.total = max(row.iterations, 1)
        self._bar.set_postfix_str(self.told(), refresh=False)
        self._bar.update(row.iteration - self._bar.n)
        self._stage = f"{self.title}, iteration {row.iteration} of {row.iterations}, {self.told()}"
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

    def told(self) -> str:
        """Name the best value of each objective so far."""
        if np.isinf(self._best).all():
            return "no design satisfies the constraints yet"
        best = zip(self.study.file.objectives, self.study.signs, self._best, strict=True)
        return "best " + ", ".join(f"{self.study.label(name)} {sign * x:.5g}" for name, sign, x in best)

    def _draw(self) -> None:
        if self.figure is None or not self._parts:
            return
        from optim.report.figures import write_convergence

        write_convergence(self.study, self.title, Values.join(self._parts), self.figure)
