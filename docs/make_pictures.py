"""Writes the moving picture of the press mechanism: ``python docs/make_pictures.py``."""

from pathlib import Path

import linkages
from linkages.plots.drawing import draw
from linkages.plots.drawing.raster import write_moving

FIGURES = Path(__file__).parent / "figures"

if __name__ == "__main__":
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    write_moving(draw(system), FIGURES / "seven_bar.gif", dpi=75.0)
