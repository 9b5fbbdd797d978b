"""Fingerprint of a function: a digest of its code, the values it refers to and the functions that it calls.

An edit of a function changes its own fingerprint and the fingerprints of its callers, and no others. The same text in
another folder or process has the same fingerprint. Functions called by address are not part of the caller.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from dis import get_instructions
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, cast

import llvmlite
import numba
import numpy as np
from llvmlite import binding

from linkages.base.kernel import shipped

LAZY = b"lazy"  # kind of kernels whose callers know of them but their names and results
_OURS = __name__.partition(".")[0]
#: Numba's settings, of the environment or of its file, that change the compiled code.
_SETTINGS = """OPT ENABLE_AVX LOOP_VECTORIZE SLP_VECTORIZE DISABLE_INTEL_SVML BOUNDSCHECK
DEBUGINFO_DEFAULT DEBUG_NRT NRT_STATS LLVM_REFPRUNE_PASS LLVM_REFPRUNE_FLAGS EXTEND_VARIABLE_LIFETIMES ENABLE_PROFILING
USE_LLVMLITE_MEMORY_MANAGER""".split()  # noqa: SIM905


def names_of(function: Any, *types_of_call: Any) -> list[str]:
    """Name the code of a function for these types: compiled for this processor, and for the level of `shipped`.

    TypeError if the function refers to something whose content is not known.
    """
    content = f"{fingerprint(function)} {full_name(types_of_call)}".encode()
    return [hashlib.sha256(toolchain(*each) + content).hexdigest()[:32] for each in (processor(), (shipped.LEVEL, ""))]


@cache
def full_name(kind: Any) -> str:
    """Name a type, or a tuple of types, with the fields of named tuples in their order: numba's names lack them."""
    if not isinstance(kind, tuple | numba.types.BaseTuple):
        return str(kind)
    name, fields = getattr(kind, "instance_class", tuple).__name__, getattr(kind, "fields", ())
    return f"{name}{fields}({', '.join(map(full_name, cast(Any, kind)))})"


@cache
def processor() -> tuple[str, str]:
    """Name and features of the processor that numba compiles for: this one, or that of its settings."""
    name, features = (getattr(numba.config, f"CPU_{what}", None) for what in ("NAME", "FEATURES"))
    return (
        name or binding.get_host_cpu_name(),
        binding.get_host_cpu_features().flatten() if features is None else features,
    )


@cache
def toolchain(name: str, features: str) -> bytes:
    """Fingerprint of what compiles: this folder's text, the versions behind it, its settings, a processor."""
    texts = [path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))]
    settings = [str(getattr(numba.config, name, None)) for name in _SETTINGS]
    machine = binding.get_process_triple(), name, features
    return hashlib.sha256(b"\0".join([*texts, repr((versions(), machine, settings)).encode()])).digest()


def versions() -> str:
    """Versions of what compiles, without the last number where it does not change the code."""
    python, arrays = ".".join(map(str, sys.version_info[:2])), ".".join(np.__version__.split(".")[:2])
    return f"Python {python}, numba {numba.__version__}, llvmlite {llvmlite.__version__}, numpy {arrays}"


@cache
def fingerprint(function: Any) -> str:
    """Compute the digest of a function, plain or compiled, and of all that it refers to.

    TypeError if it refers to something whose content is not known.
    """
    digest = hashlib.sha256()
    for part in _parts(function, set()):
        digest.update(part)
        digest.update(b"\0")
    return digest.hexdigest()[:32]


def _parts(value: Any, seen: set[int]) -> Iterator[bytes]:
    """Give what distinguishes a value from others; what was met before is only named."""
    if isinstance(kind := getattr(value, "kind", None), bytes):  # of a kernel
        yield kind
        if kind == LAZY:  # is called by name, and compiled by itself
            yield f"{value.__module__}.{value.__qualname__} {value.result}".encode()
            return
    value = getattr(value, "py_func", value)  # of a kernel
    if not isinstance(value, FunctionType):
        value = getattr(value, "__wrapped__", value)  # of an intrinsic
    if isinstance(value, FunctionType):
        if value.__module__ not in sys.modules:  # typed in: code could not be given back to it
            raise TypeError(f"{value.__qualname__} belongs to no module")
        yield f"{value.__module__}.{value.__qualname__}".encode()
        if id(value) in seen or not _known(value):
            return
        seen.add(id(value))
        yield from _code(value.__code__)
        yield repr(value.__defaults__).encode()
        for cell in value.__closure__ or ():
            yield from _parts(cell.cell_contents, seen)
        for name in sorted(_global_names(value.__code__)):
            if name in value.__globals__:
                yield name.encode()
                yield from _referred(value.__globals__[name], value.__code__, seen)
    elif isinstance(value, np.ndarray):
        yield repr((value.dtype, value.shape)).encode() + value.tobytes()
    elif isinstance(value, tuple | list):
        for item in value:
            yield from _parts(item, seen)
    elif isinstance(value, ModuleType):  # without its place, which differs between environments
        yield value.__name__.encode()
    elif isinstance(value, type) or callable(value):
        yield repr(getattr(value, "__qualname__", value)).encode() + repr(getattr(value, "_fields", "")).encode()
    elif value is None or isinstance(value, int | float | complex | str | bytes | np.generic | np.dtype):
        yield repr(value).encode()
    elif isinstance(value, numba.types.Type):
        yield str(value).encode()
    else:
        raise TypeError(f"{type(value).__name__} in compiled code")


def _referred(value: Any, code: CodeType, seen: set[int]) -> Iterator[bytes]:
    """Give a global value's parts; of one of our modules, those of what is read of it."""
    if isinstance(value, ModuleType) and value.__name__.partition(".")[0] == _OURS:
        for name in sorted(_names(code)):
            if hasattr(value, name):
                yield from _parts(getattr(value, name), seen)
    else:
        yield from _parts(value, seen)


def _known(function: FunctionType) -> bool:
    """Whether a function's text counts: texts of numba, numpy and this folder are part of the toolchain."""
    module = function.__module__ or ""
    return module.partition(".")[0] not in ("numba", "numpy", "math") and module.rpartition(".")[0] != __package__


def _code(code: CodeType) -> Iterator[bytes]:
    yield code.co_code
    yield repr((code.co_names, code.co_varnames, code.co_freevars)).encode()
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code(constant)
        else:
            yield repr(constant).encode()


@cache  # kernels share functions
def _global_names(code: CodeType) -> set[str]:
    """Global names that a function reads, those of functions within it too; no names of attributes."""
    inner = (_global_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return {str(step.argval) for step in get_instructions(code) if step.opname == "LOAD_GLOBAL"}.union(*inner)


def _names(code: CodeType) -> set[str]:
    """Names that a function reads, globals and attributes, those of functions within it too."""
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*inner)
