"""A drawing as an HTML page with a slider for each drive; one file, offline."""

from __future__ import annotations

from importlib.resources import files

import numpy as np
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from linkages.plots.curves import embedded
from linkages.plots.drawing.drawing import Drawing
from linkages.plots.drawing.svg import scale, svg

_DIGITS = 6


def page(drawing: Drawing) -> str:
    """Write the page."""
    sliders = [
        {
            "values": slider.values.round(2).tolist(),
            "unit": slider.unit,
            "first": slider.first,
            "poses": [[[float(f"{v:.{_DIGITS}g}") for v in row] for row in pose] for pose in slider.poses],
            "sense": slider.sense,
            "full": bool(np.ptp(slider.values) > 359.9 and slider.unit == "deg"),
        }
        for slider in drawing.sliders
    ]
    data = {"low": drawing.low[0], "high": drawing.high[1], "scale": scale(drawing), "sliders": sliders}
    text = (files("linkages.plots.drawing") / "page.html").read_text(encoding="utf-8")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(text).render(
        drawing=drawing,
        asked=[text for text in (drawing.problem, *drawing.doubts) if text],
        picture=svg(drawing, said=False),
        data=Markup(embedded(data)),
    )
