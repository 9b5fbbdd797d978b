"""Animation of wear: a page with a slider over the service life; one file, offline, without libraries."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from linkages.plots.pages import embedded, filled, own_text
from linkages.plots.style import COLORS


def write_animation(found: Mapping[str, Any], path: Path) -> None:
    """Write a page with the growing profiles of all joints, from the content of ``wear.json``."""
    joints = {}
    for name, joint in found["joints"].items():
        nodes = len(joint["profile"])
        stages = [
            {side: _depths(block["joints"][name], side, nodes) for side in ("bearing", "journal")}
            for block in found["blocks"]
        ]
        kept = {key: joint[key] for key in ("depth", "clearance", "radius")}
        joints[name] = kept | {"stages": stages}
    life = {"cycles": [block["cycles"] for block in found["blocks"]], "joints": joints}
    text = own_text("linkages.plots", "wear_animation.html")
    title = found["title"] or found["experiment"]
    path.write_text(filled(text, title=title, life=embedded(life), colors=embedded(COLORS)), encoding="utf-8")


def _depths(joint: Mapping[str, Any], side: str, nodes: int) -> list[float]:
    """Return the depths of a part at a stage [m], rounded to the visible resolution."""
    if side not in joint:
        return [0.0] * nodes
    return [float(f"{depth:.4g}") for _, depth in joint[side]["profile"]]
