"""Which numbers of a file are plausible, and how numbers are written for readers."""

from __future__ import annotations

#: Magnitudes that a number other than zero may have: what is made of six such factors is still finite, and a fifth
#: power still has a reciprocal.
SMALLEST, LARGEST = 1e-50, 1e50


def implausible(value: float) -> str:
    """Say what is wrong with a number of any kind; nothing if it is zero or of a plausible magnitude.

    Parameters
    ----------
    value : int or float
        Integers may be of any length.

    Returns
    -------
    str
        Empty, or the end of a sentence that begins with the number's place.
    """
    if value == 0 or SMALLEST <= abs(value) <= LARGEST:
        return ""
    if abs(value) < SMALLEST:
        return f"is {value:g}; a number other than zero must be at least {SMALLEST:g} in magnitude"
    shown = f"{value:g}" if isinstance(value, float) else "too large"  # the digits may be too many to be written
    return f"is {shown}; a number must be finite, and at most {LARGEST:g} in magnitude"


def rounded(value: float) -> str:
    """Write a number with three significant digits."""
    return f"{float(f'{value:.3g}'):g}"
