"""Journals in their bearings, magnified next to the linkage in a Meshcat scene.

The gap between the drawn bearing and journal is `GAP` of the bearing's radius. The eccentricity is magnified by the
same factor as the clearance: the journal touches the drawn wall when it touches the real one. The thin circle is the
clearance circle of the journal's centre, the line in it the orbit of the whole run. The arrow from the journal's centre
is the force on the journal. Marks show the rotation of journal and bearing; a spot marks the point of contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Cylinder, Rgba

from linkages.base.arrays import Array
from linkages.input.files.magnitudes import rounded
from linkages.results.assessment import Assessment
from linkages.show.plots.animation.magnified import BODY, DARK, FLOOR, GAP, WALL, MagnifiedView, closed, strongest

_RING = 0.16  # drawn thickness of the bearing over the view's radius
_ORBIT_POINTS = 3000
_ORBIT = Rgba(0.0, 0.35, 0.65, 1.0)


@dataclass(frozen=True)
class JournalFrames:
    """The motion of a journal, frame by frame."""

    e: Array  # (n, 2) eccentricity over clearance, plane axes [1]
    force: Array  # (n, 2) force on the journal [N]
    touching: NDArray[np.bool_]  # (n,) whether journal and bearing touch within the frame
    journal: Array  # (n,) angle of the body with the journal [rad]
    bearing: Array  # (n,) angle of the body with the bearing [rad]


def journal_frames(assessment: Assessment, name: str, times: Array) -> JournalFrames:
    """Compute the journal's motion at the instant of the largest force in each frame."""
    run, joint = assessment.run, assessment.system.mechanism.joint[name]
    moments = strongest(run, name, times)
    clearance = assessment.system.experiment.joints[name].clearance or 0.0

    def vector(symbol: str) -> Array:
        return np.stack([np.interp(moments, run.time, run[f"{name}.{symbol}{axis}"]) for axis in "xy"], axis=1)

    def angle(body: str) -> Array:
        return np.zeros(len(times)) if body == "world" else np.interp(times, run.time, run[f"{body}.angle"])

    e, force = vector("e") / clearance, vector("f")
    return JournalFrames(e, force, closed(run, name, times), angle(joint.child), angle(joint.parent))


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
        self.frames = journal_frames(assessment, self.name, times)
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
