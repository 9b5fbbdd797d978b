"""The paper's figures 5 to 12; figures over what the paper keeps fixed: drive angles, number of elements, speed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from linkages.base.palette import EDGE, LINE, PAPER, SCALE, SOFT
from linkages.show.plots.panels import legend_below, make_panels, narrow, note, say
from linkages.show.plots.quantities import number, quantity, share
from linkages.show.plots.style import COLORS, LINES, figure_style, small_text, write_figure
from linkages.show.plots.three_rrr.robot_lines import OUTLINE, draw_pose, shape_lines
from linkages.three_rrr.analysis import RobotResults
from linkages.three_rrr.direct import drive_map
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import DENSE, frequencies
from linkages.three_rrr.response import generalised_alpha
from linkages.three_rrr.robot import changed
from linkages.three_rrr.speed import RESONANCE, speed_sweep, velocity_effect
from linkages.three_rrr.stress import platform_stress

_WINDOW = 0.12  # drawn duration of the vibration after a start from rest [s]
_SHAPE_POSES = 3
_COUNTS = ListedColormap([PAPER, LINE, COLORS[3], COLORS[0]])
_ACCELERATION = ("d²θ/dt² [rad/s²]", "d²x/dt² [mm/s²]", "d²y/dt² [mm/s²]")


def write_figures(results: RobotResults, folder: Path, progress: Callable[[float], None] | None = None) -> list[Path]:
    """Draw all figures as PNG files; return their paths."""
    jobs: list[tuple[str, Callable[[RobotResults], Figure]]] = [
        ("fig05_pose", partial(_over_time, "x", ("θ [deg]", "x [mm]", "y [mm]"))),
        ("fig06_path", _path),
        ("fig07_velocity", partial(_over_time, "dx", ("dθ/dt [rad/s]", "dx/dt [mm/s]", "dy/dt [mm/s]"))),
        ("fig08_acceleration", partial(_over_time, "ddx", _ACCELERATION)),
        ("fig09_frequencies", _frequencies),
        ("fig10_mode_shapes", _shapes),
        ("fig11_elastic_displacement", _displacement),
        ("fig12_stress", _stress),
        ("map_assemblies", _map),
        ("convergence", _convergence),
        ("velocity_terms", _velocity),
        ("speed_sweep", _speed),
    ]
    paths: list[Path] = []
    with figure_style():
        for index, (name, draw) in enumerate(jobs):
            paths.append(write_figure(draw(results), folder / name))
            if progress is not None:
                progress((index + 1) / len(jobs))
    return paths


def _over_time(name: str, labels: tuple[str, str, str], results: RobotResults) -> Figure:
    """Draw the platform's position or a rate of it (by its name in the motion) over time, in panels."""
    values = getattr(results.motion, name) * np.array([1.0, 1e3, 1e3])
    if name == "x":
        values[:, 0] = np.rad2deg(np.unwrap(values[:, 0]))
    figure, axes = make_panels(3, 1.65, 1, sharex=True)
    for axis, label, curve, color in zip(axes, labels, values.T, COLORS, strict=False):
        axis.plot(results.motion.time, curve, color=color, lw=1.2)
        axis.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    symbol, bracket, unit = labels[1].partition(" [")
    most = float(np.abs(values[:, 1]).max())
    say(figure, f"Platform: {symbol} up to {number(most)} {unit[:-1]}" if bracket else "Platform")
    return figure


def _path(results: RobotResults) -> Figure:
    figure, (axis, whole) = make_panels(2, 3.1)
    x, y = 1e3 * results.motion.x[:, 1], 1e3 * results.motion.x[:, 2]
    for panel in (axis, whole):
        panel.plot(x, y, color=COLORS[0], lw=1.3, zorder=4)
        panel.plot(x[0], y[0], "o", color=COLORS[1], ms=4, zorder=5, label="start")
        panel.plot(x[-1], y[-1], "s", color=COLORS[2], ms=4, zorder=5, label="end")
        panel.set_aspect("equal", adjustable="datalim")
        panel.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm]")
    whole.set_ylabel("y [mm]")
    other = len(results.motion) // 3
    for index, alpha in ((0, 0.9), (other, 0.35)):
        draw_pose(whole, results.model, results.motion, index, alpha=alpha)
    axis.locator_params(nbins=5)
    travel = float(np.hypot(np.diff(x), np.diff(y)).sum())
    say(figure, f"The platform's centre travels {number(travel)} mm")
    note(figure, f"Right: in the robot at t = 0 and {results.motion.time[other]:.2f} s (light).")
    legend_below(figure, [axis])
    return figure


