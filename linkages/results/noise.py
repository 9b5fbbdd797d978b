"""Rounding level of outputs, below which a value counts as zero."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from linkages.outputs.registry import unit
from linkages.system import System

#: Rounding of an output over its natural magnitude: some thousand units in the last place.
ROUNDING = 1e-12


def noise(system: System, names: Iterable[str]) -> dict[str, float]:
    """Estimate the rounding of outputs, in their units.

    The natural magnitude of an output follows from its unit and from the length, mass, rate and weight of the linkage:
    length x rate^2 for an acceleration; mass x length x rate^2, or the weight, for a force. It is zero for outputs with
    another unit.

    Examples
    --------
    >>> import linkages
    >>> from linkages.results.noise import noise
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"))
    >>> noise(system, ["slider7.vx"])["slider7.vx"] < 1e-11  # m/s
    True
    """
    length, rate = system.tree.extent, system.motion_rate
    acceleration = length * rate**2 + float(np.linalg.norm(system.gravity))
    force = sum(link.mass for link in system.mechanism.links) * acceleration
    scales = {
        "1": 1.0, "m": length, "rad": 1.0, "m/s": length * rate, "rad/s": rate,
        "m/s2": acceleration, "rad/s2": acceleration / length,
        "N": force, "N m": force * length, "J": force * length, "W": force * length * rate,
    }  # fmt: skip
    return {name: ROUNDING * scales.get(unit(system, name), 0.0) for name in names}
