"""Journals in their bearings and blocks in their slots, magnified next to the linkage in a Meshcat scene.

The gap between bearing and journal, and on either side of a block, is drawn as `GAP` of the view's radius. Motions are
magnified by the same factor as the clearance: a part touches the drawn wall when it touches the real one. The arrow is
the force on the journal or block; spots mark points that touch. A thin circle is the clearance circle of a journal's
centre, the line in it the orbit of the whole run; marks show the rotation of journal and bearing. The view of a block
is fixed to its slot, whose axis is along x.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Cylinder, Rgba

from linkages.base.arrays import Array
from linkages.input.files.magnitudes import rounded
from linkages.results.assessment import Assessment
from linkages.show.plots.animation.magnified import BODY, DARK, FLOOR, WALL, MagnifiedView
from linkages.show.plots.instants import GAP, HEIGHT, LENGTH, guide_frames, journal_frames
from linkages.system.tree import CORNERS

_RING = 0.16  # drawn thickness of the bearing over the view's radius
_ORBIT_POINTS = 3000
_ORBIT = Rgba(0.0, 0.35, 0.65, 1.0)
_SLOT = 1.25  # half the drawn slot's length


class JournalView(MagnifiedView):
    """A revolute joint with clearance: a journal in its bearing, drawn magnified; parameters as `MagnifiedView`."""

    def caption(self, frame: int) -> str:
        """Return the numbers of a frame."""
        ratio, force = (np.linalg.norm(vector[frame]) for vector in (self.frames.e, self.frames.force))
        return f"e/c {ratio:.3f}, {rounded(float(force))} N"

    def show(self, frame: int, time: float) -> None:
        """Record a frame at this time of the recording."""
        now = self.frames
        e = GAP * now.e[frame]
        self.place("bearing", np.zeros(2), now.bearing[frame], time)
        self.place("journal", e, now.journal[frame], time)
        self.show_arrow(e, now.force[frame], time)
        self.place("touch", np.zeros(2), float(np.arctan2(e[1], e[0])), time)
        self.show_spot("touch", now.touching[frame], time)

    def draw(self, assessment: Assessment, times: Array) -> None:
        """Draw all parts at different heights above the plane, and compute the content of each frame."""
        self.frames = journal_frames(assessment.system, assessment.run, self.name, times)
        orbit = np.stack([assessment.run[f"{self.name}.{part}"] for part in ("ex", "ey")]) / self.clearance
        inner = 1.0 - GAP
        angle = np.linspace(0.0, 2.0 * np.pi, 121)
        circle = np.stack([np.cos(angle), np.sin(angle)])
        self.disc("floor", 1.02, FLOOR, [0.0, 0.0, -0.02])
        vertices, faces = _ring(self.radius, (1.0 + _RING) * self.radius, 0.04 * self.radius)
        self.meshcat.SetTriangleMesh(f"{self.path}/bearing/ring", vertices, faces, WALL)
        self.box("bearing/mark", (_RING, 0.06, 0.01), DARK, [1.0 + 0.5 * _RING, 0.0, 0.05])
        self.put("journal/disc", Cylinder(inner * self.radius, 0.04 * self.radius), BODY, [0.0, 0.0, 0.02])
        self.box("journal/mark", (0.3 * inner, 0.06, 0.01), DARK, [0.85 * inner, 0.0, 0.045])
        self.disc("journal/centre", 0.035, DARK, [0.0, 0.0, 0.075])
        self.line("wall", circle, 0.05, DARK)
        self.line("clearance", GAP * circle, 0.06, DARK)
        every = max(1, orbit.shape[1] // _ORBIT_POINTS)
        self.line("orbit", GAP * orbit[:, ::every], 0.07, _ORBIT)
        self.draw_arrow()
        self.draw_spot("touch", [1.0, 0.0])
        self.set_label(1.0 + _RING)


def _ring(inner: float, outer: float, height: float) -> tuple[Array, NDArray[np.int32]]:
    """Return vertices (3, n) and triangles (3, m) of a flat ring at a height above the plane."""
    sides = 96
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    unit = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)])
    vertices = np.hstack([inner * unit, outer * unit])
    vertices[2] = height
    k = np.arange(sides, dtype=np.int32)
    following = (k + 1) % sides
    faces = np.hstack([[k, sides + k, sides + following], [k, sides + following, following]])
    return np.asfortranarray(vertices), np.asfortranarray(faces)


class GuideView(MagnifiedView):
    """A prismatic joint with clearance: a block in its slot, drawn magnified; parameters as `MagnifiedView`."""

    def caption(self, frame: int) -> str:
        """Return the numbers of a frame."""
        now = self.frames
        nearest = abs(now.offset[frame]) + abs(now.tilt[frame])
        return f"corner/c {nearest:.3f}, {rounded(float(np.linalg.norm(now.force[frame])))} N"

    def show(self, frame: int, time: float) -> None:
        """Record a frame at this time of the recording."""
        now = self.frames
        middle = np.array([0.0, GAP * now.offset[frame]])
        angle = float(np.arctan(GAP * now.tilt[frame] / LENGTH))
        self.place("block", middle, angle, time)
        self.show_arrow(middle, now.force[frame], time)
        for k in range(len(CORNERS)):
            self.show_spot(f"corner{k + 1}", now.touching[frame, k], time)

    def draw(self, assessment: Assessment, times: Array) -> None:
        """Draw all parts at the origin of the view, and compute the content of each frame."""
        self.frames = guide_frames(assessment.system, assessment.run, self.name, times)
        wall, thick = HEIGHT + GAP, 0.14
        self.box("floor", (2.0 * _SLOT, 2.0 * wall, 0.01), FLOOR, [0.0, 0.0, -0.02])
        for name, side in (("upper", 1.0), ("lower", -1.0)):
            middle = [0.0, side * (wall + 0.5 * thick), 0.04]
            self.box(f"slot/{name}", (2.0 * _SLOT, thick, 0.04), WALL, middle)
            edge = np.array([[-_SLOT, _SLOT], [side * wall, side * wall]])
            self.line(f"edge/{name}", edge, 0.07, DARK)
        self.box("block", (2.0 * LENGTH, 2.0 * HEIGHT, 0.04), BODY, [0.0, 0.0, 0.02])
        self.disc("block/centre", 0.035, DARK, [0.0, 0.0, 0.075])
        self.draw_arrow()
        for k, (x, y) in enumerate(CORNERS):
            self.draw_spot(f"corner{k + 1}", [x * LENGTH, y * wall])
        self.set_label(wall + thick)
