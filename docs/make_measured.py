"""Draw docs/figures/measured_machines.png: measured curves, and the computed ones that the first half of each fits.

    python docs/make_measured.py --slider_crank DIR --four_bar DIR --double_pendulum DIR --pendulum DIR

DIR is the folder of ``docs/measured_machines.py`` for a machine; for the pendulum the folder of ``measured_pendulums.py``.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import linkages
from linkages.base.palette import INK, SOFT

HERE = Path(__file__).parent


class Shown(NamedTuple):
    """A curve of a machine: the folder of the fit's results, the column, its scale and unit, and a part of the time."""

    result: str
    column: str
    output: str
    scale: float
    label: str
    part: tuple[float, float]


PANELS = {
    "slider_crank": Shown("result", "run.slide", "slide.x", 1e3, "place of the slide [mm]", (3.5, 7.5)),
    "four_bar": Shown("result", "run.rate", "rocker.omega", 180.0 / np.pi, "rate of the rocker [deg/s]", (1.0, 13.0)),
    "double_pendulum": Shown("result", "run.q2", "q.E", 180.0 / np.pi, "angle of the elbow [deg]", (3.0, 7.0)),
    "pendulum": Shown("joint_force", "swing.angle", "q.O", 180.0 / np.pi, "angle of the pendulum [deg]", (8.0, 18.0)),
}


def draw(axes: Axes, folder: Path, shown: Shown) -> None:
    """Draw samples and computed curve of a part; a line where the prediction begins."""
    found = json.loads((folder / shown.result / "result.json").read_text())
    system = linkages.load(folder / shown.result / "fitted.toml")
    run = linkages.simulate(system.replaced({"duration": shown.part[1] + 0.2}))
    times = np.linspace(*shown.part, 2000)
    curve = run.evaluate(times)[shown.output]
    samples = measured(folder, shown, found)
    inside = (samples[0] >= shown.part[0]) & (samples[0] <= shown.part[1])
    axes.plot(samples[0][inside], shown.scale * samples[1][inside], ".", ms=3, color=SOFT, label="measured")
    axes.plot(times, shown.scale * curve, color=INK, lw=0.9, label="computed")
    if found["prediction"]:
        axes.axvline(found["prediction"]["from"], color=INK, lw=0.8, ls=":")
    axes.set(xlabel="time [s]", ylabel=shown.label, xlim=shown.part)


def measured(folder: Path, shown: Shown, found: dict) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of all samples, as the fit reads them: shift, gain and offset are those that it has found."""
    import optim

    task = optim.load_identification(folder / ("fit.toml" if shown.result == "result" else f"{shown.result}.toml"))
    name, _, column = shown.column.partition(".")
    one = next(m for m in task.measurements if m.name == name)
    channel = next(c for c in one.channels if c.name == column)
    given = {key: value["value"] for key, value in found["nuisance"].items()}
    gain, offset = (given.get(f"{shown.column}.{key}", getattr(channel, key)) for key in ("gain", "offset"))
    times = channel.times + given.get(f"{name}.shift", 0.0 if np.isnan(one.shift) else one.shift)
    return times, gain * channel.values + offset


def main() -> None:
    """Draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in PANELS:
        parser.add_argument(f"--{name}", type=Path, required=True, metavar="DIR")
    given = vars(parser.parse_args())
    with mpl.rc_context({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False}):
        figure = Figure(figsize=(7.0, 4.8), layout="constrained")
        for axes, (name, shown) in zip(figure.subplots(2, 2).flat, PANELS.items(), strict=True):
            draw(axes, given[name], shown)
            axes.set_title(name.replace("_", "-").replace("double-pendulum", "double pendulum"), loc="left", fontsize=8)
        figure.axes[0].legend(
            frameon=False, fontsize=7, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.0
        )
        figure.savefig(HERE / "figures" / "measured_machines.png", dpi=150)


if __name__ == "__main__":
    main()
