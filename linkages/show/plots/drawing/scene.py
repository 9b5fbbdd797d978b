"""What a film of a run shows: the machine, its joints with clearance magnified, and a curve with a moving dot."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrow, Polygon

from linkages.base.arrays import Array
from linkages.base.palette import DATA_LINE, INK, LINE, PAPER, PLAY, SOFT
from linkages.results.extremes import peaks
from linkages.results.outputs.registry import unit
from linkages.results.trajectory import Trajectory, values_at
from linkages.show.plots.drawing.drawing import Drawing
from linkages.show.plots.drawing.poses import body_poses
from linkages.show.plots.drawing.raster import put_shapes
from linkages.show.plots.instants import GAP, HEIGHT, LENGTH, guide_frames, journal_frames
from linkages.show.plots.names import name_of_output, sentence
from linkages.show.plots.quantities import number, quantity
from linkages.show.plots.shown import ShownFigure
from linkages.show.plots.style import color_for, readable
from linkages.system import System
from linkages.system.tree import CORNERS

_WIDTH, _SIDE, _STRIP, _AROUND = 8.0, 2.1, 1.35, 1.6  # widths of the film and a joint [in]; strip; half a view
_JOINTS = 3  # most magnified joints, those with the largest forces
_LEFT, _ABOVE, _BELOW = 0.75, 0.3, 0.4  # margins of the curve [in]
_FLAT = 0.4  # height over width of a machine below which its joints stand below it
_RING, _ARROW, _SPOT = 1.18, 1.1, 0.09  # outside of a bearing, longest arrow, a spot over the radius of a view


class Scene:
    """The figure of a film at given times (nt,), see `at`."""

    def __init__(self, drawing: Drawing, system: System, run: Trajectory, times: Array) -> None:
        self.drawing, self.system, self.run, self.times = drawing, system, run, times
        self.poses = body_poses(drawing, dict(system.links), run, times)
        names = sorted(system.tree.play, key=lambda name: -float(run[f"{name}.force"].max()))[:_JOINTS]
        self.figure = ShownFigure(figsize=(_WIDTH, 1.0), facecolor=PAPER)
        self.machine, places = self._arrange(len(names))
        self.views = [_view(self, name, axis) for name, axis in zip(names, places, strict=True)]
        self.column = _told(system, run, names)
        self._draw_curve()
        self.note = self.figure.text(0.01, 0.99, "", va="top", fontsize=9, color=SOFT)

    def at(self, k: int, said: str) -> list[Artist]:
        """Put the frame k into the figure, in place of another one; return what moves, from bottom to top."""
        for one in (*self.machine.patches, *self.machine.texts):
            one.remove()
        put_shapes(self.machine, self.drawing, self.poses[k])
        self.note.set_text(f"t = {self.times[k]:.4f} s, {said}")
        moved: list[Artist] = sorted((*self.machine.patches, *self.machine.texts), key=lambda one: one.get_zorder())
        for view in self.views:
            moved += view.at(k)
        self.dot.set_data([self.times[k]], [self.values[k]])
        self.cursor.set_xdata([self.times[k]])
        return [*moved, self.cursor, self.dot, self.note]

    def _arrange(self, count: int) -> tuple[Axes, list[Axes]]:
        """Add the axes of the machine and of its joints: beside it, or below a flat one."""
        wide, high = self.drawing.high - self.drawing.low
        beside = bool(count) and high / wide > _FLAT
        width = _WIDTH - _SIDE if beside else _WIDTH
        tall = max(width * float(high / wide), _SIDE * count if beside else 0.0)
        below = _SIDE if count and not beside else 0.0
        whole = tall + below + _STRIP
        self.figure.set_size_inches(_WIDTH, whole)
        machine = self.figure.add_axes((0.0, (below + _STRIP) / whole, width / _WIDTH, tall / whole))
        machine.set(xlim=(self.drawing.low[0], self.drawing.high[0]), ylim=(self.drawing.low[1], self.drawing.high[1]))
        machine.set_aspect("equal")
        machine.set_axis_off()
        self.scale = width / float(wide)  # of the machine [in/m]
        places = []
        for k in range(count):
            left = width if beside else (k + 0.5) * _WIDTH / count - 0.5 * _SIDE
            up = _STRIP + below + tall - (k + 1) * tall / count + 0.5 * (tall / count - _SIDE) if beside else _STRIP
            axis = self.figure.add_axes((left / _WIDTH, up / whole, _SIDE / _WIDTH, _SIDE / whole))
            axis.set(xlim=(-_AROUND, _AROUND), ylim=(-_AROUND, _AROUND))
            axis.set_axis_off()
            places.append(axis)
        self.whole = whole
        return machine, places

    def _draw_curve(self) -> None:
        """Draw the curve, and the line and the dot that move along it."""
        run, name = self.run, self.column
        si = unit(self.system, name)
        shown, factor = readable(si, float(np.abs(run[name]).max()))
        size = 1.0 - (_LEFT + 0.2) / _WIDTH, (_STRIP - _ABOVE - _BELOW) / self.whole
        axis = self.figure.add_axes((_LEFT / _WIDTH, _BELOW / self.whole, *size))
        axis.plot(run.time, factor * run[name], color=color_for(self.system.colors, name), lw=DATA_LINE)
        self.values = factor * values_at(run, self.times)[name]
        self.cursor = axis.axvline(run.time[0], color=SOFT, lw=0.8)
        (self.dot,) = axis.plot([], [], "o", color=INK, ms=5)
        top = peaks(run, [name])[name]
        said = f"{sentence(name_of_output(name))}: {quantity(top.value, si)} at {quantity(top.time, 's', 3)}"
        axis.set_title(said, loc="left", fontsize=9, fontweight="bold", pad=3.0)
        axis.set_xlim(run.time[0], run.time[-1])
        axis.set_xlabel("time [s]", fontsize=8, labelpad=1.0)
        axis.set_ylabel(f"[{shown or 1}]", fontsize=8)
        axis.tick_params(labelsize=7.5)
        axis.locator_params(axis="y", nbins=3)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)


def _told(system: System, run: Trajectory, names: list[str]) -> str:
    """Choose the column of the curve: the largest force in a joint with clearance, or the first output."""
    if names:
        return f"{names[0]}.force"
    known = [name for name in system.settings.outputs if name in run.columns]
    forces = [f"{name}.force" for name in system.joints if f"{name}.force" in run.columns]
    return next(iter([*known, *forces]), next(iter(run.columns)))


def _view(scene: Scene, name: str, axis: Axes) -> JournalFilm | GuideFilm:
    return (JournalFilm if name in scene.system.tree.journals else GuideFilm)(scene, name, axis)


class _View:
    """A magnified joint in its axes, whose unit is the radius of the view."""

    def __init__(self, scene: Scene, name: str, axis: Axes) -> None:
        self.name, self.axis = name, axis
        self.color = color_for(scene.system.colors, name)
        clearance = scene.system.joints[name].clearance or 0.0
        times = GAP * _SIDE / (2.0 * _AROUND) / (clearance * scene.scale) if clearance else 1.0
        self.largest = float(scene.run[f"{name}.force"].max())
        title = f"{name}: clearance {number(times, 2)} times"
        axis.text(0.0, _AROUND, title, ha="center", va="top", fontsize=8.5, fontweight="bold", color=INK)
        self.text = axis.text(0.0, -_AROUND, "", ha="center", va="bottom", fontsize=8, color=INK)
        self.moving: list[Artist] = []

    def show(self, artists: list[Any], start: Array, force: Array, said: str) -> list[Artist]:
        """Replace what moves, and add the arrow of a force [N], whose length grows with its square root."""
        for one in self.moving:
            one.remove()
        size = float(np.hypot(*force))
        if size > 0.0 and self.largest > 0.0:
            way = _ARROW * np.sqrt(size / self.largest) * force / size
            head: dict[str, Any] = {"width": 0.05, "head_width": 0.2, "head_length": 0.2, "length_includes_head": True}
            artists.append(FancyArrow(*start, *way, color=PLAY, lw=0.0, zorder=4, **head))
        for one in artists:
            self.axis.add_artist(one)
        self.text.set_text(said)
        self.moving = artists
        return [*artists, self.text]

    def spot(self, place: Array) -> Circle:
        """Mark a place that touches."""
        return Circle((float(place[0]), float(place[1])), _SPOT, fc=PLAY, ec=INK, lw=0.6, zorder=5)


class JournalFilm(_View):
    """A journal in its bearing."""

    def __init__(self, scene: Scene, name: str, axis: Axes) -> None:
        super().__init__(scene, name, axis)
        self.frames = journal_frames(scene.system, scene.run, name, scene.times)
        axis.add_patch(Circle((0.0, 0.0), _RING, fc=LINE, ec=SOFT, lw=0.8, zorder=1))
        axis.add_patch(Circle((0.0, 0.0), 1.0, fc=PAPER, ec=PLAY, lw=1.2, zorder=1))

    def at(self, k: int) -> list[Artist]:
        """Show the frame k."""
        now = self.frames
        e, inner = GAP * now.e[k], 1.0 - GAP
        turn = np.array([np.cos(now.journal[k]), np.sin(now.journal[k])])
        mark = np.array([e + 0.5 * inner * turn, e + 0.95 * inner * turn])
        ratio = float(np.hypot(*now.e[k]))
        parts: list[Any] = [
            Circle((float(e[0]), float(e[1])), inner, fc=self.color, ec=INK, lw=0.8, zorder=2),
            Polygon(mark, closed=False, ec=INK, lw=1.5, zorder=3),
        ]
        if now.touching[k] and ratio > 0.0:
            parts.append(self.spot(now.e[k] / ratio))
        said = f"e/c {number(ratio, 2)}, {quantity(float(np.hypot(*now.force[k])), 'N', 3)}"
        return self.show(parts, e, now.force[k], said)


class GuideFilm(_View):
    """A block in its slot, whose axis is horizontal."""

    def __init__(self, scene: Scene, name: str, axis: Axes) -> None:
        super().__init__(scene, name, axis)
        self.frames = guide_frames(scene.system, scene.run, name, scene.times)
        self.wall = HEIGHT + GAP
        for side in (1.0, -1.0):
            axis.fill_between([-1.3, 1.3], side * self.wall, side * (self.wall + 0.2), fc=LINE, ec=SOFT, lw=0.8)
            axis.plot([-1.3, 1.3], [side * self.wall] * 2, color=PLAY, lw=1.2)

    def at(self, k: int) -> list[Artist]:
        """Show the frame k."""
        now = self.frames
        middle, slope = np.array([0.0, GAP * now.offset[k]]), GAP * now.tilt[k] / LENGTH
        along = np.array([1.0, slope]) / np.hypot(1.0, slope)
        across = np.array([-along[1], along[0]])
        signs = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
        corners = [middle + x * LENGTH * along + y * HEIGHT * across for x, y in signs]
        parts: list[Any] = [Polygon(corners, closed=True, fc=self.color, ec=INK, lw=0.8, zorder=2)]
        touched = np.flatnonzero(now.touching[k])
        parts += [self.spot(np.array([CORNERS[c][0] * LENGTH, CORNERS[c][1] * self.wall])) for c in touched]
        used = float(abs(now.offset[k]) + abs(now.tilt[k]))
        said = f"corner/c {number(used, 2)}, {quantity(float(np.hypot(*now.force[k])), 'N', 3)}"
        return self.show(parts, middle, now.force[k], said)
