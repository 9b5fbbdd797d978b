"""Dual numbers: the same digits as floats, and the derivatives of differences; each law of the package."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from joint_records import joint
from numba import config, types

from linkages.base.kernel import address, caller, kernel
from linkages.base.kernel.by_reference import packed, reference
from linkages.base.kernel.dual import (
    DIRECTIONS,
    DualArray,
    dual_array,
    is_known,
    number,
    put_slopes,
    room,
    seeded,
    slope,
    with_number,
)
from linkages.base.kernel.simd import lane, lanes, lanes_at, put_lanes, with_lane
from linkages.laws import CONTACTS, FILMS, FRICTIONS
from linkages.laws.contact.contact_laws import contact_force
from linkages.laws.film.films import film_force
from linkages.laws.friction import friction_action

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")

#: Error of differences of the fourth order with the steps below, in parts of the largest derivative.
DIFFERENCES = 1e-8


def gradient(function, point, steps):
    """Differences of the fourth order of a function with several results, (results, entries of the point)."""
    columns = []
    for i, h in enumerate(steps):
        unit = np.zeros(len(point))
        unit[i] = h
        near, far = (np.array(function(*point + k * unit)) - np.array(function(*point - k * unit)) for k in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * h))
    return np.array(columns).T.reshape(-1, len(point))


def check(value, found, expected, count):
    """Compare duals (results,) with the floats, to the last bit, and with derivatives (results, count)."""
    found = np.asarray(found).reshape(-1, 1 + DIRECTIONS)
    np.testing.assert_array_equal(found[:, 0], np.atleast_1d(value))
    scale = np.maximum(np.abs(expected).max(axis=1, keepdims=True), 1e-300)
    np.testing.assert_allclose(found[:, 1 : 1 + count] / scale, expected / scale, atol=DIFFERENCES)
    assert not found[:, 1 + count :].any()


class Out(NamedTuple):
    """Results of a kernel: it takes arrays of duals by reference."""

    rows: DualArray


def results(count):
    """Make the results, and what a kernel takes."""
    out = Out(dual_array(count))
    return out.rows, packed(out)


@kernel
def functions(x: float, y: float) -> tuple[float, float, float, float, float, float]:
    total = 0.0  # becomes a dual
    for k in range(3):
        total += x * y / (k + 1.0) - y
    total -= (2.0 - x) / y * -x
    chosen = max(x, 0.5) + min(y, 2) * max(x, y) + abs(x - y) + math.copysign(x, -y) + math.copysign(y, x)
    powers = x**2 + x**1.5 + x**y + 2.0**x + math.pow(x, -2.5) + x**-3 + math.hypot(x, y) * math.atan2(-y, x)
    circular = math.sin(x) + math.cos(y) * math.tan(x) + math.asin(0.3 * x) - math.acos(0.3 * y) * math.atan(x)
    growing = math.exp(-x) + math.expm1(y) - math.log(y) * math.log1p(x) + math.log10(x) + math.sqrt(x * y)
    growing += math.sinh(x) - math.cosh(y) * math.tanh(x)
    whole = x * int(10.0 * y) + math.floor(y) - math.ceil(x) * y
    return total, chosen, powers, circular, growing, whole if y > x else -whole


@kernel
def differentiate(x: float, y: float, given: Out) -> None:
    out, found = reference(given).rows, functions(seeded(x, 0), seeded(y, 1))
    for k in range(6):
        out[k] = found[k]


@pytest.mark.parametrize("point", [(0.7, 1.34), (1.2, 0.44)])
def test_functions_have_the_digits_of_floats_and_exact_derivatives(point):
    out, given = results(6)
    differentiate(*point, given)
    check(functions(*point), out, gradient(functions, np.array(point), [1e-3, 1e-3]), 2)


@kernel
def at_zero(x: float, given: Out) -> None:
    z, out = seeded(x, 0), reference(given).rows
    out[0], out[1], out[2], out[3] = math.sqrt(z), math.hypot(z, z), math.atan2(z, z), z**0.5


def test_slopes_that_would_be_infinite_are_zero():
    out, given = results(4)
    at_zero(0.0, given)
    assert not out.any()


class Given(NamedTuple):
    rows: DualArray
    numbers: np.ndarray


@kernel(makes_arrays=True)
def carry(given: Given, x: float) -> float:
    """Take four duals from an array, change them, put them back; return the number of one."""
    given = reference(given)
    four = lanes_at(given.rows, 1, 0)
    four = -with_lane(four * lanes(1.0, 2.0, 3.0, 4.0) / x + 1.0, 2, x)
    put_lanes(given.rows, 0, 1, four - lanes(seeded(x, 7), 0.0, 0.0, 0.0))
    made = room(lane(four, 0), 2)
    made[1] = lane(four, 3)
    given.rows[2, 0] = with_number(made[1], 5.0)
    put_slopes(given.numbers, 0, 1, made[1])
    return number(made[0]) + number(x) + slope(made[1], 2) + (1.0 if is_known(made[1]) else 0.0)


def test_duals_side_by_side():
    given = Given(dual_array(3, 5), np.zeros((1, 10)))
    given.rows[1, :4] = np.random.default_rng(2).normal(size=(4, 1 + DIRECTIONS))
    x, kept = 1.7, np.array(given.rows[1, :4])
    assert carry(packed(given), x) == pytest.approx(x - 4.0 * kept[3, 3] / x + 1.0, rel=1e-15)
    expected = -kept * np.array([1.0, 2.0, 3.0, 4.0])[:, None] / x
    expected[:, 0] -= 1.0
    expected[2] = 0.0
    expected[2, 0] = -x
    np.testing.assert_allclose(given.rows[2, 0], [5.0, *expected[3, 1:]], rtol=1e-15)
    np.testing.assert_allclose(given.numbers[0], [0.0, *expected[3, 1:], 0.0], rtol=1e-15)
    expected[0, 0], expected[0, 8] = expected[0, 0] - x, expected[0, 8] - 1.0
    np.testing.assert_allclose(given.rows[0, 1:], expected, rtol=1e-15)


@kernel
def contact_along(delta: float, ddelta: float, ddelta0: float, law: np.record, given: Out) -> None:
    reference(given).rows[0] = contact_force(seeded(delta, 0), seeded(ddelta, 1), seeded(ddelta0, 2), law)


@pytest.mark.parametrize("name", CONTACTS)
def test_contact_laws(name):
    law = joint(contact=name, restitution=0.8, stiffness=2e9, clearance=1e-4, radius=0.02, length=0.03, damping=800.0)
    law["shape_ratio"] = 1.2
    out, given = results(1)
    for point in ([3e-6, 0.04, 0.1], [2e-6, -0.03, 0.2]):
        point = np.array(point)
        contact_along(*point, law, given)
        expected = gradient(lambda *x: contact_force(*x, law), point, 1e-3 * np.abs(point))
        check(contact_force(*point, law), out, expected, 3)


@kernel
def friction_along(v: float, bristle: float, law: np.record, given: Out) -> None:
    out = reference(given).rows
    none = seeded(0.0, -1)
    out[0], _, _, out[1] = friction_action(seeded(v, 0), (none, none, none, seeded(bristle, 1)), law)


@pytest.mark.parametrize("name", [name for name in FRICTIONS if name != "none"])
def test_friction_laws(name):
    law = joint(friction=name, mu_s=0.15, mu_d=0.1)
    out, given = results(2)
    for v in (4e-4, -3e-3):
        point = np.array([v, 2e-6])

        def values(*x):
            mu, _, _, rate = friction_action(x[0], (0.0, 0.0, 0.0, x[1]), law)
            return mu, rate

        friction_along(*point, law, given)
        check(values(*point), out, gradient(values, point, 1e-3 * np.abs(point)), 2)


@kernel
def film_along(eps: float, deps: float, ew: float, law: np.record, table: np.ndarray, given: Out) -> None:
    out, found = reference(given).rows, film_force(law, seeded(eps, 0), seeded(deps, 1), seeded(ew, 2), 0.7, table)
    for k in range(3):
        out[k] = found[k]


@pytest.mark.parametrize("name", [name for name, film in FILMS.items() if film.force is not None])
def test_films(name):
    law, table = joint(film=name), np.zeros(0)
    out, given = results(3)
    for point in ([0.4, 0.3, 1.1], [0.93, -0.2, -0.5]):
        point = np.array(point)

        def values(*x):
            return film_force(law, *x, 0.7, table)

        film_along(*point, law, table, given)
        check(values(*point), out, gradient(values, point, [1e-4, 1e-3, 1e-3]), 3)


def gamma(x: float) -> float:
    """A function that does not compile for duals."""
    return math.gamma(x)


_FLOAT = types.float64
_call = caller(_FLOAT)


@kernel
def call_along(place: int, x: float, given: Out) -> float:
    reference(given).rows[0] = _call(place, (seeded(x, 0),))
    return _call(place, (x,))


def test_a_function_without_dual_numbers_gives_no_number():
    out, given = results(1)
    assert call_along(address(gamma, _FLOAT(_FLOAT)), 4.0, given) == 6.0
    assert np.isnan(out).all()
