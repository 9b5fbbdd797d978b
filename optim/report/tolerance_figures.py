"""Figures of tolerances: histograms with limits, the two most influential values, shares and contributions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from linkages.base.palette import LIMIT
from linkages.show.plots.presentation import presentation
from linkages.show.plots.style import COLORS, axis_label, typeset
from optim.problem.study import Study
from optim.report.figures import draw_shares, label_of, png
from optim.search.sampled_machines import Sample
from optim.search.tolerance_result import QuantityStatistics, ToleranceResult

_SHOWN = 2000  # points of a figure, at most
_GOOD, _BAD = COLORS[0], LIMIT


def write_tolerances(study: Study, result: ToleranceResult, sample: Sample, folder: Path) -> list[str]:
    """Draw all figures of a study of tolerances into a folder; return their names."""
    quantities = {name: entry for name, entry in result["outputs"].items() if "histogram" in entry}
    if not quantities:
        return []
    names = [f"{stem}.{presentation().format}" for stem in ("histograms", "contributions", "influence")]
    _write_histograms(study, result, quantities, folder / names[0])
    _write_contributions(study, result, quantities, folder / names[1])
    if len(study.names) == 1:
        return names[:2]
    _write_influence(study, quantities, sample, folder / names[2])
    return names


def _write_histograms(
    study: Study, result: ToleranceResult, quantities: Mapping[str, QuantityStatistics], path: Path
) -> None:
    """Draw the distribution of each quantity with its limits."""
    with png(path, 1.0 + 3.2 * len(quantities), 3.0) as figure:
        axes = figure.subplots(1, len(quantities), sharey=True, squeeze=False)[0]
        for ax, (name, entry) in zip(axes, quantities.items(), strict=True):
            edges, counts = np.array(entry["histogram"]["edges"]), entry["histogram"]["counts"]
            ax.stairs(counts, edges, fill=True, color=_GOOD, alpha=0.7)
            for limit in entry["limits"].values():
                ax.axvline(limit, color=_BAD, label="limit" if ax is axes[0] else None)
            ax.axvline(
                entry["mean"], color="0.2", linestyle="--", linewidth=1.0, label="mean" if ax is axes[0] else None
            )
            ax.set_xlabel(label_of(study, name))
            ax.locator_params(axis="x", nbins=4)
            ax.ticklabel_format(axis="x", useOffset=False, scilimits=(-3, 4))
        axes[0].set_ylabel("machines")
        found = result["yield"]
        figure.suptitle(
            f"{result['title']}\n{result['samples']:,} machines, yield {found['value']:.2%}"
            f" ({found['interval'][0]:.2%} to {found['interval'][1]:.2%})",
            fontsize=9,
        )
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _write_contributions(
    study: Study, result: ToleranceResult, quantities: Mapping[str, QuantityStatistics], path: Path
) -> None:
    """Draw the shares of the variance of each quantity, and the yields of halved tolerances."""
    places = np.arange(len(study.names), dtype=np.float64)
    with png(path, 2.2 + 2.4 * (len(quantities) + 1), 1.3 + 0.42 * len(places)) as figure:
        axes = figure.subplots(1, len(quantities) + 1, sharey=True, squeeze=False)[0]
        for ax, (name, entry) in zip(axes, quantities.items(), strict=False):
            if entry["variance"] is not None:
                rows = [entry["variance"]["values"][one] for one in study.names]
                for key, shift, colour, text in (
                    ("first", -0.2, COLORS[3], "alone"),
                    ("total", 0.2, COLORS[0], "with others"),
                ):
                    half = 1.96 * np.array([row[f"{key}_error"] for row in rows], dtype=np.float64)
                    share = np.array([row[key] for row in rows], dtype=np.float64)
                    draw_shares(ax, places + shift, share, half, colour, text)
            ax.set_title(label_of(study, name), fontsize=9)
            ax.set_xlabel("share of the variance [1]")
            ax.set_xlim(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
        found = {name: one for name, one in result["contributions"].items() if one["halved"] is not None}
        axes[-1].errorbar(
            [100.0 * one["halved"] for one in found.values()],
            [study.names.index(name) for name in found],
            xerr=[196.0 * one["error"] for one in found.values()],
            fmt="o",
            color=COLORS[2],
        )
        axes[-1].axvline(100.0 * result["yield"]["value"], color="0.2", linestyle="--", linewidth=1.0)
        axes[-1].set_title("half the tolerance", fontsize=9)
        axes[-1].set_xlabel("yield [%], dashed: now")
        axes[0].set_yticks(places, study.names)
        axes[0].invert_yaxis()
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)


def _write_influence(study: Study, quantities: Mapping[str, QuantityStatistics], sample: Sample, path: Path) -> None:
    """Draw the machines over the two values that explain most of the scatter."""
    weight = np.zeros(len(study.names))
    for entry in quantities.values():
        if entry["variance"] is not None:
            weight += [entry["variance"]["values"][name]["total"] for name in study.names]
    i, j = sorted(np.argsort(-weight, kind="stable")[:2])
    with png(path, 4.6, 4.0) as figure:
        ax = figure.subplots()
        for meets, colour, text in ((True, _GOOD, "meets all limits"), (False, _BAD, "does not")):
            rows = np.flatnonzero(sample.good[:_SHOWN] == meets)
            ax.scatter(sample.designs[rows, i], sample.designs[rows, j], s=8, color=colour, alpha=0.6, label=text, lw=0)
        for k, axis in ((i, ax.xaxis), (j, ax.yaxis)):
            unit = study.points[0].system.value_unit(study.paths[k])
            axis.set_label_text(axis_label(study.names[k], "" if unit == "1" else typeset(unit)))
        ax.locator_params(nbins=5)
        ax.ticklabel_format(useOffset=False, scilimits=(-3, 4))
        figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2)
