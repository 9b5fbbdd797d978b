"""Work on a study through evaluations and the store: solve, resume, verify, find the variables that matter.

| module       | responsibility                                                               |
|--------------|------------------------------------------------------------------------------|
| optimise     | `optimise`: a study solved; a result can start another study                 |
| task         | what an algorithm is asked: settings, seed, identity of the study            |
| result       | the result as data, the content of ``result.json``                           |
| recorder     | evaluations and iterations in a store: stopped at any moment, resumed by replay |
| known_designs | evaluations by design, in little memory                                     |
| verification | an optimum run again: on Drake, more tightly, from unseen starts             |
| derivative_check | sensitivities of runs against differences of designs                     |
| tolerances   | `tolerances`: machines of a study with ``[scatter]``, judged by its constraints |
| sampled_machines | machines of such a study, run until there are enough                    |
| tolerance_result | the result of such a study as data, the content of ``tolerances.json``    |
| tolerance_statistics | intervals, shares of the variance, yields of narrower tolerances       |
| rare_limits  | shares beyond limits that hardly any machine exceeds, and what remains unknown |
| rare_shares  | subset simulation, importance sampling, FORM on normal numbers               |
| numerics     | numbers that tune searches, samples and checks                               |
| sensitivity  | Sobol's indices, one variable at a time                                      |
"""
