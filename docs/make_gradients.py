"""Draw an objective before and beyond the horizon of predictability, with its derivative: ``python docs/make_gradients.py``.

Writes docs/figures/gradients.png; a minute.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import linkages
from linkages.show.plots.shown import ShownFigure
from linkages.show.plots.style import COLORS, figure_style

FIGURE = Path(__file__).parent / "figures" / "gradients.png"
PATH, OUTPUT = "joints.B.clearance", "B.force"
DURATIONS = (3.0e-3, 2.4e-2)  # a quarter of a revolution, and two [s]
RANGE, POINTS, TANGENT = 0.002, 241, 6e-4  # parts of the value


def main() -> None:
    """Draw both over the clearance."""
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"solver.accuracy": 1e-9})
    value = system.value(PATH)
    values = value * np.linspace(1.0 - RANGE, 1.0 + RANGE, POINTS)
    with figure_style():
        figure = ShownFigure(figsize=(7.2, 2.9), layout="constrained")
        for axis, duration in zip(figure.subplots(1, 2), DURATIONS, strict=True):
            run = system.replaced({"duration": duration})
            forces = linkages.simulate_batch(run, [PATH], values[:, None], [OUTPUT]).rms[:, 0, 0]
            axis.plot(1e3 * values, 1e-3 * forces, ".", color=COLORS[0], ms=2.5)
            found = linkages.sensitivities(run, [PATH], [OUTPUT], error_estimate=False)
            rate, force = found.derivatives[PATH][f"{OUTPUT}.rms"], found.numbers[f"{OUTPUT}.rms"]
            if rate is not None:
                away = TANGENT * value * np.array([-1.0, 1.0])
                axis.plot(1e3 * (value + away), 1e-3 * (force + rate * away), color=COLORS[1], label="derivative")
                axis.legend(fontsize=8)
            axis.set(xlabel="clearance [mm]", ylabel="rms of the joint force [kN]")
            axis.set_title(f"the first {1e3 * duration:g} ms", fontsize=9)
            print(f"{duration:g} s: rms {force:.6g} N, derivative {rate}, until {found.run.sensitivity.until:.4g} s")
    figure.savefig(FIGURE)


if __name__ == "__main__":
    main()
