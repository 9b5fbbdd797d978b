"""Texts that Meshcat cannot draw: labels in the scene of a recording; below it a clock and a curve over time.

A small script, `overlay.html`, is added to the page. It computes the screen positions of the labels' anchors, writes
the texts of the current frame there, and moves the line in the curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from markupsafe import Markup

from linkages.show.plots.pages import embedded, filled, own_text, script


@dataclass(frozen=True)
class Label:
    """A text at a point of the scene."""

    anchor: str  # Meshcat path of the point
    title: str
    lines: list[str]  # lines below the title, one for each frame; empty: title only


def add_captions(page: str, labels: list[Label], shown: Mapping[str, Any]) -> str:
    """Add labels, texts below the scene, and a bar to play, stop and seek, to a recording's page.

    `shown` has ``view`` and ``aspect``: width and height [m] of the visible scene, and the window's ratio of both for
    which the camera was set; ``clock``: a text for each frame; ``legend``: a text; ``curves``: from
    `linkages.show.plots.pages.curves`; ``end``: time of the mechanism at the last frame [s].
    """
    entries = [asdict(label) | {"path": label.anchor.strip("/").split("/")} for label in labels]
    head, found, tail = page.rpartition("</body>")
    if not found:
        raise ValueError("the recording has no body to write captions into")
    data = embedded({"labels": entries, **shown})
    text = filled(own_text("linkages.show.plots.animation", "overlay.html"), curves=Markup(script()), data=data)
    return f"{head}{text}{found}{tail}"
