"""Elements of machines: one module for each kind, with everything that the package knows of it.

| module         | responsibility                                                                          |
|----------------|-----------------------------------------------------------------------------------------|
| element        | the duties of a kind                                                                    |
| machine        | the elements of a machine in arrays; one compiled loop for each kind                    |
| load_function  | the part that forces and torques share: constant, table, formula, or signal of a file   |
| drive          | a drive of a joint: a prescribed motion, a torque, a force                              |
| flexible_link  | a flexible link                                                                         |
| flexible       | its substructures, internal forces, and the limits of its model                         |
| force          | a force at a point of a link                                                            |
| torque         | a torque on a link or in a joint                                                        |
| spring         | a spring and a damper between two points                                                |
| torsion_spring | a spring and a damper along a joint's coordinate, or along the angle between two links  |
| state          | an additional state: a formula of its rate or of its next value                         |
| motor          | a motor that turns a revolute joint                                                     |
| controller     | PID, or a function in Python                                                            |
| friction       | friction in an ideal joint                                                              |
| stop           | a limit of a joint's coordinate                                                         |
| touch          | a point at a straight line                                                              |
| gear           | a gear, belt, rack or screw                                                             |
| coupling       | a coupling of coaxial shafts                                                            |
| gearbox        | the backlash of a drive's gearbox                                                       |
| mesh           | what these three have in common                                                         |
| backlash       | their backlash: keys and flanks                                                         |
| coordinates    | what elements do to coordinates and points: couplings, contacts, pushes                 |
| outputs        | outputs of elements, and where their values come from                                   |
| pictures       | pictures of elements as data                                                            |
| validity       | rules on the validity of models in a run                                                |
| analysis       | what is done with a machine, and why an element cannot take part in it                  |
| law_tables     | tables that name a law, with the law's declared parameters                              |
| contact_tables | tables of contact and friction                                                          |
"""
