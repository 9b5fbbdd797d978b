"""Time the force laws, and measure the film maps: ``python benchmarks/laws.py``."""

from __future__ import annotations

import math
import time

import numpy as np
from numba import njit

from linkages.laws.contact import CONTACTS, contact_force
from linkages.laws.film import half_film_long
from linkages.laws.film_map import CAVITATIONS, build_map, finite_film, solve_scaled
from linkages.laws.films import FILMS, film_force
from linkages.laws.mixed import asperity_force

CALLS = 1_000_000


@njit
def many_films(code, table, count):
    total = 0.0
    for i in range(count):
        eps = 0.95 * (0.618 * i % 1.0)
        total += film_force(code, eps, math.cos(i), math.sin(i), 1.0, table)[0]
    return total


@njit
def many_contacts(code, count):
    total = 0.0
    for i in range(count):
        delta = 1e-6 * (0.618 * i % 1.0)
        total += contact_force(code, delta, math.sin(i), 1.0, 1e10, 1.5, 0.9, 1e3, 3e-4, 7.0, 1.0)
    return total


@njit
def many_asperities(count):
    total = 0.0
    for i in range(count):
        total += asperity_force(0.98 + 0.02 * (0.618 * i % 1.0), 1e-4, 0.015, 0.04, 5e-7, 1e8)
    return total


def clock(function, *arguments, calls=CALLS):
    function(*arguments, 1)
    start = time.perf_counter()
    function(*arguments, calls)
    return (time.perf_counter() - start) / calls * 1e6


def map_error(rule, slenderness, table, largest, count=300):
    """Largest difference from the solver at random points, in units of |F_long|."""
    random, worst = np.random.default_rng(1), 0.0
    for x, y in random.uniform((0.0, 0.0), (-math.log1p(-largest), math.pi), (count, 2)):
        eps = -math.expm1(-x)
        deps, ew = math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25
        exact = solve_scaled(eps, slenderness, rule, np.array([y]))[0]
        scale = math.hypot(*half_film_long(eps, deps, ew, slenderness)[:2])
        f_n, f_t, _ = finite_film(eps, deps, ew, table)
        worst = max(worst, math.hypot(f_n / scale - exact[0], f_t / scale - exact[1]))
    return worst


def main():
    print(f"{'film map':24s}{'L/D':>8s}{'build [s]':>12s}{'error, eps < 0.99':>20s}{'eps < 0.999':>14s}")
    for rule in CAVITATIONS:
        for slenderness in (0.25, 4.0 / 3.0, 4.0):
            start = time.perf_counter()
            table = build_map(slenderness, rule)
            built = time.perf_counter() - start
            near, all_ = (map_error(rule, slenderness, table, largest) for largest in (0.99, 0.999))
            print(f"{rule:24s}{slenderness:8.3g}{built:12.2f}{near:20.1e}{all_:14.1e}")
    print(f"\n{'evaluation':24s}{'[us]':>8s}")
    for name, film in FILMS.items():
        print(f"{name:24s}{clock(many_films, film.code, table):8.3f}")
    for name, law in CONTACTS.items():
        print(f"{name:24s}{clock(many_contacts, law.code):8.3f}")
    print(f"{'greenwood-tripp':24s}{clock(many_asperities, calls=CALLS // 10):8.3f}")


if __name__ == "__main__":
    main()
