"""The fields of a result that follow from a fit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from linkages import RunError
from linkages.base.arrays import Array
from linkages.input.files.writing import finite
from optim.identify.accuracy import ErrorOfRuns
from optim.identify.certainty import Certainty, interval
from optim.identify.correlation import DOUBT
from optim.identify.doubts import ASSUMED, correlated, doubts, mixture_text
from optim.identify.fit import Fitted, agreeing
from optim.identify.numerics import CONTENT_NEARLY
from optim.identify.plan import missing_sensors
from optim.identify.residuals import Residuals
from optim.identify.result import (
    Alternative,
    ColumnNumbers,
    Compared,
    Correlations,
    Curve,
    Interval,
    Nuisance,
    Parameter,
    Prediction,
    Residual,
    Stage,
    Starts,
)
from optim.identify.statistics import NAMES, Statistics


def content_of(
    residuals: Residuals, found: Fitted, judged: Certainty, share: float, runs: ErrorOfRuns
) -> dict[str, Any]:
    """Return the fields of a result that follow from a fit, by name."""
    n, names = len(residuals.active), residuals.names
    channels = [f"{m.name}.{c.name}" for m in residuals.task.measurements for c in m.channels]
    groups = residuals.groups(found.horizon)
    deviations = [x for one in residuals.deviations for x in one]
    rms = [
        float(np.sqrt(np.mean(found.evaluated.residual[rows] ** 2))) if rows.stop > rows.start else None
        for _, rows in groups
    ]
    open_ones = [
        mixture_text(residuals, mixture)
        for value, mixture in zip(judged.singular, judged.mixtures, strict=True)
        if value < 1.0
    ]
    rate = 1.0 / float(np.median(np.diff(residuals.task.measurements[0].channels[0].times)))
    sensors = []
    if open_ones and not residuals.budget.late:
        try:
            sensors = missing_sensors(residuals, found.z, found.evaluated.jacobian, rate)
        except RunError:  # the machine does not run as long as the samples
            sensors = []
    scale = judged.deviations
    known = np.isfinite(scale)
    correlation = np.where(np.outer(known, known), judged.covariance / np.outer(scale, scale), np.nan)
    return {
        "parameters": parameters(residuals, found, judged),
        "nuisance": _sensors(residuals, found.z, judged),
        "residual": Residual(
            columns=channels,
            rms=[None if r is None else r * d for r, d in zip(rms, deviations, strict=True)],
            deviation=deviations,
            samples=[rows.stop - rows.start for _, rows in groups],
            autocorrelation_time=judged.times,
            chi_square=judged.tests["chi_square"],
            chi_square_probability=judged.tests["chi_square_probability"],
            whiteness=judged.tests["whiteness"],
            normality=judged.tests["normality"],
            model_error=[
                None if x is None else x * d for x, d in zip(judged.tests["model_error"], deviations, strict=True)
            ],
        ),
        "assumed": ASSUMED,
        "accuracy": runs.described(),
        "correlated": correlated(residuals, judged),
        "correlation": Correlations(names=names, matrix=[[finite(x) for x in row] for row in correlation]),
        "prediction": prediction(residuals, found, share),
        "singular_values": judged.singular.tolist(),
        "mixtures": open_ones,
        "sensors": sensors,
        "fitted_until": found.horizon,
        "warnings": doubts(residuals, found, judged) + runs.warnings(residuals.task.file.fit.time),
        "history": [Stage(*row) for row in found.history],
        "curves": {} if isinstance(residuals, Statistics) else _curves(residuals, found),
        "statistics": _statistics(residuals, found.z),
        "values": dict(zip(names[:n], residuals.values(found.z).tolist(), strict=True)),
    }


def parameters(residuals: Residuals, found: Fitted, judged: Certainty) -> dict[str, Parameter]:
    """Return value, deviation and interval of each unknown by name."""
    values, slopes, result = residuals.values(found.z), residuals.slopes(found.z), dict[str, Parameter]()
    for k, j in enumerate(residuals.active):
        deviation, known = float(judged.deviations[k]), bool(judged.told[k])
        ends = interval(residuals, found.z, k, deviation, judged.freedom) if known else None
        result[residuals.task.names[j]] = Parameter(
            path=residuals.task.paths[j],
            value=float(values[k]),
            unit=residuals.task.units()[j],
            deviation=deviation * float(slopes[k]) if known else None,
            interval=None if ends is None else Interval(*ends),
            identifiable=bool(judged.identifiable[k]),
        )
    return result


def _sensors(residuals: Residuals, z: Array, judged: Certainty) -> dict[str, Nuisance]:
    """Return fitted gains, offsets and shifts as the file defines them, with their deviations."""
    result: dict[str, Nuisance] = {}
    n = len(residuals.active)
    for k, (kind, m, c) in enumerate(residuals.places, n):
        one = residuals.task.measurements[m]
        gradient = np.zeros(len(z))
        if kind == "shift":
            name, value, gradient[k] = f"{one.name}.shift", float(z[k]), 1.0
        else:
            factor, bias = residuals.sensor(z, "factor", m, c), residuals.sensor(z, "bias", m, c)
            at = {p.kind: i for i, p in enumerate(residuals.places, n) if (p.measurement, p.channel) == (m, c)}
            name = f"{one.name}.{one.channels[c].name}." + ("gain" if kind == "factor" else "offset")
            factor = factor or math.inf  # an output without effect on the column
            value = 1.0 / factor if kind == "factor" else -bias / factor
            if kind == "factor":
                gradient[k] = -1.0 / factor**2
            else:
                gradient[k] = -1.0 / factor
                if "factor" in at:
                    gradient[at["factor"]] = bias / factor**2
        known = gradient != 0.0
        variance = float(gradient[known] @ judged.covariance[np.ix_(known, known)] @ gradient[known])
        deviation = finite(math.sqrt(max(variance, 0.0)) if variance == variance else math.nan)
        result[name] = Nuisance(value=value, deviation=deviation)
    return result


def prediction(residuals: Residuals, found: Fitted, share: float) -> Prediction | None:
    """Root mean square of the residuals after the fitted part, by column; None if nothing is predicted."""
    if share == 0.0:
        return None
    evaluated = residuals(found.z)
    result: dict[str, float | None] = {}
    groups, k = residuals.groups(math.inf), 0
    for m, one in enumerate(residuals.task.measurements):
        for c, channel in enumerate(one.channels):
            rows = groups[k][1]
            left = evaluated.residual[rows][residuals.used(channel, found.horizon).stop :] * residuals.deviations[m][c]
            good = len(left) and not evaluated.reason
            result[f"{one.name}.{channel.name}"] = float(np.sqrt(np.mean(left**2))) if good else None
            k += 1
    return Prediction(**{"from": found.horizon}, rms=result)


def _statistics(residuals: Residuals, z: Array) -> dict[str, Compared]:
    """Return measured and computed statistics by column and name; none if samples are compared."""
    if not isinstance(residuals, Statistics):
        return {}
    return {
        column: Compared(**{key: ColumnNumbers(**dict(zip(NAMES, row, strict=True))) for key, row in rows.items()})
        for column, rows in residuals.compared_numbers(z).items()
    }


def best_prediction(models: Mapping[str, Alternative], residuals: Residuals) -> str:
    """Return the name of the model whose prediction has the least sum of squares, in deviations of the columns."""
    misses = _misses(models, residuals)
    return min(misses, key=lambda name: misses[name])


def other_laws(models: Mapping[str, Alternative], residuals: Residuals) -> dict[str, float]:
    """Return how far each unknown lies from this model's value in those that predict nearly as well as the best one.

    It estimates the error of a value that comes from the choice of a law.
    """
    misses, found = _misses(models, residuals), dict[str, float]()
    for name in (name for name in models if name != "this" and misses[name] <= CONTENT_NEARLY * min(misses.values())):
        for key, one in models[name].parameters.items():
            away = abs(one.value - models["this"].parameters[key].value)
            found[key] = max(away, found.get(key, 0.0))
    return found


def _misses(models: Mapping[str, Alternative], residuals: Residuals) -> dict[str, float]:
    """Return the sums of squares of the predictions, in deviations of the columns."""
    deviations, misses = [x for one in residuals.deviations for x in one], {}
    for name, one in models.items():
        assert one.prediction is not None  # alternatives are compared by it
        left = [math.inf if x is None else x for x in one.prediction.rms.values()]
        misses[name] = sum((x / deviation) ** 2 for x, deviation in zip(left, deviations, strict=True))
    return misses


def _curves(residuals: Residuals, found: Fitted) -> dict[str, Curve]:
    """Return times, measured and computed samples of the fitted part, for figures: some thousand of each column."""
    curves, k = {}, 0
    groups = residuals.groups(found.horizon)
    for m, one in enumerate(residuals.task.measurements):
        for c, channel in enumerate(one.channels):
            rows, part = groups[k][1], residuals.used(channel, found.horizon)
            step = max(1, (part.stop - part.start) // 4000)
            left = found.evaluated.residual[rows] * residuals.deviations[m][c]
            measured = channel.filtered(channel.raw[part])
            curves[f"{one.name}.{channel.name}"] = Curve(
                unit=channel.unit,
                time=channel.times[part][::step].tolist(),
                measured=measured[::step].tolist(),
                computed=(measured - left)[::step].tolist(),
            )
            k += 1
    return curves


def agreement(all_starts: list[Fitted], best: Fitted, judged: Certainty) -> tuple[Starts, list[str]]:
    """Return how many starts have ended at the best chi-square, and a warning if one has that no deviation confirms."""
    costs = [one.cost for one in all_starts]
    same = agreeing(all_starts, best)
    starts = Starts(count=len(costs), same=same, chi_square=[finite(x) for x in costs])
    explained = [p is not None and p >= DOUBT for p in judged.tests["chi_square_probability"]]
    if len(costs) > 1 and same == 1 and not all(explained):
        return starts, ["one start only has found these values: give more starts, or narrower limits"]
    return starts, []
