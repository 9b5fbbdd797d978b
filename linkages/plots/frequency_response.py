"""Bode plot of a linear model."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.arrays import Array
from linkages.explore.linearisation import StateSpace
from linkages.plots.style import COLORS, LINES, figure_style, typeset


def bode_figure(model: StateSpace, frequencies: Array, response: NDArray[np.complex128]) -> Figure:
    """Draw magnitude and phase of a response (no, nu, nf) over frequencies (nf,) [Hz]: each output over each input."""
    with figure_style():
        figure = Figure(figsize=(6.3, 4.6), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        k, units = 0, set()
        for i, output in enumerate(model.outputs):
            for j, given in enumerate(model.inputs):
                if not response[i, j].any():
                    continue
                unit = f"{_factor(model.units[output])}/{_factor(model.units[given])}"
                units.add(unit)
                style = {"color": COLORS[k % len(COLORS)], "ls": LINES[k % len(LINES)], "lw": 1.2}
                upper.loglog(frequencies, np.abs(response[i, j]), label=f"{output} / {given} [{unit}]", **style)
                phase = np.degrees(np.unwrap(np.angle(response[i, j])))
                lower.semilogx(frequencies, phase - 360.0 * np.round(phase[0] / 360.0), **style)
                k += 1
        upper.set_ylabel(f"magnitude [{units.pop() if len(units) == 1 else 'see legend'}]")
        lower.set(xlabel="frequency [Hz]", ylabel="phase [°]")
        if k:
            figure.legend(loc="outside upper center", ncols=2, fontsize=8)
        return figure


def _factor(unit: str) -> str:
    """Write a unit as a factor of a product."""
    return f"({typeset(unit)})" if set(" /") & set(unit) else typeset(unit)
