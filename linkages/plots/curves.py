"""Curves of a run for pages that draw them: as many points as a screen shows, with every peak among them."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.arrays import Array
from linkages.files.writing import json_text
from linkages.results.trajectory import Trajectory

_PIECES = 800  # of the time; each keeps its first, least and largest value


def columns(outputs: Iterable[str], play: Iterable[str], drives: Iterable[str]) -> list[str]:
    """Name what is looked at first: outputs, forces in joints with play, torques of drives."""
    return [*outputs, *(f"{name}.force" for name in play), *(f"{name}.torque" for name in drives)]


def curves(
    names: Iterable[str], run: Trajectory, ideal: Trajectory | None, pieces: int = _PIECES
) -> list[dict[str, Any]]:
    """Return columns over time for `curves.js`.

    Parameters
    ----------
    names : iterable of str
        Those that the run does not have are left out.
    run : Trajectory
    ideal : Trajectory or None
        The same with ideal joints.
    pieces : int
        See `seen`.

    Returns
    -------
    list of dict
        For each curve `name`, `unit`, and `run` and `ideal`, each with `time` [s] and `values`, `ideal` None where
        there is none. None at all for a run of a single sample.
    """
    if len(run.time) < 2:
        return []
    return [
        {"name": name, "unit": run.units.get(name, ""), "run": _drawn(run, name, pieces)}
        | {"ideal": _drawn(ideal, name, pieces)}
        for name in names
        if name in run.columns
    ]


def script() -> str:
    """Return the function `drawCurves` of the pages, as JavaScript."""
    return (files("linkages.plots") / "curves.js").read_text(encoding="utf-8")


def embedded(content: Any) -> str:
    """Write JSON that nothing in it can end before its time where it stands in a page."""
    return json_text(content).strip().replace("<", "\\u003c")


def seen(time: Array, values: Array, pieces: int = _PIECES) -> NDArray[np.int64]:
    """Choose samples (k,) that draw the same curve: of each piece of time the first, the least and the largest.

    Parameters
    ----------
    time, values : (n,) arrays
    pieces : int
        Of equal length.
    """
    piece = np.searchsorted(np.linspace(time[0], time[-1], pieces + 1)[1:-1], time, side="right")
    starts = np.flatnonzero(np.diff(piece, prepend=-1))
    by_value = np.lexsort((np.nan_to_num(values), piece))  # within each piece of time from the least to the largest
    ends = np.append(starts[1:], len(time)) - 1
    return np.unique(np.concatenate([[0, len(time) - 1], starts, by_value[starts], by_value[ends]]))


def _drawn(run: Trajectory | None, name: str, pieces: int) -> dict[str, list[float | None]] | None:
    if run is None or name not in run.columns:
        return None
    keep = seen(run.time, run[name], pieces)
    return {"time": _short(run.time[keep]), "values": _short(run[name][keep])}


def _short(values: Array) -> list[float | None]:
    """Return numbers with six digits, which is more than a screen shows; null for what is not finite."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
