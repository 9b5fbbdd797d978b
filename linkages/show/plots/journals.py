"""Figures of journals in their bearings and blocks in their slots: orbits, contacts over time, by kind of contact."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.base.brief import counted
from linkages.base.palette import INK, LINE, PANEL, PLAY, SOFT
from linkages.input.model.skeleton import OTHER
from linkages.results.assessment import Assessment, touching
from linkages.results.impacts import FREE, IMPACT, SUSTAINED_CONTACT, phases
from linkages.results.trajectory import Trajectory
from linkages.show.plots.names import sentence
from linkages.show.plots.panels import WIDE, legend_below, make_panels, narrow, say
from linkages.show.plots.quantities import number, quantity
from linkages.show.plots.shown import ShownFigure
from linkages.show.plots.style import (
    COLORS,
    axis_label,
    color_for,
    engineering,
    round_length,
    small_text,
    stacked_axes,
    write_answer,
)
from linkages.system import System

# phases of a journal: label, colour, width; distinct in grey too
_PHASES = {
    FREE: ("free flight", COLORS[3], 0.7),
    SUSTAINED_CONTACT: ("sustained contact", INK, 1.4),
    IMPACT: ("impact", PLAY, 1.4),
}

# marks of a journal, and of a guide's corners
_MARKS = {"": "o", "upper": "o", "lower": "s", "corner1": "o", "corner2": "s", "corner3": "^", "corner4": "D"}
_FEW = 4  # most panels of orbits that are large
_GAP, _LEFT = 0.3, 0.8  # room above a panel and at its left [in]
_DOTTED = 10  # contacts with a dot, the largest ones
_INSET, _MAGNIFIED = 0.4, 4.0  # size of a magnified orbit in its axes; least magnification
_AROUND = 1.15  # axis limit over the drawn range
_CHORD = 0.05  # distance of points of a drawn orbit over the clearance
_MOST_SEGMENTS = 2000  # most refined segments of a drawn orbit


def orbits_figure(assessment: Assessment) -> Figure:
    """Draw each journal's centre in its clearance circle, and for a joint with contact the penetration over the angle.

    A small orbit is drawn again, magnified, in its circle.
    """
    names, touches = assessment.system.tree.journals, touching(assessment.system)
    count = sum(1 + (name in touches) for name in names)
    few = narrow() or count <= _FEW
    figure, axes = make_panels(count, 3.1 if few and not narrow() else 2.2, 2 if few else 4, 2)
    rest = iter(axes)
    for name in names:
        _draw_orbit(assessment, name, next(rest), next(rest) if name in touches else None)
    peaks = {name: float(np.max(assessment.run[f"{name}.eccentricity_ratio"])) for name in names}
    most = max(peaks, key=peaks.__getitem__)
    say(figure, f"Largest eccentricity over the clearance: {number(peaks[most], 3)}, in {most}")
    start = Line2D([], [], color=OTHER, marker="o", ms=3.5, lw=0.0, label="start")
    filled = all(model.has_film for model in assessment.system.models if model.can_touch)
    handles = [
        Line2D([], [], color=color, lw=2.0, label="film alone" if filled and code == FREE else label)
        for code, (label, color, _) in _PHASES.items()
        if touches
    ]
    legend_below(figure, entries={str(one.get_label()): one for one in [*handles, start]})
    return figure


def _draw_orbit(assessment: Assessment, name: str, whole: Axes, wall: Axes | None) -> None:
    """Draw the orbit of a journal and, if there is a panel for it, its penetration into the wall."""
    clearance = 1e6 * (assessment.system.joints[name].clearance or 0.0)
    ex, ey = 1e6 * assessment.run[f"{name}.ex"], 1e6 * assessment.run[f"{name}.ey"]
    reach = _AROUND * max(clearance, float(np.hypot(ex, ey).max()))
    _draw_circle(whole, clearance)
    peak = float(np.max(assessment.run[f"{name}.eccentricity_ratio"]))
    whole.set_title(f"{name}: e/c up to {number(peak, 3)}", fontsize="medium", loc="left")
    if wall is not None:
        path, phase = finely(assessment, name)
        _draw_phases(whole, 1e6 * path, phase)
        _draw_wall(wall, 1e6 * path, clearance, phase)
    else:
        color = color_for(assessment.system.colors, name)
        whole.plot(ex, ey, color=color, lw=1.0)
        _magnify(whole, np.column_stack([ex, ey]), reach, color)
    whole.plot(ex[0], ey[0], "o", color=OTHER, ms=3.5)
    whole.set(xlim=(-reach, reach), ylim=(-reach, reach))
    whole.set_aspect("equal", adjustable="box")
    whole.set(xlabel="e$_x$ [µm]", ylabel="e$_y$ [µm]")
    for axis in (whole,) if wall is None else (whole, wall):
        axis.locator_params(nbins=3 if narrow() else 5, axis="both")


def _magnify(axis: Axes, path: Array, reach: float, color: str) -> None:
    """Draw a small orbit (nt, 2) again, magnified by a round factor, inside axes from -reach to reach."""
    low, high = path.min(axis=0), path.max(axis=0)
    middle, half = 0.5 * (low + high), _AROUND * max(0.5 * float((high - low).max()), 1e-9 * reach)
    times = round_length(max(reach * _INSET / half, 1.0))[0]
    if times < _MAGNIFIED:
        return
    left, below = (0.0 if value > 0.0 else 1.0 - _INSET for value in middle)  # in the corner opposite to the orbit
    inset = axis.inset_axes((left, below, _INSET, _INSET))
    inset.plot(*path.T, color=color, lw=1.0)
    inset.plot(*path[0], "o", color=OTHER, ms=3.5)
    around = np.array([-reach, reach]) * _INSET / times
    inset.set(xlim=middle[0] + around, ylim=middle[1] + around, xticks=[], yticks=[])
    inset.grid(False)
    for side in inset.spines.values():
        side.set(visible=True, color=SOFT)
    look: dict[str, Any] = {"fontsize": small_text(), "color": SOFT, "va": "top"}
    inset.text(0.04, 0.96, f"{times:g} times", transform=inset.transAxes, **look)


def orbit(
    system: System, run: Trajectory, joint: str, axis: Axes | None = None, color: str = "", label: str = ""
) -> Axes:
    """Draw the path of a journal's centre in its clearance circle, in micrometres; return the axes.

    Parameters
    ----------
    system : System
    run : Trajectory
    joint : str
        A joint with a journal.
    axis : Axes, optional
        Axes to draw on; default: a new figure. The circle is drawn once, so that several runs can be added.
    color, label : str
        Default: the colour of the joint's link, and the joint.
    """
    if axis is None:
        _, (axis,) = make_panels(1, 4.0)
    if not axis.patches:
        _draw_circle(axis, 1e6 * (system.joints[joint].clearance or 0.0))
    axis.plot(
        1e6 * run[f"{joint}.ex"],
        1e6 * run[f"{joint}.ey"],
        color=color or color_for(system.colors, joint),
        lw=1.0,
        label=label or joint,
    )
    axis.set(xlabel="e$_x$ [µm]", ylabel="e$_y$ [µm]", aspect="equal")
    return axis


def _draw_circle(axis: Axes, radius: float) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    axis.fill(radius * np.cos(turn), radius * np.sin(turn), facecolor=PANEL, edgecolor=SOFT, lw=1.2)


def contacts_figure(assessment: Assessment) -> Figure:
    """Draw the peak force and the approach speed of every contact at its start, separately for a guide's corners."""
    joints: dict[str, list[str]] = {}
    for owner, label in sorted({(row.owner, row.joint) for row in assessment.contacts}):  # joints, corners of a guide
        joints.setdefault(owner, []).append(label)
    figure = ShownFigure(figsize=(WIDE, 0.8 + (3.2 if len(joints) < 3 else 2.4) * len(joints)))
    axes = stacked_axes(figure, [1.0] * (2 * len(joints)), _GAP, _LEFT)
    run, small, marked = assessment.run, narrow(), {}
    told = []
    for (name, labels), force, speed in zip(joints.items(), axes[::2], axes[1::2], strict=True):
        kind_of = "joint" if name in assessment.system.joints else "contact"
        units = ("N m", "rad/s") if f"{labels[0]}.torque" in run else ("N", "m/s")
        own = [[row for row in assessment.contacts if row.joint == label] for label in labels]
        top = max((row for rows in own for row in rows), key=lambda row: row.peak_force)
        hardest = quantity(top.peak_force, units[0])
        said = f"{kind_of} {name}: {counted(sum(map(len, own)), 'contact')}, hardest {hardest}"
        if not small:
            said += f" at {quantity(top.start, 's', 3)}"
        told.append(said)
        write_answer(force, said, "" if small else "peak force")
        write_answer(speed, "", "approach speed")
        for axis, quantity_, si in zip((force, speed), ("peak_force", "approach_speed"), units, strict=True):
            unit, factor = engineering(si, max(getattr(row, quantity_) for rows in own for row in rows))
            heights = sorted((getattr(row, quantity_) for rows in own for row in rows), reverse=True)
            least = heights[min(len(heights), _DOTTED) - 1]
            for label, rows in zip(labels, own, strict=True):
                corner = label.removeprefix(name).removeprefix(".")
                start, height = np.array([(row.start, getattr(row, quantity_)) for row in rows]).T
                kind = phases(run, label)[np.searchsorted(run.time, start)]
                for code in (IMPACT, SUSTAINED_CONTACT):
                    color, chosen = _PHASES[code][1], kind == code
                    axis.vlines(start[chosen], 0.0, factor * height[chosen], color=color, lw=1.0)
                    large = chosen & (height >= least)
                    mark = "o" if small else _MARKS[corner]
                    axis.plot(start[large], factor * height[large], mark, color=color, ms=3.5)
                if len(labels) > 1 and not small:
                    marked[corner.replace("corner", "corner ")] = _MARKS[corner]
            axis.set_ylabel(f"[{unit}]")
            axis.set_ylim(0.0, None)
    looks = [_PHASES[code][:2] for code in (IMPACT, SUSTAINED_CONTACT)]
    handles = [Line2D([], [], color=color, lw=2.0, label=label) for label, color in looks]
    handles += [Line2D([], [], color=SOFT, marker=mark, ms=3.5, lw=0.0, label=label) for label, mark in marked.items()]
    look: dict[str, Any] = {"fontsize": small_text(), "borderaxespad": 0.1, "columnspacing": 1.0, "handlelength": 1.2}
    figure.legend(handles=handles, ncols=len(handles), loc="lower right", **look)
    figure.set_label(". ".join(map(sentence, told)) + ".")
    figure.align_ylabels(axes)
    axes[-1].set_xlabel("start [s]", loc="left")
    axes[-1].set_xlim(run.time[0], run.time[-1])
    return figure


