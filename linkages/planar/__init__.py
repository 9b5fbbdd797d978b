"""Planar multibody kernels shared by the assembly and both engines.

| module     | what it holds                                                                    |
|------------|----------------------------------------------------------------------------------|
| records    | the plain arrays that describe a tree, its cut joints, its journals               |
| topology   | `Tree`: a mechanism's spanning tree, which joints are cut, names of coordinates   |
| kinematics | positions, velocities and accelerations of all bodies, and of the closure rows    |
| dynamics   | articulated-body dynamics with prescribed joints, loop reactions                  |
| driven     | generalised forces of loads, drives and loops, for a simulator of all coordinates |
| clearance  | clearance joints in a tree: from body states to force pairs                       |
| loads      | applied forces, torques and springs: from body states to wrenches, their tangent |
| closure    | Newton's method on the closure rows: assembly, consistent rates and accelerations |
| reactions  | all joint reactions by Newton-Euler on free bodies                                |

Body frames are at the joint that carries the body and parallel to the plane axes in the drawn
configuration. Body 0 is the world. Wrenches on a body are (moment about its frame's origin, fx, fy).
"""
