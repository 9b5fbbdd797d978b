"""Design optimisation of linkages: problems in files, algorithms, a store of every evaluation.

| module        | responsibility                                                                             |
|---------------|--------------------------------------------------------------------------------------------|
| nlp           | what an algorithm sees: bounds, a function of whole populations, what it returns           |
| archive       | every design of a run, none evaluated twice; order by the rules of feasibility             |
| derivatives   | differences, one population for a whole Jacobian                                           |
| algorithms    | all of them by name; several starts of the local ones                                      |
| ga            | genetic algorithms on pygad: one objective, several (NSGA-II)                              |
| evolution     | differential evolution, SciPy's                                                            |
| snopt         | sequential quadratic programming, Drake's SNOPT                                            |
| pareto        | domination, fronts, hypervolume, knee                                                      |
| gradient      | generalised reduced gradient method                                                        |
| standard_form | its problem: scaled, slacks, the partition in basic and nonbasic variables                 |
| phases        | what it minimises: violations first, then the objective                                    |
| line_search   | how far along a step                                                                       |
| restoration   | its way back to the constraints, exchanges of basic variables                              |
| quadratic     | its model: minimum within bounds, quasi-Newton update                                      |
| schema        | the tables of a study file                                                                 |
| problem       | study file -> `Study`, checked against experiment and mechanism                            |
| formula       | arithmetic on names, parsed, never executed                                                |
| nominal       | the value that a dotted path has in an experiment                                          |
| outputs       | which outputs of a run a functional can look at                                            |
| evaluate      | designs -> runs -> objectives and constraints; failures are explicit                       |
| batches       | runs of some designs at one operating point: what engines are asked for and answer         |
| limits        | what algorithms see of them: all to be minimised, violations relative to their limits      |
| screen        | designs that are not run: formulas say that they are infeasible                            |
| ideal_runs    | outputs of the linkage without clearance, which need no run                                |
| evaluations   | what designs are worth, or why there are no values                                         |
| cluster       | an executor on a Dask cluster                                                              |
| study         | the store of every evaluation and iteration, in SQLite                                     |
| sqlite        | files of SQLite that can be trusted                                                        |
| files, lock   | files written whole or not at all; one process at a time                                   |
| run           | an algorithm over a store: stopped at any moment, gone on with by replay                   |
| task          | a study, an algorithm and a seed as a task for `run`                                       |
| trust         | an optimum run again: more tightly, on Drake, from unseen starts                           |
| drake_runs    | runs on Drake, as statistics like the batch engine's                                       |
| sensitivity   | which variables matter: Sobol's indices, one variable at a time                            |
| result        | ``result.json``; table, show and export: the same for readers                              |
| observe       | progress bar and figure of the convergence; interrupt: Ctrl-C                              |
| figures       | matplotlib: convergence, front; sensitivity_figures: indices; figures_replication: sources |
| press_paper   | the press paper's printed numbers and the runs beside them                                 |
| press_claims  | claim by claim; press_designs: those of its optima                                         |
| patent_claims | the four-bar patent's claims, its optimum and the runs beside them                         |
| recorded      | designs that a search found, kept with where they come from                                |
| replication   | published results beside ours, as a page                                                   |
| commands      | ``linkages optimise`` and ``linkages study``                                               |
| data          | where the shipped studies are                                                              |
| versions      | of the packages that determine the numbers                                                 |

`linkages` never imports this package; its commands reach the command line through entry points.
"""
