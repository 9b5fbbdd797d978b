"""The integrators alone: published stiff problems, measured orders, steps that fail, pauses, events."""

import numpy as np
import pytest
from ivp_problems import (
    BALL,
    COSINE,
    HOLE,
    KINDS,
    POLE,
    PROBLEMS,
    SMOOTH,
    TURNING,
    WEAKER,
    drive,
    jacobian,
    rhs,
    take_steps,
)
from scipy.integrate import solve_ivp
from scipy.special import ellipj

from linkages.base.kernel.simd import lane_array
from linkages.mechanics.integrate.driver import COLLAPSED, DONE, PAUSED, Options
from linkages.mechanics.integrate.factor import back_substitute, decompose, factorise
from linkages.mechanics.integrate.shifted import SMALL, factorise_both, make_shifted, solve_both
from linkages.mechanics.integrate.stepper import make_stepper

METHODS = [pytest.param(True, id="radau"), pytest.param(False, id="dormand-prince")]
IMPLICIT = {"radau": True, "dormand-prince": False}
NO_EVENTS = np.zeros(0, np.int64)


def integrate(
    kind, start, end, tolerance, implicit=True, relative=0.0, parameters=(0.0,), first=None, modes=NO_EVENTS,
    landing=0.0, most=10**6, largest=np.inf, t=0.0,
):  # fmt: skip
    """Run the driver; `tolerance` (n,) or a number, absolute."""
    start = np.asarray(start, dtype=float)
    options = Options(
        float(end),
        1e-6 * (end - t) if first is None else first,
        largest,
        most,
        relative,
        np.full(len(modes), landing),
        np.zeros((0, 1)),
        0.0,
        np.zeros(1, np.int64),
    )
    problem = (np.array(parameters, dtype=float), kind, np.zeros(2))
    stepper, tolerance = make_stepper(len(start)), np.broadcast_to(tolerance, start.shape).copy()
    return drive(implicit, problem, stepper, tolerance, t, start, modes.copy(), options)


# --- published stiff problems -----------------------------------------------------------------------------------------


def published(name, tolerance):
    """Run of a published problem, and the error of its end in parts of the reference."""
    p = PROBLEMS[name]
    run = integrate(KINDS[name], p.start, p.end, tolerance * p.scale, relative=tolerance, parameters=(1e3,), first=1e-6)
    assert run.status == DONE
    return run, float(np.max(np.abs(run.states[-1] / p.reference - 1.0)))


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
def test_stiff_problems_end_as_published(name):
    """The error follows the tolerance, down to the last digits.

    A factor of 30 between them, as in the test set's own diagrams: the methods control the error of each step.
    """
    tolerances = (1e-4, 1e-6, 1e-8, 1e-10)
    errors = [published(name, tolerance)[1] for tolerance in tolerances]
    for tolerance, error in zip(tolerances, errors, strict=True):
        assert error < 30.0 * tolerance
    assert np.all(np.diff(np.log(errors)) < 0.0)


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_work_is_that_of_scipys_radau(name, tolerance):
    """The same method with the same tolerances: as many steps and evaluations, to a tenth."""
    p = PROBLEMS[name]
    run, _ = published(name, tolerance)
    assert run.steps + 1 == len(run.times)

    def f(t, y):
        rhs((np.array([1e3]), KINDS[name], np.zeros(2)), t, y, dy)
        return dy.copy()

    def slope(t, y):
        jacobian((np.array([1e3]), KINDS[name], np.zeros(2)), t, y, out)
        return out.copy()

    dy, out = np.zeros(len(p.start)), np.zeros((len(p.start), len(p.start)))
    other = solve_ivp(
        f, (0.0, p.end), p.start, "Radau", rtol=tolerance, atol=tolerance * p.scale, jac=slope, first_step=1e-6
    )
    assert run.steps < 1.1 * (len(other.t) - 1)
    assert run.evaluations < 1.1 * other.nfev


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_a_stiff_direction_that_turns_does_not_look_like_divergence(tolerance):
    """Newton's corrections with the direction of the step's start shrink in pairs, not one by one.

    Of first order in 1/rate, the velocity is sin t - 2 (1 - cos t)/rate along the line and -2 sin t/rate across it.
    """
    rate, end = 1e4, 1.5
    run = integrate(TURNING, [0.0, 0.0], end, tolerance, parameters=(rate,))
    along, across = np.array([np.cos(end), np.sin(end)]), np.array([-np.sin(end), np.cos(end)])
    expected = np.sin(end) * along - 2.0 / rate * ((1.0 - np.cos(end)) * along + np.sin(end) * across)
    np.testing.assert_allclose(run.states[-1], expected, rtol=0, atol=10.0 * tolerance)
    assert run.rejected < run.steps


