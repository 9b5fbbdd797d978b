"""One run: the equations of motion, their Jacobian, integrators, states and outputs at any time.

| module     | responsibility                                                                       |
|------------|--------------------------------------------------------------------------------------|
| model      | a system as named tuples of plain arrays                                             |
| methods    | one attempted step, by the implicit or the explicit method                           |
| equations  | equations of motion, driven coordinates eliminated: accelerations; balance of forces |
| jacobian   | their Jacobian: exact mechanics, partial derivatives of the contacts' laws           |
| linear     | the equations of motion linearised about a state at rest                             |
| binding    | integrators and equations bound together: runs, and states between their steps       |
| replay     | states between steps, by stepping there again; back onto closed loops after a step   |
| kinks      | steps divided where the slope of a contact's force jumps                             |
| sampling   | outputs at any times of a run                                                        |
| runner     | `Runner`: a system as an object that runs                                            |
| job        | numbers of one design, and the arrays that a run and its statistics work on          |
"""
