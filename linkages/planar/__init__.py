"""Planar multibody kernels on plain arrays; they may import laws, integrators and the compiler.

| module           | responsibility                                                                    |
|------------------|-----------------------------------------------------------------------------------|
| records          | the plain arrays that describe bodies, markers, closure rows, contacts, loads     |
| markers          | points fixed to bodies: where they are, how they move, what a force at them does  |
| motion           | prescribed motions and torques over time                                          |
| kinematics       | positions, velocities and accelerations of all bodies, and of the closure rows    |
| dynamics         | articulated-body dynamics with prescribed joints, loop reactions                  |
| driven           | forces of loads, drives and loops, for a simulator of all coordinates             |
| contacts         | joints with play: from body states to force pairs, by the laws                    |
| contact_partials | partial derivatives of a contact's force                                          |
| loads            | applied forces, torques, springs: from body states to wrenches, their derivative  |
| tangent          | exact derivatives of kinematics and of the balance of forces                      |
| closure          | Newton's method on the closure rows; consistent rates and accelerations           |
| ideal            | the ideal linkage at the time and near the state of a run                         |
| reactions        | forces in all joints, efforts of all drives                                       |

Body frames are at the joint that carries the body and parallel to the plane axes in the drawn
configuration. Body 0 is the world. Wrenches on a body are (moment about its frame's origin, fx, fy).
"""
