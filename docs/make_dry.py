"""Compute the distributions of dry objectives: ``python docs/make_dry.py [STUDY...]``, a quarter of an hour.

Writes docs/replication/computed/dry.json, from which docs/make_replication.py writes intervals: see `replication.dry`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np
from replication.computed import keep, read
from replication.dry import CASES, COUNTED, FILE, counts, peaks, phases


def main(names: Sequence[str]) -> None:
    """Compute the named studies, or all."""
    data = read(FILE)
    for name in names or CASES:
        found = peaks(name, phases())
        if np.isnan(found).any():
            raise SystemExit(f"{name}: {int(np.isnan(found).any(axis=(2, 3)).sum())} runs failed")
        data[name] = {
            output: {"start": digits(found[:, :, 0, k]), "running": digits(found[:, :, 1:, k])}
            for k, output in enumerate(CASES[name].outputs)
        }
        if name == "fourbar_jitter":
            data[f"{name}/counts"] = counts(name, phases(COUNTED))
        keep(FILE, data)
        print(name, flush=True)


def digits(values: np.ndarray) -> list:
    """Keep four digits: no run has more."""
    return np.vectorize(lambda value: float(f"{value:.4g}"))(values).tolist()


if __name__ == "__main__":
    main(sys.argv[1:])
