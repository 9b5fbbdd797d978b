"""Find the conditions that the press paper does not print: ``python docs/make_conditions.py``, about twenty minutes.

Writes docs/replication/measured/press_conditions.json, from which docs/make_replication.py writes rows and tables:

- ``maps``: of the ideal press over both speeds, how many points meet the six forces, by gravity and start;
- ``natural``: the best pairs of round speeds;
- ``fits``: per scenario the best conditions for all ten numbers, by differential evolution and the simplex method;
- ``profiles``: the least mismatch with one unknown held, all others fitted anew.

``python docs/make_conditions.py PART...`` computes some parts anew: maps, natural, profiles, or names of `SCENARIOS`. All searches
are seeded.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from replication.measured import keep, read
from replication.press_conditions import SAME_SENSE, Conditions, met, mismatch, outcome
from replication.press_ideal import GRAVITY, deviation, grid
from replication.press_paper import Array
from scipy.optimize import differential_evolution, minimize

LIMIT, STEP = 13.0, 0.25  # rad/s
SPEEDS = np.arange(-LIMIT, LIMIT + 0.5 * STEP, STEP)
LEVELS = (0.05, 0.1)
SEED, POPULATION, GENERATIONS, POLISH = 1, 30, 14, 160
#: Scenarios: gravity, start, whether eqs. (12)-(13) are used, whether both speeds are positive.
SCENARIOS = {
    f"gravity {gravity}, start {start}{', (12)-(13)' if patched else ''}": (gravity, start, patched, False)
    for gravity, start, patched in (
        ("none", "moving", False), ("none", "moving", True), ("none", "at rest", True),
        ("-y", "moving", False), ("-y", "moving", True), ("-y", "at rest", False), ("-y", "at rest", True), ("-y", "offset", False),
        ("+y", "moving", True),
    )
} | {SAME_SENSE: ("-y", "moving", True, True)}  # fmt: skip
BEST = "gravity -y, start moving, (12)-(13)"
#: Bounds of omega_1, omega_4 [rad/s], the logarithm to base 10 of eps_0, and m (which the paper bounds).
BOUNDS = ((-LIMIT, LIMIT), (-LIMIT, LIMIT), (-7.0, -0.3), (0.0, 5.0))
#: Held values of the profiles.
HELD = {
    "omega_1": (3.0, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.5),
    "omega_4": (-8.5, -7.5, -7.0, -6.5, -6.0, -5.5, -4.5, -3.5),
    "eps_0": (1e-7, 3e-7, 1e-6, 1.5e-6, 2e-6, 3e-6, 1e-5, 1e-4),
    "m": (0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.2, 3.0),
    "size": (0.0, 5.0, 8.0, 9.0, 9.81, 11.0, 13.0, 18.0),
}


def of_values(values: Sequence[float], base: Conditions) -> Conditions:
    """Conditions with speeds and, if there are four values, eps_0 and m; few digits, so that a page can print them."""
    one, four, *rest = (float(f"{value:.4g}") for value in values)
    patch = {"eps_0": float(f"{10.0 ** rest[0]:.3g}"), "m": rest[1]} if rest else {}
    return base._replace(omega_1=one, omega_4=four, **patch)


def miss(values: Sequence[float], base: Conditions) -> float:
    """Mismatch of all ten numbers."""
    return mismatch(outcome(of_values(values, base)))


def maps() -> dict[str, Any]:
    """Count the points of a map of the ideal press that meet the six forces."""
    found = {}
    for name, pull in GRAVITY.items():
        for start in ("moving", "at rest"):
            values = grid(SPEEDS, pull, start == "at rest")
            apart = deviation(values.reshape(-1, values.shape[-1]))
            best = int(apart.argmin())
            four, one = np.unravel_index(best, values.shape[:2])
            found[f"{name}, {start}"] = {
                "below": [int((apart < level).sum()) for level in LEVELS],
                "best": float(apart[best]),
                "speeds": [float(SPEEDS[one]), float(SPEEDS[four])],
                "acceleration": values[four, one, -2:].tolist(),
            }
    return found


def natural() -> list[dict[str, Any]]:
    """Evaluate pairs of round speeds, n pi/4 and whole tens of r/min, that nearly meet the forces without clearance."""
    tens = np.arange(-12, 13) * 10.0 * np.pi / 30.0
    quarters = np.arange(-16, 17) * np.pi / 4.0
    found = []
    for kind, speeds in (("n π/4", quarters), ("10 n r/min", tens)):
        values = grid(speeds, GRAVITY["-y"], at_rest=False)
        apart = deviation(values.reshape(-1, values.shape[-1])).reshape(len(speeds), -1)
        for four, one in np.argwhere(apart < 0.15):
            guess = Conditions(float(speeds[one]), float(speeds[four]), gravity="-y")
            found.append({"kind": kind, "guess": guess, "mismatch": mismatch(outcome(guess))})
    return sorted(found, key=lambda row: row["mismatch"])[:8]


def seeds(gravity: str, start: str, number: int, positive: bool) -> Array:
    """First population: the best speeds of the ideal press, other values at random."""
    rng = np.random.default_rng(SEED)
    values = grid(SPEEDS[::2], GRAVITY[gravity], start == "at rest")
    apart = deviation(values.reshape(-1, values.shape[-1]))
    rig = np.abs(np.log(np.maximum(values[..., -2].ravel(), 1e-3) / 4.366))
    left_out = np.minimum(*np.meshgrid(SPEEDS[::2], SPEEDS[::2])).ravel() <= 0.0 if positive else False
    order = np.argsort(np.where(left_out, np.inf, np.hypot(np.sqrt(6.0) * apart, rig)))[: 2 * POPULATION]
    rows, columns = np.unravel_index(rng.choice(order, POPULATION, replace=False), values.shape[:2])
    chosen = np.stack([SPEEDS[::2][columns], SPEEDS[::2][rows]], axis=1)
    low, high = np.array(BOUNDS[2:]).T
    return np.hstack([chosen, low + (high - low) * rng.random((POPULATION, 2)) ** (1.0, 2.0)])[:, :number]


def fit(gravity: str, start: str, patched: bool, positive: bool) -> dict[str, Any]:
    """Search for the best conditions of a scenario."""
    base, number = Conditions(gravity=gravity, start=start), 4 if patched else 2
    bounds = [(0.0, LIMIT)] * 2 + list(BOUNDS[2:]) if positive else list(BOUNDS)
    found = differential_evolution(
        partial(miss, base=base), bounds[:number], init=seeds(gravity, start, number, positive), maxiter=GENERATIONS, rng=SEED,
        polish=False, tol=0.0, mutation=(0.4, 0.8), recombination=0.8,
    )  # fmt: skip
    values, evaluations = polish(found.x, base)
    guess = of_values(values, base)
    numbers = outcome(guess)
    return {
        "guess": guess, "mismatch": mismatch(numbers), "met": met(numbers), "unknowns": number,
        "evaluations": int(found.nfev) + evaluations, "seed": SEED,
    }  # fmt: skip


def polish(values: Sequence[float], base: Conditions, held: int | None = None) -> tuple[Array, int]:
    """Improve values by the simplex method of Nelder and Mead, one of them held."""
    x = np.array(values, dtype=float)
    free = [k for k in range(len(x)) if k != held]

    def whole(part: Array) -> Array:
        return np.array([part[free.index(k)] if k in free else x[k] for k in range(len(x))])

    lower, upper = np.array(BOUNDS[: len(x)]).T[:, free]
    simplex = np.array([x[free], *(x[free] + step for step in np.diag(np.array([0.1, 0.1, 0.1, 0.1])[free]))])
    settings = {"maxfev": POLISH, "initial_simplex": np.clip(simplex, lower, upper), "xatol": 1e-3, "fatol": 1e-4}
    found = minimize(
        lambda part: miss(whole(part), base), x[free], method="Nelder-Mead", bounds=list(zip(lower, upper, strict=True)),
        options=settings,
    )  # fmt: skip
    return whole(found.x), int(found.nfev)


def profiles(best: Conditions) -> dict[str, Any]:
    """Hold one unknown after another, and fit the others anew, outwards from the best conditions."""
    found: dict[str, Any] = {}
    centre = [best.omega_1, best.omega_4, np.log10(best.eps_0), best.m]
    for place, (name, values) in enumerate(HELD.items()):
        at = getattr(best, name)
        rows = {}
        for side in (sorted(v for v in values if v >= at), sorted((v for v in values if v < at), reverse=True)):
            x = np.array(centre)
            for value in side:
                base, held = best, place if place < len(x) else None
                if held is None:
                    base = best._replace(size=value)
                else:
                    x[held] = np.log10(value) if name == "eps_0" else value
                x, _ = polish(x, base, held)
                rows[value] = miss(x, base)
        found[name] = {"values": sorted(rows), "mismatch": [rows[value] for value in sorted(rows)]}
    return found


def main(words: Sequence[str]) -> None:
    """Compute some parts, or all."""
    data = read("press_conditions")
    makers = {"maps": maps, "natural": natural, "profiles": lambda: profiles(Conditions(*data["fits"][BEST]["guess"]))}
    if not words:
        words = ("maps", "natural", *SCENARIOS, "profiles")
    for word in words:
        if word in makers:
            data[word] = makers[word]()
        elif word in SCENARIOS:
            data.setdefault("fits", {})[word] = fit(*SCENARIOS[word])
        else:
            print(f'docs/make_conditions.py: "{word}" is neither a part nor a scenario', file=sys.stderr)
            raise SystemExit(2)
        keep("press_conditions", data)
        print(word, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
