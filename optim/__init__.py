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

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from optim.algorithms.archive import Archive as Archive
    from optim.algorithms.nlp import Ending as Ending
    from optim.algorithms.nlp import Problem as Problem
    from optim.algorithms.nlp import Progress as Progress
    from optim.algorithms.nlp import Result as Result
    from optim.algorithms.nlp import Values as Values
    from optim.algorithms.pareto import hypervolume as hypervolume
    from optim.algorithms.pareto import knee as knee
    from optim.algorithms.registry import ALGORITHMS as ALGORITHMS
    from optim.algorithms.registry import Table as Table
    from optim.algorithms.registry import minimise as minimise
    from optim.evaluate.evaluations import Evaluations as Evaluations
    from optim.evaluate.evaluator import Evaluator as Evaluator
    from optim.evaluate.limits import problem_of as problem_of
    from optim.evaluate.screen import Screened as Screened
    from optim.problem.load import load_study as load_study
    from optim.problem.shipped import find_study as find_study
    from optim.problem.study import OperatingPoint as OperatingPoint
    from optim.problem.study import Study as Study
    from optim.report.export import export as export
    from optim.report.figures import write_front as write_front
    from optim.report.result import format_result as format_result
    from optim.report.sensitivity_figures import write_indices as write_indices
    from optim.report.sensitivity_figures import write_one_at_a_time as write_one_at_a_time
    from optim.search.optimise import optimise as optimise
    from optim.search.run import Stopped as Stopped
    from optim.search.sensitivity import format_sensitivity as format_sensitivity
    from optim.search.sensitivity import sensitivity as sensitivity
    from optim.search.start import start_of as start_of
    from optim.search.verification import format_verification as format_verification
    from optim.search.verification import verify as verify
    from optim.store.store import Store as Store
    from optim.store.store import read_store as read_store

#: Modules and their public names, which are loaded on first use, so that ``import optim`` is fast.
_NAMES = {
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
    "report.figures": ("write_front",),
    "report.result": ("format_result",),
    "report.sensitivity_figures": ("write_indices", "write_one_at_a_time"),
    "search.optimise": ("optimise",),
    "search.run": ("Stopped",),
    "search.sensitivity": ("format_sensitivity", "sensitivity"),
    "search.start": ("start_of",),
    "search.verification": ("format_verification", "verify"),
    "store.store": ("Store", "read_store"),
}
_HOME = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'optim' has no attribute '{name}'")
    import importlib

    return getattr(importlib.import_module(f"optim.{_HOME[name]}"), name)
