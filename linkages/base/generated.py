"""Functions that are made of others: lazy kernels of a module, and functions from lines."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from linkages.base.kernel import lazy_kernel


def lazy(module: str, name: str, function: Callable[..., Any], makes_arrays: bool = False) -> Any:
    """Make a lazy kernel of a function, under a name of a module, by which other processes find it."""
    function.__module__, function.__name__, function.__qualname__ = module, name, name
    made = lazy_kernel(makes_arrays=makes_arrays)(function)
    setattr(sys.modules[module], name, made)
    return made


def made(module: str, name: str, lines: Iterable[str], names: Mapping[str, Any]) -> Any:
    """Make a function of its lines, which call others by name."""
    known = {**names, "__name__": module}
    exec("\n".join(lines), known)
    return known[name]