def test_steps_grow_again_where_the_jacobian_has_changed():
    """Newton's method converges in two iterations with an old Jacobian, but too slowly for longer steps."""
    run = integrate(WEAKER, [0.0], 2.0, 1e-6, parameters=(1e4, 6e-4), first=3e-4)
    assert run.status == DONE
    assert abs(run.states[-1, 0] - np.sin(2.0)) < 1e-5
    assert run.steps < 50  # 835 without a new Jacobian


# --- order ------------------------------------------------------------------------------------------------------------


def smooth(t, amplitude=2.0):
    """Angle and rate of a pendulum released at rest, by Jacobi's functions: sin(y/2) = k cd(clock, k)."""
    k = np.sin(0.5 * amplitude)
    sn, cn, dn, _ = ellipj(t + 0.5 * t**2, k**2)
    y = 2.0 * np.arcsin(k * cn / dn)
    return np.array([y, -2.0 * k * (1.0 - k**2) * sn / dn**2 / np.cos(0.5 * y)])


def steps(name, t, sizes, scale, exact):
    """End of steps of given sizes from the pendulum's state at t, and the estimate of the last one's error."""
    problem, y = (np.zeros(1), SMOOTH, np.zeros(2)), smooth(t)
    return take_steps(IMPLICIT[name], problem, make_stepper(len(y)), t, y, np.array(sizes), scale, exact)


NEWTON = 1e-12  # scale of errors that takes Newton's method to round-off


def slope(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


# Dormand and Prince's leading error is small against the next one: its order shows at shorter steps.
@pytest.mark.parametrize(("name", "counts"), [("radau", (60, 90, 135, 200)), ("dormand-prince", (400, 600, 900))])
def test_solutions_converge_with_order_five(name, counts):
    sizes, errors = 4.0 / np.array(counts), []
    for n in counts:
        end, _ = steps(name, 0.0, np.full(n, 4.0 / n), NEWTON, True)
        errors.append(np.linalg.norm(end - smooth(4.0)))
    assert slope(sizes, errors) == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize(("name", "t"), [("radau", 1.3), ("dormand-prince", 1.0)])
def test_single_steps_err_with_order_six(name, t):
    sizes, errors = 0.04 * 0.85 ** np.arange(6), []
    for h in sizes:
        end, _ = steps(name, t, [h], NEWTON, True)
        errors.append(np.linalg.norm(end - smooth(t + h)))
    assert slope(sizes, errors) == pytest.approx(6.0, abs=0.1)


@pytest.mark.parametrize(("name", "order"), [("radau", 4), ("dormand-prince", 5)])
def test_error_estimate_is_of_its_order_and_in_parts_of_the_tolerance(name, order):
    """Radau's estimate is of order 3 (error of a step: 4), Dormand and Prince's of order 4; neither is too small."""
    sizes = 0.03 * 0.8 ** np.arange(6)

    def estimate(h, scale):
        end, error = steps(name, 1.3, [h], scale, False)
        return error, np.linalg.norm((end - smooth(1.3 + h)) / scale) / np.sqrt(2.0)

    errors = np.array([estimate(h, 1e-4) for h in sizes])
    assert slope(sizes, errors[:, 0]) == pytest.approx(order, abs=0.1)
    assert np.all(errors[:, 0] > errors[:, 1])
    assert estimate(sizes[-1], 1e-3)[0] == pytest.approx(0.1 * errors[-1, 0], rel=1e-3)


@pytest.mark.parametrize("implicit", METHODS)
def test_error_follows_the_tolerance(implicit):
    tolerances = 10.0 ** -np.arange(4, 11)
    errors = []
    for tolerance in tolerances:
        run = integrate(SMOOTH, smooth(0.0), 1.8, tolerance, implicit, first=1e-3)
        assert run.status == DONE
        errors.append(np.abs(run.states[-1] - smooth(1.8)).max())
    assert slope(tolerances, errors) == pytest.approx(1.0, abs=0.3)
    assert np.all(errors < 300.0 * tolerances)


# --- steps that fail --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("implicit", METHODS)
@pytest.mark.parametrize("hole", [0.0, 0.3])
def test_a_right_hand_side_without_values_ends_the_run(implicit, hole):
    run = integrate(HOLE, [1.0], 1.0, 1e-8, implicit, parameters=(hole,))
    assert run.status == COLLAPSED
    assert run.times[-1] <= hole
    assert run.times[-1] == pytest.approx(hole, abs=1e-10)
    assert run.states[-1, 0] == pytest.approx(np.exp(-hole), rel=1e-6)
    assert run.steps + run.rejected < 1000


@pytest.mark.parametrize("implicit", METHODS)
def test_a_pole_ends_the_run(implicit):
    run = integrate(POLE, [1.0], 2.0, 0.0, implicit, relative=1e-6)
    assert run.status == COLLAPSED
    assert run.times[-1] == pytest.approx(1.0, abs=1e-5)
    assert np.all(np.isfinite(run.states))
    assert run.steps + run.rejected < 2000


# --- pauses -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("implicit", METHODS)
def test_a_paused_run_goes_on_where_it_was(implicit):
    t, y, first, status, parts = 0.0, smooth(0.0), 1e-4, PAUSED, 0
    while status == PAUSED:
        run = integrate(SMOOTH, y, 4.0, 1e-10, implicit, t=t, first=first, most=25)
        assert run.times[0] == t
        assert run.steps <= 25
        assert np.all(np.diff(run.times) > 0.0)
        t, y, first, status, parts = run.times[-1], run.states[-1], run.next_step, run.status, parts + 1
    whole = integrate(SMOOTH, smooth(0.0), 4.0, 1e-10, implicit, first=1e-4)
    assert status == whole.status == DONE
    assert parts > 2
    assert t == whole.times[-1] == 4.0
    np.testing.assert_allclose(y, whole.states[-1], rtol=0, atol=1e-8)
    assert whole.steps <= 25 * parts < 1.5 * whole.steps + 25


@pytest.mark.parametrize("implicit", METHODS)
def test_no_step_is_longer_than_allowed(implicit):
    run = integrate(COSINE, [1.0, 0.0], 10.0, 1e-4, implicit, largest=0.07)
    assert np.diff(run.times).max() <= 0.07 * (1.0 + 1e-3)
    assert run.times[-1] == 10.0


# --- events -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("implicit", METHODS)
def test_a_ball_on_a_spring_bounces_as_its_closed_form(implicit):
    """Free flight is integrated without error, so that the first contact is found to round-off.

    Contact with y'' = -g - w^2 y from -v lasts (2/w)(pi - atan(v w/g)), and free flight 2v/g.
    """
    g, w, height = 9.81, 1e3, 0.2
    run = integrate(
        BALL, [height, 0.0], 2.0, np.array([1e-10, 1e-9]), implicit, parameters=(g, w), modes=np.array([1]), landing=1e-15
    )  # fmt: skip
    assert run.status == DONE
    v = np.sqrt(2.0 * g * height)
    contact, flight = 2.0 / w * (np.pi - np.arctan(v * w / g)), 2.0 * v / g
    expected = v / g + np.cumsum([0.0, *[contact, flight] * 5])
    expected = expected[expected < 2.0]
    found = run.times[np.abs(run.states[:, 0]) < 1e-14]
    assert len(found) == len(expected)
    assert found[0] == pytest.approx(expected[0], rel=4e-16 * 4)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)
    speeds = np.abs(run.states[np.abs(run.states[:, 0]) < 1e-14, 1])
    np.testing.assert_allclose(speeds, v, rtol=1e-7)


