"""Figures and animations of results; matplotlib is imported nowhere else in `linkages`, and no engine is run here.

| module     | what it draws                                                                          |
|------------|----------------------------------------------------------------------------------------|
| style      | nothing: palette, line styles, labels and settings that all figures share              |
| histories  | outputs, joint forces and drive torques over time, ideal joints beside real ones       |
| journals   | orbits of the journals in their clearances, contacts over time                         |
| attractors | Poincaré sections, bifurcation diagrams, Lyapunov exponents, spectra                   |
| animation  | a run as a Meshcat recording, its clearance joints magnified                           |
| three_rrr  | the flexible 3-RRR robot                                                               |
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkages.plots.animation.recording import write_animation as write_animation
    from linkages.plots.attractors import bifurcation_figure as bifurcation_figure
    from linkages.plots.attractors import exponent_figure as exponent_figure
    from linkages.plots.attractors import section_figure as section_figure
    from linkages.plots.attractors import spectrum_figure as spectrum_figure
    from linkages.plots.histories import write_figures as write_figures
    from linkages.plots.style import COLORS as COLORS
    from linkages.plots.style import LINES as LINES
    from linkages.plots.style import figure_style as figure_style

#: Modules and their public names, loaded on first use: the animation needs Drake, the palette nothing.
_NAMES = {
    "animation.recording": ("write_animation",),
    "attractors": ("bifurcation_figure", "exponent_figure", "section_figure", "spectrum_figure"),
    "histories": ("write_figures",),
    "style": ("COLORS", "LINES", "figure_style"),
}
_HOME = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'linkages.plots' has no attribute '{name}'")
    import importlib

    return getattr(importlib.import_module(f"linkages.plots.{_HOME[name]}"), name)
