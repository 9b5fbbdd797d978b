"""The compiled engine: the same mechanisms and laws as Drake's, a thousand times faster, for batches of runs.

It may import whatever lies below the engines, and not the Drake engine.

| module              | responsibility                                                                               |
|---------------------|----------------------------------------------------------------------------------------------|
| model               | a system as named tuples of plain arrays                                                     |
| methods             | one attempted step, by the implicit or the explicit method                                   |
| equations           | equations of motion, driven coordinates eliminated: accelerations; balance of forces         |
| jacobian            | their Jacobian: exact mechanics, partial derivatives of the contacts' laws                   |
| linear              | the equations of motion linearised about a state at rest                                     |
| projection          | back onto the closure of ideal loops after each step                                         |
| binding             | integrators and equations bound together: runs, and states between their steps               |
| replay              | states between steps, by stepping there again                                                |
| variation           | a model that follows values, and the derivatives of its numbers                              |
| contact_changes     | changes of contacts' laws with values, and of their results along columns                    |
| forcing             | derivatives of the equations with respect to values and to what contacts remember            |
| kinks               | steps divided where the slope of a contact's force jumps                                     |
| step_derivatives    | a step of a run, differentiated                                                              |
| event_derivatives   | start and end of a contact, differentiated                                                   |
| run_derivatives     | a run, differentiated at its steps and at any times                                          |
| neighbours          | systems at neighbouring values, and derivatives of their numbers                             |
| start_derivatives   | derivatives of the state at t = 0                                                            |
| output_derivatives  | derivatives of outputs                                                                       |
| sensitivity         | `differentiate`: derivatives of a finished run                                               |
| statistics          | extremes, mean and rms of outputs over windows, values at their ends                         |
| runner              | `Runner`: a system as an object that runs                                                    |
| simulation          | `simulate`: a run as a `linkages.Trajectory`                                                 |
| job                 | numbers of one design, and the arrays that a run and its statistics work on                  |
| rows                | runs and statistics of many designs in one call of compiled code                             |
| designs             | the designs of a batch as numbers                                                            |
| runs                | `Runs`: runs of many designs in parallel threads                                             |
| batch_derivatives   | derivatives of the statistics of many runs                                                   |
| batch               | `simulate_batch`: summaries of many runs                                                     |
"""
