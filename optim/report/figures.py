"""Figures of an optimisation and of a sensitivity analysis, as files that are written whole or not at all."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from linkages.base.brief import counted
from linkages.input.files.writing import whole
from linkages.show.plots.style import COLORS, axis_label, figure_style, save_figure, stacked_axes, typeset
from optim.algorithms import pareto
from optim.algorithms.nlp import Values
from optim.evaluate.limits import FEASIBLE
from optim.problem.study import Array, Study
from optim.search.result import Design, StudyResult
from optim.store.store import Iteration

_BEST, _NOMINAL, *_DESIGNS = COLORS
_KNEE = "#000000"
_MARKERS = ("s", "^", "v", "P")
_FIRST, _TOTAL = COLORS[5], COLORS[0]
_LINE = 42  # letters of a title above a panel of a front


@contextmanager
def png(
    path: Path, width: float, height: float, layout: Literal["constrained"] | None = "constrained"
) -> Iterator[Figure]:
    """Give a figure of this size [inches] to draw in, and write it."""
    with figure_style():
        figure = Figure(figsize=(width, height), layout=layout)
        yield figure
        with whole(path) as partial:
            save_figure(figure, partial, path.suffix[1:] or "png")


def write_convergence(study: Study, title: str, iterations: Sequence[Iteration], nominal: Values, path: Path) -> None:
    """Draw the best value of each objective over the evaluations; replaces the figure before.

    The values of the nominal design, one row, are the values that the algorithm minimises.
    """
    named = "nominal" if nominal.violation[0] <= FEASIBLE else "nominal, violates constraints"
    names = list(study.file.objectives)
    with png(path, 5.5, 1.2 + 2.0 * len(names), layout=None) as figure:
        axes = stacked_axes(figure, [1.0] * len(names))
        count = [row.evaluations for row in iterations]
        best = np.array([row.best_feasible for row in iterations])
        for k, (ax, name, sign) in enumerate(zip(axes, names, study.signs, strict=True)):
            ax.step(count, sign * best[:, k], where="post", color=_BEST, label="best")
            if np.isfinite(value := nominal.objectives[0, k]):
                ax.axhline(sign * value, color=_NOMINAL, linestyle="--", label=named)
            ax.set_ylabel(label_of(study, name))
            ax.ticklabel_format(axis="y", useOffset=False)
        axes[0].set_title(title)
        axes[0].legend()
        axes[-1].set_xlabel("evaluations")
        axes[-1].xaxis.set_major_locator(MaxNLocator(integer=True))


def write_pareto_front(study: Study, result: StudyResult, path: Path) -> None:
    """Draw the Pareto front of several objectives, two at a time.

    The knee (of a Pareto front without one, the compromise), the nominal and the reference designs are marked.

    Parameters
    ----------
    study : Study
    result : StudyResult
        From `optim.optimise`.
    path : Path

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_pareto"))
    >>> result = optim.optimise(study, algorithm={"name": "nsga2", "population": 6, "generations": 2})
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "front.png"
    >>> optim.write_pareto_front(study, result, file)
    >>> file.exists()
    True
    """
    names = list(study.file.objectives)
    labels = [label_of(study, name) for name in names]
    front = _objectives(result.front, names)
    marked = "compromise" if pareto.knee(front * study.signs) is None else "knee"
    points = [
        ("Pareto front", front, {"marker": "o", "color": _BEST, "s": 12, "alpha": 0.7, "linewidths": 0}),
        (marked, _objectives([result.best], names), {"marker": "*", "color": _KNEE, "s": 110}),
        ("nominal", _objectives([result.nominal], names), {"marker": "D", "color": _NOMINAL, "s": 32}),
    ]
    for k, (name, entry) in enumerate(result.designs.items()):
        look = {"marker": _MARKERS[k % 4], "color": _DESIGNS[k % 4], "s": 40}
        points.append((name, _objectives([entry], names), look))
    pairs = list(itertools.combinations(range(len(names)), 2))
    columns = min(len(pairs), 3)
    rows = -(-len(pairs) // columns)
    with png(path, 3.4 * columns, 0.9 + 2.8 * rows) as figure:
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, (i, j) in zip(axes, pairs, strict=False):
            for which, at, look in points:
                ax.scatter(at[:, i], at[:, j], label=which, zorder=2 if which == "Pareto front" else 3, **look)
            for axis, k in ((ax.xaxis, i), (ax.yaxis, j)):
                better = "larger" if study.signs[k] < 0.0 else "smaller"
                axis.set_label_text(f"{labels[k]}, {better} is better")
            ax.margins(0.06)
            ax.locator_params(nbins=4)
            ax.ticklabel_format(useOffset=False, scilimits=(-3, 4))
        for ax in axes[len(pairs) :]:
            ax.set_visible(False)
        title = textwrap.fill(f"{study.title}: {counted(len(front), 'design')}", _LINE * columns)
        figure.suptitle(title, fontsize="medium")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2 * columns)


write_front = write_pareto_front  # its earlier name


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
    quantities = report["quantities"]
    places = np.arange(len(study.names))
    with png(path, 1.6 + 2.6 * len(quantities), 1.2 + 0.42 * len(places)) as figure:
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
                ax.barh(places + shift, value, 0.38, xerr=half, color=colour, label=text, error_kw={"lw": 1.0})
            for place, row in zip(places, rows, strict=True):
                if row["inert"]:
                    ax.text(0.02, place, "inert", va="center", color="0.35")
            ax.set_title(label_of(study, name), fontsize="medium")
            ax.set_xlabel("share of the variance [1]")
            ax.set_xlim(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
        axes[0].set_yticks(places, study.names)
        axes[0].invert_yaxis()
        figure.suptitle(f"{report['title']}\nSobol's indices, bars of 95 % confidence", fontsize="medium")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)


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
    quantities = report["quantities"]
    shape = len(quantities), len(study.names)
    with png(path, 0.8 + 1.8 * shape[1], 0.6 + 1.9 * shape[0]) as figure:
        axes = figure.subplots(*shape, sharex="col", sharey="row", squeeze=False)
        for line, (name, entry) in zip(axes, quantities.items(), strict=True):
            line[0].set_ylabel(label_of(study, name))
            for k, (ax, row) in enumerate(zip(line, entry["variables"].values(), strict=True)):
                grid = report["grid"][study.paths[k]]
                ax.plot(grid, np.array(row["one_at_a_time"], dtype=float), color=_TOTAL)
                ax.axvline(study.nominal[k], color=_NOMINAL, linestyle="--", linewidth=1.0)
                ax.ticklabel_format(axis="both", style="sci", scilimits=(-2, 3), useOffset=False)
                ax.margins(y=0.1)
        for ax, name, value in zip(axes[-1], study.names, study.paths, strict=True):
            unit = study.points[0].system.value_unit(value)
            ax.set_xlabel(axis_label(f"{name}\n", "" if unit == "1" else typeset(unit)))  # a power of ten follows
        figure.suptitle(f"{report['title']}: one variable at a time (dashed: nominal)", fontsize="medium")


def label_of(study: Study, name: str) -> str:
    """Name of an objective or constraint, with its unit as figures write it."""
    text, bracket, unit = study.label(name).rpartition(" [")
    return f"{text} [{typeset(unit)}" if bracket else unit


def _objectives(entries: Sequence[Design], names: Sequence[str]) -> Array:
    """Objectives of designs of ``result.json``, (m, no); NaN where one failed."""
    return np.array([[entry.objectives[name] for name in names] for entry in entries], dtype=np.float64)
