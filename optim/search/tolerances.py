"""`tolerances`: which share of machines meets the limits of a study, and which tolerance costs most."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from linkages.base.arguments import Whole, validated
from linkages.input.files.versions import versions
from linkages.input.files.writing import finite
from optim.evaluate.evaluations import OK
from optim.evaluate.evaluator import Evaluator
from optim.problem.scatter import Scatter
from optim.problem.schema import SAMPLING
from optim.problem.study import Array, Study
from optim.search import numerics
from optim.search import tolerance_statistics as statistics
from optim.search.rare_limits import chaotic, rare_limits
from optim.search.recorder import recording
from optim.search.sampled_machines import Sample, SampledMachines, identity_of, settings_of
from optim.search.tolerance_result import (
    Corners,
    FirstOrder,
    Halved,
    Histogram,
    Interval,
    Quantile,
    QuantityStatistics,
    Scattering,
    Share,
    ToleranceResult,
    Variance,
    Yield,
)


@validated
def tolerances(
    study: Study,
    store: Path | None = None,
    *,
    seed: Whole | None = None,
    samples: Whole | None = None,
    evaluator: Evaluator | None = None,
    resume: bool = False,
    progress: Callable[[float], None] | None = None,
) -> ToleranceResult:
    """Run the machines of a study with ``[scatter]``, and judge them by its constraints.

    Parameters
    ----------
    study : Study
        Its algorithm is "scatter".
    store : Path, optional
        File that keeps every machine, ``study.sqlite``; default a temporary one.
    seed, samples : int, optional
        Default the study's. A stored study with fewer machines is extended.
    evaluator : Evaluator, optional
        Default one that runs here, in all threads.
    resume : bool
        Whether the store may exist; it must be of the same study, sequence and seed.
    progress : callable, optional
        Called with the finished part of the machines.

    Returns
    -------
    ToleranceResult
        Attributes and keys of ``tolerances.json``, SI units; see docs/tolerances.md.

    Raises
    ------
    InputError
        If the study has no scatter, or the store cannot be used.
    RunError
        If the disk is full, no machine runs, or relative quantities have no nominal value.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("slidercrank_tolerances"))
    >>> result = optim.tolerances(study, samples=64)
    >>> result.share.value > 0.5  # the yield
    True
    """
    return sampled(study, store, seed, samples, evaluator, resume, progress)[0]


def sampled(
    study: Study,
    store: Path | None,
    seed: int | None,
    samples: int | None,
    evaluator: Evaluator | None,
    resume: bool,
    progress: Callable[[float], None] | None,
) -> tuple[ToleranceResult, Sample]:
    """Return the result and the machines; arguments as of `tolerances`."""
    settings, seed = settings_of(study, samples), study.file.seed if seed is None else seed
    evaluator = Evaluator(study) if evaluator is None else evaluator
    with ExitStack() as stack:
        if store is None:
            store = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "study.sqlite"
        recorder = stack.enter_context(recording(store, identity_of(study, settings, seed), evaluator, resume))
        machines = SampledMachines(study, settings, seed, recorder)
        sample = machines.sample(evaluator, progress or (lambda part: None))
        return _report(machines, sample), sample


def _report(machines: SampledMachines, sample: Sample) -> ToleranceResult:
    study, settings, total = machines.study, machines.settings, len(sample.good)
    failures = {state: sample.status.count(state) for state in dict.fromkeys(sample.status) if state != OK}
    interval = Interval(*statistics.clopper_pearson(int(sample.good.sum()), total, settings.confidence))
    scattered = _chaos(machines, sample)
    rates = machines.rates(study.nominal)
    excess = machines.excess(sample.values)
    violated = {limit.key: int((column > 0.0).sum()) for limit, column in zip(machines.limits, excess.T, strict=True)}
    corners = _corners(machines, sample)
    quantities = {
        name: _quantity(machines, sample, k, scattered[k], rates[k], corners[k] if corners else {})
        for k, (_, name, _) in enumerate(study.quantities)
    }
    own = {"yield": Yield(value=sample.good.mean().item(), interval=interval)}  # a word of Python
    return ToleranceResult(
        study=study.source.stem,
        title=study.title,
        seed=machines.seed,
        algorithm={"name": SAMPLING, **settings.model_dump(mode="json")},
        labels={name: study.label(name) for _, name, _ in study.quantities},
        samples=total,
        failed=sum(failures.values()),
        failures=failures,
        **own,
        violated=violated,
        scatter={name: _value(machines.scatter, k, study.paths[k]) for k, name in enumerate(study.names)},
        outputs=quantities,
        shares={name: entry.alone for name, entry in quantities.items()},
        contributions=_contributions(machines, sample),
        rare=rare_limits(machines, sample, quantities),
        versions=dict(versions("scipy")),
    )


def _value(scatter: Scatter, k: int, path: str) -> Scattering:
    lower, upper = scatter.limits[:, k].tolist()
    mean, deviation = float(scatter.means[k]), float(scatter.deviations[k])
    return Scattering(path=path, mean=mean, deviation=deviation, lower=lower, upper=upper)


def _quantity(
    machines: SampledMachines, sample: Sample, k: int, scattered: float | None, rates: Array, corners: dict[str, Any]
) -> QuantityStatistics:
    """Report the statistics of quantity k; ``unknown`` has a sentence for each that has no value."""
    study, confidence = machines.study, machines.settings.confidence
    quantity = study.quantities[k][2]
    ends = {key: getattr(quantity, key, None) for key in ("at_least", "at_most", "equals")}
    values = sample.values[sample.ran, k]
    limits = {key: end for key, end in ends.items() if end is not None}
    if len(values) < 2:
        said = ["no statistics: fewer than two machines ran"]
        return QuantityStatistics(limits=limits, unknown=said, **corners)
    moments, ordered = statistics.moments(values), np.sort(values)
    counts, edges = statistics.histogram(values)
    variance = _shares(machines, sample, values)
    linear = _first_order(machines, rates, moments["deviation"], scattered)
    quantiles = {str(level): Quantile(*statistics.quantile(ordered, level, confidence)) for level in statistics.LEVELS}
    return QuantityStatistics(
        limits=limits,
        unknown=_missing(scattered, variance, linear),
        mean=moments["mean"],
        mean_error=moments["mean_error"],
        deviation=moments["deviation"],
        deviation_error=moments["deviation_error"],
        quantiles=quantiles,
        capability=statistics.capability(moments["mean"], moments["deviation"], ends["at_least"], ends["at_most"]),
        histogram=Histogram(counts=counts.tolist(), edges=edges.tolist()),
        unpredictable_deviation=scattered,
        variance=variance,
        first_order=linear,
        **corners,
    )


def _missing(scattered: float | None, variance: Variance | None, linear: FirstOrder) -> list[str]:
    """Tell which statistics of a quantity have no value."""
    said = []
    if scattered is None:
        said.append("predictability is unknown: no machine with slightly changed values ran")
    if variance is None:
        said.append("no shares of the variance: the quantity varies in too few machines")
    if linear.why:
        said.append(f"first order says nothing here: {linear.why}")
    return said


def _first_order(machines: SampledMachines, rates: Array, deviation: float, scattered: float | None) -> FirstOrder:
    """Report the scatter of a quantity from its derivatives (n,) at the means; ``unknown`` if they say nothing."""
    linear = statistics.first_order(rates, machines.scatter)
    known = finite(linear.deviation)
    unknown = ""
    if known is None:
        unknown = "the derivatives at the means have no values"
    elif deviation == 0.0:
        unknown = "the quantity does not vary"
    elif chaotic(deviation, scattered):
        unknown = "a change of the values by 1e-6 changes the quantity, which has no derivatives"
    elif linear.deviation < numerics.TOLERANCES_NOTHING * deviation:
        unknown = "the derivatives vanish at the means, or nearly"
    if unknown:
        return FirstOrder(deviation=known, error=None, shares=None, unknown=unknown)
    shares = dict(zip(machines.study.names, linear.shares.tolist(), strict=True))
    return FirstOrder(deviation=known, error=linear.deviation / deviation - 1.0, shares=shares, unknown="")


def _shares(machines: SampledMachines, sample: Sample, values: Array) -> Variance | None:
    """Split the variance of the values of the machines that ran among the scattering values."""
    found = statistics.variance_shares(sample.normal[sample.ran] @ machines.scatter.factor.T, values)
    if found is None:
        return None
    rows = zip(*(part.tolist() for part in found[:4]), strict=True)
    by_name = {
        name: Share(first=first, first_error=first_error, total=total, total_error=total_error)
        for name, (first, first_error, total, total_error) in zip(machines.study.names, rows, strict=True)
    }
    return Variance(values=by_name, unexplained=found.unexplained)


def _chaos(machines: SampledMachines, sample: Sample) -> list[float | None]:
    """Return the deviation of each quantity that a relative change of the values by 1e-6 causes."""
    rows = np.flatnonzero(sample.ran)[: numerics.TOLERANCES_REPEATED]
    if len(rows) == 0:
        return [None] * sample.values.shape[1]
    designs = sample.designs[rows]
    sizes = np.maximum(np.abs(designs), machines.scatter.deviations)
    again, _ = machines.run(designs + numerics.TOLERANCES_CHANGE * sizes)
    with np.errstate(invalid="ignore", over="ignore"):
        change = again - sample.values[rows]
    known = change[np.isfinite(change).all(axis=1)]
    if not len(known):
        return [None] * change.shape[1]
    return [statistics.root_mean_square(column) / math.sqrt(2.0) for column in known.T]


def _corners(machines: SampledMachines, sample: Sample) -> list[dict[str, Any]]:
    """Find the extremes of each quantity at the corners of the tolerance limits; empty if the values are many.

    ``outside`` is the share of machines beyond them: a quantity has extremes inside the limits if it is large.
    """
    n = len(machines.scatter.names)
    if n > numerics.TOLERANCES_CORNERS:
        return []
    corners = np.array(
        [
            [pair[side] for pair, side in zip(machines.scatter.limits.T, sides, strict=True)]
            for sides in product((0, 1), repeat=n)
        ]
    )
    values, found = machines.run(corners)
    reports = []
    for column, machine in zip(values.T, sample.values[sample.ran].T, strict=True):
        known = column[np.isfinite(column)]
        ends = Interval(float(known.min()), float(known.max())) if len(known) else None
        own = {}
        if ends is not None and len(machine):
            own["outside"] = float(np.mean((machine < ends.lower) | (machine > ends.upper)))
        reports.append({"corners": Corners(count=len(corners), range=ends, failed=int(found.failed.sum()), **own)})
    return reports


def _contributions(machines: SampledMachines, sample: Sample) -> dict[str, Halved]:
    """Return the yields that half of each tolerance gives, the best first; None if no machine tells."""
    found = {}
    for k, name in enumerate(machines.scatter.names):
        share, error = statistics.yield_of(
            machines.scatter, machines.scatter.narrowed(k, 0.5), sample.designs, sample.good
        )
        found[name] = Halved(halved=share, error=error)
    return dict(sorted(found.items(), key=lambda entry: -math.inf if (at := entry[1].halved) is None else -at))
