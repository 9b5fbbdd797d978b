"""Time the force laws, and measure the film maps: ``python benchmarks/laws.py``."""

from __future__ import annotations

import math
import statistics
import time
import timeit
from functools import partial
from pathlib import Path

import numpy as np
from numba import njit

import linkages
from linkages.laws import CONTACTS, FILMS, FRICTIONS, PARAMETERS, register_contact, register_film, register_friction
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.film_map import CAVITATIONS, GROOVED_CAVITATIONS, MapCase, build_map
from linkages.laws.film.films import film_force
from linkages.laws.film.map_nodes import solve_plain
from linkages.laws.film.map_table import mapped_film
from linkages.laws.film.surface import Groove
from linkages.laws.journal import clearance_force
from linkages.laws.parameters import MODELS

CALLS, ROUNDS = 100_000, 15
#: By kind: the model of a joint that shows such laws, the laws, the one that a user's own is compared with.
KINDS = {
    "film": ("lubricated", FILMS, "long"),
    "contact": ("dry", CONTACTS, "lankarani-nikravesh"),
    "friction": ("dry", FRICTIONS, "coulomb"),
}
#: Parameters that the laws declare.
OWN = {"exponent": 1.5, "damping": 1e3, "v_0": 1e-4, "v_1": 1e-3, "bristle_stiffness": 1e5, "bristle_damping": 0.0}
RATIOS = {"lubricated": (0.0, 0.95), "dry": (1.0, 1.01), "mixed": (0.98, 1.0)}  # of eccentricity, by model


def joint(model, film="long", contact="lankarani-nikravesh", friction="ambrosio"):
    """One record: Chen 2025, Tables 4 and 5, clearance 0.1 mm."""
    record = np.zeros(1, PARAMETERS)
    values = OWN | {"restitution": 0.9, "coefficient": 0.03, "static": 0.05, "stiffness": 1e10}
    for each in (CONTACTS[contact], FRICTIONS[friction], FILMS[film]):
        each.fill(record[0], values)
    for name, value in {
        "model": MODELS[model], "clearance": 1e-4, "radius": 0.015, "length": 0.04,
        "film": FILMS[film].address, "viscosity": 0.4, "shape_ratio": 7.0,
        "roughness": 5e-7, "asperity_pressure": 1e8, "film_limit": 0.99,  # assumed
    }.items():  # fmt: skip
        record[name] = value
    return record


@njit
def many_joints(joints, table, low, high, count):
    """Evaluate the force pair at penetrations or eccentricities between two eccentricity ratios."""
    total = 0.0
    for i in range(count):
        e = 1e-4 * (low + (high - low) * (0.618 * i % 1.0))
        total += clearance_force(joints[0], table, e, 0.0, 0.1 * (e - 5e-5), 0.01, 1.0, 3.0, (0.1, 0.0, 0.0, 1e-7))[0]
    return total


def force_pair(model, table, **laws):
    """Return function and arguments of the force pair of a joint with these laws."""
    return many_joints, joint(model, **laws), table, *RATIOS[model]


@njit
def many_films(joints, table, count):
    """Evaluate a film alone."""
    total = 0.0
    for i in range(count):
        eps = 0.95 * (0.618 * i % 1.0)
        total += film_force(joints[0], eps, eps - 0.3, 1.0 - eps, 1.0, table)[0]
    return total


def clocked(*runs):
    """Medians of the times of one evaluation, of functions with arguments that take turns [ns]."""
    times = [[] for _ in runs]
    for _ in range(ROUNDS + 1):
        for (function, *arguments), kept in zip(runs, times, strict=True):
            kept.append(timeit.timeit(partial(function, *arguments, CALLS), number=1) / CALLS * 1e9)
    return [statistics.median(kept[1:]) for kept in times]  # the first round compiles


def map_error(rule, slenderness, table, largest, count=300):
    """Largest difference from the solver at random points, in units of |F_long|."""
    random, worst = np.random.default_rng(1), 0.0
    for x, y in random.uniform((0.0, 0.0), (-math.log1p(-largest), math.pi), (count, 2)):
        eps = -math.expm1(-x)
        deps, ew = math.cos(y), 2.0 * math.sin(y) / (1.0 - eps * eps) ** 0.25
        exact = solve_plain(eps, slenderness, rule, np.array([y]))[0]
        scale = math.hypot(*half_film_long(eps, deps, ew, slenderness)[:2])
        f_n, f_t, _ = mapped_film(eps, deps, ew, 0.0, table, False)
        worst = max(worst, math.hypot(f_n / scale - exact[0], f_t / scale - exact[1]))
    return worst


