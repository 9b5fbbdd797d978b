"""A folder of results, read and checked."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkages.errors import InputError
from linkages.files.toml import validate
from linkages.files.writing import file_name
from linkages.results.impacts import Impact, read_impacts
from linkages.results.shape import Summary

#: Figures with their captions, in the order of reading; the outputs' come first.
FIGURES = {
    "orbits": "Orbits of the journals' centres in their clearance circles, and magnified.",
    "links": "Deflection and largest stress of links that bend, where along them that stress is; strain energy of all.",
    "guides": "Where each block lies in its slot; beside, its ends across the slot over time.",
    "impacts": "Peak force and approach speed of every contact, at the time of its start.",
    "joint_forces": "Magnitudes of the joint forces, ideal joints beside clearance; below, their difference.",
    "drive_torques": "Torques (forces) of the drives, ideal joints beside clearance; below, their difference.",
}


@dataclass(frozen=True)
class Results:
    """What ``linkages simulate`` left in a folder.

    Attributes
    ----------
    folder : Path
    summary : dict
        ``summary.json``.
    figures : tuple of Path
        PNG files, in the order of reading.
    animation, drawing : Path or None
    impacts : tuple of Impact or None
        Every contact; None if no joint could touch.
    """

    folder: Path
    summary: dict[str, Any]
    figures: tuple[Path, ...]
    animation: Path | None
    drawing: Path | None
    impacts: tuple[Impact, ...] | None

    @property
    def experiment(self) -> dict[str, Any]:
        """The experiment as it was run: nested tables of a TOML file."""
        return {k: v for k, v in self.summary["provenance"]["experiment"].items() if k != "file"}

    @property
    def source(self) -> str:
        """Name of the experiment's file."""
        return str(self.summary["provenance"]["experiment"]["file"])

    @property
    def sources(self) -> dict[str, str]:
        """Where each value comes from, by dotted path."""
        return dict(self.summary["provenance"]["sources"])

    @property
    def title(self) -> str:
        """The experiment's title, or its file's name."""
        return self.experiment.get("title") or Path(self.source).stem

    @property
    def play(self) -> dict[str, dict[str, Any]]:
        """Joints with clearance and their models."""
        joints = self.experiment.get("joints", {})
        return {name: joint for name, joint in joints.items() if joint.get("model", "ideal") != "ideal"}


def load_results(folder: str | Path) -> Results:
    """Read a folder of results.

    Parameters
    ----------
    folder : str or Path
        The ``--out`` folder of ``linkages simulate``.

    Raises
    ------
    InputError
        If it is not a folder written by ``linkages simulate``.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(str(folder), "", "is not a folder; give the --out folder of `linkages simulate`")
    summary = _summary(folder)
    figures, impacts = _figures(folder, list(summary["outputs"])), _impacts(folder)
    animation, drawing = (
        path if path.is_file() else None for path in (folder / "animation.html", folder / "drawing.svg")
    )
    return Results(folder, summary, figures, animation, drawing, impacts)


def _summary(folder: Path) -> dict[str, Any]:
    path = folder / "summary.json"
    hint = "give the --out folder of `linkages simulate`"
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(str(folder), "summary.json", f"is not there; {hint}") from None
    except (OSError, ValueError, RecursionError) as problem:
        raise InputError(str(path), "", f"cannot be read ({problem}); {hint}") from None
    if not isinstance(summary, dict):
        raise InputError(str(path), "", f"is not a summary of `linkages simulate`; {hint}")
    validate(Summary, summary, path)
    return summary


def _figures(folder: Path, outputs: list[str]) -> tuple[Path, ...]:
    order = {stem: k for k, stem in enumerate([*(f"output_{file_name(name)}" for name in outputs), *FIGURES])}
    found = (path for path in folder.glob("*.png") if path.stem != "drawing")
    return tuple(sorted(found, key=lambda path: (order.get(path.stem, len(order)), path.name)))


def _impacts(folder: Path) -> tuple[Impact, ...] | None:
    path = folder / "impacts.csv"
    if not path.is_file():
        return None
    try:
        return tuple(read_impacts(folder))
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise InputError(str(path), "", f"is not a list of contacts written by linkages ({problem})") from None
