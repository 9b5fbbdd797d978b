"""A run as a GIF or MP4 file: the machine, its clearance joints magnified, and a curve, moved as the run moves them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib import animation as animations
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.results.trajectory import Trajectory
from linkages.show.plots.drawing.drawing import Drawing
from linkages.show.plots.drawing.scene import Scene
from linkages.show.plots.quantities import number
from linkages.system import System

_RATE = 25  # frames per second: a GIF counts hundredths of a second
_FRAMES = 250  # most frames of a GIF; a longer one has fewer per second
_BYTES = 2_000_000  # most of a GIF: frames are left out until it is as small
_DPI = 80  # 640 pixels of width
_COLOURS, _SAMPLES = 64, 6  # colours of a GIF, and the frames that give them


def write_moving(drawing: Drawing, system: System, run: Trajectory, path: Path, kind: str, seconds: float) -> int:
    """Write a run as a film of so many seconds, "gif" or "mp4"; return the number of frames.

    The last frame is a step before the end of the run: a film of whole periods begins again without a jump. A GIF has
    at most 2 MB. InputError for MP4 without ffmpeg.
    """
    if kind == "mp4" and not animations.FFMpegWriter.isAvailable():
        raise InputError("--format", "mp4", "needs ffmpeg, which is not found; install it, or give --format gif")
    hundredths = round(100 * seconds)
    step = 100 // _RATE if kind == "mp4" else max(100 // _RATE, -(-hundredths // _FRAMES))
    times = np.linspace(run.time[0], run.time[-1], max(round(hundredths / step), 2) + 1)[:-1]
    scene = Scene(drawing, system, run, times)
    scene.figure.set_dpi(_DPI)
    said = f"{number((run.time[-1] - run.time[0]) / seconds, 3)} of real time"
    if kind == "mp4":
        writer = animations.FFMpegWriter(fps=_RATE, extra_args=["-f", "mp4", "-pix_fmt", "yuv420p"])
        with writer.saving(scene.figure, str(path), _DPI):
            for k in range(len(times)):
                scene.at(k, said)
                writer.grab_frame()
        return len(times)
    content, count = _smallest(list(_images(scene, said)), 10 * step)
    path.write_bytes(content)
    return count


def _images(scene: Scene, said: str) -> Iterator[Image.Image]:
    """Yield the frames with the same colours, which some of them give."""
    film = _Film(scene, said)
    some = [film.frame(int(k)) for k in np.unique(np.linspace(0, len(scene.times) - 1, _SAMPLES).astype(int))]
    colours = Image.fromarray(np.concatenate(some)).quantize(_COLOURS, dither=Image.Dither.NONE)
    for k in range(len(scene.times)):
        yield Image.fromarray(film.frame(k)).quantize(palette=colours, dither=Image.Dither.NONE)


class _Film:
    """Pixels of frames: what does not move is drawn once."""

    def __init__(self, scene: Scene, said: str) -> None:
        self.scene, self.said = scene, said
        self.canvas = FigureCanvasAgg(scene.figure)
        hidden = scene.at(0, said)
        for one in hidden:
            one.set_visible(False)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(scene.figure.bbox)
        for one in hidden:
            one.set_visible(True)

    def frame(self, k: int) -> Array:
        """Return the pixels (height, width, 3) of a frame."""
        self.canvas.restore_region(self.still)
        for one in self.scene.at(k, self.said):
            self.scene.figure.draw_artist(one)
        return np.array(self.canvas.buffer_rgba())[..., :3].copy()


def _smallest(images: Sequence[Image.Image], step: int) -> tuple[bytes, int]:
    """Encode frames of a duration [ms] as a GIF, with every second, third, ... frame if it is too large."""
    content, kept = b"", list(range(len(images)))
    for every in range(1, max(len(images) // 2, 1) + 1):
        kept = list(range(0, len(images), every))
        lasts = [step * (after - before) for before, after in pairwise([*kept, len(images)])]
        buffer, some = BytesIO(), [images[k] for k in kept]
        some[0].save(buffer, format="GIF", save_all=True, append_images=some[1:], duration=lasts, loop=0)
        content = buffer.getvalue()
        if len(content) <= _BYTES:
            break
    return content, len(kept)
