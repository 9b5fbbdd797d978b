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

1. ``search.optimise.optimise``: the steps below, then the content of ``result.json``
2. ``algorithms.registry.read_settings``: the algorithm's settings, checked
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

from typing import TYPE_CHECKING

import lazy_loader

# ruff: noqa: F401 - for type checkers, what is loaded on first use below
if TYPE_CHECKING:
    from optim.algorithms.archive import Archive
    from optim.algorithms.nlp import Ending, Problem, Progress, Result, Values
    from optim.algorithms.pareto import hypervolume, knee
    from optim.algorithms.registry import ALGORITHMS, Table, minimise
    from optim.evaluate.evaluations import Evaluations
    from optim.evaluate.evaluator import Evaluator, Screened
    from optim.evaluate.gradients import Gradients
    from optim.evaluate.limits import problem_of
    from optim.identify.identify import identify
    from optim.identify.load import Identification, load_identification
    from optim.identify.plan import format_plan, plan
    from optim.identify.writing import format_identification
    from optim.problem.load import find_study, load_study
    from optim.problem.study import OperatingPoint, Study
    from optim.report.export import export
    from optim.report.figures import write_front, write_indices, write_one_at_a_time, write_pareto_front
    from optim.report.identification import write_identification
    from optim.report.result import format_result
    from optim.report.tolerance_text import format_tolerances
    from optim.search.derivative_check import check_derivatives, format_derivative_check
    from optim.search.optimise import Stopped, optimise, start_of
    from optim.search.sensitivity import format_sensitivity, sensitivity
    from optim.search.tolerances import tolerances
    from optim.search.verification import format_verification, verify
    from optim.store.store import Store, read_store

#: Modules and their public names, which are loaded on first use, so that ``import optim`` is fast.
__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "algorithms.archive": ("Archive",),
        "algorithms.nlp": ("Ending", "Problem", "Progress", "Result", "Values"),
        "algorithms.pareto": ("hypervolume", "knee"),
        "algorithms.registry": ("ALGORITHMS", "Table", "minimise"),
        "evaluate.evaluations": ("Evaluations",),
        "evaluate.evaluator": ("Evaluator", "Screened"),
        "evaluate.gradients": ("Gradients",),
        "evaluate.limits": ("problem_of",),
        "identify.identify": ("identify",),
        "identify.load": ("Identification", "load_identification"),
        "identify.plan": ("format_plan", "plan"),
        "identify.writing": ("format_identification",),
        "problem.load": ("find_study", "load_study"),
        "problem.study": ("OperatingPoint", "Study"),
        "report.export": ("export",),
        "report.figures": ("write_front", "write_indices", "write_one_at_a_time", "write_pareto_front"),
        "report.identification": ("write_identification",),
        "report.result": ("format_result",),
        "report.tolerance_text": ("format_tolerances",),
        "search.derivative_check": ("check_derivatives", "format_derivative_check"),
        "search.optimise": ("Stopped", "optimise", "start_of"),
        "search.sensitivity": ("format_sensitivity", "sensitivity"),
        "search.tolerances": ("tolerances",),
        "search.verification": ("format_verification", "verify"),
        "store.store": ("Store", "read_store"),
    },
)
