"""Draws the figure of docs/flexible_limits.md: ``python docs/make_flexible.py``, a minute.

The slider-crank with an elastic rod, over Young's modulus of the rod at unchanged mass: force in the joint between rod and slider and
jitter of the slider, with a film, without oil and without play, beside the same with a rigid rod.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.show.plots import COLORS, LINES, figure_style

FIGURE = Path(__file__).parent / "figures" / "flexible_stiffness.png"
STEEL = 2e11  # Pa, as in the file
RATIOS = np.geomspace(0.2, 200.0, 13)
REVOLUTIONS = (2, 7)  # first and last one that is looked at
OUTPUTS = ["B.force", "slider.ax.jitter"]
DRY = {
    "model": "dry",
    "clearance": 5e-5,
    "contact": {"law": "lankarani-nikravesh", "youngs_modulus": 2.07e11, "poissons_ratio": 0.3, "restitution": 0.9},
}
#: Changed values of each joint, and its axial modes, which matter to impacts alone.
JOINTS = {"ideal": ({"joints.B": {"model": "ideal"}}, 0), "lubricated": ({}, 0), "dry": ({"joints.B": DRY}, 4)}


def curves(joint: dict[str, object], axial: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean of the revolutions' peak forces and rms of the jitter, over `RATIOS` and last of a rigid rod."""
    changed = joint | {"links.rod.axial": axial, "outputs": ["slider.ax"]}
    system = linkages.load(linkages.find_file("slider_crank_flexible.toml"), changed)
    period = 2.0 * np.pi / system.value("drives.O.speed")
    edges = period * np.arange(REVOLUTIONS[0], REVOLUTIONS[1] + 1)
    system = system.replaced({"duration": float(edges[-1])})
    windows = list(pairwise(edges))
    values = STEEL * RATIOS[:, None]
    bent = linkages.simulate_batch(system, ["sdf.links.rod.beam.youngs_modulus"], values, OUTPUTS, windows)
    rigid = linkages.simulate_batch(system.replaced({"links.rod": {}}), outputs=OUTPUTS, windows=windows)
    peak = np.concatenate([each.peak[:, :, 0].mean(axis=1) for each in (bent, rigid)])
    jitter = np.concatenate([np.sqrt((each.rms[:, :, 1] ** 2).mean(axis=1)) for each in (bent, rigid)])
    return peak, jitter


def draw() -> None:
    """Draw both quantities over the stiffness; thin lines are those of a rigid rod."""
    with figure_style():
        figure = Figure(figsize=(6.5, 6.0), layout="constrained")
        axes = figure.subplots(2, 1, sharex=True)
        for (name, (joint, axial)), color, line in zip(JOINTS.items(), COLORS, LINES, strict=False):
            for axis, values in zip(axes, curves(joint, axial), strict=True):
                axis.plot(1e-9 * STEEL * RATIOS, values[:-1], color=color, ls=line, label=name)
                axis.axhline(values[-1], color=color, lw=0.7, alpha=0.6)
        for axis in axes:
            axis.axvline(1e-9 * STEEL, color="0.5", lw=0.7, ls=":")
        axes[0].set(xscale="log", ylabel="mean peak force in B [N]")
        axes[0].legend(title="joint B")
        axes[1].set(yscale="log", ylim=(1e-2, None), ylabel="rms jitter of the slider [m/s²]")
        axes[1].set(xlabel="Young's modulus of the rod [GPa]; dotted: steel; thin: rigid rod")
        figure.savefig(FIGURE, dpi=150)


if __name__ == "__main__":
    draw()
