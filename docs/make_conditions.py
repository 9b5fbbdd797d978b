"""Find the conditions that the press paper does not print: ``python docs/make_conditions.py``, about a quarter of an hour.

Writes docs/replication/computed/press_conditions.json, from which docs/make_replication.py writes rows and tables:

- ``scan``: of the ideal press at commensurate speeds, the pairs whose six forces are near the printed ones, by gravity and start
  (a few minutes);
- ``fits``: eps_0 and m at given speeds, from several starting points, by the simplex method;
- ``profiles``: the least mismatch with one unknown held and the others fitted anew, each from several starting points.

``python docs/make_conditions.py PART...`` computes some parts anew.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from replication.computed import keep, read
from replication.press_conditions import FITTED, NEAR_FORCES, Conditions, best, mismatch, outcome
from replication.press_ideal import GRAVITY, scan
from replication.press_paper import Array
from scipy.optimize import minimize

LIMIT, STEP = 13.0, 0.05  # rad/s
EVALUATIONS = 80  # of one search
#: Starting points of a search: logarithm to base 10 of eps_0, and m.
STARTS = ((-5.5, 0.5), (-5.0, 0.05), (-4.5, 0.05), (-4.0, 0.05), (-2.0, 0.1), (-0.5, 0.5))
#: Other starting points of a profile's searches: omega_1 [rad/s], and as above.
OTHERS = ((2.9, -5.0, 0.1), (3.3, -4.2, 0.03))
#: Bounds of omega_1 [rad/s], the logarithm to base 10 of eps_0, and m (which the paper bounds).
BOUNDS = ((0.5, LIMIT), (-7.0, -0.3), (0.0, 5.0))
STEPS = (0.05, 0.1, 0.02)
#: Held values of the profiles.
HELD = {
    "omega_1": (2.6, 2.8, 3.0, 3.1, 3.2, 3.3, 3.4, 3.6),
    "eps_0": (1e-6, 1e-5, 2e-5, 2.5e-5, 3e-5, 4e-5, 1e-4, 1e-3),
    "m": (0.0, 0.02, 0.03, 0.04, 0.05, 0.06, 0.1, 0.5),
    "size": (0.0, 6.0, 8.0, 9.0, 9.81, 10.5, 11.5, 13.0),
}


def of_values(values: Sequence[float], base: Conditions) -> Conditions:
    """Conditions with a speed, eps_0 and m; few digits, so that a page can print them."""
    one, small, m = values
    one = one if one == base.omega_1 else float(f"{one:.4g}")
    return base._replace(
        omega_1=one, omega_4=one * base.omega_4 / base.omega_1, eps_0=float(f"{10.0**small:.3g}"), m=float(f"{m:.3g}")
    )


def improve(values: Sequence[float], base: Conditions, held: Sequence[int]) -> tuple[Array, float]:
    """Improve omega_1, the logarithm of eps_0 and m by the simplex method of Nelder and Mead, some of them held."""
    x = np.array(values, dtype=float)
    free = [k for k in range(len(x)) if k not in held]

    def miss(part: Array) -> float:
        x[free] = part
        return mismatch(outcome(of_values(x, base)))

    lower, upper = np.array(BOUNDS)[free].T
    simplex = np.array([x[free], *(x[free] + step for step in np.diag(np.array(STEPS)[free]))])
    settings = {"maxfev": EVALUATIONS, "initial_simplex": np.clip(simplex, lower, upper), "xatol": 1e-3, "fatol": 1e-5}
    found = minimize(miss, x[free], method="Nelder-Mead", bounds=list(zip(lower, upper, strict=True)), options=settings)
    x[free] = found.x
    return x, float(found.fun)


def scans() -> dict[str, Any]:
    """Scan all commensurate speeds for both starts and five directions of gravity."""
    found = {}
    for start in ("moving", "at rest"):
        for name, pull in GRAVITY.items():
            rows = scan(pull, start == "at rest", LIMIT, STEP)
            near = rows[rows[:, 2] < NEAR_FORCES]
            found[f"{name}, {start}"] = {
                "pairs": len(rows),
                "best": rows[rows[:, 2].argmin()].tolist(),
                "near": [[float(f"{value:.6g}") for value in row] for row in near],
            }
    return found


def fits() -> dict[str, Any]:
    """Fit eps_0 and m at given speeds, from each of `STARTS`."""
    found: dict[str, Any] = {}
    for name, base in FITTED.items():
        for small, m in STARTS:
            x, miss = improve((base.omega_1, small, m), base, held=(0,))
            end = of_values(x, base)
            row = {"start": {"eps_0": 10.0**small, "m": m}, "end": {"eps_0": end.eps_0, "m": end.m}, "mismatch": miss}
            found.setdefault(name, []).append(row)
    return found


def profiles() -> dict[str, Any]:
    """Hold one unknown after another, and fit the others anew from several starting points."""
    found: dict[str, Any] = {}
    at = best()
    starts = ((at.omega_1, np.log10(at.eps_0), at.m), *OTHERS)
    for place, (name, values) in enumerate(HELD.items()):
        least = []
        for value in values:
            base = at._replace(size=value) if name == "size" else at
            held = () if name == "size" else (place,)
            ends = []
            for start in starts:
                x = list(start)
                if held:
                    x[place] = np.log10(value) if name == "eps_0" else value
                ends.append(improve(x, base, held)[1])
            least.append(min(ends))
        found[name] = {"values": list(values), "mismatch": least}
    return found


PARTS = {"scan": scans, "fits": fits, "profiles": profiles}


def main(words: Sequence[str]) -> None:
    """Compute some parts, or all."""
    data = read("press_conditions")
    for word in words or PARTS:
        if word not in PARTS:
            print(f'docs/make_conditions.py: "{word}" is no part; parts: {", ".join(PARTS)}', file=sys.stderr)
            raise SystemExit(2)
        data[word] = PARTS[word]()
        keep("press_conditions", data)
        print(word, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
