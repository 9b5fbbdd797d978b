"""Results of a study for readers: text, tables, files, figures (matplotlib is imported here alone).

| module            | responsibility                                                     |
|-------------------|--------------------------------------------------------------------|
| result            | ``result.json``, and the same as text; several results as a table  |
| tolerance_text    | ``tolerances.json`` as text                                        |
| tolerance_figures | histograms, influence, contributions of tolerances                 |
| tables            | tables of studies for reports, as data                             |
| export            | a store as text, CSV or Parquet                                    |
| observe           | progress bar and convergence while an algorithm runs               |
| figures           | convergence, Pareto front                                          |
| shares            | Sobol's indices, one variable at a time                            |
| identification    | fits, correlations, windows and profiles of an identification      |
"""