def finely(assessment: Assessment, name: str) -> tuple[Array, NDArray[np.int64]]:
    """Sample the path of a journal with contact, finely enough for a drawing.

    The steps of a free flight may be long: the run is evaluated between them, unless there are too many for a visible
    difference. Returns eccentricities (n, 2) [m], and the phases (n - 1,) between them, see
    `linkages.results.impacts.phases`.
    """
    run, phase = assessment.run, phases(assessment.run, name)
    e = np.column_stack([run[f"{name}.ex"], run[f"{name}.ey"]])
    chord = _CHORD * (assessment.system.joints[name].clearance or np.inf)
    counts = np.ceil(np.hypot(*np.diff(e, axis=0).T) / chord).astype(int).clip(1, _MOST_SEGMENTS)
    extra = int(np.sum(counts - 1))
    if not run.evaluate or not 0 < extra <= _MOST_SEGMENTS:
        return e, phase
    cuts = [np.linspace(a, b, n + 1)[1:-1] for a, b, n in zip(run.time, run.time[1:], counts, strict=False)]
    times = np.concatenate(cuts)
    between = run.evaluate(times)
    order = np.argsort(np.concatenate([run.time, times]), kind="stable")
    added = np.column_stack([between[f"{name}.ex"], between[f"{name}.ey"]])
    return np.concatenate([e, added])[order], np.repeat(phase, counts)


