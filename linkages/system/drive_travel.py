"""How far drives travel, before a run."""

from __future__ import annotations

import numpy as np

from linkages.mechanics.planar.motion import Motions

_SAMPLED = 2000  # number of times at which the drives' rates are compared


def drive_travel(motions: Motions, duration: float) -> float:
    """Compute the fastest drive's travel at its largest rate [rad or m]; an oscillation counts as 2 pi.

    The number of oscillations follows from the total variation of the rate: four times its largest value in each. Rates
    and accelerations are sampled at irregular times up to the duration [s], to avoid aliasing.
    """
    between = np.random.default_rng(0).random(_SAMPLED)
    _, *sampled = motions(duration * np.concatenate([[0.0], np.sort(between), [1.0]]))
    rates, accelerations = np.abs(sampled)
    largest = rates.max(axis=0, initial=0.0)
    turns = accelerations.mean(axis=0) / np.where(largest > 0.0, 4.0 * largest, np.inf)
    ways = duration * np.maximum(largest, 2.0 * np.pi * turns)
    return float(ways.max(initial=0.0))
