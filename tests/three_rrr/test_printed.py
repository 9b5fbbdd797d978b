"""Lu et al. (2010), equations as printed: where they hold, and which law they break where they do not."""

from __future__ import annotations

import numpy as np
import pytest
from replication import robot_printed as printed

from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion, determinants, motion, pivots
from linkages.three_rrr.response import Response, quasi_static_response
from linkages.three_rrr.robot import Robot, changed
from linkages.three_rrr.stress import link_stress, platform_stress


@pytest.fixture(scope="module")
def pushed(robot: Robot, branch: AssemblyBranch) -> RobotMotion:
    """Poses away from the alignments of eq. (3), with drives that accelerate."""
    state = branch.motion(np.linspace(0.0, robot.duration, 60))
    state = state.part(
        np.flatnonzero(np.min(np.abs(determinants(robot.geometry, state.phi, state.x)[1]), axis=1) > 0.1)
    )
    rates = np.random.default_rng(4).normal(size=state.phi.shape)
    assert len(state) > 20
    return motion(robot.geometry, state.time, state.phi, 3.0 * state.dphi, rates, state.x)


def test_the_lines_of_the_position_equation_hold_for_j_2_only(robot: Robot, poses: RobotMotion) -> None:
    """Equations for the origin A_1 and (x, y) = C_1; for j = 3 in axes turned by 60 degrees."""
    g = robot.geometry
    base, platform, l1 = (
        np.linalg.norm(g.base[1] - g.base[0]),
        np.linalg.norm(g.platform[1] - g.platform[0]),
        g.crank[0],
    )
    _, c = pivots(g, poses.phi, poses.x)
    third, turn = [], np.pi / 3
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    for phi, theta, point in zip(poses.phi, poses.x[:, 0], c[:, 0] - g.base[0], strict=True):
        *along, rest = printed.line(base, platform, l1, theta, phi[0], phi[1])
        assert along @ point + rest == pytest.approx(0.0, abs=1e-12)
        *along, rest = printed.line(base, platform, l1, theta, phi[0], phi[2])
        third.append(abs(along @ point + rest))
        *along, rest = printed.line(base, platform, l1, theta, phi[0] - turn, phi[2] - turn)
        assert along @ (axes @ point) + rest == pytest.approx(0.0, abs=1e-12)
    assert np.median(third) > 0.01


def test_second_order_influence_gives_the_accelerations(robot: Robot, pushed: RobotMotion) -> None:
    """Eq. (6) with the first row of G on both sides, and eq. (5) for the joints."""
    np.testing.assert_allclose(printed.accelerations(robot.geometry, pushed), pushed.ddx, rtol=1e-9, atol=1e-9)
    first, second = printed.leg_influence(robot.geometry, pushed)
    rates = printed.joint_rates(pushed)
    quadratic = np.einsum("nli,nlj,nlijk->nlk", rates, rates, second)
    assert np.max(np.abs(quadratic)) > 0.1
    joints = np.linalg.solve(first, (pushed.ddx[:, None] - quadratic)[..., None])[..., 0]
    want = np.stack([pushed.ddphi, pushed.ddpsi - pushed.ddphi, pushed.ddx[:, :1] - pushed.ddpsi], axis=-1)
    np.testing.assert_allclose(joints, want, rtol=1e-9, atol=1e-9)


def test_the_printed_load_of_the_platform_has_no_resultant(robot: Robot, pushed: RobotMotion) -> None:
    """Newton: the inertia forces of a body add up to -m a; as printed, without translation, to nothing."""
    free = changed(robot, drives={"roots": "free"})
    model = FiniteElementModel(free)
    bare = FiniteElementModel(changed(free, sections={"platform_thickness": 1e-12}))  # rods alone
    ours, theirs = (
        np.sum((load(model) - load(bare))[:, model.c], axis=1)
        for load in (lambda m: m.full_load(pushed), lambda m: printed.load(m, pushed))
    )
    np.testing.assert_allclose(ours, -model.triangle.total_mass * pushed.ddx[:, 1:], atol=1e-9)
    assert np.max(np.abs(ours)) > 1.0
    np.testing.assert_allclose(theirs, 0.0, atol=1e-9)


