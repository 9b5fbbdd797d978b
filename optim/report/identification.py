"""Figures of an identification: measured and computed samples, residuals, correlations, profiles, progress."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.ticker import MaxNLocator

from linkages.base.palette import IDEAL, INK, MEASURED
from linkages.show.plots.style import COLORS, axis_label, typeset
from optim.identify.result import IdentificationResult
from optim.report.figures import png


def write_identification(found: IdentificationResult, folder: Path, form: str = "png") -> None:
    """Write figures: ``fit``, ``correlation``, ``windows`` and, if they are known, ``profiles`` and ``posterior``.

    Parameters
    ----------
    found : IdentificationResult
        From `optim.identify`.
    folder : Path
    form : str
        Format of the files.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> found = optim.identify(optim.load_identification("slider_crank_fit"))
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> optim.write_identification(found, folder)
    >>> sorted(file.name for file in folder.iterdir())
    ['correlation.png', 'fit.png']
    """
    if found["curves"]:
        _write_fit(found, folder / f"fit.{form}")
    _write_correlation(found, folder / f"correlation.{form}")
    if len(found["history"]) > 1:
        _write_windows(found, folder / f"windows.{form}")
    if any("profile" in one for one in found["parameters"].values()):
        _write_profiles(found, folder / f"profiles.{form}")
    if "posterior" in found:
        _write_posterior(found, folder / f"posterior.{form}")


def _write_fit(found: IdentificationResult, path: Path) -> None:
    curves = found["curves"]
    with png(path, 8.0, 2.2 * len(curves) + 0.6) as figure:
        axes = np.atleast_2d(figure.subplots(len(curves), 2, squeeze=False, gridspec_kw={"width_ratios": (3, 2)}))
        for (left, right), (name, curve) in zip(axes, curves.items(), strict=True):
            time, measured, computed = (np.array(curve[key]) for key in ("time", "measured", "computed"))
            left.plot(time, measured, ".", color=MEASURED, markersize=2.0, label="measured")
            left.plot(time, computed, color=COLORS[0], linewidth=1.0, label="computed")
            left.set_ylabel(axis_label(name, typeset(curve["unit"])))
            right.plot(time, measured - computed, ".", color=INK, markersize=2.0)
            right.axhline(0.0, color="0.5", linewidth=0.6)
            right.set_ylabel(axis_label("residual", typeset(curve["unit"])))
        axes[0, 0].legend()
        for ax in axes[-1]:
            ax.set_xlabel("time of the file [s]")


def _write_correlation(found: IdentificationResult, path: Path) -> None:
    names = found["correlation"]["names"]
    matrix = np.array([[np.nan if x is None else x for x in row] for row in found["correlation"]["matrix"]])
    size = 2.2 + 0.55 * len(names)
    with png(path, size + 0.6, size) as figure:
        ax = figure.subplots()
        image = ax.imshow(matrix, vmin=-1.0, vmax=1.0, cmap="RdBu_r")
        ax.set_xticks(range(len(names)), names, rotation=45, ha="right")
        ax.set_yticks(range(len(names)), names)
        for (i, k), value in np.ndenumerate(matrix):
            text = "-" if np.isnan(value) else f"{value:.2f}"
            ax.text(k, i, text, ha="center", va="center", color="white" if abs(value) > 0.6 else "black")
        ax.grid(False)
        ax.set_title("correlation of the values")
        figure.colorbar(image, ax=ax)


def _write_windows(found: IdentificationResult, path: Path) -> None:
    runs, ends, mean = np.array(found["history"]).T
    with png(path, 5.0, 3.2) as figure:
        ax = figure.subplots()
        ax.plot(ends, mean, "o-", color=COLORS[0])
        ax.set_xscale("log")
        ax.set_xlabel("end of the window [s]")
        ax.set_ylabel("chi-square of a sample")
        for x, y, count in zip(ends, mean, runs, strict=True):
            ax.annotate(f"{count:.0f} runs", (x, y), textcoords="offset points", xytext=(3, 5), fontsize=7)


def _write_profiles(found: IdentificationResult, path: Path) -> None:
    shown = {name: one for name, one in found["parameters"].items() if "profile" in one}
    with png(path, 3.2 * len(shown), 3.0) as figure:
        for ax, (name, one) in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown.items(), strict=True):
            points = np.array(one["profile"])
            ax.plot(points[:, 0], points[:, 1], "o", color=COLORS[0], label="profile")
            if one["deviation"]:
                values = np.linspace(points[0, 0], points[-1, 0], 100)
                ax.plot(
                    values,
                    ((values - one["value"]) / one["deviation"]) ** 2,
                    color=IDEAL,
                    linewidth=3.0,
                    zorder=1,
                    label="linear",
                )
            ax.axhline(3.84, color="0.5", linestyle="--", label="95 %")
            ax.xaxis.set_major_locator(MaxNLocator(4))
            ax.ticklabel_format(axis="x", scilimits=(-2, 3))
            ax.set_xlabel(f"{name} [{one['unit'] or '1'}]", loc="left")
            ax.set_ylabel("rise of chi-square")
            ax.legend()


def _write_posterior(found: IdentificationResult, path: Path) -> None:
    """Draw the samples of each pair of unknowns, and histograms, with the values and intervals of the fit."""
    samples, n = np.array(found["posterior"]["samples"]), len(found["parameters"])
    with png(path, 1.9 * n + 0.8, 1.7 * n + 0.8) as figure:
        axes = figure.subplots(n, n, squeeze=False, sharex="col")
        for (i, k), ax in np.ndenumerate(axes):
            if k > i:
                ax.set_axis_off()
                continue
            name, one = list(found["parameters"].items())[k]
            if k == i:
                ax.hist(samples[:, k], 30, color=COLORS[0], alpha=0.6)
                ax.set_yticks([])
                ax.set_title(name)
                for x in one["interval"] or ():
                    ax.axvline(x, color="0.4", linestyle="--", linewidth=0.8)
            else:
                ax.plot(samples[:, k], samples[:, i], ".", color=COLORS[0], markersize=1.5, alpha=0.4)
                ax.axhline(list(found["parameters"].values())[i]["value"], color=INK, linewidth=0.8)
            ax.axvline(one["value"], color=INK, linewidth=0.8)
            ax.ticklabel_format(scilimits=(-2, 3))
            if i == n - 1:
                ax.set_xlabel(f"{name} [{one['unit'] or '1'}]", loc="left")  # beside the power of ten
            if k == 0 and i > 0:
                below, other = list(found["parameters"].items())[i]
                ax.set_ylabel(f"{below} [{other['unit'] or '1'}]")
