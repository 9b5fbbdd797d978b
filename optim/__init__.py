"""Design optimisation of linkages: studies in files, algorithms, a store of every evaluation.

Each folder imports only from those above it (`algorithms` and `problem` do not know each other):

| folder     | what lives there                                                              |
|------------|-------------------------------------------------------------------------------|
| algorithms | mathematical optimisation: bounds and a function of populations               |
| problem    | study files, checked                                                          |
| evaluate   | designs -> runs -> objectives and constraints                                 |
| store      | the file that keeps every evaluation                                          |
| search     | a study solved, resumed, verified; which variables matter                     |
| report     | text, tables, figures                                                         |
| cli        | ``linkages optimise`` and ``linkages study``                                  |

A *study* is what a study file says; a *problem* is what an algorithm sees of it; a *design* is a value of every
variable, (n,). `linkages` never imports this package; its commands reach the command line through entry points.
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
    from optim.evaluate.evaluator import Evaluator
    from optim.evaluate.limits import problem_of
    from optim.evaluate.screen import Screened
    from optim.problem.load import load_study
    from optim.problem.shipped import find_study
    from optim.problem.study import OperatingPoint, Study
    from optim.report.export import export
    from optim.report.figures import write_front, write_indices, write_one_at_a_time
    from optim.report.result import format_result
    from optim.search.optimise import optimise
    from optim.search.run import Stopped
    from optim.search.sensitivity import format_sensitivity, sensitivity
    from optim.search.start import start_of
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
        "evaluate.evaluator": ("Evaluator",),
        "evaluate.limits": ("problem_of",),
        "evaluate.screen": ("Screened",),
        "problem.load": ("load_study",),
        "problem.shipped": ("find_study",),
        "problem.study": ("OperatingPoint", "Study"),
        "report.export": ("export",),
        "report.figures": ("write_front", "write_indices", "write_one_at_a_time"),
        "report.result": ("format_result",),
        "search.optimise": ("optimise",),
        "search.run": ("Stopped",),
        "search.sensitivity": ("format_sensitivity", "sensitivity"),
        "search.start": ("start_of",),
        "search.verification": ("format_verification", "verify"),
        "store.store": ("Store", "read_store"),
    },
)
