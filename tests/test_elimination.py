"""Reactions of many loops against dense linear algebra: regular, redundant and nearly singular ones."""

import numpy as np
import pytest
from reference_machines import WINDOWS, tower_sdf, windows_sdf

from linkages.base.kernel.by_reference import packed
from linkages.mechanics.planar.articulated_body import articulated_inertias
from linkages.mechanics.planar.closure import jacobian_at
from linkages.mechanics.planar.composite_inertia import mass_matrix
from linkages.mechanics.planar.kinematics import body_positions
from linkages.mechanics.planar.loop_dynamics import correct
from linkages.mechanics.planar.workspace import make_workspace

_TOML = f"duration = 1.0\n{WINDOWS}"


def _posed(system, q):
    """Return a workspace at coordinates (n,) where the loops are closed."""
    tree, arrays = system.tree, system.arrays
    work = packed(make_workspace(len(tree.bodies.records), tree.size, len(arrays.rows)))
    work.q[:] = q
    assert np.abs(tree.gaps(work.q)).max() < 1e-12
    body_positions(tree.bodies, work.q, work.pose)
    return work


def _at(system, angle):
    """Return a workspace with all cranks of windows at an angle."""
    turn = {"A": 1.0, "P": 1.0, "B": -1.0, "C": 1.0, "D": -1.0}  # couplers keep their direction
    return _posed(system, [turn[name[0]] * (angle - np.pi / 2) for name in system.tree.coordinates])


def _dense(system, work):
    """Return the mass matrix (n, n) and the Jacobian of the rows (nr, n)."""
    arrays, mass = system.arrays, np.zeros((len(work.q),) * 2)
    mass_matrix(arrays.bodies, work, mass)
    return mass, jacobian_at(arrays.bodies, arrays.rows, work.q)


def _assert_least(system, work):
    """The change that closes open loops has the least kinetic energy; no row contradicts the others."""
    arrays, (mass, jacobian) = system.arrays, _dense(system, work)
    error = jacobian @ np.random.default_rng(1).normal(size=len(work.q))
    root = np.linalg.cholesky(np.linalg.inv(mass))
    expected = root @ np.linalg.lstsq(jacobian @ root, error, rcond=1e-9)[0]
    x, work.row_error[:] = np.zeros(len(work.q)), error
    assert correct(arrays.bodies, arrays.rows, arrays.elimination, work, x) > 1e-4
    np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("n", [1, 3, 12])
@pytest.mark.parametrize("propped", [False, True])
@pytest.mark.parametrize("angle", [1.2, 0.1, 0.02])
def test_smallest_change_that_closes_loops_side_by_side(system_of, n, propped, angle):
    system = system_of(windows_sdf(n, propped), _TOML)
    assert len(system.arrays.rows) == (4 if propped else 2) * n
    assert system.arrays.elimination.rank == (3 if propped else 2) * n
    _assert_least(system, _at(system, angle))


@pytest.mark.parametrize("n", [2, 12])
def test_smallest_change_that_closes_loops_on_top_of_each_other(system_of, n):
    """Each reaction moves all levels."""
    system = system_of(tower_sdf(n), "duration = 1.0\n")
    tree = system.tree
    angles, turn = np.random.default_rng(2).uniform(-0.8, 0.8, n), {"A": 1.0, "B": 1.0, "C": -1.0, "D": -1.0}
    _assert_least(system, _posed(system, [turn[name[0]] * angles[int(name[1:])] for name in tree.coordinates]))


@pytest.mark.parametrize("n", [1, 12])
@pytest.mark.parametrize("propped", [False, True])
def test_conditioning_is_zero_where_windows_are_flat(system_of, n, propped):
    """Further rows become dependent; in the poses beside, the conditioning grows in proportion to the distance."""
    system = system_of(windows_sdf(n, propped), _TOML)
    found = []
    for angle in (0.0, 1e-4, 2e-4):
        work = _at(system, angle)
        found.append(correct(system.arrays.bodies, system.arrays.rows, system.arrays.elimination, work, work.q.copy()))
    assert found[0] == 0.0
    assert found[2] == pytest.approx(2.0 * found[1], rel=1e-3)


@pytest.mark.parametrize("propped", [False, True])
def test_rows_meet_their_neighbours_only(system_of, propped):
    """The matrix of many windows in series has the entries of dense algebra; the elimination adds none."""
    system = system_of(windows_sdf(12, propped), _TOML)
    arrays, work = system.arrays, _at(system, 1.2)
    mass, jacobian = _dense(system, work)
    articulated_inertias(arrays.bodies, work)
    dense = np.abs(jacobian @ np.linalg.solve(mass, jacobian.T)) > 1e-12
    later = arrays.elimination.later
    assert sorted(arrays.elimination.order) == list(range(len(arrays.rows)))
    pairs = np.zeros_like(dense)
    for k in range(len(arrays.rows)):
        pairs[k, later.entries[later.first[k] : later.first[k + 1]]] = True
    assert not np.any(dense & ~(pairs | pairs.T | np.eye(len(dense), dtype=bool)))
    assert np.count_nonzero(pairs) <= (7 if propped else 4) * len(pairs)
