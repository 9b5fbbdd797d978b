"""Figures of an identification: measured and computed samples, residuals, correlations, profiles, progress."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from linkages.base.palette import IDEAL, IDEAL_LINE, INK, LIMIT, LIMIT_LINE, LINE, MEASURED, SOFT, shade, written_on
from linkages.show.plots.names import name_of_value, sentence
from linkages.show.plots.panels import legend_below, make_panels, narrow, page, say
from linkages.show.plots.quantities import number, quantity, uncertain
from linkages.show.plots.style import COLORS, axis_label, engineering, small_text, typeset
from optim.identify.result import IdentificationResult, Parameter
from optim.report.figures import write

_FLAT = 6  # most names below a matrix that are horizontal
_NAME, _TOLD, _BOUND = 18, 3, 3.84  # letters of a line of a name; most sentences above a figure; 95 % of chi-square


def write_identification(found: IdentificationResult, folder: Path, form: str = "png") -> None:
    """Write figures: ``fit``, ``correlation``, ``windows`` and, if they are known, ``profiles`` and ``posterior``.

    Parameters
    ----------
    found : IdentificationResult
        From `optim.identify`.
    folder : Path
    form : str
        Format of the files.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> found = optim.identify(optim.load_identification("slider_crank_fit"))
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> optim.write_identification(found, folder)
    >>> sorted(file.name for file in folder.iterdir())
    ['correlation.png', 'fit.png']
    """
    if found["curves"]:
        write(folder / f"fit.{form}", lambda: _fit(found))
    write(folder / f"correlation.{form}", lambda: _correlation(found))
    if len(found["history"]) > 1:
        write(folder / f"windows.{form}", lambda: _windows(found))
    if any("profile" in one for one in found["parameters"].values()):
        write(folder / f"profiles.{form}", lambda: _profiles(found))
    if "posterior" in found:
        write(folder / f"posterior.{form}", lambda: _posterior(found))


def values_said(found: IdentificationResult) -> Iterable[str]:
    """Tell each value with its deviation, and which are not identifiable."""
    for one in found["parameters"].values():
        name = sentence(name_of_value(one["path"]))
        if one["identifiable"] and one["deviation"]:
            yield f"{name}: {uncertain(one['value'], one['deviation'], one['unit'])}"
        else:
            yield f"{name}: not identifiable from these measurements"


def _fit(found: IdentificationResult) -> Figure:
    curves = found["curves"]
    figure, axes = make_panels(2 * len(curves), 1.9)
    for left, right, (name, curve) in zip(axes[::2], axes[1::2], curves.items(), strict=True):
        time, measured, computed = (np.array(curve[key]) for key in ("time", "measured", "computed"))
        unit, factor = engineering(curve["unit"], float(np.abs(measured).max(initial=0.0)))
        left.plot(time, factor * measured, ".", color=MEASURED, ms=2.0, label="measured")
        left.plot(time, factor * computed, color=COLORS[0], lw=1.0, label="computed")
        left.set(ylabel=axis_label(textwrap.fill(name, _NAME), unit, "\n"), xlabel="time of the file [s]")
        residual = measured - computed
        unit, factor = engineering(curve["unit"], float(np.abs(residual).max(initial=0.0)))
        right.plot(time, factor * residual, ".", color=INK, ms=2.0)
        right.axhline(0.0, color=SOFT, lw=0.6)
        right.set(ylabel=axis_label("residual", unit), xlabel="time of the file [s]")
    say(figure, *list(values_said(found))[:_TOLD])
    legend_below(figure, axes[:1])
    return figure


def _correlation(found: IdentificationResult) -> Figure:
    known = {name: name_of_value(one["path"]) for name, one in found["parameters"].items()}
    names = [textwrap.fill(known.get(name, name), _NAME) for name in found["correlation"]["names"]]
    matrix = np.array([[np.nan if x is None else x for x in row] for row in found["correlation"]["matrix"]])
    figure, (ax,) = make_panels(1, 1.5 + 0.32 * len(names))
    for (i, k), value in np.ndenumerate(matrix):
        color = shade(0.0 if np.isnan(value) else float(value))
        ax.add_patch(Rectangle((k, i), 1.0, 1.0, fc=color, ec=LINE, lw=0.4))
        look: dict[str, Any] = {"ha": "center", "va": "center", "color": written_on(color), "fontsize": small_text()}
        ax.text(k + 0.5, i + 0.5, "-" if np.isnan(value) else number(float(value), 2), **look)
    middles = np.arange(len(names)) + 0.5
    ax.set(xlim=(0.0, len(names)), ylim=(len(names), 0.0))
    turned = 90 if len(names) > (_FLAT // 2 if narrow() else _FLAT) else 0
    ax.set_xticks(middles, names, rotation=turned, fontsize=small_text())
    ax.set_yticks(middles, names, fontsize=small_text())
    ax.grid(False)
    say(figure, _most_alike(matrix, [" ".join(name.split("\n")) for name in names]))
    return figure


def _most_alike(matrix: np.ndarray, names: list[str]) -> str:
    """Tell the pair of values with the largest correlation."""
    pairs = np.abs(np.nan_to_num(np.triu(matrix, 1)))
    i, k = np.unravel_index(int(pairs.argmax()), pairs.shape)
    if not pairs.max(initial=0.0) > 0.0:
        return "No correlation of two values is known"
    return f"Largest correlation of two values: {number(float(matrix[i, k]), 2)}, {names[i]} and {names[k]}"


def _windows(found: IdentificationResult) -> Figure:
    runs, ends, mean = np.array(found["history"]).T
    figure, (ax,) = make_panels(1, 3.0)
    ax.plot(ends, mean, "o-", color=COLORS[0])
    ax.set(xscale="log", xlabel="end of the window [s]", ylabel="chi-square of a sample [1]")
    for x, y, count in zip(ends, mean, runs, strict=True):
        look: dict[str, Any] = {"textcoords": "offset points", "fontsize": small_text(), "ha": "center"}
        ax.annotate(f"{count:.0f} runs", (x, y), (0, 5), **look)
    ax.margins(0.12)
    end = quantity(float(ends[-1]), "s", 3)
    say(figure, f"Chi-square of a sample in the last window, up to {end}: {number(float(mean[-1]), 3)}")
    return figure


def _profiles(found: IdentificationResult) -> Figure:
    shown = {name: one for name, one in found["parameters"].items() if "profile" in one}
    figure, axes = make_panels(len(shown), 2.4)
    for ax, one in zip(axes, shown.values(), strict=True):
        points = np.array(one["profile"])
        unit, factor = engineering(one["unit"] or "1", float(np.abs(points[:, 0]).max()))
        ax.plot(factor * points[:, 0], points[:, 1], "o", ms=4, color=COLORS[0], label="profile")
        if one["deviation"]:
            values = np.linspace(points[0, 0], points[-1, 0], 100)
            rise = ((values - one["value"]) / one["deviation"]) ** 2
            ax.plot(factor * values, rise, color=IDEAL, lw=IDEAL_LINE, zorder=1, label="linear")
        ax.axhline(_BOUND, color=LIMIT, lw=LIMIT_LINE, ls="--", label="95 %")
        ax.xaxis.set_major_locator(MaxNLocator(4))
        ax.ticklabel_format(axis="x", useOffset=False)
        ax.set(xlabel=axis_label(name_of_value(one["path"]), unit or "1"), ylabel="rise of chi-square [1]")
    say(figure, *list(values_said(found))[:_TOLD])
    legend_below(figure)
    return figure


def _posterior(found: IdentificationResult) -> Figure:
    """Draw the samples of each pair of unknowns, and histograms, with the values and intervals of the fit."""
    given = list(found["parameters"].values())
    samples, n = np.array(found["posterior"]["samples"]), len(given)
    units = [engineering(one["unit"] or "1", abs(one["value"])) for one in given]
    figure = page((1.3 if narrow() else 1.6) * n + 0.3)
    axes = figure.subplots(n, n, squeeze=False, sharex="col")
    for (i, k), ax in np.ndenumerate(axes):
        if k > i:
            ax.remove()
            continue
        _draw_pair(ax, samples, given, [factor for _, factor in units], i, k)
        ax.locator_params(nbins=3)
        if i == n - 1:
            ax.set_xlabel(_label(given[k], units[k][0]), fontsize=small_text())
        if k == 0 and i > 0:
            ax.set_ylabel(_label(given[i], units[i][0]), fontsize=small_text())
        ax.tick_params(labelleft=k == 0 and i > 0, labelbottom=i == n - 1, labelsize=small_text())
    say(figure, *list(values_said(found))[:_TOLD])
    return figure


def _draw_pair(ax: Axes, samples: np.ndarray, given: list[Parameter], factors: list[float], i: int, k: int) -> None:
    """Draw the samples of two unknowns, or the histogram of one."""
    x, y = factors[k] * samples[:, k], factors[i] * samples[:, i]
    if k == i:
        ax.hist(x, 30, color=COLORS[0], alpha=0.6)
        ax.set_yticks([])
        for end in given[k]["interval"] or ():
            ax.axvline(factors[k] * end, color=SOFT, ls="--", lw=0.8)
    else:
        ax.plot(x, y, ".", color=COLORS[0], ms=1.5, alpha=0.4)
        ax.axhline(factors[i] * given[i]["value"], color=INK, lw=0.8)
    ax.axvline(factors[k] * given[k]["value"], color=INK, lw=0.8)
    ax.ticklabel_format(useOffset=False)


def _label(one: Parameter, unit: str) -> str:
    return axis_label(textwrap.fill(name_of_value(one["path"]), _NAME) + "\n", typeset(unit) or "1")
