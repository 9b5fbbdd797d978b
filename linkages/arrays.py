"""Types of arrays, for annotations; it imports neither the compiler nor anything else of the package."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Records = NDArray[np.record]


def record_type(**fields: Any) -> np.dtype[np.void]:
    """Type of records with these fields, given by the types of their values, in this order."""
    return np.dtype((np.record, list(fields.items())))
