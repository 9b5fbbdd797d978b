"""Versions of the packages that determine the numerical results."""

from __future__ import annotations

import importlib.metadata
import platform
from functools import cache


@cache
def determining() -> dict[str, str]:
    """Return the versions of the packages that two processes must share so that both compute the same numbers."""
    return {package: version for package, version in versions().items() if package not in ("python", "drake")}


def versions(*more: str) -> dict[str, str]:
    """Return the versions of Python, of the numerical packages and of `more`, or "not installed"."""
    found = {"python": platform.python_version()}
    for package in sorted({"linkages", "drake", "numba", "numpy", "scipy", *more}):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found
