"""`sensitivity`: Sobol's indices over the bounds, and one variable at a time from the nominal design."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import bootstrap, qmc

from linkages import InputError, RunError
from linkages.base.arguments import Whole, validated
from linkages.input.files.versions import versions
from linkages.input.files.writing import finite
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.limits import in_units
from optim.problem.study import Array, Study
from optim.search import numerics

#: Relative variation below which a quantity counts as independent of the variables: rounding.
CONSTANT = 1e-9


@dataclass(frozen=True)
class SobolIndices:
    """Sobol's indices of nq quantities to n variables, and half-widths of their 95 % confidence intervals."""

    first: Array  # (nq, n) share of the variance that a variable explains alone; NaN where the quantity does not vary
    first_confidence: Array
    total: Array  # (nq, n) share that vanishes if all other variables are known: with interactions
    total_confidence: Array
    mean: Array  # (nq,) mean and standard deviation of the quantity over the bounds
    deviation: Array
    evaluations: int
    failed: int  # designs without values: each takes its sample, n + 2 designs, out of the estimate


def sobol(evaluate: Callable[[Array], Array], lower: Array, upper: Array, samples: int, seed: int) -> SobolIndices:
    """Estimate Sobol's indices of functions of independent variables, uniform between bounds (n,).

    `evaluate` returns quantities (m, nq) of designs (m, n), NaN where a design has failed; it gets samples*(n + 2), the
    samples a power of two. Designs and estimators as in `scipy.stats.sobol_indices`, which takes no failed designs:
    A. Saltelli et al., Variance based sensitivity analysis of model output, Computer Physics Communications 181 (2010)
    259-270, table 2 (b) and (f), on scrambled Sobol points. Confidence intervals are 1.96 standard errors, from
    bootstrap resampling. RunError if fewer than half of the samples are left by failures.
    """
    n, rng = len(lower), np.random.default_rng(seed)
    first, second = np.hsplit(qmc.scale(qmc.Sobol(2 * n, rng=rng).random(samples), *np.tile([lower, upper], 2)), 2)
    mixed = np.where(np.eye(n, dtype=bool)[:, None, :], second, first)  # variable i of page i is the second point's
    designs = np.concatenate([first, second, *mixed])
    values = evaluate(designs)
    good = np.isfinite(values).all(axis=1)
    whole = good.reshape(n + 2, samples).all(axis=0)
    failed = int(np.sum(~good))
    if 2 * whole.sum() < samples:
        raise RunError(f"{failed} of {len(designs)} designs failed: too many for indices; choose narrower bounds")
    kept = values.reshape(n + 2, samples, -1)[:, whole]
    every = kept.reshape(-1, kept.shape[2])
    varies = np.ptp(every, axis=0) > CONSTANT * np.abs(every).max(axis=0)

    def estimate(chosen: NDArray[np.int64]) -> Array:
        return _indices(kept[:, chosen][..., varies])

    found, width = np.full((2, 2, kept.shape[2], n), np.nan)
    if varies.any():
        chosen = np.arange(kept.shape[1])
        found[:, varies] = estimate(chosen)
        resampled = bootstrap((chosen,), estimate, n_resamples=numerics.SENSITIVITY_RESAMPLES, method="basic", rng=rng)
        width[:, varies] = 1.96 * resampled.standard_error
    mean, deviation = every.mean(axis=0), every.std(axis=0)
    return SobolIndices(found[0], width[0], found[1], width[1], mean, deviation, len(designs), failed)


def _indices(values: Array) -> Array:
    """Estimate first-order and total indices (2, nq, n) from values (n + 2, samples, nq): points, then pages."""
    centred = values - values[:2].mean(axis=(0, 1))
    first, second, mixed = centred[0], centred[1], centred[2:]
    variance = np.var(values[:2], axis=(0, 1))
    shares = np.stack([np.mean(second * (mixed - first), axis=1), 0.5 * np.mean((first - mixed) ** 2, axis=1)])
    return np.swapaxes(shares / variance, 1, 2)


def one_at_a_time(
    evaluate: Callable[[Array], Array], lower: Array, upper: Array, nominal: Array, steps: int
) -> tuple[Array, Array]:
    """Vary each variable between its bounds while the others are nominal.

    Returns the values of each variable (n, steps), and the quantities there (n, steps, nq); NaN where a design failed.
    """
    grid = np.linspace(lower, upper, steps, axis=1)
    designs = np.tile(nominal, (len(lower) * steps, 1))
    for k, line in enumerate(grid):
        designs[k * steps : (k + 1) * steps, k] = line
    found = evaluate(designs)
    return grid, found.reshape(len(lower), steps, -1)


