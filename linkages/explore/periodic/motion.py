"""A periodic motion of a linkage, found by Newton's method on the return map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from linkages.base.arguments import validated
from linkages.base.brief import Brief, counted
from linkages.explore.numerics import MOTION_UNDECIDED
from linkages.explore.periodic.continuation import Settings, Solution, solve
from linkages.explore.periodic.multipliers import Multipliers
from linkages.explore.periodic.return_map import Passage, ReturnMap, least_clearance
from linkages.explore.periodic.settings import ACCURACY, TOLERANCE, check_settings
from linkages.explore.sections import Section
from linkages.system import System


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicMotion(Brief):
    """A periodic motion; made by `periodic_motion` and `linkages.branches`.

    Attributes
    ----------
    periods : int
        Number of common periods of the drives in one period of the motion.
    value : float or None
        The varied value.
    state : dict of str to float
        State at the section, the start of a period of the drives: coordinates ``q.NAME``, rates ``v.NAME``, states,
        and the approach speeds that contacts remember.
    residual : float
        Largest change of a state in a period, over its usual change (some clearances, or its range) [1].
    passage : Passage
        One period of the motion.
    outputs : Section or None
        Outputs of each of the drives' periods, if the motion keeps them; see `section`.
    """

    periods: int
    value: float | None
    state: dict[str, float]
    residual: float
    passage: Passage
    outputs: Section | None = None

    def _facts(self) -> tuple[str, dict[str, str]]:
        stable = {True: "stable", False: "unstable", None: "stability undecided"}[self.stable]
        line = f"period {self.period:g} s ({counted(self.periods, 'period')} of the drives), {stable}"
        largest = f"{np.abs(self.multipliers[0]):.6g}" if len(self.multipliers) else "-"
        return line, {"largest multiplier": largest, "residual": f"{self.residual:.2g}"}

    @property
    def period(self) -> float:
        """Return the period [s]."""
        return self.passage.period

    @property
    def multipliers(self) -> Multipliers:
        """Return the Floquet multipliers, the largest magnitude first; NaN if an impact grazes."""
        return self.passage.multipliers

    @property
    def stable(self) -> bool | None:
        """Check whether all multipliers lie inside the unit circle; None if the largest is on it, or unknown."""
        largest = float(np.abs(self.multipliers).max(initial=0.0))
        return None if not abs(largest - 1.0) > MOTION_UNDECIDED else largest < 1.0

    def section(self, names: Sequence[str]) -> Section:
        """Compute outputs at the end of each of the drives' periods, and their extremes within."""
        return self.passage.section(names, self.periods)


@validated
def periodic_motion(
    system: System, periods: int = 1, transient: int = 50, accuracy: float = ACCURACY, tolerance: float = TOLERANCE
) -> PeriodicMotion:
    """Find a periodic motion: shooting with the exact derivative of the run, from the state after a transient.

    Parameters
    ----------
    system : System
    periods : int
        Number of common periods of the drives in one period of the motion.
    transient : int
        Common periods from the experiment's start to the first guess.
    accuracy : float
        Accuracy of the runs, unless the experiment's is smaller.
    tolerance : float
        Tolerance of the residual.

    Returns
    -------
    PeriodicMotion
        Stable or not; Newton's method finds both.

    Raises
    ------
    InputError
        If the drives have no common period or determine the whole motion, a model does not support it, or a number is
        out of its range.
    RunError
        If a run fails, or Newton's method does not converge.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"))
    >>> motion = linkages.periodic_motion(system, transient=3)
    >>> motion.stable, round(motion.period, 6)
    (True, 0.012)
    """
    check_settings(periods=periods, transient=transient, accuracy=accuracy, tolerance=tolerance)
    found = ReturnMap(system, None, periods, transient, accuracy)
    sizes = found.sizes(least_clearance(system))
    settings = Settings(sizes, 1.0, np.minimum(found.error, sizes), tolerance)
    point = solve(found, found.start, 0.0, settings)
    return made(found, point, None)


def made(found: ReturnMap, point: Solution, value: float | None) -> PeriodicMotion:
    """Make the periodic motion of a point."""
    state = dict(zip(found.names, map(float, point.u), strict=True))
    return PeriodicMotion(found.periods, value, state, point.residual, point.detail)