@pytest.mark.parametrize("implicit", METHODS)
def test_an_event_function_that_dips_below_zero_within_a_step_is_caught(implicit):
    """cos(t) + 1 - d is negative for 2 sqrt(2 d) about pi: a small part of the step there."""
    depth = 1e-6
    run = integrate(
        COSINE, [1.0, 0.0], 6.0, 1e-9, implicit, parameters=(1.0 - depth,), modes=np.array([1]), landing=1e-13
    )  # fmt: skip
    g = run.states[:, 0] + 1.0 - depth
    crossed = run.times[np.abs(g) < 1e-12]
    expected = np.array([np.arccos(-1.0 + depth), 2.0 * np.pi - np.arccos(-1.0 + depth)])
    assert len(crossed) == 2
    np.testing.assert_allclose(crossed, expected, atol=1e-6)  # 1e-9 of g, at a slope of 1.4e-3
    around = np.diff(run.times)[(run.times[:-1] < 3.0) & (run.times[:-1] > 2.5)]
    assert np.median(around) > 5.0 * np.diff(expected)


@pytest.mark.parametrize("implicit", METHODS)
def test_an_event_function_that_stays_positive_is_none(implicit):
    run = integrate(
        COSINE, [1.0, 0.0], 6.0, 1e-9, implicit, parameters=(1.0 + 1e-6,), modes=np.array([1]), landing=1e-13
    )  # fmt: skip
    without = integrate(COSINE, [1.0, 0.0], 6.0, 1e-9, implicit)
    np.testing.assert_array_equal(run.times, without.times)


