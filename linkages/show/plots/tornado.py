"""The tornado chart: changes of peaks with values that grow by 1 %."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from linkages.show.plots.shown import ShownFigure
from linkages.show.plots.style import COLORS, figure_style

if TYPE_CHECKING:
    from linkages.explore.sensitivity import Sensitivities

_COLUMNS = 2


def tornado_figure(found: Sensitivities) -> Figure:
    """Draw the change of each peak with each value, the strongest first, with its error as a line."""
    keys = [key for key in found.numbers if key.endswith(".peak") and found.numbers[key] != 0.0]
    rows = -(-len(keys) // _COLUMNS)
    with figure_style():
        size = 7.2, 0.4 + rows * (0.9 + 0.24 * len(found.values))
        figure = ShownFigure(figsize=size, layout="constrained")
        axes = figure.subplots(max(rows, 1), _COLUMNS, squeeze=False).ravel()
        for axis, key in zip(axes, keys, strict=False):
            shares = {path: share for path in found.values if (share := found.per_cent(path, key)) is not None}
            paths = [path for _, path in sorted((abs(share), path) for path, share in shares.items())]
            errors = [
                0.01 * abs(found.values[path] / found.numbers[key]) * (found.errors[path][key] or 0.0) for path in paths
            ]
            heights = [100.0 * shares[path] for path in paths]
            axis.barh(paths, heights, color=[COLORS[0] if x > 0 else COLORS[1] for x in heights])
            axis.errorbar(heights, range(len(paths)), xerr=[100.0 * x for x in errors], fmt="none", ecolor="k", lw=0.8)
            axis.axvline(0.0, color="k", lw=0.6)
            axis.tick_params(axis="y", labelsize=7)
            axis.set_title(key, fontsize=9)
            axis.set_xlabel("change with 1 % of the value [%]", fontsize=8)
            axis.xaxis.set_major_locator(MaxNLocator(4))
            axis.xaxis.set_major_formatter("{x:.3g}")
            if not any(heights):
                axis.set(xticks=[0.0], xlim=(-1.0, 1.0))
                axis.text(0.75, 0.5, "no change", transform=axis.transAxes, ha="center", va="center", fontsize=8)
        for axis in axes[len(keys) :]:
            axis.axis("off")
        return figure
