"""Writes the pictures of the press: it moves, and its dry joint strikes: ``python docs/make_pictures.py``."""

import dataclasses
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import linkages
from linkages.plots import COLORS, figure_style, orbit
from linkages.show.plots.drawing import Drawing, draw
from linkages.show.plots.drawing.raster import picture

FIGURES = Path(__file__).parent / "figures"
_FRAME = 50  # duration of a frame [ms]
_LEAST = 0.1  # least drawn force [N]


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


def draw_contact(joint: str) -> Figure:
    """Draw a dry joint of the press: the path of its journal, and its force and the one of the ideal joint."""
    system = linkages.load(linkages.find_file("seven_bar_dry.toml"))
    run, ideal = linkages.simulate(system), linkages.ideal(system)
    figure = Figure(figsize=(8.4, 3.4), layout="constrained")
    circle, force = figure.subplots(1, 2, width_ratios=[1.0, 1.7])
    fine = run.evaluate(np.linspace(0.0, run.time[-1], 20001))  # a free flight has few steps
    orbit(system, dataclasses.replace(run, time=fine["time"], columns=fine), joint, circle)
    circle.set_title(f"journal of {joint} in its clearance circle", fontsize=9)
    force.semilogy(ideal.time, ideal[f"{joint}.force"], color=COLORS[1], lw=2.2, label="ideal joint")
    force.semilogy(run.time, np.maximum(run[f"{joint}.force"], _LEAST), color=COLORS[0], lw=0.6, label="dry joint")
    force.set(xlabel="time [s]", ylabel=f"force in {joint} [N]", ylim=(_LEAST, None))
    force.legend(ncols=2, loc="upper right")
    return figure


if __name__ == "__main__":
    with figure_style():
        draw_contact("A").savefig(FIGURES / "seven_bar_contact.png", dpi=120.0)
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    write_moving(draw(system), FIGURES / "seven_bar.gif", dpi=75.0)
