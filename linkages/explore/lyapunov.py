"""Largest Lyapunov exponent: rate of divergence of two close trajectories.

Two trajectories are followed. Many times in each revolution the second is moved close to the first, along the line
between them, and the logarithm of their distance is added. Benettin, Galgani and Strelcyn,
Kolmogorov entropy and numerical experiments, Phys. Rev. A 14 (1976) 2338-2345.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from linkages.base.arguments import Count, Whole, validated
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError
from linkages.elements.analysis import Analysis
from linkages.explore.flow import Flow, lasting, period_of
from linkages.explore.numerics import LYAPUNOV_ACCURACY, LYAPUNOV_BLOCKS
from linkages.system import System


@dataclass(frozen=True, repr=False)
class Exponent(Brief):
    """Largest Lyapunov exponent; made by `largest_exponent`.

    Attributes
    ----------
    growth : (nr,) array
        Natural growth rate in each revolution [1/s].
    period : float
        Period of a revolution [s].
    """

    growth: Array
    period: float

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{self.value:.4g} ± {self.error:.2g} 1/s, {counted(len(self.growth), 'revolution')}"
        return line, {"in a revolution": f"{self.per_revolution:.4g}", "period": f"{self.period:g} s"}

    @property
    def value(self) -> float:
        """Return the exponent: the mean over all revolutions [1/s]."""
        return float(self.growth.mean())

    @property
    def per_revolution(self) -> float:
        """Return the natural logarithm of the growth in one revolution."""
        return self.value * self.period

    @property
    def error(self) -> float:
        """Return the standard error of the mean, from ten nearly independent blocks of revolutions [1/s]."""
        blocks = [block.mean() for block in np.array_split(self.growth, min(LYAPUNOV_BLOCKS, len(self.growth)))]
        return float(np.std(blocks, ddof=1) / np.sqrt(len(blocks))) if len(blocks) > 1 else float("nan")

    @property
    def running(self) -> Array:
        """Return the mean up to each revolution (nr,) [1/s], which shows the convergence."""
        return np.cumsum(self.growth) / np.arange(1, len(self.growth) + 1)


@validated
def largest_exponent(
    system: System,
    revolutions: Count,
    transient: Whole = 0,
    drive: str | None = None,
    distance: float = 1e-7,
    renormalisations: Count = 20,
) -> Exponent:
    """Compute the largest Lyapunov exponent of a driven linkage.

    The distance of two states is the root mean square of their entries' differences, each relative to the scale of
    the engine's error control (`Flow.scale`); states that no formula reads do not count. The trajectories run at an
    accuracy of 1e-4 times that distance, or the experiment's if that is smaller. A drive's phase is not part of the
    state, so the exponent of zero that every flow has along itself does not appear.

    Parameters
    ----------
    system : System
    revolutions, transient : int
        Averaged revolutions, and discarded ones before them; the second trajectory starts with the former.
    drive : str, optional
        Drive that defines a revolution; default: see `linkages.explore.flow.period_of`.
    distance : float
        Distance of the trajectories after each renormalisation [1].
    renormalisations : int
        Renormalisations per revolution; use more if trajectories diverge fast.

    Returns
    -------
    Exponent
        Growth rate in each revolution [1/s], its mean, and the standard error of the mean.

    Raises
    ------
    InputError, AssemblyError
        See `linkages.engines.assessment.simulate`; also if no coordinate is free, or a model does not support it.
    RunError
        If a trajectory fails.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> sticky = system.replaced({"joints.B.friction.coefficient": 0.1})
    >>> exponent = linkages.largest_exponent(sticky, revolutions=4, transient=4)
    >>> exponent.per_revolution < 0.0  # with high friction the linkage forgets its start
    True
    """
    system.check_analysis(Analysis.EXPONENT)
    period = period_of(system, drive)
    if not distance > 0.0:
        raise InputError("argument", "distance", f"is {distance:g}; it must be above zero")
    accuracy = min(system.settings.accuracy, LYAPUNOV_ACCURACY * distance)
    total = transient + revolutions
    tight = lasting(system, total, drive).replaced({"solver.accuracy": accuracy})
    first, second = Flow(tight), Flow(tight)
    model, unread, own = first.runner.model, system.unread_states, system.own_states
    moves = len(model.free) > model.elimination.rank
    counts = np.array([moves] * (len(first.y) - len(own)) + [name not in unread for name in own])
    if not counts.any():
        problem = "they determine the whole motion, so nothing can diverge"
        raise InputError(system.description.source, "drives", problem)
    second.resume(first.t, first.y + distance * counts * first.scale, first.memory, first.step)
    logarithms = np.empty((total, renormalisations))
    for turn in range(total):
        for k in range(renormalisations):
            until = (turn + (k + 1) / renormalisations) * period
            for flow in (first, second):
                flow.reach(until)
            apart = counts * (second.y - first.y)
            size = float(np.sqrt(np.mean((apart / first.scale)[counts] ** 2)))
            logarithms[turn, k] = np.log(size / distance)
            second.resume(first.t, first.y + distance / size * apart, first.memory, first.step)
    return Exponent(logarithms[transient:].sum(axis=1) / period, period)
