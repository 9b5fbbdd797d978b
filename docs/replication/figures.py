"""The sources' figures, drawn from our runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.show.plots.style import COLORS

Columns = dict[str, NDArray[np.float64]]

#: Line styles tell the designs apart without colours.
STYLES = {
    "nominal": {"color": "#000000", "linestyle": "-"},
    "paper 1": {"color": COLORS[1], "linestyle": "--"},
    "paper 2": {"color": COLORS[0], "linestyle": "-."},
    "ours": {"color": COLORS[2], "linestyle": ":"},
}
_RC = {"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 150, "lines.linewidth": 1.2}
_SETTLED = 0.01  # s: before it the journals leave the centre, and differences hide all others
_MOTION = (
    ("slider7.x", 1e3, "displacement [mm]", "mm"),
    ("slider7.vx", 1.0, "velocity [m/s]", "mm/s"),
    ("slider7.ax", 1.0, "acceleration [m/s²]", "mm/s²"),
)


@contextmanager
def _figure(path: Path, size: tuple[float, float], *grid: int, **shared: bool) -> Iterator[tuple[Figure, Any]]:
    """Give an empty figure and its axes, and write it at the end."""
    with mpl.rc_context(_RC):
        figure = Figure(figsize=size, layout="constrained")
        yield figure, figure.subplots(*grid, **shared)
        figure.savefig(path, format="png")


def write_motion(designs: Mapping[str, Columns], path: Path) -> None:
    """Draw the slider's motion (the paper's figures 6-8) and how far each design is from the nominal one.

    Parameters
    ----------
    designs : mapping of columns
        At the same times, by name; "nominal" is among them.
    """
    with _figure(path, (7.5, 6.5), 3, 2, sharex=True) as (_, axes):
        for (left, right), (name, scale, label, unit) in zip(axes, _MOTION, strict=True):
            for key, columns in designs.items():
                left.plot(columns["time"], scale * columns[name], label=key, **STYLES[key])
                if key != "nominal":
                    later = columns["time"] > _SETTLED
                    apart = 1e3 * (columns[name] - designs["nominal"][name])[later]
                    right.plot(columns["time"][later], apart, label=key, **STYLES[key])
            left.set_ylabel(label)
            right.set_ylabel(f"minus nominal [{unit}]")
        axes[0, 0].legend(frameon=False)
        for ax in axes[-1]:
            ax.set_xlabel("time [s]")


def write_orbits(designs: Mapping[str, Columns], clearance: float, path: Path) -> None:
    """Draw the journals' paths in joints A and B (figure 9), within the circle where they touch, and enlarged; `clearance` [m]."""
    turn, c = np.linspace(0.0, 2.0 * np.pi, 361), 1e6 * clearance
    with _figure(path, (7.5, 7.6), 2, 2) as (figure, axes):
        for column, joint in zip(axes.T, "AB", strict=True):
            largest = 0.0
            for key, columns in designs.items():
                x, y = 1e6 * columns[f"{joint}.ex"], 1e6 * columns[f"{joint}.ey"]
                largest = max(largest, 1.1 * float(np.hypot(x, y).max()))
                for ax in column:
                    ax.plot(x, y, label=key, **STYLES[key])
            column[0].plot(c * np.cos(turn), c * np.sin(turn), color="0.5", linewidth=2.0, label="contact")
            for ax, half, title in zip(column, (1.05 * c, largest), (f"joint {joint}", "enlarged"), strict=True):
                ax.set(title=title, aspect="equal", xlim=(-half, half), ylim=(-half, half))
                ax.set(xlabel="$e_x$ [µm]", ylabel="$e_y$ [µm]")
        names = axes[0, 0].get_legend_handles_labels()
        figure.legend(*names, loc="outside lower center", ncols=5, frameon=False)


def write_forces(designs: Mapping[str, Columns], path: Path) -> None:
    """Draw the forces in joints A and B (figure 10)."""
    with _figure(path, (6.5, 5.0), 2, 1, sharex=True) as (_, axes):
        for ax, joint in zip(axes, "AB", strict=True):
            for key, columns in designs.items():
                ax.plot(columns["time"], columns[f"{joint}.force"], label=key, **STYLES[key])
            ax.set_ylabel(f"force in joint {joint} [N]")
        axes[0].legend(frameon=False, ncols=4)
        axes[1].set_xlabel("time [s]")


