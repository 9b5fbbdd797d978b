"""Velocities, accelerations, inverse kinematics, branches, folds and singularities."""

from __future__ import annotations

import numpy as np
import pytest

from linkages.base.errors import Status
from linkages.three_rrr.branch import AssemblyBranch, BranchError, follow, travel
from linkages.three_rrr.direct import assemblies, count
from linkages.three_rrr.kinematics import RobotMotion, determinants, inverse, jacobians, loop_errors, pivots, unit
from linkages.three_rrr.robot import Robot, changed


def test_loops_are_closed_over_the_revolution(robot: Robot, branch: AssemblyBranch) -> None:
    state = branch.motion(np.linspace(0.0, robot.duration, 720))
    assert branch.status is Status.OK
    assert np.max(np.abs(loop_errors(robot.geometry, state.phi, state.x))) <= 1e-12


def test_velocities_and_accelerations_are_derivatives(branch: AssemblyBranch) -> None:
    times = np.linspace(0.5, 11.5, 40)
    h = 2e-3
    weights = {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60}  # sixth order
    state = branch.motion(times)
    moved = {k: branch.motion(times + k * h) for k in weights}
    for value, rate in (("x", "dx"), ("dx", "ddx"), ("dpsi", "ddpsi")):
        difference = sum(w * getattr(moved[k], value) for k, w in weights.items()) / h
        np.testing.assert_allclose(getattr(state, rate), difference, atol=2e-10)
    turn = sum(w * np.unwrap(np.stack([state.psi, moved[k].psi]), axis=0)[1] for k, w in weights.items()) / h
    np.testing.assert_allclose(state.dpsi, turn, atol=2e-10)


def table_of(times: np.ndarray, phi: np.ndarray) -> dict:
    return {"phi0": None, "phidot": None, "times": times.tolist(), "angles": np.rad2deg(phi).tolist()}


def test_drives_may_accelerate(robot: Robot) -> None:
    """A smooth start from rest, and a table that goes there and back: rates are derivatives, the way back ends at the start."""
    times = np.linspace(0.0, 2.0, 41)
    swing = robot.phi0 + 0.4 * np.array([1.0, -0.7, 0.5]) * (1.0 - np.cos(np.pi * times[:, None]))
    x0 = assemblies(robot.geometry, robot.phi0).x[0]
    for drives in ({"ramp": 0.8}, table_of(times, swing)):
        cranks = changed(robot, drives=drives, duration=2.0).cranks
        branch = follow(robot.geometry, cranks, x0, 2.0)
        assert branch.status is Status.OK
        at, h = np.linspace(0.1, 1.9, 19) + 0.003, 1e-4
        state, before, after = (branch.motion(at + d) for d in (0.0, -h, h))
        assert np.max(np.abs(state.ddphi)) > 0.5
        np.testing.assert_allclose(state.dx, (after.x - before.x) / (2 * h), atol=1e-6)
        np.testing.assert_allclose(state.ddx, (after.dx - before.dx) / (2 * h), atol=1e-5)
    ends = branch.motion(np.array([0.0, 2.0]))
    np.testing.assert_allclose(ends.x[1], ends.x[0], atol=1e-9)
    np.testing.assert_allclose(ends.phi, np.tile(robot.phi0, (2, 1)), atol=1e-12)
    assert np.ptp(branch.motion(times).x[:, 1]) > 0.01


