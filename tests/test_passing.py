"""Code of a wheel and code compiled on another processor call each other: they pass vectors alike."""

import os
import subprocess
import sys

import pytest
from llvmlite import ir

from linkages.base.kernel import passing, shipped
from linkages.base.kernel.cache import pack

SCRIPT = """
import sys
from pathlib import Path

import numpy as np
from numba import types

from linkages.base.kernel import address, caller, kernel, lazy_kernel, precompiled, shipped
from linkages.base.kernel.dual import DUAL, put_slopes, seeded

call = caller(types.float64)

@lazy_kernel
def cube(x: float) -> float:
    return x * x * x

@kernel
def in_wheel(law: int, x: float, y: float) -> tuple[float, float, int, float]:
    return call(law, (x,)), cube(y), 7, x * y

def square(x):
    return x * x

@kernel
def missing(law, slopes):
    first, second, count, third = in_wheel(law, seeded(2.0, 1), seeded(3.0, 6))
    put_slopes(slopes, 0, 0, first)
    put_slopes(slopes, 1, 0, second)
    put_slopes(slopes, 2, 0, third)
    return count

if sys.argv[1:]:
    shipped.ARCHIVE = Path(sys.argv[1])
    slopes = np.zeros((3, 8))
    count = missing(address(square, types.float64(types.float64)), slopes)
    print(count, *slopes[:, 1], *slopes[:, 6], np.count_nonzero(slopes), "loaded", precompiled.counts()[1])
else:
    in_wheel.prepare(types.int64, DUAL, DUAL)
"""


@pytest.mark.skipif(not shipped.fits(), reason="the processor is below the level of the package's kernels")
def test_a_kernel_that_a_wheel_lacks_calls_those_it_has_and_is_called_by_them(tmp_path):
    """Derivatives of the squared first, the cubed second, and the product of both numbers, 2 and 3.

    It can fail only on processors with AVX-512, whose own code otherwise passes other vectors than the wheel's.
    """
    (tmp_path / "script.py").write_text(SCRIPT)

    def run(*words, **settings):
        command = [sys.executable, "script.py", *words]
        done = subprocess.run(command, cwd=tmp_path, env=os.environ | settings, capture_output=True, text=True)
        return done.returncode, done.stdout

    level = {"NUMBA_CPU_NAME": shipped.LEVEL, "NUMBA_CPU_FEATURES": ""}
    assert run(NUMBA_CACHE_DIR=str(tmp_path / "packed"), **level) == (0, "")
    pack(tmp_path / "packed", tmp_path / "kernels.zip")
    found = run("kernels.zip", NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert found == (0, "7 4.0 0.0 3.0 0.0 27.0 2.0 4 loaded 1\n")


def test_no_vector_that_is_passed_is_wider_than_a_register_of_all_processors_of_the_level():
    wide, narrow = (ir.VectorType(ir.DoubleType(), width) for width in (16, 4))
    number = ir.DoubleType()
    kind = ir.FunctionType(ir.LiteralStructType([number, ir.ArrayType(wide, 2)]), [narrow, wide.as_pointer()])
    pieces = ir.ArrayType(narrow, 4)
    outer = ir.FunctionType(ir.LiteralStructType([number, ir.ArrayType(pieces, 2)]), [narrow, wide.as_pointer()])
    assert passing.passed(kind) == outer
    assert passing.entry(ir.Module(), "f", kind) == "f.passed"
    assert passing.entry(ir.Module(), "f", outer) == "f"


def test_processors_named_in_numbas_settings_do_not_load_code_of_the_level(monkeypatch):
    monkeypatch.setattr("numba.config.CPU_NAME", None, raising=False)
    monkeypatch.setattr("numba.config.CPU_FEATURES", "-avx", raising=False)
    assert not shipped.fits()
