"""Elastodynamics of a planar 3-RRR parallel robot with flexible links, and its rigid kinematics.

The source is Lu, Shi, Gao and Dan, "Elastic-dynamics of planar flexile parallel mechanism", Transactions of
the Chinese Society for Agricultural Machinery 41(6), 2010, pp. 208-215 ("the paper"); equation numbers are
its own.

| module      | responsibility                                                                            |
|-------------|-------------------------------------------------------------------------------------------|
| geometry    | base, platform, crank and coupler lengths, from the SDFormat mechanism                    |
| robot       | TOML file -> `Robot`: sections, material, drives, model options                           |
| kinematics  | loops, Jacobians, velocities, accelerations, inverse kinematics                           |
| direct      | every assembly, from a trigonometric polynomial of degree three; exact count of its roots |
| branch      | one assembly followed over time; folds and singularities; travel                          |
| maps        | assembly counts and singularities over the drive angles                                   |
| elements    | beam (Euler-Bernoulli, Timoshenko), chains of beams, constant-strain triangle             |
| turning     | body angles and matrices that turn with them                                              |
| model       | mass and stiffness matrices of the robot for any pose, rigid fields, inertia loads        |
| rotating    | velocity-dependent terms: gyroscopic, centrifugal, geometric stiffness                    |
| modes       | natural frequencies and shapes, dense or sparse, followed by MAC                          |
| response    | quasi-static, the paper's recursion, generalised-alpha                                    |
| stress      | stress along each link and in the platform                                                |
| sweep       | the response against the drives' speed                                                    |
| verify      | comparison with Drake's rigid plant; the only module here that may import it              |
| study       | everything about one robot on one branch                                                  |
| figures     | the paper's figures 5-12; figures_more: maps, convergence, speed; drawing: the robot      |
| animation   | a mode over the moving pose, as HTML                                                      |
| replication | the paper's printed numbers beside ours                                                   |

Conventions: SI units, plane axes x, y as in the paper (origin at the base's centre in the shipped machine).
Leg r has the pivots A_r (base), B_r (crank - coupler), C_r (coupler - platform). phi_r is the angle of A_r
B_r, psi_r of B_r C_r, theta of the platform, all absolute, counter-clockwise from x. A platform position is
the row (theta, x, y), as in the paper. Elastic displacements are small, in plane axes, relative to the
rigid motion. Arrays over poses have the pose as their first axis.
"""
