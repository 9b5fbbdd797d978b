"""Figures of an optimisation."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from linkages.files.writing import whole
from linkages.plots.style import COLORS, figure_style
from optim.algorithms import pareto
from optim.evaluate.limits import FEASIBLE
from optim.problem.study import Array, Study
from optim.store.store import Iteration

_BEST, _NOMINAL, *_DESIGNS = COLORS
_KNEE = "#000000"
_MARKERS = ("s", "^", "v", "P")


@dataclass(frozen=True)
class Panel:
    """An objective: its label with unit, -1 if it is maximised (else 1), the nominal design's value, minimised."""

    label: str
    sign: float
    nominal: float


def write_convergence(
    title: str, panels: Sequence[Panel], iterations: Sequence[Iteration], path: Path
) -> None:
    """Draw the best value of each objective over the evaluations, as a PNG file; replaces the one before."""
    with figure_style():
        figure = Figure(figsize=(5.5, 1.2 + 2.0 * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        count = [row.evaluations for row in iterations]
        for k, (ax, panel) in enumerate(zip(axes, panels, strict=True)):
            best = panel.sign * np.array([_best(row, k) for row in iterations])
            ax.step(count, best, where="post", color=_BEST, label="best")
            if np.isfinite(panel.nominal):
                ax.axhline(panel.sign * panel.nominal, color=_NOMINAL, linestyle="--", label="nominal")
            ax.set_ylabel(panel.label)
        axes[0].set_title(title)
        axes[0].legend()
        axes[-1].set_xlabel("evaluations")
        axes[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
        with whole(path) as partial:
            figure.savefig(partial, format="png")


def write_front(study: Study, result: Mapping[str, Any], path: Path) -> None:
    """Draw the front of several objectives, two at a time, as a PNG file.

    The knee (of a front without one, the compromise), the nominal and the reference designs are marked.

    Parameters
    ----------
    study : Study
    result : mapping
        Content of ``result.json``.
    path : Path

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_pareto"))
    >>> result = optim.optimise(study, algorithm={"name": "nsga2", "population": 6, "generations": 2})
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "front.png"
    >>> optim.write_front(study, result, file)
    >>> file.exists()
    True
    """
    names = list(study.file.objectives)
    labels = [study.label(name) for name in names]
    signs = [-1.0 if study.file.objectives[name].maximise else 1.0 for name in names]
    front = _objectives(result["front"], names)
    marked = "compromise" if pareto.knee(front * signs) is None else "knee"
    points = [
        ("front", front, {"marker": "o", "color": _BEST, "s": 12, "alpha": 0.7, "linewidths": 0}),
        (marked, _objectives([result["best"]], names), {"marker": "*", "color": _KNEE, "s": 110}),
        ("nominal", _objectives([result["nominal"]], names), {"marker": "D", "color": _NOMINAL, "s": 32}),
    ]
    for k, (name, entry) in enumerate(result["designs"].items()):
        look = {"marker": _MARKERS[k % 4], "color": _DESIGNS[k % 4], "s": 40}
        points.append((name, _objectives([entry], names), look))
    pairs = list(itertools.combinations(range(len(names)), 2))
    columns = min(len(pairs), 3)
    rows = -(-len(pairs) // columns)
    with figure_style():
        figure = Figure(figsize=(3.4 * columns, 0.9 + 2.8 * rows), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, (i, j) in zip(axes, pairs, strict=False):
            for which, at, look in points:
                ax.scatter(at[:, i], at[:, j], label=which, zorder=2 if which == "front" else 3, **look)
            for axis, k in ((ax.xaxis, i), (ax.yaxis, j)):
                better = "larger" if signs[k] < 0.0 else "smaller"
                axis.set_label_text(f"{labels[k]}, {better} is better")
            ax.margins(0.06)
            ax.locator_params(nbins=4)
            ax.ticklabel_format(useOffset=False, scilimits=(-3, 4))
        for ax in axes[len(pairs) :]:
            ax.set_visible(False)
        figure.suptitle(f"{study.title}: {len(front)} designs", fontsize=10)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=6)
        with whole(path) as partial:
            figure.savefig(partial, format="png")


def _objectives(entries: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Array:
    """Objectives of designs of ``result.json``, (m, no); NaN where one failed."""
    return np.array([[entry["objectives"][name] for name in names] for entry in entries], dtype=np.float64)


def _best(row: Iteration, k: int) -> float:
    """Smallest value of objective k among the best designs that satisfy the constraints; NaN if none does."""
    feasible = row.violation <= FEASIBLE
    return float(row.objectives[feasible, k].min()) if feasible.any() else np.nan
