"""Poses of a drawing's bodies over a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.input.model.mechanism import Link
from linkages.results.trajectory import Trajectory, values_at
from linkages.show.plots.drawing.drawing import Drawing


def body_poses(drawing: Drawing, links: Mapping[str, Link], run: Trajectory, times: Array) -> Array:
    """Compute the poses (nt, nb, 3: x, y [m], angle [rad]) of the drawing's bodies from the links of a run at times."""
    at = values_at(run, times)
    poses = np.tile(drawing.reference, (len(times), 1, 1))
    for body, name in drawing.links_of.items():
        if f"{name}.angle" not in at:  # the ground
            continue
        link = links[name]
        angle = at[f"{name}.angle"] - link.angle
        x, y = link.origin - drawing.reference[body, :2]
        cosine, sine = np.cos(angle), np.sin(angle)
        poses[:, body, 0] = at[f"{name}.x"] - (cosine * x - sine * y)
        poses[:, body, 1] = at[f"{name}.y"] - (sine * x + cosine * y)
        poses[:, body, 2] = angle
    return poses
