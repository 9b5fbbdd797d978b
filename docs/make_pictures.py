"""Writes the moving picture of the press mechanism: ``python docs/make_pictures.py``."""

from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image

import linkages
from linkages.show.plots.drawing import Drawing, draw
from linkages.show.plots.drawing.raster import picture

FIGURES = Path(__file__).parent / "figures"
_FRAME = 50  # duration of a frame [ms]


def write_moving(drawing: Drawing, path: Path, frames: int = 60, dpi: float = 90.0) -> None:
    """Write a GIF of a mechanism, moved by its first drive: one revolution, or one stroke forth and back."""
    way = drawing.sliders[0]
    full = np.allclose(way.poses[0, :, :2], way.poses[-1, :, :2], atol=1e-4 * drawing.unit)
    turn = np.linspace(0.0, 1.0, frames, endpoint=False)
    part = turn if full else 0.5 - 0.5 * np.cos(2.0 * np.pi * turn)
    pictures = []
    for pose in way.poses[(part * (len(way.poses) - 1)).round().astype(int)]:
        buffer = BytesIO()
        picture(drawing, said=False, pose=pose).savefig(buffer, dpi=dpi)
        pictures.append(Image.open(buffer))
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=_FRAME, loop=0)


if __name__ == "__main__":
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    write_moving(draw(system), FIGURES / "seven_bar.gif", dpi=75.0)