def write_jitter(before: tuple[Columns, Columns], after: tuple[Columns, Columns], path: Path) -> None:
    """Draw the follower's acceleration before and after the optimisation (the patent's figure 4).

    Parameters
    ----------
    before, after : pairs of columns
        With clearance, and ideal, at the same times.
    """
    looks = (("with clearance", {"color": COLORS[1], "linewidth": 0.7}), ("ideal", {"color": "#000000"}))
    with _figure(path, (6.5, 5.0), 2, 1, sharex=True, sharey=True) as (_, axes):
        for ax, motions, title in zip(axes, (before, after), ("before", "after"), strict=True):
            for columns, (label, look) in zip(motions, looks, strict=True):
                ax.plot(columns["time"], 1e-3 * columns["follower.alpha"], label=label, **look)
            ax.set(title=title, ylabel="angular acceleration\nof the follower [10³ rad/s²]")
        axes[0].legend(frameon=False, loc="upper right", ncols=2)
        axes[1].set_xlabel("time [s]")


def write_rig(run: Columns, perfect: Columns, printed: Mapping[str, float], path: Path) -> None:
    """Draw the slider's acceleration on the rig (figure 5), with the largest printed values by name [m/s2]."""
    with _figure(path, (6.5, 3.4), 1, 1) as (_, ax):
        ax.plot(run["time"], run["slider7.ax"], label="with clearance", color=COLORS[1])
        ax.plot(perfect["time"], perfect["slider7.ax"], label="ideal", color="#000000", linestyle="--")
        for (name, value), style in zip(printed.items(), (":", "-."), strict=True):
            ax.axhline(value, color=COLORS[0], linestyle=style, label=f"printed: largest {name}, {value:+g}")
        ax.set(
            xlabel="time [s]",
            ylabel="acceleration [m/s²]",
            ylim=(1.1 * min(printed.values()), 1.5 * max(printed.values())),
        )
        ax.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 0.1), fontsize=8)


def write_spike(plain: Columns, patched: Mapping[str, Columns], printed: Mapping[str, float], path: Path) -> None:
    """Draw the acceleration at the start with eqs. (12)-(13) for each design, without them for the nominal one (figure 8).

    Parameters
    ----------
    plain : columns
    patched : mapping of columns
    printed : mapping of float
        Printed sizes at the start by design [m/s2].
    path : Path
    """
    with _figure(path, (7.5, 3.8), 1, 2) as (_, (whole, start)):
        for ax, end, scale in ((whole, np.inf, 1.0), (start, 1e-4, 1e6)):
            for key, columns in {"without (12)-(13)": plain, **patched}.items():
                part = columns["time"] <= end
                look = STYLES.get(key, {"color": "0.6", "linewidth": 2.5})
                ax.plot(scale * columns["time"][part], columns["slider7.ax"][part], label=key, **look)
            ax.set_xlabel("time [s]" if scale == 1.0 else "time [µs]")
        for key, value in printed.items():
            start.axhline(-value, color=STYLES[key]["color"], linewidth=0.6, linestyle=STYLES[key]["linestyle"])
        whole.set_ylabel("acceleration [m/s²]")
        start.set_title("start; thin: printed sizes", fontsize=9)
        whole.legend(frameon=False, fontsize=8)


def write_generations(searches: Mapping[str, tuple[str, Mapping[str, Any]]], path: Path) -> None:
    """Draw the best and the mean objective of each generation; searches are a label with its unit, and the generations, by title."""
    with _figure(path, (7.5, 3.0), 1, len(searches)) as (_, axes):
        for ax, (title, (label, found)) in zip(axes, searches.items(), strict=True):
            for key, look in (("mean", {"color": COLORS[1], "linestyle": "--"}), ("best", {"color": COLORS[0]})):
                ax.plot(np.arange(1, 1 + len(found[key])), found[key], label=key, **look)
            ax.set_title(title, fontsize=9)
            ax.set(xlabel="generation", ylabel=label)
        axes[0].legend(frameon=False)


