"""Identification: the values of a machine that explain measurements, and how certain they are.

| module      | content                                                                     |
|-------------|-----------------------------------------------------------------------------|
| schema      | the tables of an identification file                                        |
| load        | the file, its experiment and its data, checked: an `Identification`         |
| filters     | filters of measured and computed samples                                    |
| residuals   | measured less computed samples, and their derivatives, from one run         |
| batches     | the sum of squares of many values, from runs in a batch                     |
| curves      | outputs of a run and their derivatives at the times of samples              |
| integrals   | integrals over the first impacts, which lead the start of the fit           |
| budget      | the limit of time of a fit                                                  |
| accuracy    | the error of the runs, and runs that are accurate enough                    |
| statistics  | means, deviations and peaks of many turns, beyond the horizon               |
| algebra     | linear algebra of least squares                                             |
| search      | least squares from one start                                                |
| fit         | least squares from several starts, over windows that grow                   |
| certainty   | deviations, intervals, what is identifiable, tests of the residuals         |
| correlation | correlation of neighbouring residuals                                       |
| doubts      | warnings, mixtures of unknowns                                              |
| profile     | profile likelihood of one unknown                                           |
| posterior   | samples of the posterior by emcee                                           |
| plan        | certainty that candidate sensors would give, before any measurement         |
| writing     | results as text, and as an experiment                                       |
| result      | the result as data, the content of ``result.json``                          |
| content     | the fields of a result that follow from a fit                               |
| identify    | all of it                                                                   |
| numerics    | numbers that tune identification, with unit and effect                       |
"""
