"""Elements of machines: one module for each kind, with everything that the package knows of it.

| module            | responsibility                                                                         |
|-------------------|----------------------------------------------------------------------------------------|
| element           | the duties of a kind                                                                   |
| machine           | the elements of a machine in arrays; one compiled loop for each kind                   |
| load_function     | the part that forces and torques share: constant, table, formula, or signal of a file  |
| drive             | a drive of a joint: a prescribed motion, a torque, a force                             |
| flexible_link     | a flexible link                                                                        |
| flexible          | its substructures, internal forces, and the limits of its model                        |
| force             | a force at a point of a link                                                           |
| torque            | a torque on a link or in a joint                                                       |
| spring            | a spring and a damper between two points                                               |
| torsion_spring    | a spring and a damper along a joint's coordinate, or along the angle between two links |
| state             | an additional state: a formula of its rate or of its next value                        |
| motor             | a motor that turns a revolute joint                                                    |
| controller        | PID, or a function in Python                                                           |
| friction          | friction in an ideal joint                                                             |
| stop              | a limit of a joint's coordinate                                                        |
| touch             | a point at a straight line                                                             |
| gear              | a gear, belt, rack or screw                                                            |
| coupling          | a coupling of coaxial shafts                                                           |
| gearbox           | the backlash of a drive's gearbox                                                      |
| mesh              | what these three have in common                                                        |
| backlash          | their backlash: keys and flanks                                                        |
| coordinates       | what elements do to coordinates and points: couplings, contacts, pushes                |
| outputs           | outputs of elements, and where their values come from                                  |
| pictures          | pictures of elements as data                                                           |
| models            | what models of joints and links have beside: choices, substitutes on Drake             |
| validity          | rules on the validity of models in a run                                               |
| analysis          | what is done with a machine, and why an element cannot take part in it                 |
| law_tables        | tables that name a law, with the law's declared parameters                             |
| contact_tables    | tables of contact and friction                                                         |
| contact_kinds     | the contacts of a machine in arrays; one compiled loop for each kind over each duty    |
| journal           | contact: a journal in its bearing: lubricated, dry, mixed                              |
| worn              | contact: a journal and a bearing, at least one of which is worn                        |
| film_with_history | contact: a journal whose film remembers its content                                    |
| guide             | a block in its slot: four points at walls                                              |
| wall              | contact: a point at a straight wall                                                    |
| limit             | contact: a coordinate at a stop, or a gear's error at a flank of its teeth             |
"""
