"""Figure of several runs, also of different machines: a panel for each output, a curve for each run."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from linkages.results.trajectory import Trajectory
from linkages.show.plots.names import name_of_output
from linkages.show.plots.panels import legend_below, make_panels, say
from linkages.show.plots.quantities import quantity
from linkages.show.plots.style import COLORS, LINES, axis_label, figure_style, readable

_LETTERS = 20  # of a line of a label


def _largest(runs: Mapping[str, Trajectory], names: Sequence[str]) -> list[str]:
    """Tell the largest value of the first column in each run."""
    name = names[0]
    peaks = {label: float(np.abs(run[name]).max()) for label, run in runs.items() if name in run}
    si = next(run.units.get(name, "") for label, run in runs.items() if label in peaks)
    told = (f"{quantity(peak, si)} in {label}" for label, peak in peaks.items())
    return [f"Largest {name_of_output(name)}: {', '.join(told)}"]


def overlay_figure(runs: Mapping[str, Trajectory], names: Sequence[str]) -> Figure:
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
        figure, axes = make_panels(len(names), 2.2, 1, sharex=True)
        for axis, name in zip(axes, names, strict=True):
            found = {label: run for label, run in runs.items() if name in run}
            values = np.concatenate([run[name] for run in found.values()])
            unit, factor = readable(next(iter(found.values())).units.get(name, ""), float(np.abs(values).max()))
            for k, (label, run) in enumerate(runs.items()):
                if label in found:
                    look: dict[str, Any] = {
                        "color": COLORS[k % len(COLORS)],
                        "ls": LINES[k // len(COLORS) % len(LINES)],
                    }
                    axis.plot(run.time, factor * run[name], lw=1.0, label=label, **look)
            axis.set_ylabel(axis_label(textwrap.fill(name_of_output(name), _LETTERS), unit))
        say(figure, *_largest(runs, names))
        legend_below(figure)
        figure.align_ylabels(axes)
        axes[-1].set_xlabel("time [s]")
        return figure
