"""Evaluation of designs: runs through the engines of `linkages`, objectives, constraints, explicit failures.

| module      | responsibility                                                                     |
|-------------|------------------------------------------------------------------------------------|
| evaluations | `Evaluations`: numbers of designs, or why there are none                           |
| requests    | `Request`, runs of some designs at one operating point; `Statistics`, its answer   |
| ideal_runs  | outputs of the linkage without clearance                                           |
| life_runs   | service lives of designs: cycles until a quantity exceeds its limit                 |
| drake_runs  | requests answered by Drake                                                         |
| evaluator   | `Evaluator`: designs -> requests -> evaluations                                    |
| gradients   | `Gradients`: derivatives by sensitivities of runs                                  |
| limits      | evaluations -> the mathematical problem that algorithms see                        |
| screen      | `Screened`: designs that formulas exclude are not run                              |
| cluster     | an executor on a Dask cluster                                                      |
"""
