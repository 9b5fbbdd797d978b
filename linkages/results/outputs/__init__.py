"""One registry of named outputs: name, unit, meaning, owner and kernel; computes numbers from states.

| module          | responsibility                                                 |
|-----------------|----------------------------------------------------------------|
| quantity        | an output: quantity, formula, record, snapshot                 |
| bodies          | motion of points; coordinates; flexible links; energies        |
| contacts        | clearance joints, guides, contacts of elements                 |
| joints          | forces in joints, drives, loads                                |
| elements        | the outputs that elements declare                              |
| states          | additional states, motors, controllers                   |
| registry        | outputs of a system by name, their units, the record of each   |
| evaluation      | all outputs at states, in compiled code                        |
| columns         | outputs over time, from the states of a run or an ideal motion |
"""
