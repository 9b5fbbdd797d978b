"""Pages of lines that change from frame to frame, enlarged by the reader: wearing bearings, modes of a robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from linkages.base.arrays import Array
from linkages.base.palette import LINKS
from linkages.show.plots.pages import embedded, filled, own_text, page_style, script

_FRAMES = 101  # of a service life
_SIDE = 100.0  # radius of a new bearing in its picture
_SEEN = 0.35  # drawn depth of wear or clearance over that radius


def lines_page(title: str, data: Mapping[str, Any], **texts: Any) -> str:
    """Return a page of moving lines.

    `data` has ``machines`` (name, ``box`` of the picture, ``lines`` with ``color``, ``rest``: points by frame, one for
    all frames if they stay, ``moved``: displacements by frame and choice, None for still lines), ``texts`` by frame and
    choice, ``size``: factor on displacements, ``length`` of the play [s], ``swings``, ``times``: the shown enlargement.
    """
    texts |= {"style": page_style(), "scripts": Markup(script("curves", "player")), "data": embedded(data)}
    return filled(own_text("linkages.show.plots", "lines.html"), title=title, frames=len(data["texts"]), **texts)


def wear_page(title: str, life: Mapping[str, Any]) -> str:
    """Return the page of growing profiles: `life` has ``cycles`` of stages, and depths by joint, stage and side."""
    cycles = np.asarray(life["cycles"], dtype=float)
    shown = np.linspace(0.0, cycles[-1], _FRAMES)
    deepest = max(max(joint["depth"], joint["clearance"]) / joint["radius"] for joint in life["joints"].values())
    box = [-1.5 * _SIDE, -1.5 * _SIDE, 3.0 * _SIDE, 3.0 * _SIDE]
    machines = [
        {"name": f"joint {name}: bearing and journal, each in its frame; grey: the new bearing", "box": box}
        | {"lines": _rings(joint, cycles, shown)}
        for name, joint in life["joints"].items()
    ]
    texts = [[f"{round(count):,} cycles"] for count in shown]
    size = _SEEN / deepest
    data = {"machines": machines, "texts": texts, "size": size, "times": size, "length": 6.0, "swings": False}
    note = "Depths of wear and the clearance are enlarged; the radius of the bearing is not."
    return lines_page(title, data, choices=(), along="cycles", enlarged="enlarged", note=note)


def _rings(joint: Mapping[str, Any], cycles: Array, shown: Array) -> list[dict[str, Any]]:
    """Return bearing, journal and the new bearing as lines; displacements in parts of the radius, times `_SIDE`."""
    count = len(joint["stages"][0]["bearing"])
    turn = np.linspace(0.0, 2.0 * np.pi, count + 1)
    ring = np.round(_SIDE * np.column_stack([np.cos(turn), np.sin(turn)]), 2)
    found = [{"color": "var(--ideal)", "rest": [ring.tolist()], "moved": None}]
    for side, color, sense, apart in (("bearing", "--play", 1.0, 0.0), ("journal", "--data", -1.0, joint["clearance"])):
        depths = np.array([stage[side] for stage in joint["stages"]])
        between = np.array([np.interp(shown, cycles, column) for column in depths.T]).T  # (frames, nodes)
        out = (sense * between - apart) / joint["radius"]
        moved = [[(ring * np.append(row, row[0])[:, None]).round(6).tolist()] for row in out]
        found.append({"color": f"var({color})", "rest": [ring.tolist()], "moved": moved})
    return found


def modes_page(title: str, modes: Mapping[str, Any]) -> str:
    """Return the page of a robot's modes: `modes` has ``frames`` (``t``, ``rest``, ``shape``), ``hz`` and ``box``."""
    frames, (x, y, right, top) = modes["frames"], modes["box"]
    lines: list[dict[str, Any]] = []
    for k in range(len(frames[0]["rest"])):
        rest = [frame["rest"][k] for frame in frames]
        lines.append({"color": "var(--ideal)", "rest": rest, "moved": None})
        moved = [[shape[k] for shape in frame["shape"]] for frame in frames]
        lines.append({"color": LINKS[k % len(LINKS)], "rest": rest, "moved": moved})
    for base in modes["base"]:
        foot = [base, [base[0] - 10.0, base[1] - 18.0], [base[0] + 10.0, base[1] - 18.0], base]
        lines.append({"color": "var(--ink)", "rest": [foot], "moved": None})
    told = zip(frames, modes["hz"], strict=True)
    texts = [[f"t = {frame['t']:.2f} s, {one:.1f} Hz" for one in hz] for frame, hz in told]
    machine = {"name": "the robot and a mode", "box": [x, -top, right - x, top - y], "lines": lines}
    data = {"machines": [machine], "texts": texts, "size": 1.0, "times": None, "length": 20.0, "swings": True}
    note = (
        "Grey: the rigid pose. Colour: the mode's shape, its size and its vibration's speed chosen to be seen."
        " The mode is followed from pose to pose; its natural frequency changes with the pose."
    )
    choices: Sequence[str] = [f"{k + 1} ({one:.1f} Hz at t = 0)" for k, one in enumerate(modes["hz"][0])]
    return lines_page(title, data, choices=choices, along="pose", enlarged="deflection", note=note)
