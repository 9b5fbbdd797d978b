"""The content of ``tolerances.json`` as text."""

from __future__ import annotations

from typing import Any

from linkages.base.brief import cell, counted
from optim.problem.study import Study

_NOTICED = 0.01  # share of the variance from which an unpredictable part is reported


def format_tolerances(study: Study, result: dict[str, Any]) -> str:
    """Format the yield, the quantities, and the contributions of tolerances, as lines of text.

    Parameters
    ----------
    study : Study
    result : dict
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
    for key, entry in result["rare"].items():
        checked = ""
        if "checked" in entry:
            checked = f"; check by importance sampling {entry['checked']:.3g} +- {1.96 * entry['checked_error']:.1g}"
        state = "" if entry["converged"] else " (not converged)"
        text = f"{entry['probability']:.3g}, index {entry['index']:.3f}{state}"
        lines += ["", f"beyond {key}, from the most probable machine there (FORM): {text}{checked}"]
    return "\n".join(lines)


def _quantities(study: Study, result: dict[str, Any]) -> list[str]:
    """Format a block for each quantity: moments, quantiles, limits, shares of the variance."""
    lines = []
    for name, entry in result["outputs"].items():
        lines += ["", f"{study.label(name)}"]
        for key, limit in entry["limits"].items():
            beyond = result["violated"][f"{name}.{key}"] / result["samples"]
            lines.append(f"  {key.replace('_', ' ')} {limit:g}: {beyond:.2%} of the machines are beyond, or failed")
        if "mean" not in entry:
            continue
        index = "" if entry["capability"] is None else f", capability {entry['capability']:.2f}"
        lines.append(
            f"  mean {entry['mean']:.6g} +- {1.96 * entry['mean_error']:.1g},"
            f" deviation {entry['deviation']:.4g} +- {1.96 * entry['deviation_error']:.1g}{index}"
        )
        ends = entry["quantiles"]
        low, high = ends["0.05"], ends["0.95"]
        lines.append(f"  90 % of the machines: {low[0]:.6g} to {high[0]:.6g}")
        if entry.get("worst_case") and entry["worst_case"]["range"]:
            worst = entry["worst_case"]["range"]
            lines.append(f"  all values at their limits: {worst[0]:.6g} to {worst[1]:.6g}")
        unpredictable = (entry["unpredictable_deviation"] or 0.0) ** 2
        if unpredictable > _NOTICED * entry["deviation"] ** 2:
            share = min(unpredictable / entry["deviation"] ** 2, 1.0)
            lines.append(
                f"  unpredictable: a change of values by 1e-6 causes the deviation"
                f" {entry['unpredictable_deviation']:.3g}, {share:.0%} of the variance"
            )
        lines += _shares(entry)
    return lines


def _shares(entry: dict[str, Any]) -> list[str]:
    shares, linear = entry["variance"], entry.get("first_order")
    if shares is None:
        return []
    first = max(24, *(4 + len(name) for name in shares["values"]))
    lines = [f"  {'share of the variance':{first}s}{'alone':>18s}{'with others':>18s}{'first order':>14s}"]
    for name, one in shares["values"].items():
        pairs = ((round(one[key], 3) or 0.0, 1.96 * one[f"{key}_error"]) for key in ("first", "total"))
        cells = "".join(f"{share:9.3f} +-{error:6.3f}" for share, error in pairs)
        lines.append(f"  {name:{first}s}{cells}{cell(linear and linear['shares'][name], 14, '.3f')}")
    if linear and linear["error"] is not None:
        lines.append(
            f"  first order by derivatives: deviation {linear['deviation']:.4g},"
            f" {100.0 * linear['error']:+.1f} % of the machines';"
            f" not explained by regression: {shares['unexplained']:.1%}"
        )
    return lines


def _contributions(result: dict[str, Any]) -> list[str]:
    now = result["yield"]["value"]
    if now in (0.0, 1.0):
        return ["", "all machines meet the limits" if now else "no machine meets all limits"]
    return [
        "",
        *(
            f"half the tolerance of {name}: yield from {now:.2%} to {one['halved']:.2%} +- {1.96 * one['error']:.2%}"
            for name, one in result["contributions"].items()
        ),
    ]
