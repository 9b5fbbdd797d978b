"""Defaults of the search for periodic motions; importable without what computes."""

from __future__ import annotations

from linkages.base.errors import InputError

#: Accuracy of the runs, and tolerance of the residual over the usual change of a state (some clearances). A run's steps
#: change with its start, so the return map is not smooth below about a thousand times the accuracy.
ACCURACY, TOLERANCE = 1e-11, 1e-7
#: Largest step along a branch, over the range of the value (and, of the states, over their usual change).
STEP = 0.05
#: Smallest whole numbers.
LEAST = {"periods": 1, "transient": 0, "doublings": 0}


def check_settings(**numbers: float) -> None:
    """Check settings; InputError if one is out of its range."""
    for key, number in numbers.items():
        if key in LEAST and number < LEAST[key]:
            raise InputError("argument", key, f"is {number:g}; it must be {LEAST[key]} or more")
        if key not in LEAST and not 0.0 < number <= 1.0:
            raise InputError("argument", key, f"is {number:g}; it must be greater than 0, and at most 1")
