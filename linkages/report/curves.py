"""Curves of a run for the page that draws them: as many points as a screen shows, with every peak among them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.report.results import Results
from linkages.results.trajectory import load_trajectory

Array = NDArray[np.float64]

_PIECES = 800  # of the time; each keeps its first, least and largest value


def curves(results: Results) -> list[dict[str, Any]]:
    """Return outputs, forces in joints with play and torques of drives over time.

    Parameters
    ----------
    results : Results

    Returns
    -------
    list of dict
        For each curve `name`, `unit`, `time` [s] and `values`; none if the folder has no trajectory.

    Raises
    ------
    InputError
        If the trajectory cannot be read.
    """
    path = results.folder / "trajectory.npz"
    if not path.is_file():
        return []
    run = load_trajectory(path)
    wanted = [
        *results.summary["outputs"],
        *(f"{name}.force" for name in results.play),
        *(f"{name}.torque" for name in results.summary["drives"]),
    ]
    found = []
    for name in wanted:
        if name in run.columns and len(run.time) > 1:
            keep = seen(run.time, run[name])
            unit = run.units.get(name, "")
            found.append(
                {"name": name, "unit": unit, "time": _short(run.time[keep]), "values": _short(run[name][keep])}
            )
    return found


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
    kept = {0, len(time) - 1}
    for start, end in zip(starts, [*starts[1:], len(time)], strict=True):
        part = np.nan_to_num(values[start:end])
        kept |= {int(start), int(start + np.argmin(part)), int(start + np.argmax(part))}
    return np.array(sorted(kept))


def _short(values: Array) -> list[float | None]:
    """Return numbers with six digits, which is more than a screen shows; null for what is not finite."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
