"""Public names, which are loaded on first use: the one list of them, for type checkers and for `lazy_loader`."""

from .algorithms.archive import Archive as Archive
from .algorithms.nlp import (
    Ending as Ending,
    Problem as Problem,
    Progress as Progress,
    Result as Result,
    Values as Values,
)
from .algorithms.pareto import hypervolume as hypervolume, knee as knee
from .algorithms.registry import ALGORITHMS as ALGORITHMS, Table as Table, minimise as minimise
from .evaluate.evaluations import Evaluations as Evaluations
from .evaluate.evaluator import Evaluator as Evaluator, Screened as Screened
from .evaluate.gradients import Gradients as Gradients
from .evaluate.limits import problem_of as problem_of
from .identify.identify import identify as identify
from .identify.load import Identification as Identification, load_identification as load_identification
from .identify.result import IdentificationResult as IdentificationResult
from .identify.plan import format_plan as format_plan, plan as plan
from .identify.writing import format_identification as format_identification
from .problem.load import find_study as find_study, load_study as load_study
from .problem.study import OperatingPoint as OperatingPoint, Study as Study
from .report.export import export as export
from .report.figures import write_front as write_front, write_pareto_front as write_pareto_front
from .report.identification import write_identification as write_identification
from .report.result import format_result as format_result
from .report.tolerance_text import format_tolerances as format_tolerances
from .search.derivative_check import (
    check_derivatives as check_derivatives,
    format_derivative_check as format_derivative_check,
)
from .search.result import Design as Design, StudyResult as StudyResult
from .search.optimise import Stopped as Stopped, optimise as optimise, start_of as start_of
from .search.sensitivity import format_sensitivity as format_sensitivity, sensitivity as sensitivity
from .search.tolerance_result import ToleranceResult as ToleranceResult
from .search.tolerances import tolerances as tolerances
from .search.verification import format_verification as format_verification, verify as verify
from .store.store import Store as Store, read_store as read_store
from .report.shares import write_indices as write_indices, write_one_at_a_time as write_one_at_a_time