def inert(found: Array) -> NDArray[np.bool_]:
    """Find the variables that change nothing, (nq, n), in what `one_at_a_time` found, (n, steps, nq).

    A variable is not inert where fewer than two designs have values: nothing is known of it.
    """
    known = np.isfinite(found)
    low, high = np.where(known, found, np.inf).min(axis=1), np.where(known, found, -np.inf).max(axis=1)
    compared = known.sum(axis=1) > 1
    with np.errstate(invalid="ignore"):
        same = high - low <= CONSTANT * np.maximum(np.abs(low), np.abs(high))
    return (same & compared).T


def check_samples(samples: int, source: str = "samples") -> None:
    """Refuse a number of Sobol points that is no power of two: other numbers are not balanced."""
    if samples < 2 or samples & (samples - 1):
        raise InputError(source, str(samples), "must be a power of two, 2 at least")


@validated
def sensitivity(
    study: Study, samples: int = 256, seed: Whole | None = None, evaluator: Evaluator | None = None
) -> dict[str, Any]:
    """Find out how the objectives and constraints of a study depend on its variables.

    Parameters
    ----------
    study : Study
    samples : int
        A power of two, 2 at least; costs samples*(n + 2) evaluations.
    seed : int, optional
        Default the study's.
    evaluator : Evaluator, optional

    Returns
    -------
    dict
        The content of ``sensitivity.json``, SI units; relative quantities are multiples of the nominal design's. None
        where there is no number.

    Raises
    ------
    InputError
        If `samples` is no power of two.
    RunError
        As `sobol`; or if quantities are relative to a nominal design that failed.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.sensitivity(study, samples=2)
    >>> variables = report["quantities"]["force"]["variables"]
    >>> [path for path, entry in variables.items() if entry["inert"]]
    ['sdf.links.crank4.mass', 'sdf.links.crank4.inertia']
    """
    check_samples(samples)
    evaluate = Evaluator(study) if evaluator is None else evaluator
    seed = study.file.seed if seed is None else seed
    nominal = evaluate(study.nominal[None])

    def values(designs: Array) -> Array:
        return np.column_stack(in_units(study, evaluate(designs), nominal))

    indices = sobol(values, study.lower, study.upper, samples, seed)
    grid, found = one_at_a_time(values, study.lower, study.upper, study.nominal, numerics.SENSITIVITY_STEPS)
    unmoved = inert(found)
    quantities: dict[str, Any] = {}
    for k, name in enumerate([*study.file.objectives, *study.file.constraints]):
        quantities[name] = {
            "mean": float(indices.mean[k]),
            "standard_deviation": float(indices.deviation[k]),
            "variables": {
                path: {
                    "first": finite(indices.first[k, i]),
                    "first_confidence": finite(indices.first_confidence[k, i]),
                    "total": finite(indices.total[k, i]),
                    "total_confidence": finite(indices.total_confidence[k, i]),
                    "inert": bool(unmoved[k, i]),
                    "one_at_a_time": [finite(x) for x in found[i, :, k]],
                }
                for i, path in enumerate(study.paths)
            },
        }
    return {
        "study": study.source.stem,
        "title": study.title,
        "seed": seed,
        "samples": samples,
        "evaluations": indices.evaluations,
        "failed": indices.failed,
        "grid": {path: line.tolist() for path, line in zip(study.paths, grid, strict=True)},
        "quantities": quantities,
        "versions": versions("scipy", "pygad"),
    }


def format_sensitivity(study: Study, report: dict[str, Any]) -> str:
    """Format indices as lines of text.

    Parameters
    ----------
    study : Study
    report : dict
        From `optim.sensitivity`.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.sensitivity(study, samples=2)
    >>> optim.format_sensitivity(study, report).splitlines()[0]
    'Seven-bar press: least joint forces'
    """
    lines = [
        report["title"],
        f"Sobol's indices over the bounds: {report['evaluations']} designs ({report['failed']} failed),"
        f" seed {report['seed']}; +- 95 % confidence",
    ]
    labels = [f"{study.label(name)}: share of the variance" for name in report["quantities"]]
    first = max(34, *(2 + len(text) for text in (*labels, *study.paths)))
    for name, entry in report["quantities"].items():
        lines += [
            "",
            f"{study.label(name) + ': share of the variance':{first}s}{'first order':>20s}{'total':>20s}"
            f"   mean {entry['mean']:.5g}, standard deviation {entry['standard_deviation']:.2g}"
            + ("" if _varies(entry) else "; it does not vary, there are no shares"),
        ]
        for path, one in entry["variables"].items():
            cells = "".join(_cell(one[kind], one[f"{kind}_confidence"]) for kind in ("first", "total"))
            lines.append(f"{path:{first}s}{cells}" + ("   inert" if one["inert"] else ""))
    return "\n".join(lines)


def _varies(entry: dict[str, Any]) -> bool:
    """Tell whether a quantity has a variance to share."""
    return any(one["total"] is not None for one in entry["variables"].values())


def _cell(value: float | None, confidence: float | None) -> str:
    return f"{'-':>20s}" if value is None else f"{value:12.3f} +-{confidence:5.3f}"
