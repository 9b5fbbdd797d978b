"""Derivatives of the state at t = 0 with respect to values, which the closed ideal linkage determines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Records
from linkages.base.kernel.block import Duplicate
from linkages.engines.compiled.derivatives.neighbours import PAIRS, Neighbours
from linkages.engines.compiled.run.model import start_state
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure import close, consistent_rates
from linkages.system import System
from linkages.system.system import keeps_start
from linkages.system.tree import without

_STEP = 4e-4  # of differences of the fourth order, in parts of the value


class Closure(NamedTuple):
    """Numbers that the start follows: the tree, its closure rows and their values, places and speeds of the drives."""

    bodies: Bodies
    rows: Records
    offset: Array
    places: Array
    speeds: Array


def _closure(system: System) -> Closure:
    tree, experiment = system.tree, system.experiment
    offset, powered = np.zeros(len(tree.closure_rows)), [experiment.drives[name] for name in tree.powered]
    offset[: 2 * len(tree.play)] = [x for name in tree.play for x in experiment.joints[name].offset]
    places, speeds = system.motions.start
    places = np.concatenate([places, [drive.angle for drive in powered]])
    speeds = np.concatenate([speeds, [drive.speed or 0.0 for drive in powered]])
    return Closure(tree.bodies, tree.closure_rows, offset, places, speeds)


def start_derivatives(system: System, nearby: Sequence[Neighbours]) -> Array:
    """Differentiate the state at t = 0 with respect to np values, (ny, np).

    Where the loops of the tree and the drives alone determine the position, neighbouring positions are found from the
    nominal one, by closing its loops with numbers that follow the value. Otherwise neighbouring systems are assembled.
    """
    tree, experiment = system.tree, system.experiment
    determined = experiment.start == "centred" and not tree.flexible and not (tree.powered and tree.play)
    numbers = Duplicate(_closure(system)) if determined and np.isfinite(system.assembly.quality) else None
    start = start_state(system)
    found = np.zeros((len(nearby), len(start)))
    for row, near in zip(found, nearby, strict=True):
        if not all(map(keeps_start, near.along)):
            followed = None if numbers is None else _followed(system, near, numbers)
            if followed is None:
                row[:] = near.derivative(start_state)
            else:
                row[: len(followed)] = followed
    return found.T.copy()


def _followed(system: System, near: Neighbours, numbers: Duplicate) -> Array | None:
    """Differentiate positions and rates at the start with respect to a value; None where the loops do not close."""
    tree, (bodies, rows, offset, places, speeds) = system.tree, numbers.value
    moved = np.concatenate([tree.driven_dofs, tree.powered_dofs])
    free, still = without(tree.closing_dofs, moved), np.zeros(tree.size)
    rates, h = near.rates(_closure), _STEP * near.magnitude
    initial, closed, found = numbers.initial[rates.places], True, np.zeros(2 * len(tree.free_dofs))
    for place, weight in zip(*PAIRS, strict=True):
        numbers.numbers[rates.places] = initial + place * h * rates.rates
        q, v = system.assembly.q.copy(), np.zeros(tree.size)
        q[moved], v[moved] = places, speeds
        closed = closed and bool(close(bodies, rows, offset, free, tree.extent, q))
        consistent_rates(bodies, rows, free, q, v, still)
        found += weight / h * np.concatenate([q[tree.free_dofs], v[tree.free_dofs]])
    numbers.numbers[rates.places] = initial
    return found if closed else None
