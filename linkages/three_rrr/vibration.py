"""The elastic response with vibration over the whole motion, with stress: extremes in spans of time are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from linkages.base.arguments import validated
from linkages.base.arrays import Array
from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.response import Response, ResponseStart, march
from linkages.three_rrr.stress import link_stress, platform_stress

SPANS = 720


@dataclass(frozen=True)
class Vibration:
    """Extremes of the response in n equal spans of the motion; made by `vibrate`.

    Attributes
    ----------
    time : (n,) array
        Middle of each span [s].
    steps : int
        Time steps of the whole motion.
    platform : (2, n, 3) array
        Least and largest elastic displacement of the platform: x, y [m], rotation [rad].
    fibre : dict of (2, n, 3) arrays
        Least and largest stress in the outer fibre at the side of +v, for each link: at the first pivot, in the middle,
        at the second pivot [Pa].
    largest : dict of str to float
        Largest magnitude of the stress anywhere, at any time, for each link [Pa].
    plate : (2, n, 3) array or None
        Least and largest values of the principal stresses and of the largest shear in the platform [Pa]; None if it is
        rigid.
    """

    time: Array
    steps: int
    platform: Array
    fibre: dict[str, Array]
    largest: dict[str, float]
    plate: Array | None


@validated
def vibrate(
    model: FiniteElementModel,
    branch: AssemblyBranch,
    start: ResponseStart = "rest",
    radius: float = 1.0,
    steps_per_period: float = 40.0,
    progress: Callable[[float], None] | None = None,
) -> Vibration:
    """Run the whole motion by the generalised-alpha method; memory does not grow with its length.

    Start and radius as in `linkages.three_rrr.response.march`; steps are counted in the shortest period of the first
    mode over the motion.
    """
    end = float(branch.times[-1])
    first = float(frequencies(model, branch.motion(np.linspace(0.0, end, 181)), 1).max())
    steps = max(int(np.ceil(end * first * steps_per_period)), SPANS)
    times = np.linspace(0.0, end, steps + 1)
    names = [link.name for link in model.links]
    found = np.empty((2, SPANS, 3 * (2 + len(names))))
    found[0], found[1] = np.inf, -np.inf
    largest, done = np.zeros(len(names)), 0
    for part in march(model, branch, times, start, radius):
        values, peaks = _quantities(model, part)
        largest = np.maximum(largest, peaks)
        span = np.minimum(np.arange(done, done + len(values)) * SPANS // steps, SPANS - 1)
        np.minimum.at(found[0], span, values)
        np.maximum.at(found[1], span, values)
        done += len(values)
        if progress is not None:
            progress(done / len(times))
    platform, plate, *fibres = np.split(found, 2 + len(names), axis=2)
    return Vibration(
        (np.arange(SPANS) + 0.5) * end / SPANS,
        steps,
        platform,
        dict(zip(names, fibres, strict=True)),
        dict(zip(names, largest.tolist(), strict=True)),
        None if model.rigid else plate,
    )


def _quantities(model: FiniteElementModel, response: Response) -> tuple[Array, Array]:
    """Displacement, plate's stress and each link's at three places (N, 3 (2 + 6)); each link's largest stress (6,)."""
    stress = link_stress(model, response)
    plate = np.zeros((len(response.u), 3))
    if not model.rigid:
        found = platform_stress(model, response)
        plate = np.column_stack([found.first, found.second, found.largest_shear])
    fibres = [link.fibre[:, [0, len(link.s) // 2, -1]] for link in stress]
    return np.hstack([response.platform, plate, *fibres]), np.array([link.largest.max() for link in stress])
