"""`KnownDesigns`: evaluations by design, in little memory: a million machines take 150 MB."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from optim.evaluate.evaluations import Evaluations
from optim.problem.study import Array
from optim.search import numerics


class KnownDesigns:
    """Evaluations of designs in columns, found by the bytes of a design."""

    def __init__(self, objectives: int, constraints: int) -> None:
        self._row: dict[bytes, int] = {}
        rows = numerics.KNOWN_DESIGNS_FIRST
        self._objectives, self._constraints = np.empty((rows, objectives)), np.empty((rows, constraints))
        self._asked = np.zeros(rows, dtype=bool)
        self._code = np.zeros(rows, dtype=np.uint8)
        self._states: list[str] = []
        self._reasons: dict[int, str] = {}

    def __contains__(self, key: bytes) -> bool:
        return key in self._row

    @property
    def asked(self) -> int:
        """Return the number of designs that were asked for: the store may know others."""
        return int(self._asked.sum())

    def add(self, designs: Array, found: Evaluations) -> None:
        """Add evaluations of designs (m, n)."""
        first, end = len(self._row), len(self._row) + len(designs)
        self._row |= {design.tobytes(): first + k for k, design in enumerate(designs)}
        self._objectives, self._constraints, self._asked, self._code = (
            _grown(column, end) for column in (self._objectives, self._constraints, self._asked, self._code)
        )
        self._objectives[first:end], self._constraints[first:end] = found.objectives, found.constraints
        self._states += [state for state in dict.fromkeys(found.status) if state not in self._states]
        self._code[first:end] = [self._states.index(state) for state in found.status]
        self._reasons |= {first + k: reason for k, reason in enumerate(found.reason) if reason}

    def evaluations(self, keys: Sequence[bytes]) -> Evaluations:
        """Return the evaluations of designs that are known, and note that they were asked for."""
        rows = [self._row[key] for key in keys]
        self._asked[rows] = True
        status = tuple(self._states[code] for code in self._code[rows].tolist())
        reason = tuple(self._reasons.get(row, "") for row in rows)
        return Evaluations(self._objectives[rows], self._constraints[rows], status, reason)


def _grown(column: NDArray[Any], rows: int) -> NDArray[Any]:
    """Return a column of at least so many rows, with the old ones."""
    if rows <= len(column):
        return column
    grown = np.zeros((max(rows, 2 * len(column)), *column.shape[1:]), dtype=column.dtype)
    grown[: len(column)] = column
    return grown
