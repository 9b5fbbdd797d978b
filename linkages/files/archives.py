"""NumPy archives (``.npz``), read safely: any defect of a file raises one error."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def read_arrays(path: Path) -> dict[str, NDArray[np.generic]]:
    """Read all arrays of an archive, without pickle.

    Every member is read whole, so its checksum is verified.

    Raises
    ------
    ValueError
        If the file cannot be read or is damaged.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        return {
            name.removesuffix(".npy"): np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
            for name, data in members.items()
        }
    except OSError as problem:
        raise ValueError(problem.strerror or str(problem)) from None
    except Exception as problem:  # zipfile, zlib and NumPy raise a dozen types, some of them undocumented
        raise ValueError(f"it is damaged: {str(problem) or type(problem).__name__}") from None
