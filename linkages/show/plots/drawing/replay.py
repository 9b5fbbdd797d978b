"""A run as a page: the drawing of its machine with a slider of time, moved as the run moves its links."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from linkages.results.trajectory import Trajectory
from linkages.show.plots.drawing.drawing import Slider, draw
from linkages.show.plots.drawing.poses import body_poses
from linkages.show.plots.drawing.svg import page
from linkages.system import System

_FRAMES = 241  # 8 s of the page's 30 frames a second
_DECIMALS = 4  # of the shown time [s]
_MOVES = (
    "The run moves the links. Joints with clearance are not magnified: the package Drake, which draws them, is not"
    " installed."
)


def write_replay(system: System, run: Trajectory, path: Path) -> None:
    """Write the run of a system as an animation, an HTML file that needs no Drake."""
    drawing = draw(system)
    times = np.linspace(run.time[0], run.time[-1], _FRAMES)
    poses = body_poses(drawing, system.links, run, times)
    slider = Slider("time", "s", times, poses, first=0, sense=1.0, digits=_DECIMALS)
    path.write_text(page(replace(drawing, sliders=(slider,)), _MOVES), encoding="utf-8")
