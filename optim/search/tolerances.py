"""`tolerances`: which share of machines meets the limits of a study, and which tolerance costs most."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Mapping
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
from optim.search import tolerance_statistics as statistics
from optim.search.rare_limits import chaotic, rare_limits
from optim.search.recorder import recording
from optim.search.sampled_machines import Sample, SampledMachines, identity_of, settings_of

_CHANGE = 1e-6  # relative change of the values that shows how predictable the machines are
_REPEATED = 64  # machines that are run again with this change
_CORNERS = 6  # most values for which all corners of their limits are run
_NOTHING = (
    0.1  # deviation to first order over that of the machines below which it explains 1 % of the variance, or less
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
) -> dict[str, Any]:
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
    dict
        The content of ``tolerances.json``, SI units; see docs/tolerances.md.

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
    >>> result["yield"]["value"] > 0.5
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
) -> tuple[dict[str, Any], Sample]:
    """Return the content of ``tolerances.json``, and the machines; arguments as of `tolerances`."""
    settings, seed = settings_of(study, samples), study.file.seed if seed is None else seed
    evaluator = Evaluator(study) if evaluator is None else evaluator
    with ExitStack() as stack:
        if store is None:
            store = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "study.sqlite"
        recorder = stack.enter_context(recording(store, identity_of(study, settings, seed), evaluator, resume))
        machines = SampledMachines(study, settings, seed, recorder)
        sample = machines.sample(evaluator, progress or (lambda part: None))
        return _report(machines, sample), sample


def _report(machines: SampledMachines, sample: Sample) -> dict[str, Any]:
    study, settings, total = machines.study, machines.settings, len(sample.good)
    failures = {state: sample.status.count(state) for state in dict.fromkeys(sample.status) if state != OK}
    lower, upper = statistics.clopper_pearson(int(sample.good.sum()), total, settings.confidence)
    scattered = _chaos(machines, sample)
    rates = machines.rates(study.nominal)
    excess = machines.excess(sample.values)
    violated = {limit.key: int((column > 0.0).sum()) for limit, column in zip(machines.limits, excess.T, strict=True)}
    quantities = {
        name: _quantity(machines, sample, k, scattered[k], rates[k]) for k, (_, name, _) in enumerate(study.quantities)
    }
    _add_corners(machines, sample, quantities)
    return {
        "study": study.source.stem,
        "title": study.title,
        "seed": machines.seed,
        "algorithm": {"name": SAMPLING, **settings.model_dump(mode="json")},
        "labels": {name: study.label(name) for _, name, _ in study.quantities},
        "samples": total,
        "failed": sum(failures.values()),
        "failures": failures,
        "yield": {"value": sample.good.mean().item(), "interval": [lower, upper]},
        "violated": violated,
        "scatter": {name: _value(machines.scatter, k, study.paths[k]) for k, name in enumerate(study.names)},
        "outputs": quantities,
        "shares": {name: _alone(entry) for name, entry in quantities.items()},
        "contributions": _contributions(machines, sample),
        "rare": rare_limits(machines, sample, quantities),
        "versions": versions("scipy"),
    }


def _alone(entry: Mapping[str, Any]) -> dict[str, float]:
    """Return the share of the variance that each value alone causes."""
    found = entry.get("variance")
    return {} if found is None else {name: row["first"] for name, row in found["values"].items()}


def _value(scatter: Scatter, k: int, path: str) -> dict[str, Any]:
    lower, upper = scatter.limits[:, k].tolist()
    return {
        "path": path,
        "mean": float(scatter.means[k]),
        "deviation": float(scatter.deviations[k]),
        "lower": lower,
        "upper": upper,
    }


def _quantity(
    machines: SampledMachines, sample: Sample, k: int, scattered: float | None, rates: Array
) -> dict[str, Any]:
    """Report the statistics of quantity k; ``unknown`` has a sentence for each that has no value."""
    study, confidence = machines.study, machines.settings.confidence
    quantity = study.quantities[k][2]
    ends = {key: getattr(quantity, key, None) for key in ("at_least", "at_most", "equals")}
    values = sample.values[sample.ran, k]
    report: dict[str, Any] = {"limits": {key: end for key, end in ends.items() if end is not None}, "unknown": []}
    if len(values) < 2:
        report["unknown"].append("no statistics: fewer than two machines ran")
        return report
    report |= statistics.moments(values)
    ordered = np.sort(values)
    counts, edges = statistics.histogram(values)
    report |= {
        "quantiles": {str(level): statistics.quantile(ordered, level, confidence) for level in statistics.LEVELS},
        "capability": statistics.capability(report["mean"], report["deviation"], ends["at_least"], ends["at_most"]),
        "histogram": {"counts": counts.tolist(), "edges": edges.tolist()},
        "unpredictable_deviation": scattered,
        "variance": _shares(machines, sample, values),
        "first_order": _first_order(machines, rates, report["deviation"], scattered),
    }
    report["unknown"] += _missing(report)
    return report


def _missing(report: Mapping[str, Any]) -> list[str]:
    """Tell which statistics of a quantity have no value."""
    said = []
    if report["unpredictable_deviation"] is None:
        said.append("predictability is unknown: no machine with slightly changed values ran")
    if report["variance"] is None:
        said.append("no shares of the variance: the quantity varies in too few machines")
    if report["first_order"]["unknown"]:
        said.append(f"first order says nothing here: {report['first_order']['unknown']}")
    return said


def _first_order(machines: SampledMachines, rates: Array, deviation: float, scattered: float | None) -> dict[str, Any]:
    """Report the scatter of a quantity from its derivatives (n,) at the means; ``unknown`` if they say nothing."""
    linear = statistics.first_order(rates, machines.scatter)
    found = {"deviation": finite(linear.deviation), "error": None, "shares": None, "unknown": ""}
    if found["deviation"] is None:
        return found | {"unknown": "the derivatives at the means have no values"}
    if deviation == 0.0:
        return found | {"unknown": "the quantity does not vary"}
    if chaotic(deviation, scattered):
        return found | {"unknown": "a change of the values by 1e-6 changes the quantity, which has no derivatives"}
    if linear.deviation < _NOTHING * deviation:
        return found | {"unknown": "the derivatives vanish at the means, or nearly"}
    shares = dict(zip(machines.study.names, linear.shares.tolist(), strict=True))
    return found | {"error": linear.deviation / deviation - 1.0, "shares": shares}


def _shares(machines: SampledMachines, sample: Sample, values: Array) -> dict[str, Any] | None:
    """Split the variance of the values of the machines that ran among the scattering values."""
    found = statistics.variance_shares(sample.normal[sample.ran] @ machines.scatter.factor.T, values)
    if found is None:
        return None
    rows = zip(*(part.tolist() for part in found[:4]), strict=True)
    by_name = {
        name: dict(zip(("first", "first_error", "total", "total_error"), row, strict=True))
        for name, row in zip(machines.study.names, rows, strict=True)
    }
    return {"values": by_name, "unexplained": found.unexplained}


def _chaos(machines: SampledMachines, sample: Sample) -> list[float | None]:
    """Return the deviation of each quantity that a relative change of the values by 1e-6 causes."""
    rows = np.flatnonzero(sample.ran)[:_REPEATED]
    if len(rows) == 0:
        return [None] * sample.values.shape[1]
    designs = sample.designs[rows]
    sizes = np.maximum(np.abs(designs), machines.scatter.deviations)
    again, _ = machines.run(designs + _CHANGE * sizes)
    with np.errstate(invalid="ignore", over="ignore"):
        change = again - sample.values[rows]
    known = change[np.isfinite(change).all(axis=1)]
    if not len(known):
        return [None] * change.shape[1]
    return [statistics.root_mean_square(column) / math.sqrt(2.0) for column in known.T]


def _add_corners(machines: SampledMachines, sample: Sample, quantities: Mapping[str, dict[str, Any]]) -> None:
    """Add the least and greatest value of each quantity at the corners of the tolerance limits, of few values.

    ``outside`` is the share of machines beyond them: a quantity has extremes inside the limits if it is large.
    """
    n = len(machines.scatter.names)
    if n > _CORNERS:
        return
    corners = np.array(
        [
            [pair[side] for pair, side in zip(machines.scatter.limits.T, sides, strict=True)]
            for sides in product((0, 1), repeat=n)
        ]
    )
    values, found = machines.run(corners)
    for column, machine, report in zip(values.T, sample.values[sample.ran].T, quantities.values(), strict=True):
        known = column[np.isfinite(column)]
        ends = [float(known.min()), float(known.max())] if len(known) else None
        report["corners"] = {"count": len(corners), "range": ends, "failed": int(found.failed.sum())}
        if ends is not None and len(machine):
            report["corners"]["outside"] = float(np.mean((machine < ends[0]) | (machine > ends[1])))


def _contributions(machines: SampledMachines, sample: Sample) -> dict[str, Any]:
    """Return the yields that half of each tolerance gives, the best first; None if no machine tells."""
    found = {}
    for k, name in enumerate(machines.scatter.names):
        share, error = statistics.yield_of(
            machines.scatter, machines.scatter.narrowed(k, 0.5), sample.designs, sample.good
        )
        found[name] = {"halved": share, "error": error}
    return dict(sorted(found.items(), key=lambda entry: -math.inf if (at := entry[1]["halved"]) is None else -at))
