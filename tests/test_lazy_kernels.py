"""Kernels that are compiled when they are first called: from compiled code, from threads, kept on disk, edited, failing."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import get_ident

import numpy as np
import pytest
from numba import config

from linkages.base.kernel import external, kernel, lazy_kernel

compiled = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")


@lazy_kernel
def pair(x: np.ndarray, n: int) -> tuple[float, float]:
    total = 0.0
    for value in x:
        total += value
    return total, 2.0 * n


@lazy_kernel
def factorial(n: int) -> int:
    return 1 if n < 2 else n * factorial(n - 1)


@lazy_kernel
def fill(x: np.ndarray, value: float) -> None:
    for i in range(len(x)):
        x[i] = value


@lazy_kernel
def above(x: float, limit: float) -> bool:
    return x > limit


@lazy_kernel
def broken(x: float) -> float:
    return x.missing


@kernel
def of_all_kinds(x, n):
    total, twice = pair(x, n)
    fill(value=7.0, x=x[:1])
    return total, twice, factorial(n), above(total, 2)


@kernel
def for_some(x, asked):
    return broken(x) if asked else 2.0 * x


def test_calls_from_compiled_code_and_from_python_give_what_the_functions_say():
    """Nothing, numbers, tuples; parts of arrays; arguments by name, literals; itself."""
    x = np.ones(3)
    assert of_all_kinds(x, 5) == (3.0, 10.0, 120, True)
    assert np.array_equal(x, [7.0, 1.0, 1.0])
    assert of_all_kinds(x, 5) == (9.0, 10.0, 120, True)
    assert pair(np.ones(2), 1) == (2.0, 2.0)
    assert pair(np.ones(2, dtype=np.float32), 1) == (2.0, 2.0)


@compiled
def test_what_cannot_be_compiled_is_an_error_where_it_is_called_and_only_there():
    assert for_some(3.0, False) == 6.0
    for _ in range(2):
        with pytest.raises(Exception, match="Unknown attribute 'missing' of type float64"):
            for_some(3.0, True)
    assert for_some(3.0, False) == 6.0


@pytest.mark.parametrize("result", ["str", "np.ndarray", "tuple[float, str]", None])
@compiled
def test_a_result_of_unknown_type_is_refused(result):
    def made(x):
        return x

    made.__annotations__ = {} if result is None else {"return": result}
    with pytest.raises(TypeError, match=r"lazy kernel .*made.* annotate its result as None, float"):
        lazy_kernel(made)


@pytest.mark.processes
@compiled
def test_threads_may_meet_a_lazy_kernel_at_once(monkeypatch):
    """Eight, without the interpreter's lock: one compiles it, and all get the same results."""

    def made(scope):
        text = "def slow(n: int) -> int:\n    s = 0\n    for k in range(n):\n        s += k % 7\n    return s"
        exec(text, scope)
        return lazy_kernel(scope["slow"])

    scope = {"__name__": __name__}
    scope["slow"] = made(scope)
    exec("def call(n):\n    return slow(n) + slow(n + 1) if n else 0", scope)
    call = kernel(scope["call"])
    assert call(0) == 0  # the caller is compiled, its callee is not
    made_by, make = [], external.c_function
    monkeypatch.setattr(
        external, "c_function", lambda *given, **kinds: made_by.append(get_ident()) or make(*given, **kinds)
    )
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(call, [1000] * 64))
    assert set(found) == {call.py_func(1000)}
    assert len(made_by) == 1


MODULE = """
from linkages.base.kernel import external, kernel, lazy_kernel

@lazy_kernel
def added(x: float) -> float:
    return x + {added}

@kernel
def early(x, asked):
    return added(x) if asked else x
"""
SCRIPT = """
import sys
from linkages.base.kernel import precompiled
from module import early
print(early(1.0, sys.argv[1] == "lazy"), precompiled.counts()[0])
"""


@pytest.mark.slow
@compiled
def test_lazy_code_is_compiled_when_asked_for_kept_on_disk_and_no_part_of_its_callers(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def run(added, when):
        (tmp_path / "module.py").write_text(MODULE.format(added=added))
        (tmp_path / "script.py").write_text(SCRIPT)
        command = [sys.executable, "-B", "script.py", when]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return done.stdout.split()

    assert run("1.0", "early") == ["1.0", "1"]  # the caller
    assert run("1.0", "lazy") == ["2.0", "1"]  # the lazy one
    assert run("1.0", "lazy") == ["2.0", "0"]
    assert run("20.0", "lazy") == ["21.0", "1"]
    assert run("20.0", "early") == ["1.0", "0"]


def test_without_the_compiler_it_is_the_function(tmp_path):
    text = "from linkages.base.kernel import lazy_kernel\ndef f(x: float) -> float:\n    return x\nassert lazy_kernel(f) is f"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, "-c", text], env=environment, check=True)