def _frequencies(results: RobotResults) -> Figure:
    figure, (axis, loose) = make_panels(2, 2.5, 1, sharex=True)
    for n, values in enumerate(results.tracked.T):
        style: dict[str, Any] = {"color": COLORS[n], "ls": LINES[n], "label": f"mode {n + 1}"}
        axis.plot(results.motion.time, values, lw=1.4, **style)
    for n, values in enumerate(results.free[:, 3:].T):
        loose.plot(results.motion.time, values, lw=1.4, color=COLORS[n], label=f"mode {n + 4}")
    for panel in (axis, loose):
        panel.set(ylabel="natural frequency [Hz]")
        panel.set_ylim(bottom=0.0)
    loose.set_xlabel("time [s]")
    axis.set_title("crank roots held", fontsize="medium", loc="left")
    loose.set_title("crank roots free", fontsize="medium", loc="left")
    low, high = (number(float(one)) for one in (results.tracked[:, 0].min(), results.tracked[:, 0].max()))
    say(figure, f"Lowest natural frequency: {low} to {high} Hz over the motion")
    note(figure, "Modes are followed by MAC from t = 0; of free roots by size, the first three have 0 Hz.")
    legend_below(figure)
    return figure


def _shapes(results: RobotResults) -> Figure:
    """Draw the deformed modes (rows) at several poses (columns)."""
    rows = min(4, results.tracked.shape[1])
    columns = 2 if narrow() else _SHAPE_POSES
    figure, found = make_panels(rows * columns, 2.0 if narrow() else 2.4, columns, columns, sharex=True, sharey=True)
    axes = np.array(found).reshape(rows, columns)
    places = np.linspace(0, len(results.motion) - 1, columns + 1).astype(int)[:-1]
    for column, index in enumerate(places):
        for mode in range(rows):
            axis: Axes = axes[mode, column]
            draw_pose(axis, results.model, results.motion, index, color=EDGE)
            lines = shape_lines(results.model, results.motion, index, results.shapes[index, :, mode])
            for line, name in lines:
                axis.plot(*(1e3 * line.T), color=COLORS[mode], lw=1.6 if name == "platform" else 1.3)
            axis.set_aspect("equal")
            axis.grid(False)
            axis.locator_params(nbins=4)
            pose = f"{mode + 1}, {results.motion.time[index]:.2f} s"
            axis.set_title(f"{pose}: {number(float(results.tracked[index, mode]))} Hz", fontsize=small_text())
    low = number(float(results.tracked[places, 0].min()))
    say(figure, f"Mode shapes from {low} Hz on, magnified")
    for axis in axes[-1]:
        axis.set_xlabel("x [mm]")
    for axis in axes[:, 0]:
        axis.set_ylabel("y [mm]")
    return figure


def _displacement(results: RobotResults) -> Figure:
    """Draw the displacement: left over the whole motion (quasi-static, vibration), right after a start from rest."""
    figure, found = make_panels(6, 1.7, 2, 1)
    axes = [found[k : k + 2] for k in (0, 2, 4)]
    time, static = results.motion.time, 1e6 * results.static.platform
    window = min(_WINDOW, float(results.branch.times[-1]))
    near = time <= window * 1.5
    vibration = None
    if results.model.size <= DENSE:
        times = np.linspace(0.0, window, 4001)
        vibration = generalised_alpha(results.model, results.branch, times, radius=1.0)
    for k, label in enumerate(("x [µm]", "y [µm]", "rotation [µrad]")):
        left, right = axes[k]
        if results.dynamic is not None:
            left.fill_between(results.dynamic.time, *(1e6 * results.dynamic.platform[:, :, k]), color=COLORS[0], lw=0.0)
        left.plot(time, static[:, k], color=COLORS[1], lw=1.2)
        left.set_ylabel(f"elastic {label}")
        right.set_ylabel(f"elastic {label}")
        if vibration is not None:
            shaken = 1e6 * vibration.platform[:, k]
            right.plot(1e3 * times, shaken, color=COLORS[0], lw=0.8, label="started from rest")
        right.plot(1e3 * time[near], static[near, k], color=COLORS[1], lw=1.6, label="quasi-static")
        right.set_xlim(0.0, 1e3 * window)
    band = "" if results.dynamic is None else "; band: with vibration"
    axes[0][0].set_title(f"quasi-static{band}", fontsize="medium", loc="left")
    axes[0][1].set_title("from rest, undamped", fontsize="medium", loc="left")
    for left, right in axes:
        left.set_xlabel("time [s]")
        right.set_xlabel("time [ms]")
    most = float(np.hypot(static[:, 0], static[:, 1]).max())
    say(figure, f"The platform yields by up to {number(most, 3)} µm, quasi-statically")
    legend_below(figure, [axes[0][1]])
    return figure


