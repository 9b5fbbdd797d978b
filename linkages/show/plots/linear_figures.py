"""Figures of linear models: natural modes and their frequencies over the drives' poses, Bode plots."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.base.errors import listed
from linkages.base.palette import DATA_LINE, EDGE, SOFT
from linkages.explore.linearisation import StateSpace
from linkages.explore.modes import ModeLine, Modes, ModeShapes, ModesOver
from linkages.show.plots.names import name_of_output
from linkages.show.plots.panels import legend_below, make_panels, narrow, note, page, say
from linkages.show.plots.quantities import number
from linkages.show.plots.style import COLORS, engineering, figure_style, look, small_text, typeset

_SHARE = 0.12  # largest drawn displacement over the linkage's extent
_COLUMNS = 3, 2  # of mode shapes, and in one column of a page
_ARROWS = 7  # along a link of an axial mode
_INPUTS = 3  # most columns of a grid of responses
_DAMPED = 0.5**0.5  # damping ratio from which a mode has no resonance
_BENT = 1e-3  # deformation over the largest displacement from which a link is deformed


def shapes_figure(modes: Modes, count: int) -> Figure:
    """Draw the lowest mode shapes over the pose, in grey; each is magnified until visible.

    Links that stretch have arrows along them, as their shape is a straight line.
    """
    with figure_style():
        lines, count = ModeShapes(modes).lines, min(count, len(modes.squares))
        scale = _SHARE * modes.system.tree.extent
        moved = np.concatenate([line.places + scale * line.ways[k] for line in lines for k in range(count)])
        wide, high = np.ptp(moved, axis=0)
        row = 0.75 + min(1.75 * high / wide, 2.0)
        figure, axes = make_panels(count, row, *_COLUMNS, sharex=True, sharey=True)
        unit, factor = engineering("m", modes.system.tree.extent)
        across = _COLUMNS[narrow()]
        for k, axis in enumerate(axes):
            for line in lines:
                _draw_link(axis, factor * line.places, EDGE)
            for line in lines:
                _draw_link(axis, factor * (line.places + scale * line.ways[k]), line.color)
                if _stretches(line, k):
                    _draw_arrows(axis, line, k, factor, scale)
            kind = ", axial" if _axial(lines, k) else ""
            axis.set_title(f"{k + 1}: {_frequency(modes.frequencies[k])}{kind}", fontsize="medium", loc="left")
            axis.set_aspect("equal")
            axis.grid(False)
            axis.locator_params(nbins=4)
            axis.tick_params(labelbottom=k + across >= count, labelsize=small_text())
            if k + across >= count:
                axis.set_xlabel(f"x [{unit}]")
            if k % across == 0:
                axis.set_ylabel(f"y [{unit}]")
        say(figure, _lowest(modes, count))
        return figure


def _lowest(modes: Modes, count: int) -> str:
    known = modes.frequencies[:count][modes.frequencies[:count] > 0.0]
    unstable = int(np.isnan(modes.frequencies[:count]).sum())
    said = f"Lowest natural frequency: {number(float(known.min()))} Hz" if len(known) else "No mode vibrates"
    return f"{said}; unstable modes: {unstable}" if unstable else said


def _draw_link(axis: Axes, places: Array, color: str) -> None:
    axis.plot(*places.T, color=color, lw=0.8 if color == EDGE else DATA_LINE, marker="o", markevery=[0, -1], ms=2)


def _draw_arrows(axis: Axes, line: ModeLine, k: int, factor: float, scale: float) -> None:
    """Draw the displacements of points of a link that stretches."""
    some = np.unique(np.linspace(0, len(line.places) - 1, _ARROWS).round().astype(int))
    start, way = factor * line.places[some], factor * scale * line.ways[k][some]
    sizes: dict[str, Any] = {
        "scale": 1.0,
        "scale_units": "xy",
        "angles": "xy",
        "width": 0.012,
        "headwidth": 3.5,
        "headlength": 4.0,
    }
    axis.quiver(*start.T, *way.T, color=SOFT, zorder=3, **sizes)


def _deformations(line: ModeLine, k: int) -> tuple[float, float]:
    """Return how much a link stretches and bends in a mode, over the largest displacement of the linkage."""
    chord = line.places[-1] - line.places[0]
    if len(line.places) < 3 or not np.hypot(*chord) > 0.0:
        return 0.0, 0.0
    along = chord / np.hypot(*chord)
    ways, part = line.ways[k], (line.places - line.places[0]) @ along / np.hypot(*chord)
    across = ways @ np.array([-along[1], along[0]])
    straight = across[0] + part * (across[-1] - across[0])
    return float(np.ptp(ways @ along)), float(np.abs(across - straight).max())


def _stretches(line: ModeLine, k: int) -> bool:
    stretch, bend = _deformations(line, k)
    return stretch > max(bend, _BENT)


def _axial(lines: list[ModeLine], k: int) -> bool:
    """Tell whether the link that deforms most stretches."""
    most = max(lines, key=lambda line: max(_deformations(line, k)))
    return _stretches(most, k)


def frequencies_figure(over: ModesOver) -> Figure:
    """Draw the natural frequencies over the times at which the drives reach the poses."""
    with figure_style():
        figure, (axis,) = make_panels(1, 3.0)
        for k, values in enumerate(over.frequencies.T):
            axis.plot(over.times, values, label=f"mode {k + 1}", **look(k))
        axis.set(xlabel="time at which the drives reach the pose [s]", ylabel="natural frequency at rest [Hz]")
        axis.set_ylim(bottom=0.0)
        first = over.frequencies[:, 0]
        if np.isfinite(first).any():
            ends = dict.fromkeys(number(float(one)) for one in (np.nanmin(first), np.nanmax(first)))
            say(figure, f"Lowest natural frequency: {' to '.join(ends)} Hz over the cycle")
        legend_below(figure)
        return figure


def _frequency(value: float) -> str:
    if np.isnan(value):
        return "unstable"
    return f"{number(float(value))} Hz" if value else "moves freely"


def bode_figure(model: StateSpace, frequencies: Array, response: NDArray[np.complex128]) -> Figure:
    """Draw magnitude and phase of a response (no, nu, nf) over frequencies (nf,) [Hz]: each output over each input.

    If all respond, outputs are rows and inputs columns. Pairs without a response are named below.
    """
    pairs = [(i, j) for i in range(len(model.outputs)) for j in range(len(model.inputs))]
    told = [pair for pair in pairs if response[pair].any()]
    with figure_style():
        columns = 1 if narrow() else len(model.inputs) if told == pairs and len(model.inputs) <= _INPUTS else 2
        columns = min(columns, max(len(told), 1))
        rows = -(-len(told) // columns)
        figure = page(max(rows, 1) * 2.7)
        grid = figure.add_gridspec(max(rows, 1), columns)
        for k, (i, j) in enumerate(told):
            cell = grid[k // columns, k % columns].subgridspec(2, 1, height_ratios=(3, 2))
            upper, lower = (figure.add_subplot(cell[row]) for row in (0, 1))
            unit = f"{_factor(model.units[model.outputs[i]])}/{_factor(model.units[model.inputs[j]])}"
            _draw_response(upper, lower, frequencies, response[i, j])
            title = f"{name_of_output(model.outputs[i])} / {name_of_output(model.inputs[j])}"
            upper.set_title(title, loc="left", fontsize=small_text())
            upper.set_ylabel(f"magnitude\n[{unit}]")
        say(figure, _resonance(model))
        note(figure, *_silent(model, [pair for pair in pairs if pair not in told]))
        return figure


def _silent(model: StateSpace, pairs: list[tuple[int, int]]) -> list[str]:
    """Name the pairs without a response; an input to which nothing responds once."""
    mute = [j for j in range(len(model.inputs)) if sum(pair[1] == j for pair in pairs) == len(model.outputs)]
    said = [f"Nothing responds to {listed(name_of_output(model.inputs[j]) for j in mute)}."] if mute else []
    rest: dict[int, list[int]] = {}
    for i, j in pairs:
        if j not in mute:
            rest.setdefault(j, []).append(i)
    for j, several in rest.items():
        outputs = listed(name_of_output(model.outputs[i]) for i in several)
        said.append(f"No response to {name_of_output(model.inputs[j])}: {outputs}.")
    return said


def _draw_response(upper: Axes, lower: Axes, frequencies: Array, values: NDArray[np.complex128]) -> None:
    """Draw a response, its phase within half a turn at the lowest frequency."""
    upper.loglog(frequencies, np.abs(values), color=COLORS[0])
    low, high = upper.get_ylim()
    if high < 100.0 * low:  # else matplotlib writes many digits beside the decade
        upper.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        upper.yaxis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 2)))
    upper.yaxis.set_minor_formatter(NullFormatter())
    phase = np.degrees(np.unwrap(np.angle(values)))
    lower.semilogx(frequencies, phase - 360.0 * np.round(phase[0] / 360.0), color=COLORS[0])
    lower.sharex(upper)
    upper.tick_params(labelbottom=False)
    lower.set(xlabel="frequency [Hz]", ylabel="phase [°]")
    lower.locator_params(axis="y", nbins=4)


def _resonance(model: StateSpace) -> str:
    """Tell the frequency of the mode that is damped least."""
    ringing = [pole for pole in model.poles if pole.imag > 0.0 and abs(pole.real) < _DAMPED * abs(pole)]
    if not ringing:
        return "No resonance: all modes are damped"
    least = min(ringing, key=lambda pole: -pole.real / abs(pole))
    ratio = number(float(-least.real / abs(least)), 2)
    return f"Resonance at {number(float(abs(least) / (2.0 * np.pi)))} Hz, damping ratio {ratio}"


def _factor(unit: str) -> str:
    """Write a unit as a factor of a product."""
    return f"({typeset(unit)})" if set(" /") & set(unit) else typeset(unit)