def _draw_wall(axis: Axes, path: Array, clearance: float, phase: NDArray[np.int64]) -> None:
    """Draw the penetration of the journal over its angle, with the wall unrolled; lengths in µm."""
    depth = np.hypot(*path.T) - clearance
    angle = np.degrees(np.arctan2(path[:, 1], path[:, 0]))
    phase = np.where(np.abs(np.diff(angle)) < 180.0, phase, -1)  # no line across the page
    _draw_phases(axis, np.column_stack([angle, depth]), phase)
    lowest, deepest = float(depth.min()), float(depth.max())
    bottom, top = (-1.1 * deepest, 1.1 * deepest) if deepest > 0.0 else (1.1 * lowest, -0.1 * lowest)
    axis.axhspan(0.0, top, color=LINE, zorder=0)
    axis.axhline(0.0, color=SOFT, lw=1.0, zorder=1)
    axis.set(xlim=(-180.0, 180.0), ylim=(bottom, top), xticks=range(-180, 181, 90))
    axis.set(xlabel="angle of e [deg]", ylabel="penetration e $-$ c [µm]")
    axis.text(-175.0, 0.94 * top, "in the wall", va="top", fontsize=small_text(), color=SOFT)


def _draw_phases(axis: Axes, points: Array, phase: NDArray[np.int64]) -> None:
    """Draw the line through (n, 2) samples, each step in the colour of its phase; skip steps without phase."""
    steps = np.stack([points[:-1], points[1:]], axis=1)
    for code, (_, color, width) in _PHASES.items():
        lines = list(steps[phase == code])
        axis.add_collection(LineCollection(lines, colors=color, linewidths=width, capstyle="round"))
    axis.autoscale_view()


