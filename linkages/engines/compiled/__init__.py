"""The compiled engine: the same mechanisms and laws as Drake's, a thousand times faster, for batches of runs.

It may import whatever lies below the engines, and not the Drake engine.

| module      | responsibility                                                                                |
|-------------|-----------------------------------------------------------------------------------------------|
| run         | one run: the equations of motion, their Jacobian, integrators, states and outputs at any time |
| batch       | many runs of one system with different values, in parallel threads, and their statistics      |
| derivatives | derivatives of a finished run with respect to values                                          |
| effects     | values that change no number of a run, and the path that acts instead                         |
| simulation  | `simulate`: a run as a `linkages.Trajectory`                                                  |
| stepping    | `linkages.Stepper`: steps of any lengths with inputs, for closed loops of users' own          |
"""
