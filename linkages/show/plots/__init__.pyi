"""Public names, which are loaded on first use: the one list of them, for type checkers and for `lazy_loader`."""

from .animation.animated import write_animation as write_animation
from .attractors import (
    bifurcation_figure as bifurcation_figure,
    exponent_figure as exponent_figure,
    section_figure as section_figure,
    spectrum_figure as spectrum_figure,
)
from .drawing.raster import pose as pose
from .histories import write_figures as write_figures
from .journals import orbit as orbit
from .overlaid import overlay_figure as overlay_figure
from .presentation import presented as presented
from .style import COLORS as COLORS, LINES as LINES, figure_style as figure_style
from .swept import map_figure as map_figure, peaks_figure as peaks_figure
