"""Numbers side by side, in compiled code, against NumPy's arrays."""

from typing import NamedTuple

import numpy as np

from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import packed, reference
from linkages.base.kernel.simd import WIDTH, LaneArray, lane, lane_array, lanes, lanes_at, put_lanes, with_lane


class Given(NamedTuple):
    a: LaneArray
    b: LaneArray
    out: LaneArray


@kernel
def combine(given, x, place):
    t = reference(given)
    a, b, out = t.a, t.b, t.out
    total = 0.0  # becomes lanes
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            total += x * a[i, j] - a[i, j] * b[j] / x
    out[0] = total
    out[1] = -a[0, 0] / b[0]
    out[2] = x
    out[2] *= b[1]
    out[3] = with_lane(a[1, 1], place, x)
    out[4] -= b[0]
    return lane(a[1, 0], place)


def test_operations_are_numpys():
    given, generator = Given(lane_array(3, 2), lane_array(2), lane_array(5)), np.random.default_rng(3)
    for array in given:
        array[:] = generator.normal(size=array.shape)
    a, b, before = (np.array(array) for array in given)
    for place in range(WIDTH):
        given.out[:] = before
        assert combine(packed(given), 1.7, place) == a[1, 0, place]
        inserted = a[1, 1].copy()
        inserted[place] = 1.7
        expected = [(1.7 * a - a * b / 1.7).sum(axis=(0, 1)), -a[0, 0] / b[0], 1.7 * b[1], inserted, before[4] - b[0]]
        np.testing.assert_allclose(given.out, expected, rtol=1e-14)


@kernel
def carry(array, row, column, to):
    """Multiply four numbers of an array, and put them elsewhere."""
    x = lanes_at(array, row, column) * lanes(1.0, 2.0, 3.0, 4.0)
    put_lanes(array, row, to, x)


def test_lanes_are_taken_from_and_put_into_arrays():
    array = np.arange(24.0).reshape(2, 12)
    expected = array.copy()
    expected[1, 7:11] = array[1, 2:6] * [1.0, 2.0, 3.0, 4.0]
    carry(array, 1, 2, 7)
    np.testing.assert_array_equal(array, expected)


def test_numbers_of_lanes_are_those_of_the_last_axis():
    array = lane_array(2, 3)
    assert array.shape == (2, 3, WIDTH)
    assert array.flags.c_contiguous
    assert not array.any()
