"""Derivatives of the state at t = 0 with respect to values, which the closed ideal linkage determines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.model import error_scale, start_state
from linkages.engines.compiled.neighbours import PAIRS, Neighbours
from linkages.kernel import Array, Records
from linkages.kernel.block import Duplicate
from linkages.planar.bodies import Bodies
from linkages.planar.closure import close, consistent_rates
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

    Where the drives determine the position, neighbouring positions are found from the nominal one, by closing its loops
    with numbers of the bodies that follow the value. Otherwise neighbouring systems are assembled.
    """
    scale = error_scale(system)
    followed = _follower(system) if _is_determined(system) else None
    rates = [None if followed is None else followed(near) for near in nearby]
    found = [
        near.derivative(lambda one: start_state(one) / scale, True) * scale if rate is None else rate
        for near, rate in zip(nearby, rates, strict=True)
    ]
    return np.reshape(found, (len(found), len(scale))).T.copy()


def _is_determined(system: System) -> bool:
    """Tell whether the loops of the tree and the drives alone determine the start."""
    tree, experiment = system.tree, system.experiment
    simple = experiment.start == "centred" and not tree.flexible
    return simple and not (tree.powered and tree.play) and bool(np.isfinite(system.assembly.quality))


def _follower(system: System) -> Callable[[Neighbours], Array | None]:
    """Make the function that differentiates the start with respect to a value; None where the loops do not close."""
    tree, assembly = system.tree, system.assembly
    moved, ny = np.concatenate([tree.driven_dofs, tree.powered_dofs]), len(start_state(system))
    free, still = without(tree.closing_dofs, moved), np.zeros(tree.size)
    numbers = Duplicate(_closure(system))
    bodies, rows, offset, places, speeds = numbers.value

    def differentiate(near: Neighbours) -> Array | None:
        found = np.zeros(ny)
        if all(map(keeps_start, near.along)):
            return found
        rates = near.rates(_closure)
        initial, h = numbers.initial[rates.places], _STEP * near.magnitude
        closed = True
        for place, weight in zip(*PAIRS, strict=True):
            numbers.numbers[rates.places] = initial + place * h * rates.rates
            q, v = assembly.q.copy(), np.zeros(tree.size)
            q[moved], v[moved] = places, speeds
            closed = closed and bool(close(bodies, rows, offset, free, tree.extent, q))
            consistent_rates(bodies, rows, free, q, v, still)
            state = np.concatenate([q[tree.free_dofs], v[tree.free_dofs]])
            found[: len(state)] += weight / h * state
        numbers.numbers[rates.places] = initial
        return found if closed else None

    return differentiate
