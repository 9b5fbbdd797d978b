"""Kernels may hold all that numba compiles; loops over a few bodies are not unrolled."""

import numpy as np
import pytest
from llvmlite import binding, ir
from numba import config
from numba.core.registry import cpu_target

from linkages.kernel import clear, kernel
from linkages.kernel.simd import lane_array
from linkages.kernel.units import with_short_loops

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


@kernel
def with_zeros(array):
    clear(array)


@pytest.mark.parametrize("array", [np.ones(3), np.ones((2, 0)), np.ones((2, 3, 4)), lane_array(2, 3) + 1.0], ids=str)
def test_arrays_are_cleared(array):
    beside = np.ones((2, *array.shape))
    cleared = beside[1].view(type(array))
    with_zeros(cleared)
    assert not cleared.any()
    assert beside[0].all()


def products_after_optimisation(text):
    """How often the code of `product_of` multiplies."""
    codegen = cpu_target.target_context.codegen()
    module = binding.parse_assembly(text(product_of()))
    manager, builder = codegen._module_pass_manager()
    manager.run(module, builder)
    return str(module).count("fmul double")


def product_of():
    """Module with a function of numbers and their count that multiplies them in a loop."""
    module, number, index = ir.Module(), ir.DoubleType(), ir.IntType(64)
    module.triple = binding.get_process_triple()
    function = ir.Function(module, ir.FunctionType(number, [number.as_pointer(), index]), "product_of")
    start, body, end = (function.append_basic_block(name) for name in ("start", "body", "end"))
    builder = ir.IRBuilder(start)
    builder.branch(body)
    builder.position_at_end(body)
    k, total = builder.phi(index), builder.phi(number)
    grown = builder.fmul(total, builder.load(builder.gep(function.args[0], [k])))
    after = builder.add(k, index(1))
    for phi, first, later in ((k, index(0), after), (total, number(1.0), grown)):
        phi.add_incoming(first, start)
        phi.add_incoming(later, body)
    builder.cbranch(builder.icmp_signed("<", after, function.args[1]), body, end)
    builder.position_at_end(end)
    builder.ret(grown)
    return module


def test_loops_stay_as_they_are_unless_it_is_known_how_often_they_are_gone_through():
    assert products_after_optimisation(str) > 4
    assert products_after_optimisation(with_short_loops) == 1
