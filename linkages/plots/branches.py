"""Diagram of branches of periodic motions: stable and unstable ones, bifurcations, the points of a sweep."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.explore.periodic.branches import Branch, Branches
from linkages.explore.periodic.motion import PeriodicMotion
from linkages.explore.periodic.multipliers import BRANCH_POINT, DOUBLING, FOLD, GRAZING, NEIMARK_SACKER
from linkages.explore.sweep import Sweep
from linkages.plots.shown import new_figure
from linkages.plots.style import COLORS, axis_label, engineering, figure_style

#: Mark of each kind of bifurcation.
_MARKS = {FOLD: "o", DOUBLING: "s", NEIMARK_SACKER: "^", GRAZING: "x", BRANCH_POINT: "D"}


def branches_figure(
    found: Branches, units: Mapping[str, str], label: str = "", scale: float = 1.0, sweep: Sweep | None = None
) -> Figure:
    """Draw the value at the end of each period of the drives, and the largest magnitude in it, over the variable.

    Lines are solid where the motion is stable, dashed where it is not; a sweep over the same variable gives points.
    `units` are the SI units of the outputs, `scale` is a factor on the variable, `label` its name.
    """
    rows = [(name, kind) for name in found.outputs for kind in ("strobe", "peaks")]
    with figure_style():
        figure, axes = new_figure(0.9 + 2.5 * len(rows), len(rows), 1, sharex=True, squeeze=False)
        axes = axes[:, 0]
        for axis, (name, kind) in zip(axes, rows, strict=True):
            largest = max(
                float(np.abs(motion.outputs.values(name, kind)).max())
                for branch in found.branches for motion in branch.motions if motion.outputs is not None
            )  # fmt: skip
            unit, factor = engineering(units[name], largest)
            if sweep is not None:
                _draw_sweep(axis, sweep, name, kind, scale, factor)
            for k, branch in enumerate(found.branches):
                _draw_branch(axis, branch, name, kind, scale, factor, COLORS[k % len(COLORS)])
            what = "at the end of a period" if kind == "strobe" else "peak in a period"
            axis.set_ylabel(f"{axis_label(name, unit)}\n{what}")
        axes[-1].set_xlabel(label or found.path)
        handles = dict(zip(*axes[0].get_legend_handles_labels()[::-1], strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=3, fontsize=8)
        return figure


def _draw_sweep(axis: Axes, sweep: Sweep, name: str, kind: str, scale: float, factor: float) -> None:
    for point in sweep.points:
        y = np.empty(0) if point.section is None else point.section.values(name, kind)
        axis.plot(np.full(len(y), scale * point.value), factor * y, ".", color="0.6", ms=3, zorder=1, label="sweep")


def _draw_branch(axis: Axes, branch: Branch, name: str, kind: str, scale: float, factor: float, color: str) -> None:
    """Draw a line for each period of the drives, solid between stable motions, and the bifurcations."""
    motions = _with_events(branch)
    x = scale * np.array([motion.value for motion in motions], dtype=np.float64)
    y = factor * np.array([motion.outputs.values(name, kind) for motion in motions if motion.outputs is not None])
    solid = [all(motion.stable is not False for motion in pair) for pair in pairwise(motions)]
    breaks = [0, *(np.flatnonzero(np.diff(solid)) + 1), len(solid)] if solid else []
    for first, last in pairwise(breaks):
        good = solid[first]
        label = f"{branch.periods} period{'s' if branch.periods > 1 else ''}, {'stable' if good else 'unstable'}"
        for line in y[first : last + 1].T:
            axis.plot(x[first : last + 1], line, color=color, ls="-" if good else "--", lw=1.2, zorder=2, label=label)
    for event in branch.events:
        if event.motion.outputs is None:
            continue
        at = factor * event.motion.outputs.values(name, kind)
        place = np.full(len(at), scale * (event.motion.value or 0.0))
        axis.plot(place, at, _MARKS[event.kind], color="black", ms=5, mfc="none", zorder=3, ls="", label=event.kind)


def _with_events(branch: Branch) -> list[PeriodicMotion]:
    """Return the motions of a branch with its bifurcations between them."""
    found, rest = [branch.motions[0]], [event for event in branch.events if event.kind != FOLD]
    for motion, ahead in pairwise(branch.motions):
        ends = motion.value or 0.0, ahead.value or 0.0
        while rest and min(ends) <= (rest[0].motion.value or 0.0) <= max(ends):
            found.append(rest.pop(0).motion)
        found.append(ahead)
    return found
