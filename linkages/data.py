"""Finds the machines and experiments that come with the package."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path


def data_folder() -> Path:
    """Folder of the shipped ``.sdf`` and ``.toml`` files."""
    packaged = Path(str(files("linkages"))) / "sdf"
    return packaged if packaged.is_dir() else Path(__file__).resolve().parents[1] / "sdf"


def find_file(name: str | Path) -> Path:
    """Return the file as given if it exists, else a shipped file of that name, else the path as given."""
    path = Path(name)
    shipped = data_folder() / path.name
    bare = path.parent in (Path(), Path("sdf"))
    return shipped if bare and not path.exists() and shipped.exists() else path
