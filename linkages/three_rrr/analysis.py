"""Analysis of one robot on one branch: motion, modes, quasi-static response, stress."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from linkages.base.arguments import Count, validated
from linkages.base.arrays import Array
from linkages.three_rrr.branch import AssemblyBranch, follow, start_assembly
from linkages.three_rrr.direct import Assemblies, assemblies
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion, loop_errors
from linkages.three_rrr.modes import DENSE, frequencies, modes, tracked_modes
from linkages.three_rrr.response import Response, quasi_static_response
from linkages.three_rrr.robot import Robot, changed
from linkages.three_rrr.stress import LinkStress, link_stress
from linkages.three_rrr.vibration import Vibration

POSES = 361
TRACKED = 6  # modes that are followed and drawn
_SPARE = 4  # additional modes for crossings


@dataclass(frozen=True)
class RobotResults:
    """Results over one motion at N poses; made by `analyse`.

    Attributes
    ----------
    robot : Robot
    model : FiniteElementModel
        With locked roots, or with servos if the robot has them.
    assemblies : Assemblies
        All assemblies at t = 0.
    branch : AssemblyBranch
        The assembly, followed over time.
    motion : RobotMotion
        Rigid motion at the poses.
    loop_error : float
        Largest error of the loop equations [m].
    frequencies : (N, n) array
        Natural frequencies at each pose, rising [Hz].
    tracked, shapes, mac : arrays
        Frequencies [Hz], shapes and modal assurance criteria of the modes followed from the first pose, see
        `linkages.mechanics.flexible.modes.track`.
    free : (N, m) array
        The lowest frequencies with free roots [Hz]: the paper's 24 numbers, the three zeros of the rigid motion among
        them.
    static : Response
        Quasi-static response.
    stress : list of LinkStress
        Quasi-static stress of each link.
    dynamic : Vibration or None
        The response with vibration, if requested.
    """

    robot: Robot
    model: FiniteElementModel
    assemblies: Assemblies
    branch: AssemblyBranch
    motion: RobotMotion
    loop_error: float
    frequencies: Array
    tracked: Array
    shapes: Array
    mac: Array
    free: Array
    static: Response
    stress: list[LinkStress]
    dynamic: Vibration | None = None


@validated
def analyse(robot: Robot, progress: Callable[[float], None] | None = None, poses: Count = POSES) -> RobotResults:
    """Follow the robot's branch (`robot.branch`, or the first assembly) and compute everything along it.

    A branch that ends at a fold is analysed up to nearly there. BranchError if there is no such assembly.
    """
    found = assemblies(robot.geometry, robot.phi0)
    theta = None if robot.branch is None else float(np.deg2rad(robot.branch))
    start = start_assembly(robot.geometry, robot.phi0, theta)
    branch = follow(robot.geometry, robot.cranks, start, robot.duration).trimmed()
    state = branch.motion(np.linspace(0.0, branch.times[-1], poses))
    held = changed(robot, drives={"roots": "locked"}) if robot.drives.roots == "free" else robot
    model = FiniteElementModel(held)
    count = model.size if model.size <= DENSE else 24
    values, shapes = modes(model, state, count, progress)
    followed = shapes[:, :, : TRACKED + _SPARE]
    tracked, forms, quality = tracked_modes(model, branch, state, values, followed, TRACKED)
    loose = FiniteElementModel(changed(robot, drives={"roots": "free"}))
    free = frequencies(loose, state, TRACKED + 3)
    static = quasi_static_response(model, state)
    stress = link_stress(model, static)
    error = float(np.max(np.abs(loop_errors(robot.geometry, state.phi, state.x))))
    return RobotResults(held, model, found, branch, state, error, values, tracked, forms, quality, free, static, stress)