# --- linear equations -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 3, 8, 20])
def test_lu_solves_as_numpy(n):
    generator = np.random.default_rng(n)
    for _ in range(20):
        matrix, right = generator.standard_normal((n, n)), generator.standard_normal(n)
        matrix[0, 0] = 0.0 if n > 1 else matrix[0, 0]  # cannot do without interchanges
        factors, pivots, x = matrix.copy(), np.zeros(n, np.int64), right.copy()
        assert factorise(factors, pivots)
        back_substitute(factors, pivots, x)
        exact = np.linalg.solve(matrix, right)
        limit = 1e-15 * n**2 * np.linalg.cond(matrix)
        assert np.linalg.norm(x - exact) <= limit * np.linalg.norm(exact)
        assert np.all(np.abs(np.tril(factors, -1)) <= 1.0)


SINGULAR = [
    np.zeros((3, 3)),
    np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [4.0, 8.0, 12.0]]),
    np.array([[1.0, 2.0, 3.0], [2.0, np.nan, 6.0], [4.0, np.nan, 1.0]]),
]


@pytest.mark.parametrize("matrix", SINGULAR)
def test_lu_says_that_a_matrix_is_singular(matrix):
    assert not factorise(matrix.copy(), np.zeros(3, np.int64))


def side_by_side(real, other):
    """Numbers and complex numbers in lanes."""
    out = lane_array(*real.shape)
    out[..., 0], out[..., 1], out[..., 2] = real, other.real, other.imag
    return out


def prepared(one, two):
    """Both matrices factorised side by side; None if one is singular."""
    both = make_shifted(len(one))
    both.matrix[:] = side_by_side(one, two)
    return both if factorise_both(both) else None


@pytest.mark.parametrize("band", [2, 40])
@pytest.mark.parametrize("n", [1, 2, 3, 8, SMALL, SMALL + 1, 40])
def test_two_systems_side_by_side_are_solved_as_by_numpy(n, band):
    """A matrix minus a real or complex shift, as in Newton's iterations; both need pivoting."""
    generator = np.random.default_rng(n)
    for _ in range(20):
        matrix = np.triu(np.tril(generator.standard_normal((n, n)), band), -band)
        matrix[0, 0] = 0.0 if n > 1 else matrix[0, 0]
        one, two = matrix.copy(), matrix + 0.3j * np.eye(n, k=1)
        both = prepared(one, two)
        both.given[:] = x = side_by_side(
            generator.standard_normal(n), generator.standard_normal(n) + 1j * generator.standard_normal(n)
        )
        solve_both(both)
        for exact, found, given in (
            (np.linalg.solve(one, x[:, 0]), both.found[:, 0], one),
            (np.linalg.solve(two, x[:, 1] + 1j * x[:, 2]), both.found[:, 1] + 1j * both.found[:, 2], two),
        ):
            assert np.linalg.norm(found - exact) <= 1e-14 * n**2 * np.linalg.cond(given) * np.linalg.norm(exact)
        assert not both.found[:, 3].any()


@pytest.mark.parametrize("n", [3, SMALL + 2])
@pytest.mark.parametrize("matrix", SINGULAR)
def test_a_singular_one_of_two_matrices_side_by_side_is_found(matrix, n):
    regular, larger = np.eye(n) + 0.5j, np.eye(n)
    larger[-3:, -3:] = matrix
    for one, two in ((larger, regular), (regular.real, larger + 0j)):
        assert prepared(one, two) is None


def decomposed(matrix):
    (m, n), few = matrix.shape, min(matrix.shape)
    parts = np.empty((m, few)), np.empty(few), np.empty((few, n))
    decompose(matrix, *parts)
    return parts


@pytest.mark.parametrize("shape", [(1, 1), (3, 3), (10, 7), (7, 10), (2, 40), (0, 3), (3, 0)], ids=str)
def test_singular_values_are_those_of_lapack_and_the_parts_make_the_matrix(shape):
    generator, few = np.random.default_rng(sum(shape)), min(shape)
    for rank in {few, few // 2}:
        matrix = generator.standard_normal((shape[0], rank)) @ generator.standard_normal((rank, shape[1]))
        u, s, vt = decomposed(matrix)
        exact = np.linalg.svd(matrix, compute_uv=False) if few else np.zeros(0)
        limit = 1e-14 * exact.max(initial=1.0)  # rounding
        assert np.abs(s - exact).max(initial=0.0) <= limit
        assert np.abs(u * s @ vt - matrix).max(initial=0.0) <= limit
        for sides in (u[:, :rank].T, vt[:rank]):
            assert np.abs(sides @ sides.T - np.eye(rank)).max(initial=0.0) <= 1e-14


def test_small_singular_values_are_exact_where_columns_differ_in_scale():
    """Of orthogonal columns of lengths 1, 1e-8, ... the values are those lengths, to rounding of each."""
    generator = np.random.default_rng(1)
    lengths = 10.0 ** -np.arange(0.0, 41.0, 8.0)
    columns = np.linalg.qr(generator.standard_normal((6, 6)))[0] * lengths
    assert decomposed(columns)[1] == pytest.approx(lengths, rel=1e-14)
