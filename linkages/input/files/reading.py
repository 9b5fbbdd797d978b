"""Complete reading of files: texts that users write, archives (``.npz``) that runs wrote."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from linkages.base.errors import InputError, unreadable

_MOST = 10_000_000  # largest file size [bytes]; typical files have thousands


def read_whole(path: Path, most: int = _MOST) -> bytes:
    """Read a file that a user wrote; InputError if it cannot be read, or is larger than `most` bytes (`/dev/zero`)."""
    try:
        with open(path, "rb") as file:
            data = file.read(most + 1)
    except OSError as problem:
        raise unreadable(path, problem) from None
    except ValueError as problem:  # a name with a null character
        raise InputError(path, "", f"cannot be read ({problem})") from None
    if len(data) > most:
        asked = "a mechanism or an experiment" if most == _MOST else "a shorter recording"
        raise InputError(path, "", f"is larger than {most // 1_000_000} MB; give {asked}")
    return data


def read_arrays(path: Path) -> dict[str, NDArray[np.generic]]:
    """Read all arrays of an archive, without pickle, and verify their checksums; ValueError for any defect."""
    try:
        with zipfile.ZipFile(path) as archive:
            return {name.removesuffix(".npy"): _read_array(archive, name) for name in archive.namelist()}
    except OSError as problem:
        raise ValueError(problem.strerror or str(problem)) from None
    except Exception as problem:  # zipfile, zlib and NumPy raise a dozen types, some of them undocumented
        raise ValueError(f"it is damaged: {str(problem) or type(problem).__name__}") from None


def _read_array(archive: zipfile.ZipFile, name: str) -> NDArray[np.generic]:
    """Read an array of an archive; ValueError if something follows it. Its checksum is verified at its end."""
    with archive.open(name) as file:
        array: NDArray[np.generic] = np.lib.format.read_array(file, allow_pickle=False)
        if file.read(1):
            raise ValueError(f"the array {name} is longer than its header says")
    return array
