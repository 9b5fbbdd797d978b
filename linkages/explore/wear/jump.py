"""A jump: profiles worn by a block's loads over many cycles."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import RunError
from linkages.explore.wear.measure import LoadSamples, Removed, Wearing, depths_of, equal_works
from linkages.laws.wear.archard import FRACTION, wear_away

_SWEEPS = (1, 1000)
_MISSED = 0.01  # largest fraction of the work without a found journal position


def between(before: LoadSamples, after: LoadSamples, part: float) -> dict[str, Array]:
    """Mix the loads of two blocks: a fraction `part` of the cycles is like the second."""
    found = {}
    for name in after:
        lines = np.concatenate([before[name], after[name]])
        lines[:, 6] *= np.repeat([1.0 - part, part], [len(before[name]), len(after[name])])
        found[name] = equal_works(lines[lines[:, 6] > 0.0])
    return found


def work_of(loads: LoadSamples, joint: str) -> float:
    """Compute the integral of N |v_t| dt over a mean cycle [N m]."""
    return float(loads[joint][:, 6].sum())


def worn(joints: tuple[Wearing, ...], removed: Removed, loads: LoadSamples, cycles: float) -> dict[str, Array]:
    """Compute the profiles after `cycles` cycles of a block's loads; RunError if no journal positions are found."""
    result = {}
    for joint in joints:
        lost, samples = removed[joint.name].copy(), loads[joint.name].copy()
        result[joint.name] = lost
        if len(samples) == 0:
            continue
        k = np.array(joint.coefficients) * cycles
        # repetitions such that deposits are small against their overlaps, except for a tenth of the work
        parts = (
            k.sum() * samples[:, 6] / (FRACTION * joint.radius * joint.length * np.hypot(samples[:, 4], samples[:, 5]))
        )
        order = np.argsort(parts)
        reached = np.cumsum(samples[order, 6])
        sweeps = int(np.clip(parts[order][np.searchsorted(reached, 0.9 * reached[-1])], *_SWEEPS)) + 1
        journal = joint.radius - joint.clearance
        missed = wear_away(samples, joint.reach, (joint.radius, journal), joint.length, (k[0], k[1]), sweeps, lost)
        if missed > _MISSED:
            raise RunError(f"joint {joint.name}: no position found for {missed:.0%} of its loads; use more nodes")
    return result


def difference(joints: tuple[Wearing, ...], one: Removed, other: Removed) -> float:
    """Compute the largest difference of depth between two sets of profiles [m]."""
    return max(float(np.abs(depths_of(j, one[j.name]) - depths_of(j, other[j.name])).max()) for j in joints)


def deepest(joints: tuple[Wearing, ...], removed: Removed) -> float:
    """Compute the largest depth over the bearing's radius."""
    return max(float(depths_of(joint, removed[joint.name]).max()) / joint.radius for joint in joints)
