"""Evaluation of designs: runs through the engines of `linkages`, objectives, constraints, explicit failures.

| module      | responsibility                                                                     |
|-------------|------------------------------------------------------------------------------------|
| evaluations | `Evaluations`: numbers of designs, or why there are none                           |
| requests    | `Request`, runs of some designs at one operating point; `Statistics`, its answer   |
| remote      | `Dispatcher`: requests to other processes, of equal work                           |
| single_runs | runs on Drake, of the linkage without clearance, over the service life             |
| evaluator   | `Evaluator`: designs -> requests -> evaluations; `Screened`: excluded designs      |
| machines    | `Machines`: the machines of a design that scatters, combined                       |
| gradients   | `Gradients`: derivatives by sensitivities of runs                                  |
| limits      | evaluations -> the mathematical problem that algorithms see                        |
"""
