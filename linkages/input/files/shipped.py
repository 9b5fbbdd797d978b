"""Find the mechanisms, experiments and studies of the package."""

from __future__ import annotations

import errno
import os
from importlib.resources import files
from itertools import chain
from pathlib import Path

from linkages.base.errors import unreadable


def data_folder() -> Path:
    """Return the folder of the shipped ``.sdf`` and ``.toml`` files."""
    packaged = Path(str(files("linkages"))) / "sdf"
    return packaged if packaged.is_dir() else Path(__file__).resolve().parents[3] / "sdf"


def studies_folder() -> Path:
    """Return the folder of the shipped studies, beside this package."""
    return Path(__file__).resolve().parents[3] / "optim" / "studies"


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
    folders = (data_folder(), studies_folder()) if path.parent in (Path(), Path("sdf"), Path("optim/studies")) else ()
    for end in ("", *suffixes):
        for place in (Path(f"{path}{end}"), *(folder / f"{path.name}{end}" for folder in folders)):
            # unlike Path.is_file, False for invalid names; a name without suffix may be a folder
            if os.path.exists(place) and not (suffixes and os.path.isdir(place)):
                return place
    if os.path.exists(path):
        return path
    others = chain.from_iterable(folder.glob(f"*{path.suffix}") for folder in folders)
    raise unreadable(path, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)), others)
