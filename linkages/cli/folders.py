"""Folders of results: one holds what one command wrote, of one run."""

from __future__ import annotations

import argparse
from pathlib import Path

from linkages.errors import InputError
from linkages.files.writing import OutputFolder

#: What stays in a folder of each command, and of reports and exports of it; by the first it is known whose it is.
_WRITTEN = {
    "simulate": (
        "summary.json", "trajectory.npz", "ideal.npz", "trajectory.csv", "trajectory.mat", "trajectory.parquet",
        "trajectory.nc", "impacts.csv", "impacts_normal.csv", "output_*.png", "orbits.png", "guides.png", "impacts.png",
        "joint_forces.png", "drive_torques.png", "animation.html", "drawing.html", "drawing.png", "drawing.svg",
        "report.html",
    ),
    "compare": ("compare.json", "warnings.json"),
    "sweep": ("sweep.json", "sweep.csv", "sweep.png"),
    "wear": ("wear.json", "wear_*.png", "wear.html", "report.html", "blocks"),
    "modes": ("modes.json", "animation.html", "*.png"),
    "bearing": ("bearing.json", "bearing_chart.png", "bearing_pressure.png"),
    "draw": ("drawing.html", "drawing.png", "drawing.svg"),
    "optimise": ("study.sqlite", "result.json", "results.csv", "convergence.png", "front.png"),
    "study sensitivity": ("sensitivity.json", "sobol.png", "one_at_a_time.png"),
}  # fmt: skip
_KEPT = {"wear": ("blocks",)}  # of an earlier run, which a new one goes on from


def add_out(parser: argparse.ArgumentParser) -> None:
    """Add ``--out`` and ``--force``."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the results; default: results/NAME")
    parser.add_argument("--force", action="store_true", help="replace what another command wrote into the folder")


def output_folder(options: argparse.Namespace, name: str, command: str) -> Path:
    """Return the folder of the results, ``results/NAME`` unless ``--out`` says otherwise.

    Raises
    ------
    InputError
        If there is a file of that name, or the results of another command are there, without ``--force``.
    """
    out: Path = options.out or Path("results") / name
    if out.exists() and not out.is_dir():
        raise InputError("--out", str(out), "is a file; give a folder")
    others = _others(out, command)
    if others and not options.force:
        problem = f"holds results of `linkages {others[0]}`; give another folder, or --force to replace them"
        raise InputError("--out", str(out), problem)
    return out


def results_folder(out: Path, command: str) -> OutputFolder:
    """Return a folder that is written whole; what was there of another run, or of other commands, is removed."""
    stale = {name for owner in (command, *_others(out, command)) for name in _WRITTEN[owner]}
    return OutputFolder(out, sorted(stale - set(_KEPT.get(command, ()))))


def _others(out: Path, command: str) -> list[str]:
    """Find the other commands whose results a folder holds; a drawing belongs to what is run of the machine."""
    return [
        owner
        for owner, (key, *_) in _WRITTEN.items()
        if owner != command and (out / key).exists() and not any(Path(key).match(own) for own in _WRITTEN[command])
    ]
