"""Planar multibody kernels on plain arrays; they may import laws, integrators and the compiler.

| module                | responsibility                                                                       |
|-----------------------|--------------------------------------------------------------------------------------|
| record_types          | records of bodies, markers, closure rows, contacts, loads, joints                    |
| arrays                | `Arrays`: the constant model that kernels read                                       |
| bodies                | `Bodies`: records and shapes of the bodies; layout of their poses                    |
| workspace             | `Workspace`: the data that an evaluation of the dynamics fills                       |
| traversal             | forward and backward passes over the tree                                            |
| markers               | points fixed to bodies: positions, velocities, accelerations, forces                 |
| jets                  | arithmetic with values and their first two derivatives                               |
| motion                | functions of time and of the state: tables and formulas                              |
| kinematics            | positions, velocities and accelerations of bodies; propagation of forces             |
| closure_rows          | values, rates, accelerations and reactions of closure rows                           |
| deformable_kinematics | kinematics of deformable bodies and their nodes                                      |
| deformable_dynamics   | inertias, elimination of shapes, forces and energy of deformable bodies              |
| newton_euler          | recursive Newton-Euler algorithm: inverse dynamics, force residual                   |
| composite_inertia     | composite rigid body algorithm: mass matrix                                          |
| articulated_body      | articulated-body algorithm: forward dynamics of the tree, response to forces         |
| elimination           | sparse elimination of the closure rows' reactions                                    |
| loop_dynamics         | forward dynamics with the reactions of cut ideal joints; projection onto closed loops |
| singularities         | forward dynamics near singularities; forces of drives and loops for a simulator      |
| contacts              | clearance joints: from body states to force pairs, by the laws                       |
| contact_memory        | what contacts remember: latched states, states of laws, cells of films               |
| contact_partials      | partial derivatives of a contact's force                                             |
| functions             | values of formulas and tables at a state of the motion                               |
| loads                 | frictions in ideal joints: wrenches; additional states                               |
| closure               | Newton's method on the closure rows; consistent rates; the ideal linkage near a run  |
| reactions             | forces in all joints, efforts of all drives                                          |
| reactive_loads        | loads that depend on the forces in joints, as friction does                          |

Arguments have the same names everywhere:

| name                               | shape   | quantity                                                          |
|------------------------------------|---------|-------------------------------------------------------------------|
| ``bodies``                         |         | `Bodies`                                                          |
| ``rows, ends, joints``             |         | arrays of records                                                 |
| ``q, v, a, tau``                   | (n,)    | coordinates, rates, accelerations, generalised forces             |
| ``pose``                           | (nb, 5) | x, y [m] and angle [rad] of body frames, its cosine and sine      |
| ``vel, acc``                       | (nb, 3) | angular velocity and velocity of the frame's origin; their rates  |
| ``wrench, bias``                   | (nb, 3) | moment about the frame's origin [N m] and force [N]               |
| ``work``                           |         | `Workspace`                                                       |
| ``gravity``                        | (2,)    | in plane axes [m/s2]                                              |
| ``elimination``                    |         | `Elimination` of the rows' reactions                              |
| ``size``                           |         | length of the linkage [m], the scale of tolerances                |
| ``free``                           | (nf,)   | coordinates that may move                                         |
| ``offset``                         | (nr,)   | required values of the rows [m, rad]; zero closes the joints      |

A function that fills arrays has them as its last arguments. If any body is deformable, lines of poses are longer:
`linkages.mechanics.planar.bodies`.

Body frames are at the joint that carries the body; in the reference configuration they are parallel to the plane axes.
Body 0 is the world.
"""
