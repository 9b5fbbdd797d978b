"""Limits that few or no machines of a sample exceed: the share beyond each, its interval, and the unknown part."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr, ndtri

from optim.evaluate.limits import Limit
from optim.problem.study import Array
from optim.search import numerics
from optim.search.rare_shares import (
    CHAINS,
    Climb,
    DesignPoint,
    Sampled,
    design_point,
    importance_sampling,
    subset_simulation,
)
from optim.search.sampled_machines import Sample, SampledMachines
from optim.search.tolerance_result import Climbed, Interval, MostProbable, QuantityStatistics, Rare, Weighted

_FEWEST = 5 * CHAINS  # machines from which a search starts


def chaotic(deviation: float, scattered: float | None) -> bool:
    """Tell whether derivatives of a quantity mean nothing, as a tiny change of the values scatters it too."""
    return (scattered or 0.0) > math.sqrt(numerics.RARE_LIMITS_CHAOTIC) * deviation


def rare_limits(
    machines: SampledMachines, sample: Sample, quantities: Mapping[str, QuantityStatistics]
) -> dict[str, Rare]:
    """Find the shares beyond limits that few or no machines of the sample exceed, by limit.

    Each has ``share`` and ``interval``, None if there is none, and ``unknown``: why, or what is doubtful.
    """
    excess, found = machines.excess(sample.values), dict[str, Rare]()
    for k, limit in enumerate(machines.limits):
        if limit.equality or (excess[:, k] > 0.0).sum() > numerics.RARE_LIMITS_RARE * len(excess):
            continue
        why = _impossible(len(excess), limit, quantities[limit.name])
        found[limit.key] = _nothing(why) if why else _beyond(machines, sample, k, excess[:, k])
    return found


def _impossible(total: int, limit: Limit, report: QuantityStatistics) -> str:
    """Tell why no machines are sought beyond a limit; nothing if they are."""
    if total < _FEWEST:
        return f"{total} machines are too few to search from; run {_FEWEST} or more"
    if not report.deviation or report.mean is None:
        return "the quantity is the same for all machines that ran"
    if chaotic(report.deviation, report.unpredictable_deviation):
        return "in chaotic machines a change of the values by 1e-6 decides which are beyond; count more machines"
    away = abs(limit.value - report.mean) / report.deviation
    return (
        f"the limit is {away:.0f} deviations from the mean; it was not sought"
        if away > numerics.RARE_LIMITS_FAR
        else ""
    )


def _nothing(why: str) -> Rare:
    return Rare(share=None, interval=None, unknown=why)


def _beyond(machines: SampledMachines, sample: Sample, k: int, values: Array) -> Rare:
    """Find the share beyond limit k from the excess of the sample's machines (m,)."""
    rng = np.random.default_rng([machines.seed, k])

    def excess(normal: Array) -> Array:
        return machines.excess(machines.run(machines.scatter.values(normal))[0])[:, k]

    climb = subset_simulation(excess, sample.normal, values, rng)
    if climb.points is None:
        return _unreached(climb, machines.settings.confidence)
    point = _design_point(machines, k, climb.points)
    usable = None if point is None or not point.converged or point.beta <= 0.0 else point.normal
    sampled = importance_sampling(excess, climb.points, usable, rng)
    entry = judged(climb, sampled, machines.settings.confidence)
    return entry.model_copy(update={"failed": sampled.failed, "form": _form(machines, point)})


def _unreached(climb: Climb, confidence: float) -> Rare:
    """Report a climb that ended before the limit."""
    if climb.stuck:
        return _nothing("the quantity has one value for many machines, beyond which the search does not climb")
    most = climb.share * math.exp(_width(confidence) * climb.error)
    return Rare(share=None, interval=Interval(0.0, most), unknown="the search ended before the limit")


def judged(climb: Climb, sampled: Sampled, confidence: float) -> Rare:
    """Combine both estimates: importance sampling, or all that either allows where they contradict each other."""
    width = _width(confidence)
    wide = _interval(climb.share, climb.error, width)
    subset, weighted = Climbed(share=climb.share, interval=wide), Weighted(**sampled._asdict())
    if sampled.share > 0.0:
        error = sampled.error / sampled.share
        narrow = _interval(sampled.share, error, width)
        if abs(math.log(sampled.share / climb.share)) <= numerics.RARE_LIMITS_APART * math.hypot(error, climb.error):
            return Rare(share=sampled.share, interval=narrow, unknown="", subset=subset, sampled=weighted)
        wide = Interval(min(wide.lower, narrow.lower), max(wide.upper, narrow.upper))
    unknown = f"two estimates differ, {climb.share:.2g} and {sampled.share:.2g}; the interval covers both"
    return Rare(share=climb.share, interval=wide, unknown=unknown, subset=subset, sampled=weighted)


def _interval(share: float, error: float, width: float) -> Interval:
    """Return the interval of a share whose logarithm has a standard error."""
    return Interval(share * math.exp(-width * error), min(share * math.exp(width * error), 1.0))


def _width(confidence: float) -> float:
    """Return half the width of an interval, in standard errors."""
    return float(ndtri(0.5 + 0.5 * confidence))


def _design_point(machines: SampledMachines, k: int, beyond: Array) -> DesignPoint | None:
    """Search the most probable machine beyond limit k, from the nearest one known; None if one has no value."""
    scatter, limit, column = machines.scatter, machines.limits[k], machines.columns[k]

    def excess(normal: Array) -> float:
        value = float(machines.excess(machines.run(scatter.values(normal[None]))[0])[0, k])
        return value if math.isfinite(value) else math.nan  # a failed run

    def slopes(normal: Array) -> Array:
        x = scatter.values(normal[None])[0]
        return np.asarray(
            limit.sign / limit.size * (machines.rates(x)[column] * scatter.stretch(normal)) @ scatter.factor
        )

    nearest = beyond[np.argmin(np.sum(beyond**2, axis=1))]
    return design_point(excess, slopes, nearest)


def _form(machines: SampledMachines, point: DesignPoint | None) -> MostProbable | None:
    """Report the most probable machine, and the share of a limit that is a plane there: FORM."""
    if point is None:
        return None
    scatter = machines.scatter
    x = scatter.values(point.normal[None])[0]
    return MostProbable(
        index=point.beta,
        share=float(ndtr(-point.beta)),
        converged=point.converged,
        iterations=point.iterations,
        machine=dict(zip(scatter.names, x.tolist(), strict=True)),
    )
