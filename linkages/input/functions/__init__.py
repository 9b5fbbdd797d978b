"""Functions that an experiment gives: formulas, tables, signals from data files.

| module          | responsibility                                                                        |
|-----------------|---------------------------------------------------------------------------------------|
| definitions     | formulas and tables of time, positions, speeds and states, as programs for kernels    |
| own_quantities  | quantities of an element: formulas of its numbers and of each other                   |
| smoothing       | smooth functions of recorded signals: Fourier series, smoothing splines               |
| recorded_tables | the part of a table that takes its signal from a data file                            |
"""
