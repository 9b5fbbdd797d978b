"""Figures of linear models: natural modes and their frequencies over the drives' poses, Bode plots, sensitivities."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.explore.linearisation import StateSpace
from linkages.explore.modes import Modes, ModeShapes, ModesOver
from linkages.explore.sensitivity import Sensitivities
from linkages.show.plots.shown import new_figure
from linkages.show.plots.style import COLORS, engineering, figure_style, look, typeset

_SHARE = 0.12  # largest drawn displacement over the linkage's extent
_COLUMNS = 3


def shapes_figure(modes: Modes, count: int) -> Figure:
    """Draw the lowest mode shapes over the pose, in grey; each is magnified until visible."""
    with figure_style():
        lines, count = ModeShapes(modes).lines, min(count, len(modes.squares))
        rows, scale = -(-count // _COLUMNS), _SHARE * modes.system.tree.extent
        moved = np.concatenate([line.places + scale * line.ways[k] for line in lines for k in range(count)])
        wide, high = np.ptp(moved, axis=0)
        row = 0.7 + min(2.0 * high / wide, 2.0)
        figure, axes = new_figure(
            0.4 + row * rows, rows, min(count, _COLUMNS), squeeze=False, sharex=True, sharey=True, width=7.2
        )
        unit, factor = engineering("m", modes.system.tree.extent)
        for k, axis in enumerate(axes.ravel()):
            if k >= count:
                axis.axis("off")
                continue
            for line in lines:
                axis.plot(*(factor * line.places.T), color="0.75", lw=1.6, marker="o", markevery=[0, -1], ms=2)
            for line in lines:
                axis.plot(
                    *(factor * (line.places + scale * line.ways[k])).T,
                    color=line.color,
                    lw=1.4,
                    marker="o",
                    markevery=[0, -1],
                    ms=2,
                )
            axis.set_title(f"mode {k + 1}: {_frequency(modes.frequencies[k])}", fontsize="medium")
            axis.set_aspect("equal")
            axis.grid(False)
        for column in axes.T:
            axis = [one for one in column if one.axison][-1]
            axis.set_xlabel(f"x [{unit}]")
            axis.tick_params(labelbottom=True)
        for axis in axes[:, 0]:
            axis.set_ylabel(f"y [{unit}]")
        return figure


def frequencies_figure(over: ModesOver) -> Figure:
    """Draw the natural frequencies over the times at which the drives reach the poses."""
    with figure_style():
        figure, axis = new_figure(3.6)
        for k, values in enumerate(over.frequencies.T):
            axis.plot(over.times, values, lw=1.4, label=f"mode {k + 1}", **look(k))
        axis.set(xlabel="time at which the drives reach the pose [s]", ylabel="natural frequency at rest [Hz]")
        axis.set_ylim(bottom=0.0)
        figure.legend(loc="outside upper center", ncols=6, fontsize="small")
        return figure


def _frequency(value: float) -> str:
    if np.isnan(value):
        return "unstable"
    return f"{float(f'{value:.4g}'):.10g} Hz" if value else "moves freely"


def bode_figure(model: StateSpace, frequencies: Array, response: NDArray[np.complex128]) -> Figure:
    """Draw magnitude and phase of a response (no, nu, nf) over frequencies (nf,) [Hz]: each output over each input."""
    with figure_style():
        figure, (upper, lower) = new_figure(4.6, 2, 1, sharex=True)
        k, units = 0, set()
        for i, output in enumerate(model.outputs):
            for j, given in enumerate(model.inputs):
                if not response[i, j].any():
                    continue
                unit = f"{_factor(model.units[output])}/{_factor(model.units[given])}"
                units.add(unit)
                style = look(k) | {"lw": 1.2}
                upper.loglog(frequencies, np.abs(response[i, j]), label=f"{output} / {given} [{unit}]", **style)
                phase = np.degrees(np.unwrap(np.angle(response[i, j])))
                lower.semilogx(frequencies, phase - 360.0 * np.round(phase[0] / 360.0), **style)
                k += 1
        upper.set_ylabel(f"magnitude [{units.pop() if len(units) == 1 else 'see legend'}]")
        lower.set(xlabel="frequency [Hz]", ylabel="phase [°]")
        if k:
            figure.legend(loc="outside upper center", ncols=2, fontsize="small")
        return figure


def _factor(unit: str) -> str:
    """Write a unit as a factor of a product."""
    return f"({typeset(unit)})" if set(" /") & set(unit) else typeset(unit)


def tornado_figure(found: Sensitivities) -> Figure:
    """Draw the change of each peak with each value, the strongest first, with its error as a line."""
    keys = [key for key in found.numbers if key.endswith(".peak") and found.numbers[key] != 0.0]
    rows = -(-len(keys) // 2)
    with figure_style():
        height = 0.4 + rows * (0.9 + 0.24 * len(found.values))
        figure, axes = new_figure(height, max(rows, 1), 2, squeeze=False, width=7.2)
        for axis, key in zip(axes.flat, keys, strict=False):
            shares = {path: share for path in found.values if (share := found.per_cent(path, key)) is not None}
            paths = [path for _, path in sorted((abs(share), path) for path, share in shares.items())]
            scales = [abs(found.values[path] / found.numbers[key]) for path in paths]
            known = [np.nan if (error := found.errors[path][key]) is None else error for path in paths]
            heights = [100.0 * shares[path] for path in paths]
            axis.barh(paths, heights, color=[COLORS[0] if x > 0 else COLORS[1] for x in heights])
            axis.errorbar(heights, range(len(paths)), xerr=np.multiply(scales, known), fmt="none", ecolor="k", lw=0.8)
            axis.axvline(0.0, color="k", lw=0.6)
            axis.tick_params(axis="y", labelsize=7)
            axis.set_title(key, fontsize="medium")
            axis.set_xlabel("change with 1 % of the value [%]", fontsize="small")
            axis.xaxis.set_major_locator(MaxNLocator(4))
            axis.xaxis.set_major_formatter("{x:.3g}")
            if not any(heights):
                axis.set(xticks=[0.0], xlim=(-1.0, 1.0))
                said = "no change" if heights else "no statement about 1 %"
                axis.text(0.75, 0.5, said, transform=axis.transAxes, ha="center", va="center", fontsize="small")
        for axis in axes.flat[len(keys) :]:
            axis.axis("off")
        return figure