def guides_figure(assessment: Assessment) -> Figure:
    """Draw the state of each block in its slot, and the transverse offsets of both ends over time.

    The state consists of the offset of the block's middle across the slot, and the additional offset of its front end
    (in the direction of the joint's axis). A corner touches if the sum of their magnitudes equals the clearance.
    """
    system, run = assessment.system, assessment.run
    names = [name for name in system.tree.play if name not in system.tree.journals]
    figure, axes = make_panels(2 * len(names), 2.6)
    told = []
    for whole, ends, name in zip(axes[::2], axes[1::2], names, strict=True):
        joint = system.joints[name]
        clearance = system.joints[name].clearance or 0.0
        unit, factor = engineering("m", clearance)
        middle = factor * run[f"{name}.offset"]
        lift = factor * run[f"{name}.tilt"] * (0.5 * joint.slot.length if joint.slot is not None else 0.0)
        wall = factor * clearance
        rim = wall * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
        whole.fill(*rim.T, facecolor=PANEL, edgecolor=SOFT, lw=1.2)
        whole.plot(lift, middle, color=color_for(system.colors, name), lw=0.7)
        whole.plot(lift[0], middle[0], "o", color=OTHER, ms=3.5, label="start")
        whole.set_title(f"{name}: contact on the rim", loc="left", fontsize="medium")
        whole.set_aspect("equal", adjustable="datalim")
        whole.set_xlabel(axis_label("front end $-$ middle", unit))
        whole.set_ylabel(axis_label("offset of the middle", unit))
        used = float(np.abs(np.array([middle + lift, middle - lift])).max()) / wall
        told.append(f"Block of {name}: its ends move up to {number(used, 3)} of the clearance")
        reach = 1.15 * max(wall, float(np.abs(np.array([middle + lift, middle - lift])).max()))
        for side in (1.0, -1.0):
            ends.axhspan(side * wall, side * reach, color=LINE, zorder=0)
        ends.plot(run.time, middle + lift, color=COLORS[0], lw=0.9, label="front end")
        ends.plot(run.time, middle - lift, color=COLORS[1], lw=0.9, ls="--", label="back end")
        ends.set_title("grey: in the wall", loc="left", fontsize="medium")
        ends.set_ylabel(f"offset across the slot [{unit}]")
        ends.set(xlabel="time [s]", ylim=(-reach, reach))
    say(figure, *told)
    legend_below(figure, axes[:2])
    return figure
