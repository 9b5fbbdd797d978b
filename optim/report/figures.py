"""Figures of an optimisation, as files that are written whole or not at all."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.base.brief import counted
from linkages.base.palette import IDEAL, IDEAL_LINE, INK
from linkages.input.files.writing import whole
from linkages.show.plots.panels import legend_below, make_panels, say
from linkages.show.plots.quantities import change, quantity
from linkages.show.plots.style import COLORS, axis_label, engineering, figure_style, save_figure, typeset
from optim.algorithms import pareto
from optim.algorithms.nlp import Values
from optim.evaluate.limits import FEASIBLE
from optim.problem.study import Array, Study
from optim.search.result import Design, StudyResult

_BEST, *_DESIGNS = COLORS
_NOMINAL, _KNEE = IDEAL, INK
_MARKERS = ("s", "^", "v", "P")


def write(path: Path, draw: Callable[[], Figure]) -> None:
    """Draw a figure in the common style, and write it whole or not at all."""
    with figure_style():
        figure = draw()
        with whole(path) as partial:
            save_figure(figure, partial, path.suffix[1:] or "png")


def write_convergence(study: Study, title: str, values: Values, path: Path) -> None:
    """Draw each objective of every design in the order of evaluation, and the best so far; replaces the figure before.

    The values (m,) are those that the algorithm minimises; the first design is the nominal one. Designs that violate
    constraints are open circles, failed ones are missing.
    """
    write(path, lambda: _convergence(study, title, values))


def _convergence(study: Study, title: str, values: Values) -> Figure:
    names, feasible = list(study.file.objectives), values.violation <= FEASIBLE
    count = np.arange(1.0, 1.0 + len(feasible), dtype=np.float64)
    figure, axes = make_panels(len(names), 2.0, 1, sharex=True)
    told = [f"{title}: {counted(len(count), 'design')}"]
    for ax, name, sign, column in zip(axes, names, study.signs, values.objectives.T, strict=True):
        found = sign * np.where(np.isfinite(column), column, np.nan)
        best = sign * np.fmin.accumulate(np.where(feasible, column, np.inf))
        best[np.isinf(best)] = np.nan
        _draw_designs(ax, count, found, feasible)
        ax.step([*count, count[-1] + 0.5], [*best, best[-1]], where="post", color=_BEST, label="best so far")
        if np.isfinite(found[0]):
            ax.axhline(found[0], color=_NOMINAL, lw=IDEAL_LINE, zorder=1, label=_named(feasible[0]))
        if np.isfinite(best[-1]):
            _mark_best(ax, count, best)
        told.append(_reached(study, name, best[-1], found[0]))
        ax.set_ylabel(label_of(study, name))
        ax.set_ylim(*_seen(found, best, feasible))
        ax.ticklabel_format(useOffset=False)
    axes[-1].set_xlim(0.5, count[-1] + 0.5)
    axes[-1].set_xlabel("evaluations")
    axes[-1].xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    say(figure, *told)
    legend_below(figure, axes[:1])
    return figure


def _reached(study: Study, name: str, best: float, nominal: float) -> str:
    """Tell the best value of an objective, and its change from the nominal design."""
    if not np.isfinite(best):
        return f"{name}: no design satisfies the constraints yet"
    told = change(best, nominal, "nominal")
    return f"{name}: best {value_said(study, name, best)}" + (f", {told}" if told else "")


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
    write(path, lambda: _front(study, labels, points, marked))


def _front(study: Study, labels: list[str], points: list[tuple[str, Array, dict[str, Any]]], marked: str) -> Figure:
    """Draw pairs of objectives; `points` are groups of designs with their looks, the front first."""
    pairs = list(itertools.combinations(range(len(labels)), 2))
    figure, axes = make_panels(len(pairs), 2.8)
    for ax, (i, j) in zip(axes, pairs, strict=True):
        for which, at, look in points:
            ax.scatter(at[:, i], at[:, j], label=which, zorder=2 if which == "Pareto front" else 3, **look)
        for axis, k in ((ax.xaxis, i), (ax.yaxis, j)):
            better = "larger" if study.signs[k] < 0.0 else "smaller"
            axis.set_label_text(f"{labels[k]},\n{better} is better")
        ax.margins(0.08)
        ax.locator_params(nbins=4)
        ax.ticklabel_format(useOffset=False, scilimits=(-3, 4))
    (_, front, _), (_, best, _), (_, nominal, _), *_ = points
    changes = (
        f"{labels[k].partition(' [')[0]} {change(best[0, k], nominal[0, k], 'nominal')}" for k in range(len(labels))
    )
    say(figure, f"{counted(len(front), 'design')} on the front; the {marked}: {', '.join(changes)}")
    legend_below(figure, axes[:1])
    return figure


write_front = write_pareto_front  # its earlier name


def label_of(study: Study, name: str) -> str:
    """Name of an objective or constraint, with its unit as figures write it."""
    text, bracket, unit = study.label(name).rpartition(" [")
    return f"{text} [{typeset(unit)}" if bracket else unit


def scaled_label(study: Study, name: str, values: Array) -> tuple[str, float]:
    """Return the label of a quantity in a unit that suits its values, and their factor."""
    unit = study.unit(name)
    finite = np.abs(values[np.isfinite(values)])
    readable, factor = engineering(unit, float(finite.max(initial=0.0)))
    return axis_label(name, readable), factor


def value_said(study: Study, name: str, value: float) -> str:
    """Write a value of a quantity with its readable unit."""
    return quantity(float(value), study.unit(name))


def _objectives(entries: Sequence[Design], names: Sequence[str]) -> Array:
    """Objectives of designs of ``result.json``, (m, no); NaN where one failed."""
    return np.array([[entry.objectives[name] for name in names] for entry in entries], dtype=np.float64)
