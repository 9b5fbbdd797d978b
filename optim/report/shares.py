"""Figures of a sensitivity analysis: Sobol's indices, and each variable alone."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.base.brief import counted
from linkages.base.palette import IDEAL, IDEAL_LINE, INK, LINE, SOFT
from linkages.show.plots.names import name_of_value
from linkages.show.plots.panels import legend_below, make_panels, narrow, note, page, say
from linkages.show.plots.quantities import number
from linkages.show.plots.style import COLORS, axis_label, engineering, small_text
from optim.problem.study import Array, Study
from optim.report.figures import scaled_label, value_said, write

_NOMINAL, _FIRST, _TOTAL = IDEAL, COLORS[3], COLORS[0]
_ROUNDING, _WIDE = 1e-9, 0.1  # of shares, of half an interval that says little [1]
_NAME = 20  # letters of a line of a name


def write_indices(study: Study, report: Mapping[str, Any], path: Path) -> None:
    """Draw Sobol's indices of every quantity with their 95 % confidence intervals.

    Parameters
    ----------
    study : Study
    report : mapping
        Content of ``sensitivity.json``.
    path : Path

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.sensitivity(study, samples=2)
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "figure.png"
    >>> optim.write_indices(study, report, file)
    >>> file.exists()
    True
    """
    write(path, lambda: _indices(study, report))


def _indices(study: Study, report: Mapping[str, Any]) -> Figure:
    quantities = report["quantities"]
    places, vague = np.arange(len(study.names), dtype=np.float64), False
    figure, axes = make_panels(len(quantities), 0.9 + 0.36 * len(places), sharey=True)
    told = []
    for ax, (name, entry) in zip(axes, quantities.items(), strict=True):
        rows = entry["variables"].values()
        for kind, shift, color, text in (
            ("first", -0.2, _FIRST, "first order: alone"),
            ("total", 0.2, _TOTAL, "total: with interactions"),
        ):
            value, half = (
                np.array([row[key] for row in rows], dtype=np.float64) for key in (kind, f"{kind}_confidence")
            )
            vague = draw_shares(ax, places + shift, value, half, color, text) or vague
        for place, row in zip(places, rows, strict=True):
            if row["inert"]:
                ax.text(0.02, place, "inert", va="center", color=SOFT, fontsize=small_text())
        told.append(_most(study, name, {path: row["total"] for path, row in entry["variables"].items()}))
        style_shares(ax, name, places, study)
    few = f"; grey: uncertain, {counted(report['evaluations'], 'design')} are too few" if vague else ""
    say(figure, *[one for one in told if one][:2], f"Lines: 95 % confidence{few}")
    legend_below(figure, axes[:1])
    return figure


def _most(study: Study, name: str, totals: Mapping[str, float | None]) -> str:
    """Tell which variable a quantity depends on most; empty where it does not vary."""
    known = {path: share for path, share in totals.items() if share is not None}
    if not known:
        return ""
    path = max(known, key=known.__getitem__)
    share = number(100.0 * min(known[path], 1.0), 2)
    return f"{name} depends most on the {name_of_value(path)}: {share} % of the variance"


def style_shares(ax: Axes, title: str, places: Array, study: Study) -> None:
    """Name the rows of a panel of shares by the values of a study, the first one above."""
    ax.set_title(title, fontsize="medium", loc="left")
    ax.set_xlabel("share of the variance [1]")
    ax.set_xlim(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
    ax.set_yticks(places, [textwrap.fill(name_of_value(path), _NAME) for path in study.paths], fontsize=small_text())
    ax.set_ylim(len(places) - 0.5, -0.5)


def draw_shares(ax: Axes, places: Array, share: Array, half: Array, color: str, label: str) -> bool:
    """Draw shares of a variance as bars with half their intervals of confidence; return whether one is uncertain.

    A share is grey where its interval contains 0, or is wide and exceeds 1. It is uncertain if that interval is wide.
    """
    vague = (share - half <= 0.0) & (half > 0.0) | (share + half > 1.0 + _ROUNDING) & (half > _WIDE)
    look: dict[str, Any] = {"height": 0.38, "error_kw": {"lw": 0.8, "ecolor": INK}}
    ax.barh(places, share, xerr=half, color=[LINE if one else color for one in vague], edgecolor=color, lw=0.6, **look)
    ax.scatter([], [], marker="s", color=color, label=label)  # of the legend
    return bool((vague & (half > _WIDE)).any())


def write_one_at_a_time(study: Study, report: Mapping[str, Any], path: Path) -> None:
    """Draw every quantity over each variable between its bounds, the others nominal.

    The report is the content of ``sensitivity.json``.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.sensitivity(study, samples=2)
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "figure.png"
    >>> optim.write_one_at_a_time(study, report, file)
    >>> file.exists()
    True
    """
    write(path, lambda: _one_at_a_time(study, report))


def _one_at_a_time(study: Study, report: Mapping[str, Any]) -> Figure:
    quantities, count = report["quantities"], len(study.names)
    across = min(count, 2 if narrow() else 4)
    down = -(-count // across)
    figure = page(1.75 * down * len(quantities))
    grid = figure.add_gridspec(down * len(quantities), across)
    for row, (name, entry) in enumerate(quantities.items()):
        first, found = None, [one["one_at_a_time"] for one in entry["variables"].values()]
        label, scale = scaled_label(study, name, np.array(found, dtype=float))
        for k, one in enumerate(entry["variables"].values()):
            ax = figure.add_subplot(grid[row * down + k // across, k % across], sharey=first)
            first = first or ax
            values, path = report["grid"][study.paths[k]], study.paths[k]
            unit, factor = engineering(study.points[0].system.value_unit(path), max(map(abs, values)))
            ax.plot(factor * np.array(values), scale * np.array(one["one_at_a_time"], dtype=float), color=_TOTAL)
            ax.axvline(factor * study.nominal[k], color=_NOMINAL, lw=IDEAL_LINE, zorder=1)
            ax.ticklabel_format(axis="both", style="sci", scilimits=(-3, 5), useOffset=False)
            ax.locator_params(axis="x", nbins=4)
            ax.margins(y=0.1)
            ax.set_xlabel(axis_label(textwrap.fill(name_of_value(path), _NAME) + "\n", unit), fontsize=small_text())
            if k % across == 0:
                ax.set_ylabel(textwrap.fill(label, _NAME))
            ax.tick_params(labelleft=k % across == 0)
    told = (_widest(study, name, entry["variables"]) for name, entry in quantities.items())
    say(figure, *[one for one in told if one][:2] or ["No variable alone changes a quantity"])
    note(figure, "One variable at a time between its bounds. Grey: nominal.")
    return figure


def _widest(study: Study, name: str, rows: Mapping[str, Any]) -> str:
    """Tell which variable alone moves a quantity most; empty where none does."""
    found = {path: np.array(row["one_at_a_time"], dtype=float) for path, row in rows.items()}
    spans = {
        path: float(np.ptp(values[np.isfinite(values)])) for path, values in found.items() if np.isfinite(values).any()
    }
    if not spans or not max(spans.values()) > 0.0:
        return ""
    path = max(spans, key=spans.__getitem__)
    known = found[path][np.isfinite(found[path])]
    low, high = value_said(study, name, known.min()), value_said(study, name, known.max())
    return f"{name}: from {low} to {high} with the {name_of_value(path)} alone"
