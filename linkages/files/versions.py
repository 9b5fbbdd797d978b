"""Versions of what determines the numbers."""

from __future__ import annotations

import importlib.metadata
import platform


def versions(*more: str) -> dict[str, str]:
    """Version of Python, of each package that determines the numbers and of `more`; or "not installed"."""
    found = {"python": platform.python_version()}
    for package in sorted({"linkages", "drake", "numba", "numpy", "scipy", *more}):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found
