"""Find the mechanisms and experiments of the package."""

from __future__ import annotations

import errno
import os
from importlib.resources import files
from pathlib import Path

from linkages.base.errors import unreadable


def data_folder() -> Path:
    """Return the folder of the shipped ``.sdf`` and ``.toml`` files."""
    packaged = Path(str(files("linkages"))) / "sdf"
    return packaged if packaged.is_dir() else Path(__file__).resolve().parents[3] / "sdf"


def find_file(name: str | Path, *suffixes: str) -> Path:
    """Return the given file if it exists, otherwise the shipped file with this name.

    Parameters
    ----------
    name : str or Path
    *suffixes : str
        Optional suffixes of names, such as ".toml"; the first that gives an existing file is used.

    Raises
    ------
    InputError
        If neither exists; the message names the most similar existing file.

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
            # unlike Path.is_file, False for invalid names; a name without suffix may be a folder
            if os.path.exists(place) and not (suffixes and os.path.isdir(place)):
                return Path(place)
    if os.path.exists(path):
        return path
    others = data_folder().glob(f"*{path.suffix}") if bare else ()
    raise unreadable(path, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)), others)