def test_any_function_of_time_drives_the_cranks(robot: Robot, branch: AssemblyBranch) -> None:
    """The shipped motion, passed back and forth: x(t) of the constant speeds at the same crank angles."""
    speeds = np.array(robot.drives.phidot)

    def cranks(times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        t = times[:, None]
        return robot.phi0 + speeds * np.sin(t) ** 2, speeds * np.sin(2 * t), 2 * speeds * np.cos(2 * t)

    swing = follow(robot.geometry, cranks, branch.x[0], 3.0)
    times = np.linspace(0.0, 3.0, 31)
    np.testing.assert_allclose(swing.motion(times).x, branch.motion(np.sin(times) ** 2).x, atol=1e-12)


def test_rows_agree_with_the_leg_jacobians_of_the_paper(robot: Robot, branch: AssemblyBranch) -> None:
    """Eq. (3)-(4): the first row of each inverted leg Jacobian, away from its singular alignments."""
    state = branch.motion(np.linspace(0.0, robot.duration, 50))
    g = robot.geometry
    _, sine = determinants(g, state.phi, state.x)
    b, c = pivots(g, state.phi, state.x)
    jx, jq = jacobians(g, state.phi, state.x)
    compared = 0
    for n in np.flatnonzero(np.min(np.abs(sine), axis=1) > 0.1):
        rows = []
        for r in range(3):
            arm = state.x[n, 1:] - np.stack([g.base[r], b[n, r], c[n, r]])
            leg = np.stack([np.ones(3), -arm[:, 1], arm[:, 0]])
            rows.append(np.linalg.inv(leg)[0])
        gain = np.linalg.inv(np.array(rows))
        np.testing.assert_allclose(np.linalg.solve(jx[n], np.diag(jq[n])), gain, atol=1e-12)
        compared += 1
    assert compared > 15


def test_leg_jacobians_are_singular_where_the_rows_are_not(robot: Robot, branch: AssemblyBranch) -> None:
    aligned = [s for s in branch.singularities if s.type == 1]
    assert len(aligned) == 7
    for event in aligned:
        state = branch.motion(np.array([event.time]))
        b, c = pivots(robot.geometry, state.phi, state.x)
        leg = event.leg - 1
        along, rod = b[0, leg] - robot.geometry.base[leg], c[0, leg] - b[0, leg]
        cross = along[0] * rod[1] - along[1] * rod[0]
        assert abs(cross) < 1e-9 * np.linalg.norm(along) * np.linalg.norm(rod)
        assert abs(determinants(robot.geometry, state.phi, state.x)[0][0]) > 0.1
        assert np.all(np.isfinite(state.ddx))


def test_inverse_kinematics_returns_the_drives(robot: Robot, poses: RobotMotion) -> None:
    g = robot.geometry
    b, c = pivots(g, poses.phi, poses.x)
    reach, rod = c - g.base, b - g.base
    elbow = np.sign(reach[..., 0] * rod[..., 1] - reach[..., 1] * rod[..., 0])
    for n in range(len(poses)):
        phi = inverse(g, poses.x[n : n + 1], elbow[n])
        np.testing.assert_allclose(unit(phi[0]), unit(poses.phi[n]), atol=1e-9)
        other = inverse(g, poses.x[n : n + 1], -elbow[n])
        assert np.max(np.abs(loop_errors(g, other, poses.x[n : n + 1]))) < 1e-14
    assert np.all(np.isnan(inverse(g, np.array([[0.0, 5.0, 0.0]]), np.ones(3))))


@pytest.mark.slow
def test_travel_of_the_two_persistent_branches(robot: Robot) -> None:
    g = robot.geometry
    lengths, branches = [], [follow(g, robot.cranks, x, robot.duration) for x in assemblies(g, robot.phi0).x]
    for branch in branches:
        assert branch.status is Status.OK
        lengths.append(travel(branch, "path"))
        track = branch.motion(np.linspace(0.0, robot.duration, 4001)).x[:, 1:]
        assert lengths[-1] == pytest.approx(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=1)), rel=1e-5)
    np.testing.assert_allclose(lengths, [0.876, 0.890], atol=6e-4)
    for metric in ("path", "rotation", "pivots"):
        best = min(branches, key=lambda branch: travel(branch, metric))
        assert np.rad2deg(best.x[0, 0]) == pytest.approx(98.05, abs=0.01)


def test_branch_ends_at_a_fold_where_the_number_of_assemblies_falls(robot: Robot) -> None:
    g = robot.geometry
    times = np.linspace(0.0, robot.duration, 2001)
    number = count(g, robot.cranks(times)[0])
    assert set(number) == {2, 4}
    start = times[np.flatnonzero(number == 4)[0]]
    cranks = changed(robot, drives={"phi0": np.rad2deg(robot.cranks(np.array([start]))[0][0]).tolist()}).cranks
    phi0 = cranks(np.zeros(1))[0][0]
    branches = [follow(g, cranks, x, robot.duration - start) for x in assemblies(g, phi0).x]
    ended = [b for b in branches if b.status is Status.SINGULAR]
    assert len(ended) == 2  # two assemblies meet and vanish together
    assert ended[0].times[-1] == pytest.approx(ended[1].times[-1], abs=1e-7)
    for branch in ended:
        assert branch.singularities[-1].type == 2
        time = branch.times[-1]
        fold, _ = determinants(g, cranks(np.array([time]))[0], branch.x[-1:])
        assert abs(fold[0]) < 1e-3
        assert count(g, cranks(time + np.array([-1e-5, 1e-5]))[0]).tolist() == [4, 2]
        with pytest.raises(BranchError, match="outside the branch") as caught:
            branch.motion(np.array([time + 0.1]))
        assert caught.value.status is Status.SINGULAR


def test_a_branch_has_motion_between_its_ends_only(robot: Robot, branch: AssemblyBranch) -> None:
    end = branch.times[-1]
    ends = branch.motion(np.array([0.0, end]))
    np.testing.assert_allclose(ends.x, branch.x[[0, -1]], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(ends.phi[1] - ends.phi[0], end * np.array(robot.drives.phidot), rtol=1e-12)
    for outside in (-1e-3, end + 1e-3):
        with pytest.raises(BranchError, match="outside the branch"):
            branch.motion(np.array([outside]))
