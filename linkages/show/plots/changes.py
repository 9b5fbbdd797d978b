"""Changes of a run's peaks with 1 % of its values: as a matrix, and in sentences; without matplotlib."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.explore.sensitivity import Sensitivities
from linkages.show.plots.names import name_of_number, name_of_output, name_of_value
from linkages.show.plots.quantities import number

LEAST = 1e-4  # change with 1 % of a value below which a cell is empty
_TOLD = 5e-4  # change with 1 % of a value from which a sentence tells it


class Matrix(NamedTuple):
    """Names of rows and of columns, and changes (rows, columns) with 1 % of a value; NaN where none is predicted."""

    rows: list[str]
    columns: list[str]
    changes: Array


def strongest(found: Sensitivities) -> list[str]:
    """Tell for each peak the value that changes it most, the largest change first; small changes are not told."""
    best = []
    for key in found.times:
        shares = {path: share for path in found.values if (share := found.per_cent(path, key)) is not None}
        if shares:
            path = max(shares, key=lambda path: abs(shares[path]))
            best.append((abs(shares[path]), key, path, shares[path]))
    told = [
        f"1 % more {name_of_value(path)} changes the {name_of_number(key)} by {_signed(share)} %"
        for size, key, path, share in sorted(best, reverse=True)
        if size >= _TOLD
    ]
    if not best:
        return ["No derivative predicts the change of a peak with 1 % of a value"]
    return told or [f"No peak changes by {number(100.0 * _TOLD)} % with 1 % of a value"]


def matrix_of(found: Sensitivities) -> Matrix:
    """Arrange the changes of the peaks with 1 % of each value; the longer list is in rows, the strongest first."""
    keys = [key for key in found.times if found.numbers[key] != 0.0]
    given = [[found.per_cent(path, key) for key in keys] for path in found.values]
    changes = np.array([[np.nan if one is None else one for one in line] for line in given]).reshape(-1, len(keys))
    order = np.argsort(-np.nan_to_num(np.abs(changes)).max(axis=1, initial=0.0), kind="stable")
    paths = [name_of_value(list(found.values)[k]) for k in order]
    outputs = [name_of_output(key.removesuffix(".peak")) for key in keys]
    table = Matrix(paths, outputs, changes[order])
    return table if len(paths) > len(keys) else Matrix(outputs, paths, table.changes.T)


def cell(share: float) -> str:
    """Write a change in per cent for a cell: "-" if it is small, "?" if it is not predicted."""
    return "?" if math.isnan(share) else "-" if abs(share) < LEAST else _signed(share)


def _signed(share: float) -> str:
    return f"{'+' if share > 0.0 else ''}{number(100.0 * share, 2)}"
