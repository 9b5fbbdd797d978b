"""Values and ranges that a command gives for a dotted path, in SI units or with their units."""

from __future__ import annotations

import math

from linkages.errors import InputError


def path_and_range(text: str) -> tuple[str, float, float]:
    """Read ``PATH=LO:HI`` of ``--vary``.

    Raises
    ------
    InputError
        If it is not of that form, or LO is not below HI.

    Examples
    --------
    >>> from linkages.cli.ranges import path_and_range
    >>> path_and_range("joints.A.clearance=0.1mm:0.4mm")
    ('joints.A.clearance', 0.0001, 0.0004)
    """
    path, parts = path_and_parts(text, "PATH=LO:HI")
    low, high = (value_of("--vary", part, path) for part in parts)
    if not low < high:
        raise InputError("--vary", text, "needs LO < HI")
    return path, low, high


def path_and_parts(text: str, form: str) -> tuple[str, list[str]]:
    """Split the text of ``--vary`` into its path and its parts between colons, as many as in the form."""
    path, _, numbers = text.partition("=")
    parts = numbers.split(":")
    if not path.strip() or len(parts) != len(form.split(":")):
        raise InputError("--vary", text, f"write {form}; LO and HI may have units, as 0.1mm:0.4mm")
    return path.strip(), parts


def value_of(where: str, text: str, path: str) -> float:
    """Read a finite number in the SI unit of a path, or with its unit; `where` names it in an InputError."""
    from linkages.files.unit_conversion import is_quantity, read_either
    from linkages.model.experiment import value_unit

    try:
        value = float(read_either(text, value_unit(path)) if is_quantity(text) else text)
        if not math.isfinite(value):
            raise ValueError
    except ValueError:
        raise InputError(where, text, "is no finite number in a unit of the value") from None
    return value
