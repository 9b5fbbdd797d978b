"""Agreement with Drake's rigid plant."""

from __future__ import annotations

import numpy as np
import pytest

from linkages.input.model.mechanism import load_mechanism
from linkages.three_rrr.branch import AssemblyBranch, follow
from linkages.three_rrr.direct import assemblies
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion, motion
from linkages.three_rrr.robot import Robot, changed
from linkages.three_rrr.verify import RigidPlant, verify

OPTIONS = {
    "as shipped": {},
    "refined": {"model": {"elements": 4}},
    "joint masses": {"joint_masses": {"B": 0.3, "C": 0.5}},
    "aluminium": {"material": {"youngs_modulus": 7.1e10, "density": 2770.0}},
}


@pytest.mark.slow
@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_everything_agrees_with_drake(robot: Robot, options: dict) -> None:
    for x in assemblies(robot.geometry, robot.phi0).x:
        branch = follow(robot.geometry, robot.cranks, x, robot.duration)
        found = verify(changed(robot, **options), branch.motion(np.linspace(0.0, robot.duration, 13)))
        assert found.zero_modes == 3
        assert found.failed == ()
        assert found.zero_eigenvalue <= 1e-10
        assert found.principal_angle <= 1e-10
        assert found.mass_error <= 1e-10
        for name in ("position", "velocity", "acceleration", "torque"):
            assert getattr(found, name) <= 1e-9


def test_drives_with_acceleration_agree_with_drake(robot: Robot, branch: AssemblyBranch) -> None:
    """Accelerating drives, which no experiment has, exercise every term of the accelerations."""
    state = branch.motion(np.linspace(0.0, robot.duration, 9))
    pushed = np.random.default_rng(2).normal(size=state.phi.shape) * 5.0
    fast = motion(robot.geometry, state.time, state.phi, 8.0 * state.dphi, pushed, state.x)
    found = verify(robot, fast)
    assert max(found.position, found.velocity, found.acceleration, found.torque) <= 1e-9


def test_the_sdf_file_has_the_masses_of_the_robot_file(robot: Robot) -> None:
    mechanism = load_mechanism(robot.mechanism_path)
    for key, value in robot.rigid_properties().items():
        _, link, quantity = key.split(".", 2)
        if quantity in ("mass", "inertia"):
            assert getattr(mechanism.link[link], quantity) == pytest.approx(value, rel=1e-12)
        else:
            assert mechanism.link[link].com_local["xyz".index(quantity[-1])] == pytest.approx(value, abs=1e-15)


def test_a_wrong_mass_or_motion_is_noticed(robot: Robot, poses: RobotMotion) -> None:
    one = poses.part(slice(2, 3))
    plant = RigidPlant(robot)
    plant.solve(one.phi[0], one.dphi[0], one.ddphi[0], {"coupler1": 0.0, "platform": 1.5} | _couplers(one))
    space = plant.velocity_space()
    heavy = FiniteElementModel(changed(robot, drives={"roots": "free"}, material={"density": 7851.0}))
    rigid = plant.nodal_jacobian(heavy) @ space
    drake = space.T @ plant.plant.CalcMassMatrix(plant.context) @ space
    error = np.max(np.abs(rigid.T @ heavy.full_matrices(one)[1][0] @ rigid - drake)) / np.max(np.abs(drake))
    assert error == pytest.approx(1.0 / 7850.0, rel=1e-6)


def _couplers(state: RobotMotion) -> dict[str, float]:
    return {f"coupler{leg}": float(state.psi[0, leg - 1]) for leg in (1, 2, 3)}
