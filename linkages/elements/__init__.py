"""Elements of machines: one module for each kind, with everything that the package knows of it.

| module         | responsibility                                                                          |
|----------------|-----------------------------------------------------------------------------------------|
| element        | the duties of a kind                                                                    |
| analysis       | analyses, and why a kind cannot take part in one                                        |
| machine        | the elements of a machine in arrays; one compiled loop for each kind                    |
| load_function  | the part that forces and torques share: constant, table, formula, or signal of a file   |
| force          | a force at a point of a link                                                            |
| torque         | a torque on a link or in a joint                                                        |
| spring         | a spring and a damper between two points                                                |
| torsion_spring | a spring and a damper along a joint's coordinate, or along the angle between two links  |
| state          | an additional state: a formula of its rate or of its next value                         |
| motor          | a motor that turns a revolute joint                                                     |
| controller     | PID, or a function in Python                                                            |
"""
