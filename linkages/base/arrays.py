"""Types of arrays, for annotations; imports neither the compiler nor other modules of the package."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Records = NDArray[np.record]


def record_type(**fields: Any) -> np.dtype[np.void]:
    """Make the type of records with these fields, in this order, by the types of their values."""
    return np.dtype((np.record, list(fields.items())))