def write_scan(
    speeds: NDArray[np.float64],
    shades: NDArray[np.float64],
    near: Mapping[str, NDArray[np.float64]],
    chosen: NDArray[np.float64],
    limits: tuple[float, float, float],
    path: Path,
) -> None:
    """Draw the deviation from the printed forces over both speeds, and the commensurate pairs against both criteria.

    Parameters
    ----------
    speeds : (n,) array
        Of either crank [rad/s].
    shades : (n, n) array
        Deviation with gravity along -y, rows omega_4; infinite where the linkage does not close.
    near : mapping of (m, 5) arrays
        Rows of `press_ideal.scan` by gravity; the first is -y.
    chosen : (k, 5) array
        Rows that meet both criteria.
    limits : tuple of float
        Largest deviation of the forces, printed acceleration [m/s2], and its largest deviation.
    path : Path
    """
    with _figure(path, (8.0, 3.9), 1, 2) as (figure, (left, right)):
        shown = np.where(np.isfinite(shades), 100.0 * shades, np.nan)
        image = left.pcolormesh(speeds, speeds, shown, cmap="viridis_r", vmin=0.0, vmax=60.0, shading="nearest")
        figure.colorbar(image, ax=left, label="deviation of six forces [%]", shrink=0.8)
        left.plot(*next(iter(near.values())).T[:2], ".", color="white", markersize=2)
        left.plot(*chosen.T[:2], "o", color="#D55E00", markersize=4)
        left.set(aspect="equal", xlabel="ω₁ [rad/s]", ylabel="ω₄ [rad/s]", title="gravity along -y")
        left.grid(visible=False)
        forces, printed, ratio = limits
        looks = zip("o^s", (COLORS[0], COLORS[2], COLORS[3]), strict=True)
        for (name, rows), (marker, color) in zip(near.items(), looks, strict=True):
            largest = np.abs(rows[:, 3:]).max(axis=1)
            right.plot(
                100.0 * rows[:, 2], largest, marker, markersize=3, alpha=0.5, label=f"gravity {name}", color=color
            )
        largest = np.abs(chosen[:, 3:]).max(axis=1)
        right.plot(100.0 * chosen[:, 2], largest, "o", color="#D55E00", markersize=4, label="meets both criteria")
        right.axhspan((1.0 - ratio) * printed, (1.0 + ratio) * printed, color="#D55E00", alpha=0.15)
        right.axhline(printed, color="#D55E00", linewidth=0.8)
        right.set(
            yscale="log",
            xlim=(0.0, 100.0 * forces),
            xlabel="deviation of six forces [%]",
            ylabel="slider's largest acceleration\nover a period [m/s²]",
        )
        right.legend(frameon=False, fontsize=8, ncols=2, loc="lower center", bbox_to_anchor=(0.4, 1.0))


def write_profiles(
    profiles: Mapping[str, Any], best: Mapping[str, float], labels: Mapping[str, str], path: Path
) -> None:
    """Draw the least deviation of all printed numbers with one unknown held, the others fitted anew; labels by unknown."""
    with _figure(path, (7.0, 4.6), 2, 2, sharey=True) as (_, axes):
        for ax, (name, label) in zip(axes.flat, labels.items(), strict=True):
            found = profiles[name]
            ax.plot(found["values"], 100.0 * np.array(found["mismatch"]), "o-", color=COLORS[0], markersize=3)
            ax.axvline(best[name], color="#D55E00", linewidth=0.8)
            ax.set(xlabel=label, ylim=(0.0, 32.0), xscale="log" if name == "eps_0" else "linear")
        for ax in axes[:, 0]:
            ax.set_ylabel("deviation of ten numbers [%]")


def write_ten(
    names: Sequence[str], printed: NDArray[np.float64], ours: Mapping[str, NDArray[np.float64]], path: Path
) -> None:
    """Draw the ratio of our values to ten printed numbers, by conditions; the band is 5 %, numbers beyond the axis are written."""
    low, high = 0.85, 1.15
    with _figure(path, (7.5, 3.2), 1, 1) as (_, ax):
        ax.axhspan(0.95, 1.05, color="0.85")
        places = np.arange(len(names))
        for (label, values), marker, color in zip(ours.items(), "o^s", COLORS, strict=False):
            ratio = values / printed
            ax.plot(places, np.clip(ratio, low, high - 0.01), marker, color=color, label=label)
            for place in np.flatnonzero(ratio > high):
                ax.annotate(
                    f"{ratio[place]:.1f}",
                    (place, high - 0.01),
                    (-8, -3),
                    textcoords="offset points",
                    ha="right",
                    color=color,
                )
        ax.set(ylabel="ours over printed", ylim=(low, high))
        ax.set_xticks(places, names)
        ax.legend(frameon=False, fontsize=8, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def write_robot(
    times: NDArray[np.float64], modes: NDArray[np.float64], ratios: Mapping[str, float], path: Path
) -> None:
    """Draw the lowest natural frequencies over the revolution (figure 9), and printed over our numbers by name."""
    with _figure(path, (8.0, 3.4), 1, 2) as (_, (left, right)):
        for k, frequencies in enumerate(modes.T):
            left.plot(times, frequencies, color=COLORS[k % len(COLORS)])
        left.set(xlabel="time [s]", ylabel="natural frequency [Hz]", ylim=(0.0, None))
        right.barh(list(ratios)[::-1], list(ratios.values())[::-1], color=COLORS[0])
        right.axvline(1.0, color="#000000", linewidth=0.8)
        right.set(xscale="log", xlabel="printed over ours")
