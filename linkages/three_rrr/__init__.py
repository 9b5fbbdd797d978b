"""The planar 3-RRR parallel robot: rigid kinematics, and elastodynamics with the elements of `flexible`.

It reads mechanisms through `linkages.input.model` and draws nothing; `verify` alone imports the Drake engine. The
source is Lu, Shi, Gao and Dan, "Elastic-dynamics of planar flexile parallel mechanism", Transactions of the Chinese
Society for Agricultural Machinery 41(6), 2010, pp. 208-215 ("the paper"); equation numbers are its own.

| module          | responsibility                                                                            |
|-----------------|-------------------------------------------------------------------------------------------|
| geometry        | base, platform, crank and coupler lengths, from the SDFormat mechanism                    |
| robot           | TOML file -> `Robot`: sections, material, drives, load, options                           |
| kinematics      | loops, Jacobians, velocities, accelerations, inverse kinematics                           |
| direct          | every assembly, from a polynomial of degree three, its roots counted; maps of assemblies  |
| branch          | one assembly followed over time; folds and singularities; travel                          |
| finite_elements | mass and stiffness matrices in any pose, rigid fields, inertia loads, velocity terms      |
| modes           | natural frequencies and shapes over poses, followed by MAC                                |
| response        | quasi-static, the paper's recursion, generalised-alpha                                    |
| stress          | stress along each link and in the platform                                                |
| vibration       | extremes of the response and of stress over the whole motion                              |
| analysis        | all of these for one robot on one branch                                                  |
| speed           | the response against the drives' speed                                                    |
| verify          | comparison with Drake's rigid plant                                                       |

Conventions: SI units, plane axes x, y as in the paper (origin at the base's centre in the shipped machine). Leg r has
the pivots A_r (base), B_r (crank to coupler) and C_r (coupler to platform). phi_r is the angle of A_r B_r, psi_r of
B_r C_r, theta of the platform, all absolute, counter-clockwise from x. A platform position is the row (theta, x, y), as
in the paper. Elastic displacements are small, in plane axes, relative to the rigid motion. Arrays over poses have the
pose as their first axis.
"""

from linkages.three_rrr.analysis import analyse
from linkages.three_rrr.branch import follow
from linkages.three_rrr.direct import drive_map
from linkages.three_rrr.robot import changed, load_robot
from linkages.three_rrr.speed import speed_sweep
from linkages.three_rrr.vibration import vibrate

__all__ = ["analyse", "changed", "drive_map", "follow", "load_robot", "speed_sweep", "vibrate"]
