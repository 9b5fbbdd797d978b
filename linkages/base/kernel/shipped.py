"""Compiled code in the package itself, for a level of processors: with it, a first run does not compile.

A wheel may have it (`hatch_build.py`). It serves processors of this level, with the versions of Python, numba and numpy
that it was compiled with; its names say so, as those of all compiled code do (`linkages.base.kernel.fingerprint`).
Everything else is compiled as ever, for this processor. Each may call the other (`linkages.base.kernel.passing`).
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import numba
from llvmlite import binding

LEVEL = "x86-64-v3"  #: LLVM's name of the level, given to numba as NUMBA_CPU_NAME, with empty NUMBA_CPU_FEATURES
_FEATURES = "avx avx2 bmi bmi2 cx16 f16c fma lzcnt movbe popcnt sse3 sse4.1 sse4.2 ssse3".split()  # noqa: SIM905
ARCHIVE = Path(__file__).with_name("kernels.zip")


def fits() -> bool:
    """Whether this processor has the level, and numba compiles for it and no other."""
    own = binding.get_host_cpu_features()
    another = any(getattr(numba.config, f"CPU_{what}", None) is not None for what in ("NAME", "FEATURES"))
    return not another and all(own.get(name, False) for name in _FEATURES)


@cache
def names() -> frozenset[str]:
    """Names of the code in the package; none if this processor cannot execute it."""
    archive = _archive()
    return frozenset(archive.namelist() if archive is not None and fits() else ())


def read(name: str) -> bytes:
    """Read the code with one of the names."""
    archive = _archive()
    assert archive is not None
    return archive.read(name)


def versions() -> str:
    """Versions with which the code in the package was compiled; empty without any."""
    archive = _archive()
    return "" if archive is None else archive.comment.decode()


@cache
def _archive() -> ZipFile | None:
    try:
        return ZipFile(ARCHIVE)
    except (OSError, BadZipFile):
        return None
