"""Write docs/laws.md and its figures: ``python docs/make_laws.py``."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from laws_page import MOTIONS, RATIOS, bearing_ratio, markdown
from numba import njit

from linkages.laws import CONTACTS, PARAMETERS
from linkages.laws.contact.contact_laws import contact_force
from linkages.laws.contact.material import contact_modulus, hertz_stiffness, kelvin_voigt_damping
from linkages.show.plots.style import COLORS, LINES

HERE = Path(__file__).parent
#: Chen et al. (2025), Tables 4-5, clearance 0.3 mm; mass and speed of the impact do not matter, but for Kelvin-Voigt.
RADIUS, CLEARANCE, MASS, SPEED, LINEAR = 0.015, 0.3e-3, 0.2, 0.3, 1e8


@njit
def measure(joint: np.record, step: float) -> float:
    """Restitution of a free impact, integrated by the classical Runge-Kutta method."""
    x, v = 0.0, SPEED
    for _ in range(10_000_000):
        slopes_x, slopes_v = 0.0, 0.0
        dx, dv = 0.0, 0.0
        for weight, part in ((1.0, 0.0), (2.0, 0.5), (2.0, 0.5), (1.0, 1.0)):
            at_x, at_v = x + part * step * dx, v + part * step * dv
            force = contact_force(at_x, at_v, SPEED, joint)
            dx, dv = at_v, -force / MASS
            slopes_x += weight * dx
            slopes_v += weight * dv
        x += step / 6.0 * slopes_x
        v += step / 6.0 * slopes_v
        if x <= 0.0:
            return -v / SPEED
    return math.nan


def restitution_figure(path: Path) -> None:
    """Effective against nominal restitution of every law."""
    modulus = contact_modulus(200e9, 0.3, 200e9, 0.3)
    hertz = hertz_stiffness(RADIUS, RADIUS - CLEARANCE, modulus)
    joint = np.zeros((), PARAMETERS)
    nominal = np.linspace(0.02, 1.0, 50)
    figure, axes = plt.subplots(figsize=(7.0, 5.6))
    axes.plot([0, 1], [0, 1], color="0.6", lw=3.0, alpha=0.5, label="nominal")
    for i, (name, law) in enumerate((name, law) for name, law in CONTACTS.items() if not (law.conformal or law.states)):
        values, linear = [], name == "kelvin-voigt"
        reached = nominal[nominal >= math.exp(-2.0)] if linear else nominal
        for e in map(float, reached):
            damping = kelvin_voigt_damping(LINEAR, MASS, e) if linear else 0.0
            numbers = {"restitution": e, "stiffness": LINEAR if linear else hertz, "exponent": 1.5, "damping": damping}
            law.fill(joint, numbers)
            values.append(measure(joint[()], 1e-7))
        label = f"{name} (and the cylinder laws)" if name == "lankarani-nikravesh" else name
        color, style = COLORS[i % len(COLORS)], LINES[i // len(COLORS)]
        axes.plot(reached, values, ls=style, lw=1.4, color=color, label=label)
    axes.set(xlabel="nominal restitution e [-]", ylabel="effective restitution of a free impact [-]")
    axes.set(xlim=(0, 1), ylim=(0, 1.02))
    axes.legend(fontsize=8, loc="lower right")
    axes.grid(color="0.9")
    _save(figure, path)


def long_bearing_figure(path: Path) -> None:
    """Force of the long film over that of the finite film."""
    slendernesses = np.geomspace(0.2, 16.0, 25)
    figure, panels = plt.subplots(1, 3, figsize=(10.5, 3.8), sharey=True)
    for axes, motion in zip(panels, MOTIONS, strict=True):
        for i, eps in enumerate(RATIOS):
            ratio = [bearing_ratio("long", float(s), eps, motion) for s in slendernesses]
            axes.loglog(slendernesses, ratio, color=plt.cm.viridis(i / len(RATIOS)), label=f"ε = {eps}")
        axes.axvline(4.0 / 3.0, color="0.6", lw=0.8, ls=":")
        axes.axvline(8.0, color="0.6", lw=0.8, ls="--")
        axes.text(1.3, 60.0, "Chen 2025", rotation=90, fontsize=7, color="0.4", ha="right")
        axes.text(8.2, 60.0, "L/D > 8", rotation=90, fontsize=7, color="0.4", ha="left")
        axes.set(title=motion, xlabel="L/D [-]")
        axes.set_xticks([0.25, 0.5, 1, 2, 4, 8, 16], labels=["0.25", "0.5", "1", "2", "4", "8", "16"])
        axes.minorticks_off()
        axes.grid(color="0.9")
    panels[0].set_yticks([1, 2, 5, 10, 20, 50, 100], labels=["1", "2", "5", "10", "20", "50", "100"])
    panels[0].set_ylabel("force of the long film / finite film [-]")
    panels[-1].legend(fontsize=8)
    _save(figure, path)


def _save(figure: plt.Figure, path: Path) -> None:
    path.parent.mkdir(exist_ok=True)
    figure.tight_layout()
    figure.savefig(path, dpi=130, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    (HERE / "laws.md").write_text(markdown(), encoding="utf-8")
    restitution_figure(HERE / "figures" / "restitution.png")
    long_bearing_figure(HERE / "figures" / "long_bearing_error.png")
