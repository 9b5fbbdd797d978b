"""Draw the figure of docs/periodic.md: ``python docs/make_periodic.py`` (about a minute)."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import linkages
from linkages.show.plots.attractors import branches_figure

FIGURES = Path(__file__).parent / "figures"
INERTIA = "<inertia><ixx>1e-4</ixx><iyy>1e-4</iyy><izz>1e-4</izz></inertia>"
MACHINE = f"""<sdf version="1.9"><model name="shaker">
<link name="base"><inertial><mass>1</mass>{INERTIA}</inertial></link>
<link name="block"><pose>0.2 0 0 0 0 0</pose><inertial><mass>1</mass>{INERTIA}</inertial></link>
<joint name="drive" type="prismatic"><parent>world</parent><child>base</child><axis><xyz>1 0 0</xyz></axis></joint>
<joint name="slide" type="prismatic"><parent>world</parent><child>block</child><axis><xyz>1 0 0</xyz></axis></joint>
</model></sdf>"""
EXPERIMENT = """mechanism = "shaker.sdf"
title = "Mass on a spring, with a stop, on a shaking base"
duration = 20.0
gravity = [0.0, 0.0, 0.0]
outputs = ["block.vx"]
[drives.drive]
formula = "0.01*sin(28*t)"
[springs.S]
point = "block"
to = "base"
stiffness = 100.0
free_length = 0.2
damping = 1.0
[stops.end]
joint = "slide"
side = "upper"
limit = "-3 mm"
[stops.end.contact]
law = "flores"
stiffness = 2e5
restitution = 0.8
"""
PATH, LOW, HIGH = "stops.end.limit", -3e-3, 0.0


def main() -> None:
    """Follow the branches, sweep the same range, and draw both."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "shaker.sdf").write_text(MACHINE, encoding="utf-8")
        (Path(folder) / "shaker.toml").write_text(EXPERIMENT, encoding="utf-8")
        system = linkages.load(Path(folder) / "shaker.toml")
    found = linkages.branches(system, PATH, LOW, HIGH, outputs=["block.vx"], transient=40, doublings=1, step=0.15)
    points = linkages.sweep(system, PATH, np.linspace(LOW, HIGH, 61), ["block.vx"], 8, 60)
    figure = branches_figure(found, {"block.vx": "m/s"}, "limit of the stop [mm]", 1e3, points)
    figure.savefig(FIGURES / "periodic_branches.png", dpi=130)
    for k, branch in enumerate(found.branches, 1):
        for event in branch.events:
            print(f"branch {k}, {branch.periods} periods: {event.kind} at {1e3 * (event.motion.value or 0.0):.6f} mm")


if __name__ == "__main__":
    main()
