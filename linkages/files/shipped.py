"""Finds the machines and experiments that come with the package."""

from __future__ import annotations

import errno
import os
from importlib.resources import files
from pathlib import Path

from linkages.errors import unreadable


def data_folder() -> Path:
    """Folder of the shipped ``.sdf`` and ``.toml`` files."""
    packaged = Path(str(files("linkages"))) / "sdf"
    return packaged if packaged.is_dir() else Path(__file__).resolve().parents[2] / "sdf"


def find_file(name: str | Path, *suffixes: str) -> Path:
    """Return the file as given if it exists, else a shipped file of that name.

    Parameters
    ----------
    name : str or Path
    *suffixes : str
        Ends of names, such as ".toml", that may be left out; the first that leads to a file counts.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If there is neither; it names the nearest of the files that are there.

    Examples
    --------
    >>> import linkages
    >>> linkages.find_file("seven_bar.toml").name
    'seven_bar.toml'
    """
    path = Path(name)
    bare = path.parent in (Path(), Path("sdf"))
    for end in ("", *suffixes):
        for place in (f"{path}{end}", data_folder() / f"{path.name}{end}")[: 1 + bare]:
            # unlike Path's, false for names that no file can have; without its suffix a name may be a folder's
            if os.path.exists(place) and not (suffixes and os.path.isdir(place)):
                return Path(place)
    if os.path.exists(path):
        return path
    others = data_folder().glob(f"*{path.suffix}") if bare else ()
    raise unreadable(path, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)), others)
