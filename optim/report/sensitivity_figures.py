"""Figures of a sensitivity analysis."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from linkages.plots.style import COLORS, figure_style
from optim.problem.study import Study

_FIRST, _TOTAL, _NOMINAL = COLORS[5], COLORS[0], COLORS[1]


def write_indices(study: Study, report: Mapping[str, Any], path: Path) -> None:
    """Draw Sobol's indices of every quantity with their 95 % confidence intervals, as a PNG file.

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
    quantities = report["quantities"]
    places = np.arange(len(study.names))
    with figure_style():
        figure = Figure(figsize=(1.6 + 2.6 * len(quantities), 1.2 + 0.42 * len(places)), layout="constrained")
        axes = figure.subplots(1, len(quantities), sharey=True, squeeze=False)[0]
        for ax, (name, entry) in zip(axes, quantities.items(), strict=True):
            rows = entry["variables"].values()
            for kind, shift, colour, text in (
                ("first", -0.2, _FIRST, "first order: alone"),
                ("total", 0.2, _TOTAL, "total: with interactions"),
            ):
                value, half = (
                    np.array([row[key] for row in rows], dtype=float) for key in (kind, f"{kind}_confidence")
                )
                ax.barh(
                    places + shift, value, 0.38, xerr=half, color=colour, label=text, error_kw={"lw": 1.0}
                )
            for place, row in zip(places, rows, strict=True):
                if row["inert"]:
                    ax.text(0.02, place, "inert", va="center", color="0.35")
            ax.set_title(study.label(name), fontsize=9)
            ax.set_xlabel("share of the variance [1]")
            ax.set_xlim(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
        axes[0].set_yticks(places, study.names)
        axes[0].invert_yaxis()
        figure.suptitle(f"{report['title']}: Sobol's indices, bars of 95 % confidence", fontsize=10)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.savefig(path, format="png")


def write_one_at_a_time(study: Study, report: Mapping[str, Any], path: Path) -> None:
    """Draw every quantity over each variable between its bounds, the others nominal, as a PNG file.

    Parameters are those of `write_indices`.

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
    quantities = report["quantities"]
    shape = len(quantities), len(study.names)
    with figure_style():
        figure = Figure(figsize=(0.8 + 1.8 * shape[1], 0.6 + 1.9 * shape[0]), layout="constrained")
        axes = figure.subplots(*shape, sharex="col", sharey="row", squeeze=False)
        for line, (name, entry) in zip(axes, quantities.items(), strict=True):
            line[0].set_ylabel(study.label(name))
            for k, (ax, row) in enumerate(zip(line, entry["variables"].values(), strict=True)):
                grid = report["grid"][study.paths[k]]
                ax.plot(grid, np.array(row["one_at_a_time"], dtype=float), color=_TOTAL)
                ax.axvline(study.nominal[k], color=_NOMINAL, linestyle="--", linewidth=1.0)
                ax.ticklabel_format(axis="both", style="sci", scilimits=(-2, 3), useOffset=False)
                ax.margins(y=0.1)
        for ax, name in zip(axes[-1], study.names, strict=True):
            ax.set_xlabel(name)
        figure.suptitle(f"{report['title']}: one variable at a time (dashed: nominal), SI units", fontsize=10)
        figure.savefig(path, format="png")
