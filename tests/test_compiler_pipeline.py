"""The compiler's short way: what it leaves out, kernels still have, and afterwards numba is as it was."""

import gc
import time

import numpy as np
import pytest
from numba import config, njit
from numba.core import errors, types

from linkages.kernel import kernel
from linkages.kernel.pipeline import hurried

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")


@kernel
def with_closure(x):
    def scaled(y):
        return y * x

    return scaled(2.0)


@kernel
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


def test_kernels_may_hold_what_most_do_not():
    assert with_closure(3.0) == 6.0
    assert np.array_equal(with_comprehension(3), [0.0, 2.0, 4.0])
    assert with_raise(0.5) == 0.5
    assert (with_try(0.5), with_try(2.0)) == (0.5, -1.0)
    assert with_array_arithmetic(np.ones(3), np.ones(3)) == 9.0


def test_numba_is_as_it_was_after_a_compilation_even_a_failed_one():
    """The collector runs again, the search for signatures is numba's, messages have their colours."""
    was = types.Function.get_call_type, errors._termcolor_inst
    with pytest.raises(errors.TypingError, match="Unknown attribute 'missing'"):
        kernel(_without_type)(1.0)
    assert gc.isenabled()
    assert (types.Function.get_call_type, errors._termcolor_inst) == was
    gc.disable()
    try:
        with hurried():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def _without_type(x):
    return x.missing


def test_what_is_remembered_is_forgotten_with_the_compilation():
    """A kernel that failed for a type compiles once there is a definition for it."""
    from numba.extending import overload

    def half(x):
        return x / 2

    @overload(half, strict=False)
    def _of_whole(x):
        return (lambda x: x // 2) if isinstance(x, types.Integer) else None

    scope = {"half": half, "__name__": __name__}
    new = f"def f(x):\n    return half(x) if x != {time.time_ns()} else 0.0"  # not one that an earlier run has kept
    exec(new, scope)
    with pytest.raises(errors.TypingError):
        kernel(scope["f"])(3.0)

    @overload(half, strict=False)
    def _of_real(x):
        return (lambda x: x / 2) if isinstance(x, types.Float) else None

    assert njit(scope["f"])(3.0) == 1.5
    assert kernel(scope["f"])(3.0) == 1.5
