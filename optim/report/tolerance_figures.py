"""Figures of tolerances: histograms with limits, the two most influential values, shares and contributions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from linkages.base.brief import counted
from linkages.base.palette import IDEAL, IDEAL_LINE, INK, LIMIT, LIMIT_LINE, SOFT
from linkages.show.plots.names import name_of_value
from linkages.show.plots.panels import legend_below, make_panels, say
from linkages.show.plots.presentation import presentation
from linkages.show.plots.quantities import share
from linkages.show.plots.style import COLORS, axis_label, engineering
from optim.problem.study import Array, Study
from optim.report.figures import scaled_label, write
from optim.report.shares import draw_shares, style_shares
from optim.search.sampled_machines import Sample
from optim.search.tolerance_result import QuantityStatistics, ToleranceResult

_SHOWN = 2000  # points of a figure, at most
_GOOD, _BAD = COLORS[0], LIMIT

Quantities = Mapping[str, QuantityStatistics]


def write_tolerances(study: Study, result: ToleranceResult, sample: Sample, folder: Path) -> list[str]:
    """Draw all figures of a study of tolerances into a folder; return their names."""
    quantities = {name: entry for name, entry in result["outputs"].items() if "histogram" in entry}
    if not quantities:
        return []
    names = [f"{stem}.{presentation().format}" for stem in ("histograms", "contributions", "influence")]
    write(folder / names[0], lambda: _histograms(study, result, quantities))
    write(folder / names[1], lambda: _contributions(study, result, quantities))
    if len(study.names) == 1:
        return names[:2]
    write(folder / names[2], lambda: _influence(study, quantities, sample))
    return names


def yield_said(result: ToleranceResult) -> str:
    """Tell which share of the machines meets all limits."""
    found = result["yield"]
    good, low, high = (share(one) for one in (found["value"], *found["interval"]))
    return f"{good} of {counted(result['samples'], 'machine')} meet all limits ({low} to {high})"


def _histograms(study: Study, result: ToleranceResult, quantities: Quantities) -> Figure:
    """Draw the distribution of each quantity with its limits."""
    figure, axes = make_panels(len(quantities), 2.2)
    for ax, (name, entry) in zip(axes, quantities.items(), strict=True):
        label, factor = scaled_label(study, name, np.array(entry["histogram"]["edges"]))
        edges, counts = factor * np.array(entry["histogram"]["edges"]), entry["histogram"]["counts"]
        ax.stairs(counts, edges, fill=True, color=_GOOD, alpha=0.7)
        for limit in entry["limits"].values():
            ax.axvline(factor * limit, color=_BAD, lw=LIMIT_LINE, ls="--", label="limit")
        ax.axvline(factor * entry["mean"], color=INK, lw=1.0, label="mean")
        ax.set(xlabel=label, ylabel="machines [1]")
        ax.locator_params(axis="x", nbins=4)
        ax.ticklabel_format(axis="x", useOffset=False, scilimits=(-3, 4))
    say(figure, yield_said(result))
    legend_below(figure)
    return figure


def _contributions(study: Study, result: ToleranceResult, quantities: Quantities) -> Figure:
    """Draw the shares of the variance of each quantity, and the yields of halved tolerances."""
    places = np.arange(len(study.names), dtype=np.float64)
    known = {name: entry for name, entry in quantities.items() if entry["variance"] is not None}
    figure, axes = make_panels(len(known) + 1, 1.0 + 0.36 * len(places), sharey=True)
    for ax, (name, entry) in zip(axes, known.items(), strict=False):
        rows = [entry["variance"]["values"][one] for one in study.names] if entry["variance"] else []
        for key, shift, color, text in (("first", -0.2, COLORS[3], "alone"), ("total", 0.2, COLORS[0], "with others")):
            half = 1.96 * np.array([row[f"{key}_error"] for row in rows], dtype=np.float64)
            part = np.array([row[key] for row in rows], dtype=np.float64)
            draw_shares(ax, places + shift, part, half, color, text)
        style_shares(ax, name, places, study)
    found = {name: one for name, one in result["contributions"].items() if one["halved"] is not None}
    axes[-1].errorbar(
        [100.0 * one["halved"] for one in found.values()],
        [study.names.index(name) for name in found],
        xerr=[196.0 * one["error"] for one in found.values()],
        fmt="o",
        color=COLORS[2],
        ecolor=INK,
        elinewidth=0.8,
    )
    now = 100.0 * result["yield"]["value"]
    style_shares(axes[-1], "with half the tolerance", places, study)
    axes[-1].axvline(now, color=IDEAL, lw=IDEAL_LINE, zorder=1)
    axes[-1].set(xlabel="yield [%]; grey: now", xlim=(None, None))
    axes[-1].autoscale(axis="x")
    best = max(found, key=lambda name: found[name]["halved"] or 0.0, default=None)
    if best is None:
        say(figure, yield_said(result))
    else:
        halved, value = share(found[best]["halved"] or 0.0), name_of_value(study.paths[study.names.index(best)])
        say(figure, f"Half the tolerance of the {value} raises the yield most: from {share(0.01 * now)} to {halved}")
    legend_below(figure, axes[:1])
    return figure


def _influence(study: Study, quantities: Quantities, sample: Sample) -> Figure:
    """Draw the machines over the two values that explain most of the scatter."""
    weight = np.zeros(len(study.names))
    for entry in quantities.values():
        if entry["variance"] is not None:
            weight += [entry["variance"]["values"][name]["total"] for name in study.names]
    i, j = sorted(np.argsort(-weight, kind="stable")[:2])
    figure, (ax,) = make_panels(1, 3.8)
    scaled = {k: _scaled(study, k, sample.designs[:, k]) for k in (i, j)}
    for meets, color, text in ((True, _GOOD, "meets all limits"), (False, _BAD, "does not")):
        rows = np.flatnonzero(sample.good[:_SHOWN] == meets)
        look: dict[str, Any] = {
            "s": 8,
            "color": color,
            "alpha": 0.6,
            "label": text,
            "lw": 0,
            "marker": "o" if meets else "^",
        }
        ax.scatter(scaled[i][0][rows], scaled[j][0][rows], **look)
    ax.set(xlabel=scaled[i][1], ylabel=scaled[j][1])
    ax.locator_params(nbins=5)
    ax.ticklabel_format(useOffset=False, scilimits=(-3, 4))
    ax.tick_params(color=SOFT)
    names = " and the ".join(name_of_value(study.paths[k]) for k in (i, j))
    say(figure, f"The {names} matter most")
    legend_below(figure)
    return figure


def _scaled(study: Study, k: int, values: Array) -> tuple[Array, str]:
    """Return the values of a scattering value in a readable unit, and the label of their axis."""
    unit, factor = engineering(study.points[0].system.value_unit(study.paths[k]), float(np.abs(values).max()))
    return factor * values, axis_label(name_of_value(study.paths[k]), unit)
