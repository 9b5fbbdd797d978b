"""What Meshcat itself cannot draw of a recording: texts in its scene; below it the clock and a curve over time.

A small script is added to the page, `overlay.html`. It finds where the camera sees the anchors of the labels, writes
there what belongs to the frame that is shown, and moves the line in the curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.resources import files
from typing import Any

from linkages.plots.curves import embedded, script


@dataclass(frozen=True)
class Label:
    """A text at a place in the scene.

    Attributes
    ----------
    anchor : str
        Meshcat path of the place.
    title : str
    lines : list of str
        What is written below the title, one for each frame; nothing where it is empty.
    """

    anchor: str
    title: str
    lines: list[str]


def add_captions(page: str, labels: list[Label], shown: Mapping[str, Any]) -> str:
    """Add labels, what stands below the scene, and a bar that plays in a loop, stops and seeks to a recording's page.

    Parameters
    ----------
    page : str
        HTML.
    labels : list of Label
    shown : mapping
        ``view`` and ``aspect``, width and height [m] of what is to be seen and the window's ratio of both for which the
        camera was set; ``clock``, a text for each frame; ``legend``, a text; ``curves``, from
        `linkages.plots.curves.curves`; ``end``, the machine's time at the last frame [s].

    Returns
    -------
    str
        HTML.

    Raises
    ------
    ValueError
        If the page has no body.
    """
    entries = [asdict(label) | {"path": label.anchor.strip("/").split("/")} for label in labels]
    head, found, tail = page.rpartition("</body>")
    if not found:
        raise ValueError("the recording has no body to write captions into")
    text = (files("linkages.plots.animation") / "overlay.html").read_text(encoding="utf-8")
    text = text.replace("@CURVES@", script()).replace("@DATA@", embedded({"labels": entries, **shown}))
    return f"{head}{text}{found}{tail}"
