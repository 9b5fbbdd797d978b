"""Kernels may hold all that numba compiles, whatever their results are."""

from typing import NamedTuple

import numpy as np
import pytest
from numba import config

from linkages.base.kernel import kernel, stored

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")


@kernel
def with_closure(x):
    def scaled(y):
        return y * x

    return scaled(2.0)


@kernel(makes_arrays=True)
def with_comprehension(n):
    return np.array([2.0 * k for k in range(n)])


@kernel
def with_raise(x):
    if x > 1.0:
        raise ValueError("too large")
    return x


@kernel
def with_try(x):
    try:
        return with_raise(x)
    except Exception:
        return -1.0


@kernel
def with_array_arithmetic(a, b):
    return (a + 2.0 * b).sum()


class Sized(NamedTuple):
    """Has an attribute with the name of a kernel that reads it."""

    length: float


@kernel(makes_arrays=True)
def length(given):
    return np.full(2, given.length).sum()


def test_kernels_may_hold_what_most_do_not():
    assert length(Sized(2.0)) == 4.0
    assert with_closure(3.0) == 6.0
    assert np.array_equal(with_comprehension(3), [0.0, 2.0, 4.0])
    assert with_raise(0.5) == 0.5
    assert (with_try(0.5), with_try(2.0)) == (0.5, -1.0)
    assert with_array_arithmetic(np.ones(3), np.ones(3)) == 9.0


@kernel(makes_arrays=True)
def owned(n: int) -> float:
    values = np.ones(n)
    return values.sum()


@kernel
def recursive(n: int) -> int:
    return 1 if n < 2 else n * recursive(n - 1)


@kernel
def part(values):
    return values[1:]


@kernel(makes_arrays=True)
def first(values: np.ndarray) -> float:
    return part(values)[0] + owned(3)


@kernel(makes_arrays=True)
def of_all(n):
    values = np.arange(float(n))
    return first(values), recursive(4), part(values)


def test_kernels_with_any_result_call_each_other():
    """Numbers from external functions, with and without arrays of their own; arrays from functions in the callers."""
    for _ in range(3):
        number, product, rest = of_all(5)
        assert (number, product) == (4.0, 24)
        assert np.array_equal(rest, [1.0, 2.0, 3.0, 4.0])


def own_array(n: int) -> float:
    return np.ones(n).sum()


def view_of_array(values: np.ndarray) -> float:
    return part(values)[0]


@pytest.mark.parametrize(("function", "given"), [(own_array, 3), (view_of_array, np.ones(3))])
def test_a_kernel_that_counts_references_without_declaring_it_is_compiled_twice(function, given, monkeypatch):
    monkeypatch.setattr(stored, "undeclared", [])
    monkeypatch.setattr(
        stored, "read", lambda name: None
    )  # nothing is on disk: an earlier run of this test left its code there
    assert kernel(function)(given) == function(given)
    assert stored.undeclared == [f"{__name__}.{function.__name__}"]
    assert kernel(makes_arrays=True)(function)(given) == function(given)
    assert len(stored.undeclared) == 1
