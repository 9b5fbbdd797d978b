"""Scan what the press paper's missing data would have to be: ``python docs/make_missing.py``, some minutes.

Guesses at the drives' speeds, the start, and eps_0 and m of eqs. (12)-(13), against all printed numbers with their signs
(`replication.press_missing`): a map over both speeds, and differential evolution over two, three and all five. Keeps them in
docs/replication/measured/press_missing.json, from which docs/make_replication.py writes rows and a figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from replication.measured import keep
from replication.press_missing import ASSUMED, mismatch, outcome
from scipy.optimize import differential_evolution

#: Largest and smallest guess of each of `MISSING`; the paper prints the range of m.
BOUNDS = ((-15.0, 15.0), (-15.0, 15.0), (0.0, 1.0), (0.01, 0.5), (0.0, 5.0))
SCANS = {"speeds": 2, "speeds and start": 3, "speeds, start, ε₀ and m": 5}
DIGITS, SEED, POPULATION, GENERATIONS = 3, 1, 5, 4
SPEEDS = np.arange(-13.5, 14.0, 3.0)


def scan(number: int, start: Sequence[float]) -> dict[str, Any]:
    """Search among the first of `MISSING` from a guess; guesses have few digits, so that a page can print them."""
    found: dict[tuple[float, ...], float] = {}

    def miss(values: np.ndarray) -> float:
        guess = (*(float(f"{value:.{DIGITS}g}") for value in values), *ASSUMED[number:])
        if guess not in found:
            found[guess] = mismatch(outcome(guess))
        return found[guess]

    first = [max(low, value) for (low, _), value in zip(BOUNDS[:number], start, strict=False)]
    settings = {"popsize": POPULATION, "maxiter": GENERATIONS, "rng": SEED, "polish": False, "tol": 0.0}
    differential_evolution(miss, BOUNDS[:number], x0=first, **settings)
    best = min(found, key=found.__getitem__)
    return {"guess": best, "mismatch": found[best], "evaluations": len(found), "seed": SEED, "bounds": BOUNDS[:number]}


def both() -> dict[str, Any]:
    """Misses over both speeds, the rest as assumed."""
    rows = [[mismatch(outcome((one, four, *ASSUMED[2:]))) for one in SPEEDS] for four in SPEEDS]
    return {"speeds": SPEEDS.tolist(), "mismatch": rows}


if __name__ == "__main__":
    data: dict[str, Any] = {"map": both(), "scans": {}}
    guess: Sequence[float] = ASSUMED
    for name, number in SCANS.items():
        data["scans"][name] = scan(number, guess)
        guess = data["scans"][name]["guess"]
        keep("press_missing", data)
        print(name, data["scans"][name], flush=True)
