"""A folder of results, read and checked."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from linkages.base.errors import InputError
from linkages.input.files.magnitudes import SMALLEST
from linkages.input.files.toml import Table, validate
from linkages.input.files.writing import file_name
from linkages.input.model.experiment import experiment_of
from linkages.input.model.experiment_tables import JointModel
from linkages.input.model.mechanism import load_mechanism
from linkages.results.impacts import Impact, read_impacts
from linkages.results.shape import SummaryFile
from linkages.system import System

#: Figures with their captions, in the order of the page, after the outputs'.
FIGURES = {
    "measured": "Measured curves and the run; below: measured less computed.",
    "orbits": "Orbits of the journals' centres in their clearance circles, and magnified.",
    "links": "Deflection, largest stress and its place for each flexible link; strain energy of all.",
    "guides": "Position of each block in its slot; right: its ends across the slot over time.",
    "impacts": "Peak force and approach speed of every contact, at the time of its start.",
    "joint_forces": "Magnitudes of the joint forces, ideal joints and clearance; below: their difference.",
    "drive_torques": "Torques (forces) of the drives, ideal joints and clearance; below: their difference.",
}
#: Endings of figures that a page can contain, and their media types.
PICTURES = {".png": "image/png", ".svg": "image/svg+xml"}
_HINT = "give the --out folder of a command"


@dataclass(frozen=True)
class Results:
    """The files of ``linkages simulate`` in a folder."""

    folder: Path
    summary: dict[str, Any]  # ``summary.json``
    figures: tuple[Path, ...]  # PNG and SVG files, in the order of the page
    animation: str | None  # the page of the animation
    drawing: Path | None
    impacts: tuple[Impact, ...] | None  # all contacts; None if no joint can touch

    @property
    def experiment(self) -> dict[str, Any]:
        """Return the experiment of the run, with overrides: nested tables of a TOML file."""
        return {k: v for k, v in self.summary["provenance"]["experiment"].items() if k != "file"}

    @property
    def source(self) -> str:
        """Return the name of the experiment's file."""
        return str(self.summary["provenance"]["experiment"]["file"])

    @property
    def sources(self) -> dict[str, str]:
        """Return the source of each value by dotted path."""
        return dict(self.summary["provenance"]["sources"])

    def source_of(self, path: str) -> str:
        """Return the source of the value at a dotted path, or of the table that it came with; empty if unknown."""
        sources = self.sources
        while path and path not in sources:
            path = path.rpartition(".")[0]
        return sources.get(path, "")

    @property
    def title(self) -> str:
        """Return the experiment's title, or its file's name."""
        return self.experiment.get("title") or Path(self.source).stem

    @property
    def play(self) -> dict[str, dict[str, Any]]:
        """Return the clearance joints and their models."""
        joints = self.experiment.get("joints", {})
        return {
            name: joint | {"clearance": JointModel.model_validate(joint).clearance}  # which a fit may give
            for name, joint in joints.items()
            if joint.get("model", "ideal") != "ideal"
        }


def load_results(folder: str | Path) -> Results:
    """Read the ``--out`` folder of ``linkages simulate``; InputError for other folders."""
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(str(folder), "", f"is not a folder; {_HINT}")
    if not (folder / "summary.json").exists():
        raise InputError(str(folder), "summary.json", f"is missing; {_HINT}")
    summary = read_json(folder / "summary.json", SummaryFile, _HINT)
    first = [*(f"output_{file_name(name)}" for name in summary["outputs"]), *FIGURES]
    order = {stem: k for k, stem in enumerate(first)}
    found = (path for path in folder.iterdir() if path.suffix in PICTURES and path.stem != "drawing")
    figures = tuple(sorted(found, key=lambda path: (order.get(path.stem, len(order)), path.name)))
    drawing, impacts = folder / "drawing.svg", _impacts(folder)
    animation = read_page(folder / "animation.html")
    return Results(folder, summary, figures, animation, drawing if drawing.is_file() else None, impacts)


def recorded_system(results: Results) -> System:
    """Build the system of a run again from its record; InputError if its files are missing."""
    path = Path(results.summary["provenance"].get("folder") or ".", results.source)
    if not path.exists():
        problem = f"is missing; the run of {results.folder} cannot be repeated without it"
        raise InputError(str(path), "", problem)
    experiment = experiment_of(path, results.experiment, results.sources)
    return System(load_mechanism(experiment.mechanism_path, experiment.sdf_overrides), experiment)


def read_json(path: Path, shape: type[Table], hint: str) -> dict[str, Any]:
    """Read a JSON file and check it against a schema; InputError with a hint if it is not a JSON object.

    Runs compute numbers below the smallest plausible one, such as 1e-53: they are zero.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"), parse_float=_of_plausible_size)
        json.dumps(content, ensure_ascii=False).encode()  # lone surrogates cannot be written into a page
    except (OSError, ValueError, RecursionError) as problem:
        raise InputError(str(path), "", f"cannot be read ({problem}); {hint}") from None
    if not isinstance(content, dict):
        raise InputError(str(path), "", f"is not a JSON object; {hint}")
    validate(shape, content, path)
    return content


def _of_plausible_size(text: str) -> float:
    value = float(text)
    return value if abs(value) >= SMALLEST else 0.0


def read_page(path: Path) -> str | None:
    """Read a page to embed; None if the file is missing, InputError if it cannot be read or ends early."""
    try:
        page = path.read_text(encoding="utf-8") if path.is_file() else None
    except (OSError, ValueError) as problem:
        raise InputError(str(path), "", f"cannot be read ({problem}); remove it, or write it again") from None
    if page is not None and not page.rstrip().endswith("</html>"):
        raise InputError(str(path), "", "ends before </html>, so a part is missing; remove it, or write it again")
    return page


def _impacts(folder: Path) -> tuple[Impact, ...] | None:
    path = folder / "impacts.csv"
    if not path.is_file():
        return None
    try:
        return tuple(read_impacts(folder))
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as problem:
        raise InputError(str(path), "", f"is not a list of contacts written by linkages ({problem})") from None
