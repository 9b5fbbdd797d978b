"""Planar multibody kernels on plain arrays; they may import laws, integrators and the compiler.

| module            | responsibility                                                                    |
|-------------------|-----------------------------------------------------------------------------------|
| record_types      | records of bodies, markers, closure rows, contacts, loads, joints                 |
| arrays            | `Arrays`: what kernels read of a system                                           |
| bodies            | `Bodies`: records and shapes of a tree's bodies                                   |
| workspace         | `Workspace`: arrays of one evaluation of the dynamics                             |
| markers           | points fixed to bodies: where they are, how they move, what a force at them does  |
| jets              | arithmetic with values and their first two derivatives                            |
| motion            | functions of time and of the state: tables and formulas                           |
| kinematics        | positions, velocities and accelerations of all bodies, and of the closure rows    |
| bending           | what modal coordinates of links that bend add to kinematics and dynamics          |
| dynamics          | articulated-body dynamics with prescribed joints, loop reactions                  |
| projection        | positions and rates moved to where ideal loops are closed                         |
| passage           | accelerations through singular positions                                          |
| driven            | forces of loads, drives and loops, for a simulator of all coordinates             |
| contacts          | joints with play: from body states to force pairs, by the laws                    |
| contact_partials  | partial derivatives of a contact's force                                          |
| tangent_workspace | `Scratch`: arrays of a Jacobian and of directional derivatives                    |
| loads             | applied forces, torques, springs: from body states to wrenches, their derivative  |
| tangent           | exact derivatives of kinematics and of the balance of forces                      |
| bending_tangent   | the same of what modal coordinates add                                            |
| closure           | Newton's method on the closure rows; consistent rates and accelerations           |
| ideal             | the ideal linkage at the time and near the state of a run                         |
| internal_forces   | axial force, bending moment and stress within links that bend                     |
| beam_deflection   | deflections of links that bend, and the largest along them                        |
| reactions         | forces in all joints, efforts of all drives                                       |

Arguments have the same names everywhere:

| name                               | shape   | what it is                                                        |
|------------------------------------|---------|-------------------------------------------------------------------|
| ``bodies``                         |         | `Bodies`                                                          |
| ``rows, ends, joints``             |         | arrays of records                                                 |
| ``q, v, a, tau``                   | (n,)    | coordinates, rates, accelerations, generalised forces             |
| ``pose``                           | (nb, 5) | x, y [m] and angle [rad] of body frames, its cosine and sine      |
| ``vel, acc``                       | (nb, 3) | angular velocity and velocity of the frame's origin; their rates  |
| ``wrench, load``                   | (nb, 3) | moment about the frame's origin [N m] and force [N]               |
| ``dpose, dvel, ...``               |         | the change of what follows the d, see `tangent`                   |

Arrays that a function fills are its last arguments.

Where bodies bend, lines of the last three arrays are longer: `linkages.planar.bodies`.

Body frames are at the joint that carries the body and parallel to the plane axes in the drawn
configuration. Body 0 is the world. Wrenches on a body are (moment about its frame's origin, fx, fy).
"""
