"""Defaults of the search for periodic motions; importable without what computes."""

from __future__ import annotations

#: Accuracy of the runs, and tolerance of the residual over the usual change of a state (some clearances). A run's steps
#: change with its start, so the return map is not smooth below about a thousand times the accuracy.
ACCURACY, TOLERANCE = 1e-11, 1e-7
#: Largest step along a branch, over the range of the value (and, of the states, over their usual change).
STEP = 0.05