def test_the_printed_load_of_the_rods_has_the_other_sign(robot: Robot, pushed: RobotMotion) -> None:
    """d'Alembert: rods alone need torques that accelerate them; as printed they would pull their drives along."""
    bare = FiniteElementModel(changed(robot, drives={"roots": "free"}, sections={"platform_thickness": 1e-12}))
    np.testing.assert_allclose(printed.load(bare, pushed), -bare.full_load(pushed), atol=1e-9)
    energy = np.einsum(
        "ni,nij,nj->n", bare.rigid_velocity(pushed), bare.full_matrices(pushed)[1], bare.rigid_velocity(pushed)
    )
    h = 1e-5
    moved = []
    for step in (-h, h):
        x = pushed.x + step * pushed.dx + 0.5 * step**2 * pushed.ddx
        phi = pushed.phi + step * pushed.dphi + 0.5 * step**2 * pushed.ddphi
        psi = pushed.psi + step * pushed.dpsi + 0.5 * step**2 * pushed.ddpsi
        rates = {name: getattr(pushed, name) + step * getattr(pushed, "d" + name) for name in ("dphi", "dx", "dpsi")}
        late = RobotMotion(
            pushed.time, phi, rates["dphi"], pushed.ddphi, x, rates["dx"], pushed.ddx, psi, rates["dpsi"], pushed.ddpsi
        )
        v = bare.rigid_velocity(late)
        moved.append(0.5 * np.einsum("ni,nij,nj->n", v, bare.full_matrices(late)[1], v))
    power = np.sum(bare.drive_torques(pushed) * pushed.dphi, axis=1)
    assert np.max(np.abs(energy)) > 1e-3
    np.testing.assert_allclose(power, (moved[1] - moved[0]) / (2 * h), rtol=1e-5, atol=1e-6 * np.max(np.abs(power)))


def test_the_printed_work_lacks_the_moment(robot: Robot, poses: RobotMotion) -> None:
    """The power of M in the platform's rotation is M dtheta/dt; as printed it is nothing."""
    loads = {"still": {}, "turned": {"moment": 5.0}}
    models = {
        name: FiniteElementModel(changed(robot, drives={"roots": "free"}, load=load)) for name, load in loads.items()
    }
    velocity = models["still"].rigid_velocity(poses)
    ours = models["turned"].full_load(poses) - models["still"].full_load(poses)
    theirs = printed.load(models["turned"], poses) - printed.load(models["still"], poses)
    np.testing.assert_allclose(np.sum(ours * velocity, axis=1), 5.0 * poses.dx[:, 0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(theirs, 0.0, atol=1e-12)


def test_stress_of_prescribed_loads_does_not_depend_on_the_modulus(robot: Robot, poses: RobotMotion) -> None:
    """The robot is statically determinate: half the modulus, the same stress. The printed axial one is a strain."""
    found = []
    for e in (2.06e11, 1.03e11):
        model = FiniteElementModel(changed(robot, material={"youngs_modulus": e}))
        response = quasi_static_response(model, poses)
        found.append((*printed.rod_stress(model, response), link_stress(model, response)))
    (axial, bending, ours), (soft_axial, soft_bending, soft_ours) = found
    np.testing.assert_allclose(soft_bending, bending, rtol=1e-6)
    np.testing.assert_allclose(soft_axial, 2.0 * axial, rtol=1e-6)
    for link, soft in zip(ours, soft_ours, strict=True):
        np.testing.assert_allclose(soft.axial, link.axial, rtol=1e-6, atol=1e-6 * np.max(np.abs(link.axial)))
    ends = np.stack([np.abs(link.axial.mean(axis=1)) for link in ours], axis=1)  # one element has one axial strain
    np.testing.assert_allclose(2.06e11 * axial, ends, rtol=0.02, atol=0.02 * np.max(ends))


def test_a_pinned_coupler_is_bent_most_between_its_ends(robot: Robot, poses: RobotMotion) -> None:
    """Section 3.3 looks at the ends, where a pinned rod has no bending moment."""
    model = FiniteElementModel(robot)
    response = quasi_static_response(model, poses)
    coupler = link_stress(model, response)[3]
    middle = len(coupler.s) // 2
    assert np.max(np.abs(coupler.bending[:, [0, -1]])) < 1e-6 * np.max(np.abs(coupler.bending))
    assert np.max(np.abs(coupler.bending[:, middle])) > 0.9 * np.max(np.abs(coupler.bending))
    assert np.max(np.abs(coupler.bending)) > np.max(np.abs(coupler.axial))


def test_the_printed_shear_modulus_is_not_isotropic(robot: Robot, poses: RobotMotion) -> None:
    """Pure shear, seen in axes turned by 45 degrees, is the same state: the same principal stresses."""
    model, one = FiniteElementModel(robot), poses.part(slice(0, 1))
    r = model.platform_arms(one)[0]
    c, s = np.cos(one.x[0, 0]), np.sin(one.x[0, 0])
    axes = np.array([[c, -s], [s, c]])
    state = {}
    for name, strain in (("along", np.diag([1e-6, -1e-6])), ("across", np.array([[0.0, 1e-6], [1e-6, 0.0]]))):
        u = np.zeros((1, model.full))
        u[0, model.c] = r @ (axes @ strain @ axes.T)
        none = np.zeros((1, model.size))
        response = Response(one, u[:, model.kept], none, none, np.zeros((1, 3)))
        state[name] = platform_stress(model, response).first[0], printed.platform_stress(model, response)[0][0]
    assert state["along"][0] == pytest.approx(state["across"][0], rel=1e-9)
    nu = robot.material.poisson
    assert state["across"][1] / state["along"][1] == pytest.approx(2 * (1 + nu) / (1 + nu**2), rel=1e-9)
