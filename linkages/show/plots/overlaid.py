"""Figure of several runs, also of different machines: a panel for each output, a curve for each run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from linkages.results.trajectory import Trajectory
from linkages.show.plots.shown import ShownFigure
from linkages.show.plots.style import COLORS, LEGEND, LINES, axis_label, figure_style, readable, stacked_axes


def overlay_figure(runs: Mapping[str, Trajectory], names: Sequence[str]) -> ShownFigure:
    """Draw columns of runs over time, a panel for each column; a run without the column has no curve there.

    Parameters
    ----------
    runs : mapping of str to Trajectory
        Runs by their names in the legend.
    names : sequence of str
        Columns, such as "B.force".

    Examples
    --------
    >>> import linkages
    >>> from linkages.plots import overlay_figure
    >>> systems = {name: linkages.load(linkages.find_file(f"{name}.toml")) for name in ("seven_bar", "six_bar_dry")}
    >>> runs = {name: linkages.ideal(system) for name, system in systems.items()}
    >>> figure = overlay_figure(runs, ["A.force"])
    >>> len(figure.axes[0].lines)
    2
    """
    with figure_style():
        figure = ShownFigure(figsize=(6.3, 0.9 + 2.4 * len(names)))
        axes = stacked_axes(figure, [1.0] * len(names))
        for axis, name in zip(axes, names, strict=True):
            found = {label: run for label, run in runs.items() if name in run}
            values = np.concatenate([run[name] for run in found.values()])
            unit, factor = readable(next(iter(found.values())).units.get(name, ""), float(np.abs(values).max()))
            for k, (label, run) in enumerate(runs.items()):
                if label in found:
                    look = {"color": COLORS[k % len(COLORS)], "ls": LINES[k // len(COLORS) % len(LINES)]}
                    axis.plot(run.time, factor * run[name], lw=1.0, label=label, **look)
            axis.set_ylabel(axis_label(name, unit))
        lines = {line.get_label(): line for axis in axes for line in axis.get_lines()}
        axes[0].legend(lines.values(), lines.keys(), **LEGEND)
        figure.align_ylabels(axes)
        axes[-1].set_xlabel("time [s]")
        return figure