def _stress(results: RobotResults) -> Figure:
    """Draw the stress over time in leg 2 and the platform (bands: vibration), and along the rods at its peak."""
    options: dict[str, Any] = {} if narrow() else {"width_ratios": [1.7, 1]}
    figure, found = make_panels(6, 2.3, 2, 1, **options)
    axes = [found[k : k + 2] for k in (0, 2, 4)]
    time = results.motion.time
    for row, link in enumerate((results.stress[2], results.stress[3])):
        pose, _ = np.unravel_index(np.argmax(link.largest), link.largest.shape)
        left, right = axes[row]
        for end, k in enumerate((0, len(link.s) // 2, len(link.s) - 1)):
            label = f"{1e3 * link.s[k]:.0f} mm"
            if results.dynamic is not None:
                band = 1e-3 * results.dynamic.fibre[link.name][:, :, end]
                left.fill_between(results.dynamic.time, *band, color=COLORS[end], alpha=0.3, lw=0.0)
            left.plot(time, 1e-3 * link.fibre[:, k], color=COLORS[end], ls=LINES[end], lw=1.2, label=label)
        left.set(xlabel="time [s]", ylabel=f"{link.name}: stress in\nthe outer fibre [kPa]")
        right.plot(1e3 * link.s, 1e-3 * link.axial[pose], color=COLORS[2], ls="--", lw=1.2, label="axial")
        right.plot(1e3 * link.s, 1e-3 * link.bending[pose], color=COLORS[1], lw=1.2, label="bending")
        right.set_xlabel(f"along the rod [mm]\nat {time[pose]:.2f} s")
        right.set_ylabel("stress [kPa]")
        _legend_above(left)
        _legend_above(right)
    left, right = axes[2]
    if results.model.rigid:
        left.text(0.5, 0.5, "the platform is rigid", transform=left.transAxes, ha="center")
    else:
        plate = platform_stress(results.model, results.static)
        curves = {"larger principal": plate.first, "smaller": plate.second, "shear": plate.largest_shear}
        for k, (label, values) in enumerate(curves.items()):
            if results.dynamic is not None and results.dynamic.plate is not None:
                band = results.dynamic.plate[:, :, k]
                left.fill_between(results.dynamic.time, *band, color=COLORS[k], alpha=0.3, lw=0.0)
            left.plot(time, values, color=COLORS[k], ls=LINES[k], lw=1.2, label=label)
        _legend_above(left)
    left.set(xlabel="time [s]", ylabel="platform: stress [Pa]")
    right.axis("off")
    draw_pose(right, results.model, results.motion, 0, color=OUTLINE)
    right.set_aspect("equal")
    right.set_title("robot at t = 0", fontsize=small_text())
    largest = {link.name: float(link.largest.max()) for link in results.stress}
    name = max(largest, key=largest.__getitem__)
    say(figure, f"Largest stress: {quantity(largest[name], 'Pa')} in {name}")
    return figure


def _legend_above(axis: Axes) -> None:
    place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 0.98), "borderaxespad": 0.0}
    axis.legend(fontsize=small_text(), ncols=3, columnspacing=0.8, handlelength=1.2, handletextpad=0.4, **place)


