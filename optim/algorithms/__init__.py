"""Algorithms of mathematical optimisation: they see bounds and a function of populations (`nlp`), never a linkage.

| module          | responsibility                                                                   |
|-----------------|----------------------------------------------------------------------------------|
| nlp             | `Problem`, `Values`, `Progress`, `Result`, `Ending`                              |
| registry        | all algorithms by name; several starts of the local ones                         |
| archive         | every design of a run, none evaluated twice; order by feasibility; first designs |
| pareto          | domination, fronts, hypervolume, knee                                            |
| derivatives     | differences                                                                      |
| ga              | genetic algorithms on pygad: one objective, several (NSGA-II)                    |
| evolution       | differential evolution, SciPy's                                                  |
| snopt           | sequential quadratic programming, Drake's SNOPT                                  |
| gradient        | generalised reduced gradient, with a quadratic model                             |
| standard_form   | its problem: scaled, with slacks, in two phases; basic and nonbasic variables    |
| line_search     | how far along a step, with its return to the constraints                         |
| quadratic_model | minimum of the quadratic model within bounds, and its update                     |
| curvature       | second-order condition: a maximum or a saddle is left                            |
| numerics        | numbers that tune them and are no settings, with unit and effect                 |
"""
