"""Figures of blocks with clearance in their slots."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from linkages.plots.style import COLORS, add_legend, axis_label, engineering
from linkages.results.assessment import Assessment


def guides_figure(assessment: Assessment) -> Figure:
    """Draw the state of each block in its slot, and the transverse offsets of both ends over time.

    The state consists of the offset of the block's middle across the slot, and the additional offset of its front end
    (in the direction of the joint's axis). A corner touches if the sum of their magnitudes equals the clearance.
    """
    system, run = assessment.system, assessment.run
    names = [name for name in system.tree.play if name not in system.tree.journals]
    figure = Figure(figsize=(6.3, 2.9 * len(names)), layout="constrained")
    axes = figure.subplots(len(names), 2, squeeze=False, width_ratios=[2, 3])
    for (whole, ends), name in zip(axes, names, strict=True):
        joint = system.mechanism.joint[name]
        clearance = system.experiment.joints[name].clearance or 0.0
        unit, factor = engineering("m", clearance)
        middle = factor * run[f"{name}.offset"]
        lift = factor * run[f"{name}.tilt"] * (0.5 * joint.slot.length if joint.slot is not None else 0.0)
        wall = factor * clearance
        rim = wall * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
        whole.fill(*rim.T, facecolor="0.95", edgecolor="0.3", lw=1.2)
        whole.plot(lift, middle, color=COLORS[0], lw=0.7)
        whole.plot(lift[0], middle[0], "o", color=COLORS[2], ms=3.5, label="start")
        whole.set_title(f"joint {name}: contact on the rim", loc="left", fontsize=9)
        whole.set_aspect("equal", adjustable="datalim")
        whole.set(
            xlabel=axis_label("offset of front end $-$ middle", unit), ylabel=axis_label("offset of the middle", unit)
        )
        whole.legend(loc="upper right")
        reach = 1.15 * max(wall, float(np.abs(np.array([middle + lift, middle - lift])).max()))
        for side in (1.0, -1.0):
            ends.axhspan(side * wall, side * reach, color="0.9", zorder=0)
        ends.plot(run.time, middle + lift, color=COLORS[0], lw=0.9, label="front end")
        ends.plot(run.time, middle - lift, color=COLORS[1], lw=0.9, ls="--", label="back end")
        ends.set(
            xlabel="time [s]", ylabel=f"offset across the slot [{unit}]\n(grey: in the wall)", ylim=(-reach, reach)
        )
        add_legend(ends)
    return figure
