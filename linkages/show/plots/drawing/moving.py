"""A run as a GIF or MP4 file: the drawing of its machine, moved as the run moves its links."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib import animation as animations
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from linkages.base.errors import InputError
from linkages.input.model.mechanism import Link
from linkages.results.trajectory import Trajectory
from linkages.show.plots.drawing.drawing import Drawing
from linkages.show.plots.drawing.poses import body_poses
from linkages.show.plots.drawing.raster import picture, put_shapes

_RATE = 25  # frames per second: a GIF counts hundredths of a second
_DPI = 80  # 640 pixels of width
_COLOURS = 64


def write_moving(
    drawing: Drawing, links: Mapping[str, Link], run: Trajectory, path: Path, kind: str, seconds: float
) -> int:
    """Write a run as a film of so many seconds, "gif" or "mp4"; return the number of frames.

    InputError for MP4 without ffmpeg.
    """
    if kind == "mp4" and not animations.FFMpegWriter.isAvailable():
        raise InputError("--format", "mp4", "needs ffmpeg, which is not found; install it, or give --format gif")
    times = np.linspace(run.time[0], run.time[-1], max(round(_RATE * seconds), 2) + 1)[:-1]  # the last is the first
    poses = body_poses(drawing, links, run, times)
    speed = (run.time[-1] - run.time[0]) / seconds
    figure = picture(drawing, said=False)
    figure.set_dpi(_DPI)
    canvas, (axis,) = FigureCanvasAgg(figure), figure.axes
    note = figure.text(0.015, 0.985, "", va="top", fontsize=9)

    def show(k: int) -> None:
        for one in (*axis.patches, *axis.texts):
            one.remove()
        put_shapes(axis, drawing, poses[k])
        note.set_text(f"t = {times[k]:.4f} s, {speed:.3g} of real time")

    if kind == "mp4":
        writer = animations.FFMpegWriter(fps=_RATE, extra_args=["-f", "mp4", "-pix_fmt", "yuv420p"])
        with writer.saving(figure, str(path), _DPI):
            for k in range(len(times)):
                show(k)
                writer.grab_frame()
        return len(times)
    images: list[Image.Image] = []
    for k in range(len(times)):
        show(k)
        canvas.draw()
        pixels = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
        images.append(pixels.quantize(_COLOURS, palette=images[0] if images else None, dither=Image.Dither.NONE))
    images[0].save(path, format="GIF", save_all=True, append_images=images[1:], duration=1000 // _RATE, loop=0)
    return len(times)
