"""Folders of results: each has the files of one command and one run."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from linkages.base.errors import InputError
from linkages.input.files.writing import OutputFolder

#: Files of each command, its reports and exports; the first one identifies the command.
_WRITTEN = {
    "simulate": (
        "summary.json", "trajectory.npz", "ideal.npz", "trajectory.csv", "trajectory.mat", "trajectory.parquet",
        "trajectory.nc", "impacts.csv", "impacts_normal.csv", "output_*.png", "orbits.png", "guides.png", "impacts.png",
        "joint_forces.png", "drive_torques.png", "animation.html", "drawing.html", "drawing.png", "drawing.svg",
        "report.html",
    ),
    "compare": ("compare.json", "warnings.json"),
    "sweep": ("sweep.json", "sweep.csv", "sweep.png"),
    "continue": ("branches.json", "branches.png"),
    "wear": ("wear.json", "wear_*.png", "wear.html", "report.html", "blocks"),
    "modes": ("modes.json", "animation.html", "*.png"),
    "linearise": ("linear.json", "linear.npz", "bode.png"),
    "bearing": ("bearing.json", "bearing_chart.png", "bearing_pressure.png"),
    "draw": ("drawing.html", "drawing.png", "drawing.svg"),
    "optimise": ("study.sqlite", "result.json", "results.csv", "convergence.png", "front.png"),
    "sensitivity": ("sensitivity.json", "details.json", "tornado.png"),
    "study sensitivity": ("sensitivity.json", "sobol.png", "one_at_a_time.png"),
}  # fmt: skip
_KEPT = {"wear": ("blocks",)}  # kept from an earlier run, which a new one continues


def add_out(parser: argparse.ArgumentParser) -> None:
    """Add ``--out`` and ``--force``."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the results; default: results/NAME")
    parser.add_argument("--force", action="store_true", help="replace another command's files in the folder")


def output_folder(options: argparse.Namespace, name: str, command: str) -> OutputFolder:
    """Return the folder of the results, ``results/NAME`` unless ``--out`` is given; it is written atomically.

    Files of another run, or with ``--force`` of other commands, are removed then. InputError if it is a file, cannot be
    made or written, or (without ``--force``) has results of another command.
    """
    out = possible_folder(options.out or Path("results") / name)
    others = [
        owner
        for owner, (key, *_) in _WRITTEN.items()  # drawings are compatible with all runs
        if owner != command and (out / key).exists() and not any(Path(key).match(own) for own in _WRITTEN[command])
    ]
    if others and not options.force:
        problem = f"holds results of `linkages {others[0]}`; give another folder, or --force to replace them"
        raise InputError("--out", str(out), problem)
    stale = {name for owner in (command, *others) for name in _WRITTEN[owner]}
    return OutputFolder(out, sorted(stale - set(_KEPT.get(command, ()))))


def possible_folder(out: Path) -> Path:
    """Return a folder that exists or can be made; InputError if it is a file, or cannot be made or written."""
    place = next(place for place in (out, *out.absolute().parents) if place.exists())
    if not place.is_dir():
        raise InputError("--out", str(out), "is a file; give a folder" if place == out else f"{place.name} is a file")
    if not os.access(place, os.W_OK | os.X_OK):
        raise InputError("--out", str(out), "cannot be written; give another folder")
    return out
