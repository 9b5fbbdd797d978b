"""The content of ``tolerances.json`` as text."""

from __future__ import annotations

import math

from linkages.base.brief import cell, counted
from optim.problem.study import Study
from optim.search.tolerance_result import Halved, QuantityStatistics, Rare, ToleranceResult
from optim.search.tolerance_statistics import clopper_pearson

_NOTICED = 0.01  # share of the variance, or of rare machines, from which an unpredictable or failed part is reported
_INSIDE = 0.05  # share of the machines beyond the corners of the limits from which it is reported


def format_tolerances(study: Study, result: ToleranceResult) -> str:
    """Format the yield, the quantities, and the contributions of tolerances, as lines of text.

    Parameters
    ----------
    study : Study
    result : ToleranceResult
        From `optim.tolerances`.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("slidercrank_tolerances"))
    >>> result = optim.tolerances(study, samples=64)
    >>> optim.format_tolerances(study, result).splitlines()[0]
    'Slider-crank with three fits: films and tilt of the slider'
    """
    found, confidence = result["yield"], result["algorithm"]["confidence"]
    lines = [
        result["title"],
        f"{counted(result['samples'], 'machine')} ({result['failed']} failed), seed {result['seed']}",
        f"yield: {found['value']:.2%}, interval of {confidence:.0%} confidence"
        f" {found['interval'][0]:.2%} to {found['interval'][1]:.2%}",
    ]
    lines += [f"failed: {count} {status}" for status, count in result["failures"].items()]
    lines += _quantities(study, result) + _contributions(result)
    lines += _rare(result)
    return "\n".join(lines)


def _rare(result: ToleranceResult) -> list[str]:
    """Format the share of machines beyond each limit that few exceed, and the unknown part."""
    lines = [""] if result["rare"] else []
    for key, entry in result["rare"].items():
        lines.append(f"beyond {key}: {_share(entry, result['algorithm']['confidence'])}")
        if entry.get("failed", 0.0) > _NOTICED:
            lines.append(f"  {entry['failed']:.0%} of these machines failed")
        if (form := entry.get("form")) is not None:
            state = "" if form["converged"] else ", not converged"
            lines.append(
                f"  at the most probable of these machines (FORM{state}): index {form['index']:.3f},"
                f" share {form['share']:.3g} if the limit were a plane"
            )
    return lines


def _share(entry: Rare, confidence: float) -> str:
    """Write a rare share with its interval, or why there is none."""
    if entry["interval"] is None:
        return f"share unknown: {entry['unknown']}"
    low, high = entry["interval"]
    if entry["share"] is None:
        return f"share at most {high:.1g} ({confidence:.0%} confidence); {entry['unknown']}"
    doubt = f"; {entry['unknown']}" if entry["unknown"] else ""
    return f"share {entry['share']:.3g}, interval of {confidence:.0%} confidence {low:.2g} to {high:.2g}{doubt}"


def _quantities(study: Study, result: ToleranceResult) -> list[str]:
    """Format a block for each quantity: moments, quantiles, limits, shares of the variance."""
    lines = []
    for name, entry in result["outputs"].items():
        lines += ["", f"{study.label(name)}"]
        for key, limit in entry["limits"].items():
            count, total = result["violated"][f"{name}.{key}"], result["samples"]
            low, high = clopper_pearson(count, total, result["algorithm"]["confidence"])
            share = f"{count / total:.2%} of the machines ({low:.2%} to {high:.2%})"
            lines.append(f"  {key.replace('_', ' ')} {limit:g}: {share} are beyond, or failed")
        if "mean" in entry:
            lines += _moments(entry) + _corners(entry) + _shares(entry)
        lines += [f"  {said}" for said in entry["unknown"]]
    return lines


def _moments(entry: QuantityStatistics) -> list[str]:
    """Format mean, deviation, capability and quantiles of a quantity, and its unpredictable part."""
    index = "" if entry["capability"] is None else f", capability {entry['capability']:.2f}"
    low, high = entry["quantiles"]["0.05"], entry["quantiles"]["0.95"]
    lines = [
        f"  mean {entry['mean']:.6g} +- {1.96 * entry['mean_error']:.1g},"
        f" deviation {entry['deviation']:.4g} +- {1.96 * entry['deviation_error']:.1g}{index}",
        f"  90 % of the machines: {low[0]:.6g} to {high[0]:.6g}",
    ]
    unpredictable = entry["unpredictable_deviation"] or 0.0
    if unpredictable > math.sqrt(_NOTICED) * entry["deviation"]:
        share = min(unpredictable / entry["deviation"], 1.0) ** 2 if entry["deviation"] else 1.0
        lines.append(
            f"  unpredictable: a change of values by 1e-6 causes the deviation"
            f" {unpredictable:.3g}, {share:.0%} of the variance"
        )
    return lines


def _corners(entry: QuantityStatistics) -> list[str]:
    """Format the range of a quantity at the corners of the limits, and whether other machines exceed it."""
    if (corners := entry.get("corners")) is None:
        return []
    text = "  corners of the tolerance limits: "
    if corners["range"] is None:
        return [f"{text}all {corners['count']} failed"]
    low, high = corners["range"]
    text += f"{low:.6g} to {high:.6g}"
    if corners["failed"]:
        text += f"; {corners['failed']} of {corners['count']} failed"
    if corners["outside"] > _INSIDE:
        mean = "" if low <= entry["mean"] <= high else " and their mean"
        text += f"; {corners['outside']:.0%} of the machines{mean} are outside: extremes lie between the limits"
    return [text]


def _shares(entry: QuantityStatistics) -> list[str]:
    shares, linear = entry["variance"], entry["first_order"]
    if shares is None:
        return []
    first = max(24, *(4 + len(name) for name in shares["values"]))
    lines = [f"  {'share of the variance':{first}s}{'alone':>18s}{'with others':>18s}{'first order':>14s}"]
    for name, one in shares["values"].items():
        pairs = ((round(one[key], 3) or 0.0, 1.96 * one[f"{key}_error"]) for key in ("first", "total"))
        cells = "".join(f"{share:9.3f} +-{error:6.3f}" for share, error in pairs)
        lines.append(f"  {name:{first}s}{cells}{cell(linear['shares'] and linear['shares'][name], 14, '.3f')}")
    lines.append(f"  not explained by regression: {shares['unexplained']:.1%}".replace("-0.0%", "0.0%"))
    if linear["error"] is not None:
        lines.append(
            f"  first order by derivatives: deviation {linear['deviation']:.4g},"
            f" {100.0 * linear['error']:+.1f} % of the machines'"
        )
    return lines


def _contributions(result: ToleranceResult) -> list[str]:
    now = result["yield"]["value"]
    if now in (0.0, 1.0):
        return ["", "all machines meet the limits" if now else "no machine meets all limits"]
    return [
        "",
        *(f"half the tolerance of {name}: {_halved(now, one)}" for name, one in result["contributions"].items()),
    ]


def _halved(now: float, one: Halved) -> str:
    """Write the yield of half a tolerance, or that no machine tells it."""
    if one["halved"] is None or one["error"] is None:
        return "yield unknown, too few machines lie within it"
    return f"yield from {now:.2%} to {one['halved']:.2%} +- {1.96 * one['error']:.2%}"
