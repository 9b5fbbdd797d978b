from __future__ import annotations

import numpy as np
import pytest

from linkages.input.files.shipped import data_folder
from linkages.three_rrr.analysis import RobotResults, analyse
from linkages.three_rrr.branch import AssemblyBranch, follow, start_assembly
from linkages.three_rrr.kinematics import RobotMotion
from linkages.three_rrr.robot import Robot, load_robot


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot(data_folder() / "three_rrr.toml")


@pytest.fixture(scope="session")
def branch(robot: Robot) -> AssemblyBranch:
    start = start_assembly(robot.geometry, robot.phi0, np.deg2rad(98.05))
    return follow(robot.geometry, robot.cranks, start, robot.duration)


@pytest.fixture(scope="session")
def poses(branch: AssemblyBranch, robot: Robot) -> RobotMotion:
    return branch.motion(np.linspace(0.0, robot.duration, 13))


@pytest.fixture(scope="session")
def results(robot: Robot) -> RobotResults:
    return analyse(robot)
