"""Plausible magnitudes of numbers in files, and numbers as text."""

from __future__ import annotations

import math

#: Magnitudes of nonzero numbers in files: a product of six such factors is finite, and the reciprocal of a fifth power
#: too.
SMALLEST, LARGEST = 1e-50, 1e50
#: Largest tilt of an axis that an import corrects, as rounded angles such as 1.5708 or 1.57 cause [rad].
ALIGNED = 1e-3


def decimal(text: object) -> float:
    """Read a number as all programs read it; `float` also accepts ``2_0`` and digits of other scripts.

    ValueError if it is not a number, or not a text, such as the list of cells beyond the last column for `csv`.

    Examples
    --------
    >>> from linkages.input.files.magnitudes import decimal
    >>> decimal("-1.5e3")
    -1500.0
    """
    if not isinstance(text, str) or "_" in text or not text.isascii():
        raise ValueError(f'"{text}" is not a number')
    return float(text)


def decimal_or_nan(text: object) -> float:
    """Read a number as `decimal`; NaN for others."""
    try:
        return decimal(text)
    except ValueError:
        return math.nan


def implausible(value: float) -> str:
    """Describe the error of a number (end of a sentence); empty if it is zero or of a plausible magnitude."""
    if value == 0 or SMALLEST <= abs(value) <= LARGEST:
        return ""
    if abs(value) < SMALLEST:
        return f"is {value:g}; a number other than zero must be at least {SMALLEST:g} in magnitude"
    shown = f"{value:g}" if isinstance(value, float) else "too large"  # the integer may have too many digits to print
    return f"is {shown}; a number must be finite, and at most {LARGEST:g} in magnitude"


def rounded(value: float) -> str:
    """Write a number with three significant digits."""
    return f"{float(f'{value:.3g}'):g}"