def _map(results: RobotResults) -> Figure:
    """Draw number of assemblies and nearness to both types of singularity over phi_1 and phi_2."""
    found = drive_map(results.robot.geometry, float(results.robot.phi0[2]))
    degrees = np.rad2deg(found.angles)
    figure, axes = make_panels(3, 2.9, 3, 1, sharey=True)
    counts: dict[str, Any] = {"cmap": _COUNTS, "norm": BoundaryNorm([-1, 1, 3, 5, 7], 4)}
    nearness: dict[str, Any] = {"cmap": SCALE, "vmin": 0.0}
    start = np.rad2deg(np.angle(np.exp(1j * results.robot.phi0)))
    turns = [-180, -90, 0, 90, 180]
    for axis, values, label, colors, ticks in (
        (axes[0], found.count, "number of assemblies [1]", counts, [0, 2, 4, 6]),
        (axes[1], found.fold, "type 2: least |det $J_x$| [1]", nearness, None),
        (axes[2], found.reach, "type 1: least |sin(ψ - φ)| [1]", nearness, None),
    ):
        image = axis.pcolormesh(degrees, degrees, values, shading="nearest", **colors)
        bar = figure.colorbar(image, ax=axis, location="bottom", ticks=ticks, label=label)
        bar.ax.tick_params(labelsize=small_text())
        axis.plot(start[0], start[1], "o", color=COLORS[1], ms=4)
        axis.set(xlabel="φ₁ [deg]", xticks=turns, yticks=turns, aspect="equal", facecolor=LINE)
        axis.tick_params(labelsize=small_text())
        axis.grid(False)
    axes[0].set(ylabel="φ₂ [deg]", facecolor=PAPER)
    none = ", grey: no assembly" if np.any(found.count == 0) else ""
    say(figure, f"Up to {int(found.count.max())} assemblies for given drive angles")
    note(figure, f"φ₃ = {np.rad2deg(found.phi3):g} deg; dot: t = 0{none}.")
    return figure


def _convergence(results: RobotResults) -> Figure:
    """Draw the error of the first frequencies at t = 0 over the number of elements per link."""
    figure, (axis,) = make_panels(1, 3.1)
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
    axis.loglog(counts, error[0].max() * (1.0 / counts) ** 4, color=SOFT, lw=0.8, label="fourth order")
    axis.set_xticks(counts, [str(n) for n in counts])
    axis.minorticks_off()
    axis.set(xlabel="elements in each link", ylabel="relative error of frequency [1]")
    say(figure, f"Two elements in each link err by at most {share(float(np.abs(error[1]).max()))}")
    note(figure, "Against 32 elements in each link, t = 0, crank roots held.")
    legend_below(figure)
    return figure


def _velocity(results: RobotResults) -> Figure:
    """Draw the effect of the velocity-dependent terms over speed."""
    figure, (axis,) = make_panels(1, 3.1)
    factors = np.geomspace(1.0, 300.0, 13)
    frequency, displacement = velocity_effect(results.robot, results.branch, factors, poses=13)
    speed = factors * float(np.max(np.abs(results.motion.dphi)))
    axis.loglog(speed, frequency, "o-", color=COLORS[0], ms=3.5, lw=1.2, label="first natural frequency")
    axis.loglog(speed, displacement, "s--", color=COLORS[1], ms=3.5, lw=1.2, label="quasi-static displacement")
    axis.axhline(0.01, color=SOFT, lw=0.8, ls=":")
    axis.text(speed[0], 0.012, "1 %", fontsize=small_text(), color=SOFT)
    axis.set(xlabel="speed of the fastest drive [rad/s]", ylabel="largest relative change [1]")
    most = share(float(max(frequency[0], displacement[0])))
    say(figure, f"Terms of the velocity change this experiment by at most {most}")
    note(figure, "Gyroscopic, centrifugal and geometric stiffness terms; leftmost: this experiment.")
    legend_below(figure)
    return figure


def _speed(results: RobotResults) -> Figure:
    """Draw the peak elastic displacement over speed, up to the first resonance."""
    figure, (top, bottom) = make_panels(2, 2.1, 1, sharex=True)
    one = changed(results.robot, model={"elements": 1})
    found = speed_sweep(one, results.branch, np.geomspace(60.0, 400.0, 60), steps_per_period=24.0)
    speed = found.factors * float(np.max(np.abs(results.motion.dphi)))
    top.loglog(speed, 1e3 * found.static, color=COLORS[1], ls="--", lw=1.4, label="quasi-static")
    label = "with vibration, 1 % damping (assumed)"
    top.loglog(speed, 1e3 * found.dynamic, "o-", color=COLORS[0], ms=3, lw=1.0, label=label)
    top.set_ylabel("peak displacement\nof the platform [mm]")
    bottom.semilogx(speed, found.amplification, "o-", color=COLORS[0], ms=3, lw=1.0)
    bottom.axhline(RESONANCE, color=SOFT, lw=0.8, ls=":")
    bottom.text(
        speed[0], RESONANCE, f"resonance: at least {RESONANCE:g}", va="bottom", fontsize=small_text(), color=SOFT
    )
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
        say(figure, f"First resonance at {at:.0f} rad/s, {times}")
    legend_below(figure, [top])
    return figure
