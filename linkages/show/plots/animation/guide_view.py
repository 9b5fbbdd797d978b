"""Blocks with clearance in their slots, magnified next to the linkage in a Meshcat scene.

The view is fixed to the slot, whose axis is along x. The gap on either side of the block is `GAP` of the view's radius.
The transverse motion of the block's middle and ends is magnified by the same factor as the clearance: a corner touches
the drawn wall when it touches the real one. The arrow is the force on the block; spots mark touching corners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.input.files.magnitudes import rounded
from linkages.results.assessment import Assessment
from linkages.show.plots.animation.magnified import BODY, DARK, FLOOR, GAP, WALL, MagnifiedView, closed, strongest
from linkages.system.tree import CORNERS

_LENGTH, _HEIGHT = 0.8, 0.3  # half the drawn block's sides over the view's radius
_SLOT = 1.25  # half the drawn slot's length


@dataclass(frozen=True)
class GuideFrames:
    """The motion of a block in its slot, frame by frame."""

    offset: Array  # (n,) offset of the block's middle, over the clearance [1]
    tilt: Array  # (n,) additional offset of its end, over the clearance [1]
    force: Array  # (n, 2) force on the block, along and across the slot [N]
    touching: NDArray[np.bool_]  # (n, 4) whether each corner touches within the frame


def guide_frames(assessment: Assessment, name: str, times: Array) -> GuideFrames:
    """Compute the block's motion at the instant of the largest force in each frame."""
    run, mechanism = assessment.run, assessment.system.mechanism
    joint = mechanism.joint[name]
    moments = strongest(run, name, times)
    clearance = assessment.system.experiment.joints[name].clearance or 0.0
    half = 0.5 * joint.slot.length if joint.slot is not None else 0.0

    def at(column: str) -> Array:
        return np.interp(moments, run.time, run[column])

    angle = np.full(len(times), np.arctan2(joint.direction[1], joint.direction[0]))
    if joint.parent != "world":
        angle += at(f"{joint.parent}.angle") - mechanism.link[joint.parent].angle
    fx, fy, c, s = at(f"{name}.fx"), at(f"{name}.fy"), np.cos(angle), np.sin(angle)
    return GuideFrames(
        at(f"{name}.offset") / clearance,
        half * at(f"{name}.tilt") / clearance,
        np.stack([c * fx + s * fy, c * fy - s * fx], axis=1),
        np.stack([closed(run, f"{name}.corner{k + 1}", times) for k in range(len(CORNERS))], axis=1),
    )


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
        angle = float(np.arctan(GAP * now.tilt[frame] / _LENGTH))
        self.place("block", middle, angle, time)
        self.show_arrow(middle, now.force[frame], time)
        for k in range(len(CORNERS)):
            self.show_spot(f"corner{k + 1}", now.touching[frame, k], time)

    def draw(self, assessment: Assessment, times: Array) -> None:
        """Draw all parts at the origin of the view, and compute the content of each frame."""
        self.frames = guide_frames(assessment, self.name, times)
        wall, thick = _HEIGHT + GAP, 0.14
        self.box("floor", (2.0 * _SLOT, 2.0 * wall, 0.01), FLOOR, [0.0, 0.0, -0.02])
        for name, side in (("upper", 1.0), ("lower", -1.0)):
            middle = [0.0, side * (wall + 0.5 * thick), 0.04]
            self.box(f"slot/{name}", (2.0 * _SLOT, thick, 0.04), WALL, middle)
            edge = np.array([[-_SLOT, _SLOT], [side * wall, side * wall]])
            self.line(f"edge/{name}", edge, 0.07, DARK)
        self.box("block", (2.0 * _LENGTH, 2.0 * _HEIGHT, 0.04), BODY, [0.0, 0.0, 0.02])
        self.disc("block/centre", 0.035, DARK, [0.0, 0.0, 0.075])
        self.draw_arrow()
        for k, (x, y) in enumerate(CORNERS):
            self.draw_spot(f"corner{k + 1}", [x * _LENGTH, y * wall])
        self.set_label(wall + thick)