def main():
    print(f"{'film map':24s}{'L/D':>8s}{'build [s]':>12s}{'error, eps < 0.99':>20s}{'eps < 0.999':>14s}")
    for rule in CAVITATIONS:
        for slenderness in (0.25, 4.0 / 3.0, 4.0, 16.0):
            start = time.perf_counter()
            table = build_map(MapCase(slenderness, rule))
            built = time.perf_counter() - start
            near, all_ = (map_error(rule, slenderness, table, largest) for largest in (0.99, 0.999))
            print(f"{rule:24s}{slenderness:8.3g}{built:12.2f}{near:20.1e}{all_:14.1e}")
    print(f"\n{'force pair of a joint':40s}{'[ns]':>8s}")
    cases = [(f"{kind} {name}", model, {kind: name}) for kind, (model, names, _) in KINDS.items() for name in names]
    for name, model, laws in (*cases, ("greenwood-tripp and film", "mixed", {})):
        (taken,) = clocked(force_pair(model, table, **laws))
        print(f"{name:40s}{taken:8.1f}")
    registered_laws(table)
    grooved_films()


def grooved_films():
    """Print what a film with a groove costs: its map, its force pair, and a run of the press beside other films."""
    groove, slenderness = Groove(0.0, math.radians(20.0), 0.8), 4.0 / 3.0
    print(f"\n{'map with a groove':24s}{'build [s]':>12s}{'processor [s]':>15s}{'force pair [ns]':>17s}")
    for rule in GROOVED_CAVITATIONS:
        start, used = time.perf_counter(), time.process_time()
        table = build_map(MapCase(slenderness, rule, (groove,)))
        built, used = time.perf_counter() - start, time.process_time() - used
        (taken,) = clocked(force_pair("lubricated", table, film="finite"))
        print(f"{rule:24s}{built:12.1f}{used:15.1f}{taken:17.1f}")
    keys = {"angle": 0.0, "extent": groove.extent, "length": groove.length}
    films = {"long": {"film": "long"}, "finite": {"film": "finite"}}
    films |= {rule: {"film": "finite", "cavitation": rule, "groove": keys} for rule in GROOVED_CAVITATIONS}
    systems = {
        name: linkages.load(
            Path(__file__).with_name("seven_bar_fast.toml"),
            {f"joints.{joint}.{key}": value for joint in "AB" for key, value in values.items()},
        )
        for name, values in films.items()
    }
    times, steps = {name: [] for name in systems}, {}
    for _ in range(ROUNDS + 1):
        for name, system in systems.items():
            start = time.process_time()
            run = linkages.simulate(system, "compiled")
            times[name].append(time.process_time() - start)
            steps[name] = len(run.time) - 1
    print(f"\n{'run of the press, film':24s}{'steps':>8s}{'processor [ms]':>16s}{'over the long film':>20s}")
    for name, taken in times.items():  # the first round compiles
        ratio = statistics.median(np.divide(taken[1:], times["long"][1:]))
        print(f"{name:24s}{steps[name]:8d}{1e3 * statistics.median(taken[1:]):16.1f}{ratio:20.2f}")


def registered_laws(table):
    """Print the cost of user-defined laws against the same built-in ones."""

    def lankarani_nikravesh(delta, ddelta, ddelta0, joint):
        ratio = min(max(ddelta / max(ddelta0, 1e-6), -joint.damping_limit), joint.damping_limit)
        return joint.stiffness * delta * math.sqrt(delta) * (1.0 + joint.hysteresis * ratio)

    def coulomb(v, joint):
        return joint.mu_d * math.tanh(v / joint.v_1)

    def long_film(eps, deps, ew, slenderness):
        return half_film_long(eps, deps, ew, slenderness)

    register_contact("mine", lankarani_nikravesh, factor=CONTACTS["lankarani-nikravesh"].factor)
    register_film("mine", long_film)
    register_friction("mine", coulomb)
    print(f"\n{'registered against built in':40s}{'[ns]':>8s}{'[ns]':>8s}{'ratio':>8s}")
    pairs = {}
    for kind in ("contact", "friction", "film"):
        model, _, other = KINDS[kind]
        pairs[f"{kind}, force pair"] = [force_pair(model, table, **{kind: name}) for name in ("mine", other)]
    pairs["film alone"] = [(many_films, joint("lubricated", film=name), table) for name in ("mine", "long")]
    for name, runs in pairs.items():
        mine, built_in = clocked(*runs)
        print(f"{name:40s}{mine:8.1f}{built_in:8.1f}{mine / built_in:8.2f}")


if __name__ == "__main__":
    main()
