"""Figure of flexible links: deflection, stress and its place, strain energy."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from linkages.plots.style import COLORS, add_legend, axis_label, engineering
from linkages.results.assessment import Assessment


def links_figure(assessment: Assessment) -> Figure:
    """Draw deflections and the largest stress of each flexible link over time, and the strain energy of all.

    Next to each stress is its place along the link at each time.
    """
    system, run = assessment.system, assessment.run
    names = list(system.tree.flexible)
    figure = Figure(figsize=(6.3, 0.8 + 3.2 * len(names) + 1.4), layout="constrained")
    grid = figure.add_gridspec(2 * len(names) + 1, 2, width_ratios=[3, 1])
    strain = figure.add_subplot(grid[-1, 0])
    left = [strain]
    for k, name in enumerate(names):
        deflection, stress = (figure.add_subplot(grid[2 * k + row, 0], sharex=strain) for row in (0, 1))
        frames = [frame.name for frame in system.mechanism.frames if frame.link == name]
        moved, most = {frame: run[f"{frame}.deflection"] for frame in frames}, run[f"{name}.deflection"]
        unit, factor = engineering("m", float(most.max()))
        deflection.plot(run.time, factor * most, color="0.6", lw=0.9, label="largest magnitude")
        for (frame, values), color in zip(moved.items(), COLORS * len(moved), strict=False):
            if np.abs(values).max() > 1e-6 * most.max():  # without the ends, which are on the chord
                deflection.plot(run.time, factor * values, color=color, lw=0.9, label=frame)
        deflection.set_ylabel(axis_label(f"{name}:\ndeflection", unit))
        add_legend(deflection)
        values, place = run[f"{name}.stress"], run[f"{name}.stress_place"]
        unit, factor = engineering("Pa", float(values.max()))
        stress.plot(run.time, factor * values, color=COLORS[0], lw=0.9)
        stress.set_ylabel(axis_label("largest\nstress", unit))
        where = figure.add_subplot(grid[2 * k + 1, 1], sharey=stress)
        length = sum(piece.beam.length for piece in system.tree.flexible[name])
        along, scale = engineering("m", length)
        where.plot(scale * place, factor * values, ".", color=COLORS[0], ms=1.5)
        top = int(values.argmax())
        for axis, x in ((stress, run.time[top]), (where, scale * place[top])):
            axis.plot(x, factor * values[top], "o", color=COLORS[1], ms=4)
        where.set(xlim=(0.0, scale * length), xlabel=axis_label("place along\nthe beam", along))
        where.tick_params(labelleft=False)
        left += [deflection, stress]
    unit, factor = engineering("J", float(run["strain_energy"].max()))
    strain.plot(run.time, factor * run["strain_energy"], color=COLORS[0], lw=0.9)
    strain.set(xlabel="time [s]", ylabel=axis_label("strain\nenergy", unit))
    figure.align_ylabels(left)
    return figure
