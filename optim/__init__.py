"""Design optimisation of linkages: studies in files, algorithms, a store of every evaluation.

Each folder imports only from those above it (`algorithms` and `problem` do not know each other):

| folder     | content                                                                       |
|------------|-------------------------------------------------------------------------------|
| algorithms | mathematical optimisation: bounds and a function of populations               |
| problem    | study files, checked                                                          |
| evaluate   | designs -> runs -> objectives and constraints                                 |
| store      | the file that keeps every evaluation                                          |
| search     | a study solved, resumed, verified; which variables matter                     |
| identify   | values that explain measurements, and their certainty                         |
| report     | text, tables, figures                                                         |
| cli        | ``linkages optimise``, ``linkages tolerances`` and ``linkages study``         |

The path of ``optimise(study)``, in the order of the first calls:

1. ``search.optimise.optimise``: the steps below, then the result, ``search.result.StudyResult``
2. ``search.task.task_of``: the algorithm's settings, checked
3. ``search.recorder.recording``: the store of the study, created or opened
4. ``search.recorder.Recorder.evaluate``: designs from the store, or else by 5, each once; the nominal one first
5. ``evaluate.evaluator.Screened.__call__``: leaves out designs that formulas exclude
6. ``evaluate.evaluator.Evaluator.__call__``: runs at each operating point; objectives and constraints from them
7. ``evaluate.requests.run_compiled``: a batch of runs of the engine
8. ``evaluate.limits.problem_of``: the mathematical problem, which evaluates by 4
9. ``search.recorder.Recorder.minimise``: runs the algorithm and stores its iterations
10. ``algorithms.registry.minimise``: the algorithm by its name
11. ``algorithms.ga.genetic``: generations
12. ``algorithms.archive.Archive.__call__``: new designs of a generation, evaluated by the problem

A *study* is the content of a study file; a *problem* is its mathematical form for an algorithm; a *design* is a value
of every variable, (n,). `linkages` never imports this package; entry points add its commands to the command line.
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
