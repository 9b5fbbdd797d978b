"""Elastic response and stress of the robot: energy, equilibrium with independently computed forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from linkages.base.errors import InputError
from linkages.mechanics.flexible.modes import dense_modes
from linkages.mechanics.flexible.response import BATCH
from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.response import generalised_alpha, quasi_static, quasi_static_response, recursion
from linkages.three_rrr.robot import Robot, changed
from linkages.three_rrr.speed import faster, speed_sweep, velocity_effect
from linkages.three_rrr.stress import link_stress, platform_stress
from linkages.three_rrr.vibration import vibrate


def energy(model, response):
    """Elastic plus kinetic energy (N,) of the elastic motion [J]."""
    k, m = model.matrices(response.motion)
    strain = np.einsum("ni,nij,nj->n", response.u, k, response.u)
    return 0.5 * (strain + np.einsum("ni,nij,nj->n", response.v, m, response.v))


def still(branch: AssemblyBranch) -> AssemblyBranch:
    """Return the branch's start, with the drives at rest."""
    phi0, _, _ = branch.cranks(np.zeros(1))

    def cranks(times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        none = np.zeros((len(times), 3))
        return phi0 + none, none, none

    ends = np.array([0.0, 100.0])
    return replace(branch, cranks=cranks, times=ends, x=np.repeat(branch.x[:1], 2, axis=0), singularities=())


@pytest.mark.parametrize("scheme", [recursion, generalised_alpha])
def test_energy_is_conserved_without_damping(robot: Robot, branch: AssemblyBranch, scheme) -> None:
    """Drives at rest, the platform pushed at t = 0: the energy is the work of the constant push."""
    model = FiniteElementModel(changed(robot, load={"force": [100.0, -50.0], "moment": 5.0}))
    options = {"radius": 1.0} if scheme is generalised_alpha else {}
    result = scheme(model, still(branch), np.linspace(0.0, 0.1, 2001), **options)
    stored = energy(model, result)
    work = np.einsum("ni,ni->n", model.load(result.motion), result.u)
    assert np.max(stored) > 1e-6
    np.testing.assert_allclose(stored, work, atol=1e-9 * np.max(stored))


@pytest.mark.slow
def test_rayleigh_damping_has_its_decay(robot: Robot, branch: AssemblyBranch) -> None:
    """Free decay about the static solution: the first mode's amplitude falls as exp(-zeta p t)."""
    alpha, beta = 3.0, 2e-5
    pushed = changed(robot, load={"force": [100.0, 0.0]}, damping={"mass": alpha, "stiffness": beta})
    model = FiniteElementModel(pushed)
    times = np.linspace(0.0, 0.2, 4001)
    rest = quasi_static(model, still(branch).motion(times[:1]))[0]
    k, m = (x[0] for x in model.matrices(still(branch).motion(times[:1])))
    values, forms = dense_modes(k[None], m[None], 1)
    p = float(np.sqrt(values[0, 0]))
    rate = 0.5 * (alpha + beta * p**2)
    inner = np.sqrt(p**2 - rate**2)
    for scheme, tolerance in ((recursion, 1e-9), (generalised_alpha, 2e-2)):
        result = scheme(model, still(branch), times)
        q = (result.u - rest) @ m @ forms[0, :, 0]
        want = q[0] * np.exp(-rate * times) * (np.cos(inner * times) + rate / inner * np.sin(inner * times))
        assert np.max(np.abs(want[-200:])) < 0.5 * abs(q[0])
        np.testing.assert_allclose(q, want, atol=tolerance * abs(q[0]))


@pytest.mark.slow
def test_recursion_and_generalised_alpha_agree_on_the_moving_robot(robot: Robot, branch: AssemblyBranch) -> None:
    """Both tend to one solution: the recursion at first order, as it holds matrices over a step."""
    quick = faster(branch, 20.0)
    model = FiniteElementModel(robot)
    exact = generalised_alpha(model, quick, np.linspace(0.0, 0.05, 12801), radius=1.0).platform
    size = np.max(np.abs(exact), axis=0)
    errors = {recursion: [], generalised_alpha: []}
    for steps in (800, 1600, 3200):
        times = np.linspace(0.0, 0.05, steps + 1)
        for scheme, found in errors.items():
            platform = scheme(model, quick, times).platform
            found.append(np.max(np.abs(platform - exact[:: 12800 // steps]) / size))
    first, second = np.array(errors[recursion]), np.array(errors[generalised_alpha])
    assert first[-1] < 0.02
    np.testing.assert_allclose(np.log2(first[:-1] / first[1:]), 1.0, atol=0.25)
    assert second[-1] < 0.005
    assert np.all(second[:-1] / second[1:] > 2.5)  # the start shakes modes of many kHz, not yet resolved


def test_the_printed_recursion_is_that_of_one_basis_to_first_order(robot: Robot, branch: AssemblyBranch) -> None:
    """Eq. (13) returns with the next step's modes; order and signs, in which solvers are free, must not matter."""
    model = FiniteElementModel(robot)
    apart = []
    for steps in (250, 2000):
        times = np.linspace(0.0, 0.5, steps + 1)
        right, printed = recursion(model, branch, times), recursion(model, branch, times, printed=True)
        size = np.max(np.abs(right.platform), axis=0)
        apart.append(np.max(np.abs(printed.platform - right.platform) / size))
    assert apart[1] < 0.005
    assert apart[1] < 0.5 * apart[0]


def test_the_printed_recursion_needs_no_order_nor_signs(robot: Robot, branch: AssemblyBranch, monkeypatch) -> None:
    model, times = FiniteElementModel(robot), np.linspace(0.0, 0.1, 201)
    expected = recursion(model, branch, times, printed=True)
    draw = np.random.default_rng(2)

    def shuffled(k, m, count):
        values, shapes = dense_modes(k, m, count)
        for n in range(len(values)):
            order = draw.permutation(count)
            values[n], shapes[n] = values[n, order], shapes[n][:, order] * draw.choice([-1.0, 1.0], count)
        return values, shapes

    monkeypatch.setattr("linkages.three_rrr.response.dense_modes", shuffled)
    found = recursion(model, branch, times, printed=True)
    np.testing.assert_allclose(found.u, expected.u, rtol=0, atol=1e-9 * np.abs(expected.u).max())


@pytest.mark.parametrize("printed", [False, True, None], ids=["one basis", "printed", "generalised-alpha"])
def test_a_robot_that_nothing_drives_moves_as_its_rigid_masses_say(
    robot: Robot, branch: AssemblyBranch, printed
) -> None:
    """Free roots, pushed from rest: the part of the elastic motion in the rigid modes is a free fall, f t^2/2."""
    loose = changed(robot, drives={"roots": "free"}, load={"force": [30.0, -20.0], "at": [0.1, 0.05], "moment": 2.0})
    model, times = FiniteElementModel(loose), np.linspace(0.0, 0.05, 401)
    if printed is None:
        response = generalised_alpha(model, still(branch), times, radius=1.0)
    else:
        response = recursion(model, still(branch), times, printed=printed)
    start = response.motion.part(slice(0, 1))
    rigid, (m,) = model.rigid_modes(start)[0], model.matrices(start)[1]
    moved = response.u @ m @ rigid
    want = 0.5 * times[:, None] ** 2 * (model.load(start)[0] @ rigid)
    np.testing.assert_allclose(moved, want, atol=1e-7 * np.max(np.abs(want)))


def test_the_printed_recursion_needs_no_basis_of_the_rigid_motion(
    robot: Robot, branch: AssemblyBranch, monkeypatch
) -> None:
    """The three zero modes have only a common space: the solver may return any basis."""
    model, times = FiniteElementModel(changed(robot, drives={"roots": "free"})), np.linspace(0.0, 0.1, 201)
    expected = recursion(model, branch, times, printed=True)
    draw = np.random.default_rng(3)

    def turned(k, m, count):
        values, shapes = dense_modes(k, m, count)
        for shape in shapes:
            shape[:, :3] = shape[:, :3] @ np.linalg.qr(draw.normal(size=(3, 3)))[0]
        return values, shapes

    monkeypatch.setattr("linkages.three_rrr.response.dense_modes", turned)
    found = recursion(model, branch, times, printed=True)
    np.testing.assert_allclose(found.u, expected.u, rtol=0, atol=1e-7 * np.abs(expected.u).max())


def test_vibration_over_the_motion_is_that_of_all_its_steps(robot: Robot, branch: AssemblyBranch) -> None:
    """Extremes in spans, part by part, against the whole response at once."""
    short = replace(branch, times=branch.times[:9], x=branch.x[:9])
    model = FiniteElementModel(robot)
    found = vibrate(model, short)
    assert found.steps > 3 * BATCH
    times = np.linspace(0.0, short.times[-1], found.steps + 1)
    whole = generalised_alpha(model, short, times, radius=1.0)
    links, plate = link_stress(model, whole), platform_stress(model, whole)
    for (low, high), values in (
        (found.platform, whole.platform),
        (found.plate, np.column_stack([plate.first, plate.second, plate.largest_shear])),
        *((found.fibre[link.name], link.fibre[:, [0, 8, 16]]) for link in links),
    ):
        np.testing.assert_allclose(low.min(axis=0), values.min(axis=0), rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(high.max(axis=0), values.max(axis=0), rtol=1e-9, atol=1e-15)
        span = np.argmin(np.abs(found.time - times[123]))
        assert np.all((low[span] <= values[123]) & (values[123] <= high[span]))
    assert found.largest == pytest.approx({link.name: link.largest.max() for link in links}, rel=1e-9)


def test_a_force_acts_where_it_is_said_to(robot: Robot, branch: AssemblyBranch) -> None:
    """A force at a point of a rigid platform acts like one at the centre with the moment r x F; at a pivot on it alone."""
    state, force, at = branch.motion(np.array([0.0, 3.0])), np.array([3.0, -2.0]), np.array([0.07, -0.02])
    for n in range(2):
        one = state.part(slice(n, n + 1))
        c, s = np.cos(one.x[0, 0]), np.sin(one.x[0, 0])
        arm = np.array([[c, -s], [s, c]]) @ (at - robot.geometry.platform.mean(axis=0))
        couple = float(arm[0] * force[1] - arm[1] * force[0])
        loads = ({"force": force.tolist(), "at": at.tolist()}, {"force": force.tolist(), "moment": couple})
        stiff = [FiniteElementModel(changed(robot, model={"platform": "rigid"}, load=load)) for load in loads]
        found, want = (model.load(one) for model in stiff)
        assert np.max(np.abs(want - FiniteElementModel(changed(robot, model={"platform": "rigid"})).load(one))) > 0.3
        np.testing.assert_allclose(found, want, atol=1e-12)
    corner = robot.geometry.platform[1].tolist()
    pulled, left = (
        FiniteElementModel(changed(robot, load=load)) for load in ({"force": [3.0, -2.0], "at": corner}, {})
    )
    gain = (pulled.full_load(state) - left.full_load(state))[:, pulled.c]
    np.testing.assert_allclose(gain, np.broadcast_to([[0.0, 0.0], force, [0.0, 0.0]], gain.shape), atol=1e-12)


def test_start_on_the_quasi_static_solution_hardly_vibrates(robot: Robot, branch: AssemblyBranch) -> None:
    model = FiniteElementModel(robot)
    times = np.linspace(0.0, 0.3, 1201)
    smooth = generalised_alpha(model, branch, times, start="quasi-static")
    static = quasi_static_response(model, smooth.motion)
    shake = np.max(np.abs(smooth.platform - static.platform), axis=0)
    rest = generalised_alpha(model, branch, times).platform
    assert np.all(shake < 0.02 * np.max(np.abs(static.platform), axis=0))
    assert np.all(np.max(np.abs(rest - static.platform), axis=0) > 20.0 * shake)


def test_servo_roots_turn_by_torque_over_stiffness(robot: Robot, branch: AssemblyBranch) -> None:
    model = FiniteElementModel(changed(robot, drives={"roots": "servo", "servo_stiffness": 2e4}))
    state = branch.motion(np.linspace(0.0, robot.duration, 30))
    turn = model.expand(state, quasi_static(model, state))[:, model.roots]
    np.testing.assert_allclose(turn, -model.drive_torques(state) / 2e4, rtol=1e-9, atol=1e-15)


def test_free_roots_have_no_response(robot: Robot, branch: AssemblyBranch) -> None:
    model = FiniteElementModel(changed(robot, drives={"roots": "free"}))
    with pytest.raises(InputError, match="nothing holds the mechanism"):
        quasi_static(model, branch.motion(np.zeros(1)))


@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
@pytest.mark.parametrize("count", [1, 4])
def test_crank_root_moment_is_the_drive_torque(robot: Robot, branch: AssemblyBranch, count: int, beam: str) -> None:
    """Torque from virtual power of rigid bodies (checked against Drake); moment from elastic statics."""
    model = FiniteElementModel(changed(robot, model={"elements": count, "beam": beam}))
    state = branch.motion(np.linspace(0.0, robot.duration, 40))
    stress = {s.name: s for s in link_stress(model, quasi_static_response(model, state))}
    torque = model.drive_torques(state)
    for leg in (1, 2, 3):
        crank, coupler = stress[f"crank{leg}"], stress[f"coupler{leg}"]
        np.testing.assert_allclose(-crank.moment[:, 0], torque[:, leg - 1], atol=1e-10)
        for hinged in (crank.moment[:, -1], coupler.moment[:, 0], coupler.moment[:, -1]):
            np.testing.assert_allclose(hinged, 0.0, atol=1e-10)


def test_coupler_moment_has_the_closed_form_of_a_pinned_beam(robot: Robot, branch: AssemblyBranch) -> None:
    """Load q_0 + (q_1 - q_0) x/L across: M = -q_0 x (L - x)/2 - (q_1 - q_0) x (L^2 - x^2)/(6 L)."""
    model = FiniteElementModel(robot)
    state = branch.motion(np.linspace(0.0, robot.duration, 40))
    found = link_stress(model, quasi_static_response(model, state))[1]
    field = model.rigid_acceleration(state)
    normal = np.stack([-np.sin(state.psi[:, 0]), np.cos(state.psi[:, 0])], -1)
    density = model.links[1].beam.line_density
    q0, q1 = (-density * np.sum(field[:, model_dofs[0]] * normal, axis=1)[:, None] for model_dofs in (model.b, model.c))
    x, length = found.s, robot.geometry.coupler[0]
    want = -q0 * x * (length - x) / 2 - (q1 - q0) * x * (length**2 - x**2) / (6 * length)
    np.testing.assert_allclose(found.moment, want, atol=1e-12 + 1e-9 * np.max(np.abs(want)))
    place = found.s[np.unravel_index(np.argmax(np.abs(found.bending)), found.bending.shape)[1]]
    assert 0.4 * length < place < 0.7 * length  # mid-span, where end rotations alone see nothing
    assert np.max(np.abs(found.bending)) == pytest.approx(
        np.max(np.abs(want)) * 0.02 / (np.pi * 0.04**4 / 64), rel=1e-9
    )


@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("damping", [{}, {"stiffness": 1e-4}, {"mass": 20.0}], ids=["none", "stiffness", "mass"])
def test_hinges_carry_no_moment_in_vibration(
    robot: Robot, branch: AssemblyBranch, count: int, beam: str, damping: dict[str, float]
) -> None:
    """Started from rest, whatever the elements: where a rod is hinged its bending stress is nothing."""
    model = FiniteElementModel(changed(robot, model={"elements": count, "beam": beam}, damping=damping))
    shaken = link_stress(model, recursion(model, branch, np.linspace(0.0, 0.02, 101)))
    for crank, coupler in zip(shaken[::2], shaken[1::2], strict=True):
        for rod, ends in ((crank, [-1]), (coupler, [0, -1])):
            np.testing.assert_allclose(rod.bending[:, ends], 0.0, atol=1e-8 * np.max(np.abs(rod.bending)))


def test_stress_does_not_depend_on_the_elements(robot: Robot, branch: AssemblyBranch) -> None:
    state = branch.motion(np.linspace(0.0, robot.duration, 40))
    peaks = []
    for count in (1, 5):
        model = FiniteElementModel(changed(robot, model={"elements": count}))
        found = link_stress(model, quasi_static_response(model, state), 101 if count == 1 else 21)
        peaks.append([s.largest.max() for s in found])
    np.testing.assert_allclose(*peaks, rtol=1e-9)


def test_platform_stress_balances_its_pivots(robot: Robot, branch: AssemblyBranch) -> None:
    """Mean stress of a body is the moment of its forces r_i F_j, less the inertia's, over its volume."""
    model = FiniteElementModel(robot)
    response = quasi_static_response(model, branch.motion(np.linspace(0.0, robot.duration, 25)))
    state = response.motion
    found = platform_stress(model, response)
    stress = link_stress(model, response)
    for n in range(len(state)):
        force = np.zeros((3, 2))
        for leg in range(3):
            coupler = stress[2 * leg + 1]
            e = np.array([np.cos(state.psi[n, leg]), np.sin(state.psi[n, leg])])
            shear = np.gradient(coupler.moment[n], coupler.s, edge_order=2)[-1]
            force[leg] = -coupler.force[n, -1] * e + shear * np.array([-e[1], e[0]])
        arms = model.platform_arms(state)[n]
        virial = arms.T @ force
        spin = np.array([[-(state.dx[n, 0] ** 2), -state.ddx[n, 0]], [state.ddx[n, 0], -(state.dx[n, 0] ** 2)]])
        second = model.triangle.total_mass / 12.0 * arms.T @ arms
        virial -= second @ spin.T
        c, s = np.cos(state.x[n, 0]), np.sin(state.x[n, 0])
        turn = np.array([[c, -s], [s, c]])
        volume = abs(model.triangle.signed_area) * model.triangle.thickness
        tensor = turn.T @ virial @ turn / volume
        ours = np.array([[found.x[n], found.shear[n]], [found.shear[n], found.y[n]]])
        np.testing.assert_allclose(ours, tensor, atol=2e-3 * np.max(np.abs(tensor)) + 0.05)
        np.testing.assert_allclose([found.second[n], found.first[n]], np.linalg.eigvalsh(ours), rtol=1e-9, atol=1e-9)
        assert found.largest_shear[n] == pytest.approx(0.5 * (found.first[n] - found.second[n]))


def test_rigid_platform_has_no_stress(robot: Robot, branch: AssemblyBranch) -> None:
    model = FiniteElementModel(changed(robot, model={"platform": "rigid"}))
    with pytest.raises(InputError, match="has no stress"):
        platform_stress(model, quasi_static_response(model, branch.motion(np.zeros(1))))


@pytest.mark.slow
def test_speed_sweep_scales_and_finds_a_resonance(robot: Robot, branch: AssemblyBranch) -> None:
    low = speed_sweep(robot, branch, np.array([20.0, 40.0]), steps_per_period=8.0)
    assert low.static[1] / low.static[0] == pytest.approx(4.0, rel=1e-3)  # inertia loads grow with the square
    np.testing.assert_allclose(low.amplification, 1.0, atol=0.03)
    assert low.resonance is None
    high = speed_sweep(robot, branch, np.geomspace(180.0, 260.0, 16), steps_per_period=24.0)
    assert high.resonance is not None
    assert len(high.factors) == high.resonance + 2  # stops once it is passed
    assert high.amplification[high.resonance] > 1.5


def test_velocity_dependent_terms_grow_with_the_square_of_the_speed(robot: Robot, branch: AssemblyBranch) -> None:
    frequency, displacement = velocity_effect(robot, branch, np.array([10.0, 20.0]), poses=6)
    np.testing.assert_allclose([frequency[1] / frequency[0], displacement[1] / displacement[0]], 4.0, rtol=0.02)
    assert displacement[0] < 1e-3
