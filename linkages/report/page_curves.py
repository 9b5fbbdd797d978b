"""Curves of a folder of results."""

from __future__ import annotations

from typing import Any

from linkages.plots.curves import columns, curves
from linkages.report.result_folder import Results
from linkages.results.trajectory import load_trajectory


def curves_of(results: Results) -> list[dict[str, Any]]:
    """Return outputs, forces in clearance joints and drive torques over time, real and ideal.

    None if the folder has no trajectory; InputError if it cannot be read.
    """
    files = (results.folder / name for name in ("trajectory.npz", "ideal.npz"))
    run, ideal = (load_trajectory(path) if path.is_file() else None for path in files)
    names = columns(results.summary["outputs"], results.play, results.summary["drives"])
    errors = {name: results.summary["error"].get(f"{name}.peak") or 0.0 for name in names}
    return [] if run is None else curves(names, run, ideal, errors)
