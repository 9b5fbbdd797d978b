"""Find the mechanisms and experiments of the package, and files of packages that extend it."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from functools import cache
from importlib.metadata import entry_points
from importlib.resources import files
from itertools import chain
from pathlib import Path

from linkages.base.errors import unreadable


def data_folder() -> Path:
    """Return the folder of the shipped ``.sdf`` and ``.toml`` files."""
    packaged = Path(str(files("linkages"))) / "sdf"
    return packaged if packaged.is_dir() else Path(__file__).resolve().parents[3] / "sdf"


@cache
def _folders() -> tuple[Path, ...]:
    """Return the folders of shipped files: of this package, and of the entry points of the group ``linkages.files``."""
    others = (point.value.rpartition(".") for point in entry_points(group="linkages.files"))
    return data_folder(), *(Path(str(files(package))) / folder for package, _, folder in others)


def _shipped(path: Path) -> Iterator[Path]:
    """Yield the places where a file could be shipped: its folder, if it has one, is the end of their folders."""
    given = path.parent.parts
    return (folder / path.name for folder in _folders() if folder.parts[len(folder.parts) - len(given) :] == given)


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
    for end in ("", *suffixes):
        named = Path(f"{path}{end}")
        for place in chain([named], _shipped(named)):
            # unlike Path.is_file, False for invalid names; a name without suffix may be a folder
            if os.path.exists(place) and not (suffixes and os.path.isdir(place)):
                return place
    if os.path.exists(path):
        return path
    others = chain.from_iterable(place.parent.glob(f"*{path.suffix}") for place in _shipped(path))
    raise unreadable(path, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)), others)
