"""Figures of an optimisation and of a sensitivity analysis, as files that are written whole or not at all."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.base.brief import counted
from linkages.base.palette import IDEAL, INK, LINE, SOFT
from linkages.input.files.writing import whole
from linkages.show.plots.style import COLORS, axis_label, figure_style, save_figure, stacked_axes, typeset
from optim.algorithms import pareto
from optim.algorithms.nlp import Values
from optim.evaluate.limits import FEASIBLE
from optim.problem.study import Array, Study
from optim.search.result import Design, StudyResult

_BEST, *_DESIGNS = COLORS
_NOMINAL, _KNEE = IDEAL, INK
_MARKERS = ("s", "^", "v", "P")
_FIRST, _TOTAL = COLORS[3], COLORS[0]
_ROUNDING, _WIDE = 1e-9, 0.1  # of shares, of half an interval that says little [1]
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


def write_convergence(study: Study, title: str, values: Values, path: Path) -> None:
    """Draw each objective of every design in the order of evaluation, and the best so far; replaces the figure before.

    The values (m,) are those that the algorithm minimises; the first design is the nominal one. Designs that violate
    constraints are open circles, failed ones are missing.
    """
    names, feasible = list(study.file.objectives), values.violation <= FEASIBLE
    count = np.arange(1.0, 1.0 + len(feasible), dtype=np.float64)
    with png(path, 5.5, 1.2 + 2.0 * len(names), layout=None) as figure:
        axes = stacked_axes(figure, [1.0] * len(names))
        for ax, name, sign, column in zip(axes, names, study.signs, values.objectives.T, strict=True):
            found = sign * np.where(np.isfinite(column), column, np.nan)
            best = sign * np.fmin.accumulate(np.where(feasible, column, np.inf))
            best[np.isinf(best)] = np.nan
            _draw_designs(ax, count, found, feasible)
            ax.step([*count, count[-1] + 0.5], [*best, best[-1]], where="post", color=_BEST, label="best so far")
            if np.isfinite(found[0]):
                ax.axhline(found[0], color=_NOMINAL, lw=2.0, zorder=1, label=_named(feasible[0]))
            if np.isfinite(best[-1]):
                _mark_best(ax, count, best)
            ax.set_ylabel(label_of(study, name))
            ax.set_ylim(*_seen(found, best, feasible))
            ax.ticklabel_format(useOffset=False)
        axes[0].set_title(title, loc="left")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="lower right", ncols=4, fontsize="small")
        axes[-1].set_xlim(0.5, count[-1] + 0.5)
        axes[-1].set_xlabel("evaluations", loc="left")
        axes[-1].xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def _named(feasible: bool) -> str:
    return "nominal" if feasible else "nominal, violates constraints"


def _draw_designs(ax: Axes, count: Array, found: Array, feasible: NDArray[np.bool_]) -> None:
    """Draw feasible designs as dots, others as open circles."""
    looks = {"feasible": (feasible, _BEST), "violates constraints": (~feasible, "none")}
    for label, (which, fill) in looks.items():
        if np.isfinite(found[which]).any():
            ax.scatter(count[which], found[which], 10, fill, edgecolors=_BEST, linewidths=0.6, alpha=0.6, label=label)


def _mark_best(ax: Axes, count: Array, best: Array) -> None:
    """Mark the best design by a star with its number."""
    first = int(np.argmax(best == best[-1]))
    ax.plot(count[first], best[first], "*", color=_KNEE, ms=9, zorder=4)
    late = first > 0.7 * len(count)
    ax.annotate(
        f"{best[first]:.5g}", (count[first], best[first]), (-6 if late else 6, -4), textcoords="offset points",
        ha="right" if late else "left", va="top",
    )  # fmt: skip


def _seen(found: Array, best: Array, feasible: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the range of values that is drawn: the best ones, the nominal one, and most of the others."""
    usual = found[feasible & np.isfinite(found)] if feasible.any() else found[np.isfinite(found)]
    shown = np.concatenate([best[np.isfinite(best)], found[:1][np.isfinite(found[:1])]])
    shown = np.append(shown, np.percentile(usual, [10.0, 90.0]) if len(usual) else [])
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.0, 1.0)
    room = 0.15 * (high - low) or 0.05 * abs(high) or 1.0
    return low - 1.5 * room, high + room


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
    places, vague = np.arange(len(study.names), dtype=np.float64), False
    with png(path, 1.6 + 2.6 * len(quantities), 1.2 + 0.42 * len(places)) as figure:
        axes = figure.subplots(1, len(quantities), sharey=True, squeeze=False)[0]
        for ax, (name, entry) in zip(axes, quantities.items(), strict=True):
            rows = entry["variables"].values()
            for kind, shift, colour, text in (
                ("first", -0.2, _FIRST, "first order: alone"),
                ("total", 0.2, _TOTAL, "total: with interactions"),
            ):
                value, half = (
                    np.array([row[key] for row in rows], dtype=np.float64) for key in (kind, f"{kind}_confidence")
                )
                vague = draw_shares(ax, places + shift, value, half, colour, text) or vague
            for place, row in zip(places, rows, strict=True):
                if row["inert"]:
                    ax.text(0.02, place, "inert", va="center", color=SOFT)
            ax.set_title(label_of(study, name), fontsize="medium")
            ax.set_xlabel("share of the variance [1]")
            ax.set_xlim(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
        axes[0].set_yticks(places, study.names)
        axes[0].invert_yaxis()
        few = f"\ngrey: uncertain; {counted(report['evaluations'], 'design')} are too few" if vague else ""
        figure.suptitle(f"{report['title']}\nSobol's indices, bars of 95 % confidence{few}", fontsize="medium")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)


def draw_shares(ax: Axes, places: Array, share: Array, half: Array, color: str, label: str) -> bool:
    """Draw shares of a variance as bars with half their intervals of confidence; return whether one is uncertain.

    A share is grey where its interval contains 0 or exceeds 1. It is uncertain if that interval is wide too.
    """
    vague = (share - half <= 0.0) & (half > 0.0) | (share + half > 1.0 + _ROUNDING)
    look: dict[str, Any] = {"height": 0.38, "error_kw": {"lw": 1.0, "ecolor": INK}}
    ax.barh(places, share, xerr=half, color=[LINE if one else color for one in vague], edgecolor=color, lw=0.6, **look)
    ax.barh([], [], color=color, label=label)  # of the legend
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
