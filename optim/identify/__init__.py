"""Identification: the values of a machine that explain measurements, and how certain they are.

| module     | content                                                                     |
|------------|-----------------------------------------------------------------------------|
| schema     | the tables of an identification file                                        |
| load       | the file, its experiment and its data, checked: an `Identification`         |
| residuals  | measured less computed samples, and their derivatives, from one run         |
| batches    | the sum of squares of many values, from runs in a batch                     |
| impacts    | times and peaks of the first impacts, which lead the start of the fit       |
| statistics | means, deviations and peaks of many turns, beyond the horizon               |
| fit        | least squares from several starts, over windows that grow                   |
| certainty  | deviations, intervals, what is identifiable, tests of the residuals         |
| profile    | profile likelihood of one unknown                                           |
| posterior  | samples of the posterior by emcee                                           |
| plan       | certainty that candidate sensors would give, before any measurement         |
| writing    | results as text, and as an experiment                                       |
| identify   | all of it; the content of ``result.json``                                   |
"""
