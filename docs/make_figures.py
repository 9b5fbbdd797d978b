"""Draw the explanatory figures of the pages: ``python docs/make_figures.py``.

`joint.png` and `data_flow.png` are sketches; `film_pressure.png` shows solutions of the Reynolds equation, `contact.png` the
first contact of a shipped experiment, both computed by the package.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

import linkages
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.surface_film import FilmSurface, solve_film
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.show.plots import COLORS, figure_style

FIGURES = Path(__file__).parent / "figures"


def joint(path: Path) -> None:
    """Draw a clearance joint with its symbols; the clearance is far larger than in a machine."""
    bearing, journal, eccentricity, attitude = 1.0, 0.68, 0.2, math.radians(35.0)
    e = eccentricity * np.array([math.cos(attitude), math.sin(attitude)])
    n, t = e / eccentricity, np.array([-math.sin(attitude), math.cos(attitude)])
    figure = Figure(figsize=(5.6, 5.2), layout="constrained")
    axes = figure.subplots()
    axes.add_patch(Circle((0, 0), 1.22, fc="0.82", ec="0.5"))
    axes.add_patch(Circle((0, 0), bearing, fc="#fdf3d0", ec="0.3"))
    axes.add_patch(Circle(e, journal, fc="#b9cbe4", ec="0.3"))
    for point, name, offset in (((0.0, 0.0), "O$_b$", (-0.17, -0.07)), (e, "O$_j$", (-0.02, 0.09))):
        axes.plot(*point, "k.", ms=5)
        axes.text(point[0] + offset[0], point[1] + offset[1], name, fontsize=11)

    def arrow(start: np.ndarray, end: np.ndarray, color: str, label: str, shift: tuple[float, float]) -> None:
        axes.annotate(
            "", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.6, "shrinkA": 0, "shrinkB": 0}
        )
        axes.text(end[0] + shift[0], end[1] + shift[1], label, color=color, fontsize=12)

    arrow(np.zeros(2), e, COLORS[1], r"$\mathbf{e}$", (-0.12, 0.0))
    arrow(e, e + 0.38 * n, COLORS[0], r"$\mathbf{n}$", (0.02, 0.0))
    arrow(e, e + 0.38 * t, COLORS[0], r"$\mathbf{t}$", (-0.02, 0.03))
    load = e - 0.45 * n - 0.2 * t
    arrow(e, load, COLORS[2], r"$\mathbf{F}$", (-0.02, -0.13))
    down, right = -math.pi / 2.0, math.radians(-20.0)
    axes.annotate(
        "",
        (bearing * math.cos(right), bearing * math.sin(right)),
        (0, 0),
        arrowprops={"arrowstyle": "->", "color": "0.4"},
    )
    axes.text(0.72, -0.21, r"$R$", color="0.3", fontsize=12)
    axes.annotate("", e + journal * np.array([0.0, -1.0]), e, arrowprops={"arrowstyle": "->", "color": "0.4"})
    axes.text(e[0] + 0.03, e[1] - 0.45, r"$R_j = R - c$", color="0.3", fontsize=12)
    gap = bearing * np.array([math.cos(down - 0.6), math.sin(down - 0.6)])
    direction = (gap - e) / np.linalg.norm(gap - e)
    axes.annotate("", gap, e + journal * direction, arrowprops={"arrowstyle": "<->", "color": COLORS[3]})
    axes.text(gap[0] + 0.02, gap[1] + 0.2, r"$h$", color=COLORS[3], fontsize=12)
    arc = np.linspace(0.0, attitude, 20)
    axes.plot([0, 0.5], [0, 0], color="0.5", lw=0.8, ls="--")
    axes.plot(0.4 * np.cos(arc), 0.4 * np.sin(arc), color="0.5", lw=0.8)
    axes.text(0.41, 0.05, r"$\gamma$", fontsize=12)
    axes.text(0.0, 1.07, r"bearing (parent), turns at $\omega_b$", ha="center", fontsize=10)
    axes.text(e[0] - 0.02, e[1] + 0.5, r"journal (child), $\omega_j$", ha="center", fontsize=10)
    axes.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), aspect="equal")
    axes.axis("off")
    figure.savefig(path, dpi=90)


def data_flow(path: Path) -> None:
    """Draw the way from two files to results."""
    boxes = {  # name: (x, y, text)
        "sdf": (0.0, 1.0, "machine\nNAME.sdf"),
        "toml": (0.0, 0.0, "experiment\nNAME.toml"),
        "mechanism": (1.35, 1.0, "Mechanism"),
        "experiment": (1.35, 0.0, "Experiment"),
        "system": (2.7, 0.5, "System"),
        "engine": (4.05, 0.5, "engine:\ncompiled | Drake"),
        "run": (5.5, 1.0, "Trajectory\n(one run)"),
        "batch": (5.5, 0.0, "Batch\n(many runs)"),
        "results": (6.95, 1.0, "summary, figures,\nanimation, report"),
        "optim": (6.95, 0.0, "optim: designs,\nfronts, sensitivities"),
    }
    arrows = (
        "sdf mechanism, toml experiment, mechanism system, experiment system, system engine, engine run, engine batch"
    )
    figure = Figure(figsize=(9.4, 2.3), layout="constrained")
    axes = figure.subplots()
    for x, y, text in boxes.values():
        patch = FancyBboxPatch(
            (x - 0.5, y - 0.22), 1.0, 0.44, boxstyle="round,pad=0.04", fc="#eef2f8", ec="0.4", lw=0.9
        )
        axes.add_patch(patch)
        axes.text(x, y, text, ha="center", va="center", fontsize=8)
    for pair in (*arrows.split(", "), "run results", "batch optim"):
        (x0, y0, _), (x1, y1, _) = (boxes[name] for name in pair.split())
        style = {"arrowstyle": "-|>", "color": "0.35", "lw": 1.1}
        axes.annotate("", (x1 - 0.55, y1), (x0 + 0.55, y0), arrowprops=style)
    axes.set(xlim=(-0.6, 7.6), ylim=(-0.35, 1.35))
    axes.axis("off")
    figure.savefig(path, dpi=130)


def film_pressure(path: Path) -> None:
    """Draw the pressure of a steadily turning journal in the middle of the bearing, for two rules of cavitation."""
    eps, slenderness = 0.6, 4.0 / 3.0
    mesh = surface_mesh(slenderness, eccentricity=(-eps, 0.0))  # theta = 0 is the widest gap
    with figure_style():
        figure = Figure(figsize=(6.5, 3.6), layout="constrained")
        axes = figure.subplots()
        rules = {"Reynolds": "reynolds", "Gümbel": "guembel"}
        solutions = {
            name: solve_film(FilmSurface(mesh), Thickness(-eps, 0.0), rule=rule) for name, rule in rules.items()
        }
        for (name, film), color, width in zip(solutions.items(), COLORS, (2.6, 1.4), strict=False):
            axes.plot(np.degrees(mesh.theta), film.pressure[:, 0], color=color, lw=width, label=f"pressure, {name}")
        other = axes.twinx()
        other.plot(np.degrees(mesh.theta), 1.0 + eps * np.cos(mesh.theta), color="0.5", ls="--", label="film thickness")
        axes.set(
            xlabel="angle θ from the widest gap [°]",
            ylabel="pressure / (μ R² ω/c²) [-]",
            xlim=(0, 360),
            xticks=range(0, 361, 60),
        )
        other.set(ylabel="film thickness h/c [-]", ylim=(0, None))
        handles = [*axes.get_legend_handles_labels()[0], *other.get_legend_handles_labels()[0]]
        axes.legend(handles=handles, loc="center right")
        figure.savefig(path, dpi=130)


def contact(path: Path) -> None:
    """Draw penetration and force of the first contact of the dry slider-crank."""
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.01})
    first = linkages.impacts(linkages.simulate(system), ["B"])[0]
    end = first.start + 1.6 * first.duration
    run = linkages.simulate(system.replaced({"duration": end, "solver.max_step": first.duration / 60.0}))
    shown = run.time > first.start - 0.4 * first.duration
    time = 1e6 * (run.time[shown] - first.start)
    with figure_style():
        figure = Figure(figsize=(6.5, 4.2), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.plot(time, 1e6 * run[f"{first.joint}.penetration"][shown], color=COLORS[0])
        lower.plot(time, 1e-3 * run[f"{first.joint}.load"][shown], color=COLORS[1])
        upper.set(ylabel="penetration δ [µm]")
        lower.set(ylabel="normal force [kN]", xlabel="time from the start of the contact [µs]")
        for axes in (upper, lower):
            axes.axhline(0.0, color="0.6", lw=0.7)
            for edge in (0.0, 1e6 * first.duration):
                axes.axvline(edge, color="0.6", lw=0.7, ls=":")
        upper.annotate("free flight", (0.03, 0.85), xycoords="axes fraction", fontsize=8)
        upper.annotate(f"approach at {first.approach_speed:.2f} m/s", (0.32, 0.1), xycoords="axes fraction", fontsize=8)
        upper.annotate(
            f"separation at {first.separation_speed:.2f} m/s", (0.76, 0.85), xycoords="axes fraction", fontsize=8
        )
        figure.savefig(path, dpi=130)


if __name__ == "__main__":
    for draw in (joint, data_flow, film_pressure, contact):
        draw(FIGURES / f"{draw.__name__}.png")
