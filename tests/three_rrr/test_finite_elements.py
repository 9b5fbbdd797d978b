"""The robot's matrices, loads and modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from linkages.mechanics.flexible.modes import dense_modes, mac
from linkages.mechanics.flexible.rotation import rotations
from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel, velocity_terms
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import RobotMotion
from linkages.three_rrr.modes import frequencies, modes, tracked_modes
from linkages.three_rrr.robot import Robot, changed, load_robot, make_robot
from linkages.three_rrr.speed import faster


def papers_matrices(robot: Robot, state: RobotMotion) -> tuple[np.ndarray, np.ndarray]:
    """Add up the 24 x 24 matrices at the first pose with the index maps of section 2.3 (the text's numbers).

    Crank: element displacements (w_1, u_2, v_2, w_2) -> u_1..u_4. Coupler: (u_1, v_1, w_1, u_2, v_2, w_2) ->
    u_2, u_3, u_5, u_6, u_7, u_8. Platform: corner r -> 8 (r - 1) + 6 and 7.
    """
    model = FiniteElementModel(robot)
    result = []
    for name in ("stiffness", "mass"):
        whole = np.zeros((24, 24))
        for r in range(3):
            crank, coupler = model.links[2 * r].beam, model.links[2 * r + 1].beam
            t = rotations(state.phi[:1, r])[0]
            local = (t.T @ getattr(crank, name)() @ t)[2:, 2:]
            # crank's own order is (w_1, x, y, w_2); the paper's is (turning at A, x, y, turning at B)
            place = 8 * r + np.arange(4)
            whole[np.ix_(place, place)] += local
            t = rotations(state.psi[:1, r])[0]
            place = 8 * r + np.array([1, 2, 4, 5, 6, 7])
            whole[np.ix_(place, place)] += t.T @ getattr(coupler, name)() @ t
        c, s = np.cos(state.x[0, 0]), np.sin(state.x[0, 0])
        turn = np.kron(np.eye(3), np.array([[c, s], [-s, c]]))
        place = np.array([5, 6, 13, 14, 21, 22])
        whole[np.ix_(place, place)] += turn.T @ getattr(model.triangle, name)() @ turn
        result.append(whole)
    return result[0], result[1]


def test_the_papers_24_numbers(robot: Robot, poses: RobotMotion) -> None:
    free = changed(robot, drives={"roots": "free"})
    model = FiniteElementModel(free)
    assert (model.full, model.size) == (24, 24)
    k, m = model.matrices(poses)
    want_k, want_m = papers_matrices(free, poses)
    np.testing.assert_allclose(k[0], want_k, rtol=1e-12, atol=1e-12 * np.max(want_k))
    np.testing.assert_allclose(m[0], want_m, rtol=1e-12, atol=1e-12 * np.max(want_m))


def test_first_locked_frequency(robot: Robot, poses: RobotMotion) -> None:
    """Steel, one element per link, t = 0, branch at +98.05 deg: 133.56 Hz by two independent computations."""
    model = FiniteElementModel(robot)
    assert model.size == 21
    assert frequencies(model, poses)[0, 0] == pytest.approx(133.56, abs=0.005)


def test_frequency_scales_with_the_material(robot: Robot, poses: RobotMotion) -> None:
    soft = changed(robot, material={"youngs_modulus": 0.5 * 2.06e11, "density": 2 * 7850.0})
    np.testing.assert_allclose(
        frequencies(FiniteElementModel(soft), poses), 0.5 * frequencies(FiniteElementModel(robot), poses), rtol=1e-9
    )


def test_frequencies_do_not_depend_on_the_axes(robot: Robot, poses: RobotMotion) -> None:
    g, turn = robot.geometry, 0.7
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    other = make_robot(robot.model_dump(), robot.source, Geometry(g.base @ rotation.T, g.platform, g.crank, g.coupler))
    x = np.column_stack([poses.x[:, 0] + turn, poses.x[:, 1:] @ rotation.T])
    moved = replace(poses, phi=poses.phi + turn, psi=poses.psi + turn, x=x)
    np.testing.assert_allclose(
        frequencies(FiniteElementModel(other), moved), frequencies(FiniteElementModel(robot), poses), rtol=1e-9
    )


@pytest.mark.parametrize("platform", ["triangle", "rigid"])
@pytest.mark.parametrize("roots", ["locked", "servo", "free"])
def test_sparse_and_dense_matrices_agree(robot: Robot, poses: RobotMotion, roots: str, platform: str) -> None:
    options = {"roots": roots, "servo_stiffness": 1e5}
    model = FiniteElementModel(changed(robot, drives=options, model={"elements": 3, "platform": platform}))
    k, m = model.matrices(poses)
    for n, (sk, sm) in enumerate(model.sparse_matrices(poses)):
        np.testing.assert_allclose(sk.toarray(), k[n], atol=1e-15 * np.max(k))
        np.testing.assert_allclose(sm.toarray(), m[n], atol=1e-15)


def test_sparse_and_dense_solvers_agree(robot: Robot, poses: RobotMotion) -> None:
    model = FiniteElementModel(changed(robot, model={"elements": 8}))
    some = poses.part(slice(0, 3))
    found, shapes = modes(model, some, 10)
    k, m = model.matrices(some)
    exact = np.sqrt(dense_modes(k, m, 10)[0]) / (2 * np.pi)
    np.testing.assert_allclose(found, exact, rtol=1e-9)
    np.testing.assert_allclose(np.swapaxes(shapes, 1, 2) @ m @ shapes, np.tile(np.eye(10), (3, 1, 1)), atol=1e-9)


def test_servo_lies_between_free_and_locked(robot: Robot, poses: RobotMotion) -> None:
    def first(roots: str, stiffness: float = 1.0) -> np.ndarray:
        return frequencies(
            FiniteElementModel(changed(robot, drives={"roots": roots, "servo_stiffness": stiffness})), poses
        )

    locked, free = first("locked"), first("free")
    # the deflection of a stiff servo falls in proportion; beyond 1e12 N m/rad its rounding drowns the links
    soft, stiff = (np.max(np.abs(first("servo", k)[:, :6] / locked[:, :6] - 1.0)) for k in (1e9, 1e11))
    assert soft == pytest.approx(100.0 * stiff, rel=0.05)
    assert stiff < 2e-6
    np.testing.assert_allclose(first("servo", 1e-3)[:, 3:6], free[:, 3:6], rtol=1e-6)
    between = first("servo", 1e4)
    assert np.all(between[:, 3:] >= free[:, 3:] - 1e-6)
    assert np.all(between[:, :21] <= locked + 1e-6)


def test_rigid_platform_is_the_limit_of_a_stiff_triangle(robot: Robot, poses: RobotMotion) -> None:
    model = FiniteElementModel(robot)
    model.triangle = replace(model.triangle, youngs_modulus=1e4 * 2.06e11)
    rigid = FiniteElementModel(changed(robot, model={"platform": "rigid"}))
    assert rigid.size == 18
    np.testing.assert_allclose(frequencies(rigid, poses)[:, :6], frequencies(model, poses)[:, :6], rtol=1e-4)


def test_refinement_lowers_frequencies_to_a_limit(robot: Robot, poses: RobotMotion) -> None:
    start = poses.part(slice(0, 1))
    found = [frequencies(FiniteElementModel(changed(robot, model={"elements": n})), start, 6)[0] for n in (2, 4, 8, 16)]
    steps = -np.diff(found, axis=0)
    assert np.all(steps > 0)
    order = np.log2(steps[:-1] / steps[1:])  # bending of order four, stretching of order two
    assert np.all((order > 2.0) & (order < 4.1))


def test_joint_masses_add_their_kinetic_energy(robot: Robot, poses: RobotMotion) -> None:
    heavy, light = (FiniteElementModel(changed(robot, joint_masses={"B": 0.3, "C": 0.5})), FiniteElementModel(robot))
    v = light.rigid_velocity(poses)
    extra = [(heavy, 1.0), (light, -1.0)]
    gain = sum(s * np.einsum("ni,nij,nj->n", v, m.full_matrices(poses)[1], v) for m, s in extra)
    want = 0.3 * np.sum(v[:, light.b] ** 2, axis=(1, 2)) + 0.5 * np.sum(v[:, light.c] ** 2, axis=(1, 2))
    np.testing.assert_allclose(gain, want, rtol=1e-10)


@pytest.mark.parametrize("count", [1, 3])
def test_inertia_load_is_the_integral_over_the_bodies(robot: Robot, poses: RobotMotion, count: int) -> None:
    """Gauss quadrature of -rho a N with each material point's acceleration from rigid-body kinematics."""
    model = FiniteElementModel(changed(robot, drives={"roots": "free"}, model={"elements": count}))
    load = np.zeros((len(poses), model.full))
    g = robot.geometry
    for link in model.links:
        leg, coupler = divmod(link.angle, 2)
        e1 = np.stack([np.cos(poses.phi[:, leg]), np.sin(poses.phi[:, leg])], -1)
        n1 = np.stack([-e1[:, 1], e1[:, 0]], -1)
        at_b = g.crank[leg] * (poses.ddphi[:, leg, None] * n1 - poses.dphi[:, leg, None] ** 2 * e1)
        angle, speed, rate = (poses.psi, poses.dpsi, poses.ddpsi) if coupler else (poses.phi, poses.dphi, poses.ddphi)
        e = np.stack([np.cos(angle[:, leg]), np.sin(angle[:, leg])], -1)
        n = np.stack([-e[:, 1], e[:, 0]], -1)
        back = np.swapaxes(rotations(angle[:, leg]), 1, 2)
        s, weight = link.beam.quadrature()
        shapes = link.beam.shapes(s)[0]
        for index, dofs in enumerate(link.dofs):
            for point, w, shape in zip(s, weight, shapes, strict=True):
                x = (index + point) * link.beam.length
                a = x * (rate[:, leg, None] * n - speed[:, leg, None] ** 2 * e) + (at_b if coupler else 0.0)
                local = np.stack([np.sum(a * e, 1), np.sum(a * n, 1)], -1)
                part = -w * link.beam.line_density * np.einsum("ci,nc->ni", shape, local)
                part = np.einsum("nij,nj->ni", back, part)
                load[:, dofs[dofs >= 0]] += part[:, dofs >= 0]
    middle = [(0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)]  # exact for quadratics
    c, s = np.cos(poses.x[:, 0]), np.sin(poses.x[:, 0])
    for weights in middle:
        p = np.array(weights) @ g.platform
        r = np.stack([c * p[0] - s * p[1], s * p[0] + c * p[1]], -1)
        a = poses.ddx[:, 1:] + poses.ddx[:, :1] * np.stack([-r[:, 1], r[:, 0]], -1) - poses.dx[:, :1] ** 2 * r
        for corner, share in enumerate(weights):
            load[:, model.c[corner]] -= model.triangle.total_mass / 3.0 * share * a
    np.testing.assert_allclose(model.full_load(poses), load, atol=1e-13 * np.max(np.abs(load)) + 1e-15)


def test_platform_load_has_its_resultant(robot: Robot, poses: RobotMotion) -> None:
    pushed = FiniteElementModel(changed(robot, load={"force": [3.0, -2.0], "moment": 0.7}))
    extra = (pushed.full_load(poses) - FiniteElementModel(robot).full_load(poses))[:, pushed.c.ravel()].reshape(
        -1, 3, 2
    )
    np.testing.assert_allclose(extra.sum(axis=1), np.tile([3.0, -2.0], (len(poses), 1)), atol=1e-12)
    r = pushed.platform_arms(poses)
    couple = np.sum(r[..., 0] * extra[..., 1] - r[..., 1] * extra[..., 0], axis=1)
    np.testing.assert_allclose(couple, 0.7, atol=1e-12)


@pytest.mark.parametrize("platform", ["triangle", "rigid"])
def test_velocity_terms_are_the_derivatives_of_the_field(robot: Robot, branch: AssemblyBranch, platform: str) -> None:
    """M U'' + G U' + K_c U is the virtual work of the displacement field's second time derivative."""
    fast = faster(branch, 50.0)
    model = FiniteElementModel(changed(robot, model={"elements": 2, "platform": platform}))
    t0, h = 0.04, 4e-5
    rng = np.random.default_rng(1)
    u, v, a = rng.normal(size=(3, model.size)) * np.array([[1.0], [50.0], [2000.0]])

    def field(time: float) -> np.ndarray:
        """Displacements (points, 2) of the rods' quadrature points and the platform's edge centres."""
        state = fast.motion(np.array([time]))
        now = u + (time - t0) * v + 0.5 * (time - t0) ** 2 * a
        return shapes(state) @ now

    def shapes(state: RobotMotion) -> np.ndarray:
        g = model.reduction(state)[0]
        rows = []
        for link in model.links:
            angle = (state.psi if link.angle % 2 else state.phi)[0, link.angle // 2]
            t = rotations(np.array([angle]))[0]
            n = np.einsum("ab,qbc,cd->qad", t[:2, :2].T, link.beam.shapes(link.beam.quadrature()[0])[0], t)
            for dofs in link.dofs:
                whole = np.zeros((*n.shape[:2], model.full))
                whole[..., dofs[dofs >= 0]] = n[..., dofs >= 0]
                rows.append((whole @ g).reshape(-1, model.size))
        for weights in ((0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)):
            whole = np.zeros((2, model.full))
            for corner, share in enumerate(weights):
                whole[[0, 1], model.c[corner]] = share
            rows.append(whole @ g)
        return np.concatenate(rows)

    weight = []
    for link in model.links:
        w = np.repeat(link.beam.quadrature()[1] * link.beam.line_density, 2)
        weight += [w] * len(link.dofs)
    weight.append(np.full(6, model.triangle.total_mass / 3.0))
    c = {0: -49 / 18, 1: 3 / 2, 2: -3 / 20, 3: 1 / 90}  # second derivative, sixth order
    acceleration = sum(c[abs(k)] * field(t0 + k * h) for k in range(-3, 4)) / h**2
    state = fast.motion(np.array([t0]))
    work = shapes(state).T @ (np.concatenate(weight) * acceleration)
    _, m = model.matrices(state)
    gyro, stiff = velocity_terms(model, state)
    ours = m[0] @ a + gyro[0] @ v + stiff[0] @ u
    assert np.max(np.abs(gyro[0] @ v + stiff[0] @ u)) > 1e-3 * np.max(np.abs(m[0] @ a))
    np.testing.assert_allclose(ours, work, atol=2e-6 * np.max(np.abs(work)))


def test_modes_are_followed_by_mac(robot: Robot, branch: AssemblyBranch) -> None:
    model = FiniteElementModel(robot)
    ends = []
    for count in (181, 721):  # modes that veer are followed alike on coarse and fine poses
        state = branch.motion(np.linspace(0.0, robot.duration, count))
        values, shapes = modes(model, state)
        tracked, forms, quality = tracked_modes(model, branch, state, values, shapes, 6)
        assert np.min(quality) > 0.9
        ends.append(tracked[-1])
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-12)
    k, m = model.matrices(state)
    signs = np.einsum("nsi,nst,nti->ni", forms[:-1], m[1:], forms[1:])
    assert np.mean(signs > 0.0) > 0.999
    rayleigh = np.einsum("nsi,nst,nti->ni", forms, k, forms)
    np.testing.assert_allclose(np.sqrt(rayleigh) / (2 * np.pi), tracked, rtol=1e-8)
    np.testing.assert_allclose(mac(shapes[0], shapes[0], m[0]), np.eye(model.size), atol=1e-12)


def test_aluminium_is_a_second_experiment(robot: Robot, poses: RobotMotion) -> None:
    light = load_robot(robot.source.with_name("three_rrr_aluminium.toml"))
    a, s = light.material, robot.material
    ratio = np.sqrt(a.youngs_modulus / a.density * s.density / s.youngs_modulus)
    found = frequencies(FiniteElementModel(light), poses, 3) / frequencies(FiniteElementModel(robot), poses, 3)
    np.testing.assert_allclose(found, ratio, rtol=2e-3)  # Poisson's ratio differs, in the platform only
