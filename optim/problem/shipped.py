"""The studies that come with the package."""

from __future__ import annotations

import os
from pathlib import Path

from linkages import find_file


def studies_folder() -> Path:
    """Folder of the shipped studies."""
    return Path(__file__).resolve().parents[1] / "studies"


def find_study(name: str | Path) -> Path:
    """Return the file as given if it exists, else a shipped study of that name, else the path as given.

    Examples
    --------
    >>> import optim
    >>> optim.find_study("sevenbar_force").name
    'sevenbar_force.toml'
    """
    path = Path(name)
    shipped = studies_folder() / f"{path.stem}.toml"
    bare = path.parent in (Path(), Path("optim/studies"))
    return shipped if bare and not path.exists() and shipped.exists() else path


def find_experiment(name: str, study: Path) -> Path:
    """Return the experiment of a study: in the same folder, else a shipped one."""
    beside = study.parent / name
    return beside if os.path.exists(beside) else find_file(name)
