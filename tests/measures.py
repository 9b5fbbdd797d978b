"""How columns of results are compared: in parts of the largest value of their kind."""

from __future__ import annotations

import numpy as np

#: Columns of one kind are measured by the largest of them in the linkage: a moment that vanishes, or a component, has
#: the rounding errors of its terms.
_KINDS = {
    "ax": "a",
    "ay": "a",
    "acceleration": "a",
    "vx": "v",
    "vy": "v",
    "fx": "force",
    "fy": "force",
    "moment": "torque",
}
_KINDS |= {"x": "length", "y": "length", "tilt": "angle"}
_KINDS |= {name: name for name in ("force", "torque", "power", "alpha", "omega", "angle")}


def scales(columns: dict) -> dict[str, float]:
    """Largest magnitude of each column's kind; 1 where all are zero."""
    kinds = {name: _KINDS.get(name.removesuffix(".jitter").rpartition(".")[2], name) for name in columns}
    largest: dict[str, float] = {}
    for name, values in columns.items():
        largest[kinds[name]] = max(largest.get(kinds[name], 0.0), float(np.abs(values).max()))
    return {name: largest[kind] or 1.0 for name, kind in kinds.items()}


def worst(one: dict, other: dict) -> tuple[str, float]:
    """Name and size of the largest difference between columns; coordinates that either has alone do not count."""
    assert all(name.startswith("q.") for name in one.keys() ^ other.keys())
    scale, common = scales(other), one.keys() & other.keys()
    found = {name: float(np.abs(one[name] - other[name]).max()) / scale[name] for name in common}
    return max(found.items(), key=lambda item: item[1])
