"""Versions of what determines an optimisation's numbers."""

from __future__ import annotations

import importlib.metadata
import platform

_PACKAGES = ("linkages", "drake", "numba", "numpy", "pygad", "scipy")


def versions() -> dict[str, str]:
    """Version of Python and of each package; "not installed" where it is not."""
    found = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found
