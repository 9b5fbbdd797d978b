"""Figures over parameters that the paper keeps fixed: drive angles, number of elements, speed."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from linkages.show.plots.shown import new_figure
from linkages.show.plots.style import COLORS, LINES
from linkages.three_rrr.analysis import RobotResults
from linkages.three_rrr.direct import drive_map
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.robot import changed
from linkages.three_rrr.speed import RESONANCE, speed_sweep, velocity_effect

_COUNTS = ListedColormap(["#FFFFFF", "#C6DDEE", COLORS[5], COLORS[0]])


def map_figure(results: RobotResults) -> Figure:
    """Draw number of assemblies and nearness to both types of singularity over phi_1 and phi_2."""
    found = drive_map(results.robot.geometry, float(results.robot.phi0[2]))
    degrees = np.rad2deg(found.angles)
    figure, axes = new_figure(2.9, 1, 3, sharey=True)
    counts = {"cmap": _COUNTS, "norm": BoundaryNorm([-1, 1, 3, 5, 7], 4)}
    nearness = {"cmap": "cividis", "vmin": 0.0}
    start = np.rad2deg(np.angle(np.exp(1j * results.robot.phi0)))
    turns = [-180, -90, 0, 90, 180]
    for axis, values, label, colors, ticks in (
        (axes[0], found.count, "number of assemblies [1]", counts, [0, 2, 4, 6]),
        (axes[1], found.fold, "type 2: least |det $J_x$| [1]", nearness, None),
        (axes[2], found.reach, "type 1: least |sin(ψ - φ)| [1]", nearness, None),
    ):
        image = axis.pcolormesh(degrees, degrees, values, shading="nearest", **colors)
        bar = figure.colorbar(image, ax=axis, location="bottom", ticks=ticks, label=label)
        bar.ax.tick_params(labelsize=7.5)
        axis.plot(start[0], start[1], "o", color=COLORS[1], ms=4)
        axis.set(xlabel="φ₁ [deg]", xticks=turns, yticks=turns, aspect="equal", facecolor="0.85")
        axis.tick_params(labelsize=7.5)
        axis.grid(False)
    axes[0].set(ylabel="φ₂ [deg]", facecolor="white")
    note = "; grey: no assembly" if np.any(found.count == 0) else ""
    figure.suptitle(f"φ₃ = {np.rad2deg(found.phi3):g} deg; the dot is t = 0{note}", fontsize=9)
    return figure


def convergence_figure(results: RobotResults) -> Figure:
    """Draw the error of the first frequencies at t = 0 over the number of elements per link."""
    figure, axis = new_figure(3.3)
    start = results.motion.part(slice(0, 1))
    counts = np.array([1, 2, 4, 8])
    found = [
        frequencies(FiniteElementModel(changed(results.robot, model={"elements": int(n)})), start, 6)[0]
        for n in (*counts, 32)
    ]
    error = np.array(found[:-1]) / found[-1] - 1.0
    for n in range(6):
        style = {"color": COLORS[n], "ls": LINES[n], "label": f"mode {n + 1}"}
        axis.loglog(counts, error[:, n], "o", lw=1.2, ms=4, **style)
    axis.loglog(counts, error[0].max() * (1.0 / counts) ** 4, color="0.4", lw=0.8, label="fourth order")
    axis.set_xticks(counts, [str(n) for n in counts])
    axis.minorticks_off()
    axis.set(xlabel="elements in each link", ylabel="relative error of frequency [1]")
    axis.set_title("against 32 elements in each link, t = 0, crank roots held", fontsize=9)
    axis.legend(ncols=2)
    return figure


def velocity_figure(results: RobotResults) -> Figure:
    """Draw the effect of the velocity-dependent terms over speed."""
    figure, axis = new_figure(3.3)
    factors = np.geomspace(1.0, 300.0, 13)
    frequency, displacement = velocity_effect(results.robot, results.branch, factors, poses=13)
    speed = factors * float(np.max(np.abs(results.motion.dphi)))
    axis.loglog(speed, frequency, "o-", color=COLORS[0], ms=3.5, lw=1.2, label="first natural frequency")
    axis.loglog(speed, displacement, "s--", color=COLORS[1], ms=3.5, lw=1.2, label="quasi-static displacement")
    axis.axhline(0.01, color="0.4", lw=0.8, ls=":")
    axis.text(speed[0], 0.012, "1 %", fontsize=8, color="0.3")
    axis.set(xlabel="speed of the fastest drive [rad/s]", ylabel="largest relative change [1]")
    title = "gyroscopic, centrifugal and geometric stiffness terms; leftmost: this experiment"
    axis.set_title(title, fontsize=9)
    axis.legend()
    return figure


def speed_figure(results: RobotResults) -> Figure:
    """Draw the peak elastic displacement over speed, up to the first resonance."""
    figure, (top, bottom) = new_figure(4.4, 2, sharex=True)
    one = changed(results.robot, model={"elements": 1})
    found = speed_sweep(one, results.branch, np.geomspace(60.0, 400.0, 60), steps_per_period=24.0)
    speed = found.factors * float(np.max(np.abs(results.motion.dphi)))
    top.loglog(speed, 1e3 * found.static, color=COLORS[1], ls="--", lw=1.4, label="quasi-static")
    label = "with vibration, 1 % damping (assumed)"
    top.loglog(speed, 1e3 * found.dynamic, "o-", color=COLORS[0], ms=3, lw=1.0, label=label)
    top.set_ylabel("peak displacement\nof the platform [mm]")
    top.legend()
    bottom.semilogx(speed, found.amplification, "o-", color=COLORS[0], ms=3, lw=1.0)
    bottom.axhline(RESONANCE, color="0.4", lw=0.8, ls=":")
    bottom.text(speed[0], RESONANCE, f"resonance: at least {RESONANCE:g}", va="bottom", fontsize=8, color="0.3")
    bottom.set(xlabel="speed of the fastest drive [rad/s]", ylabel="amplification [1]")
    for axis in (top.xaxis, top.yaxis, bottom.xaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
        axis.set_major_formatter(ScalarFormatter())
        axis.set_minor_formatter(NullFormatter())
    if found.resonance is not None:
        at = speed[found.resonance]
        for panel in (top, bottom):
            panel.axvline(at, color=COLORS[2], lw=1.0, ls="-.")
        times = f"{found.factors[found.resonance]:.0f} times the experiment's speed"
        bottom.set_title(f"first resonance at {at:.0f} rad/s, {times}", fontsize=9)
    return figure
