"""`check_derivatives`: derivatives by sensitivities of runs against differences of designs."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages import InputError
from linkages.base.arguments import Vector, fitting, validated
from linkages.base.brief import cell
from linkages.input.files.writing import finite
from optim.algorithms.derivatives import jacobian
from optim.evaluate.evaluator import Evaluator, Screened
from optim.evaluate.gradients import Gradients, check_sensitivities
from optim.evaluate.limits import limits, problem_of
from optim.problem.study import Array, Study
from optim.search import numerics
from optim.search.task import settings_of

_STEPS = (1e-5, 1e-4, 1e-3, 1e-2)  # of central differences, in parts of the bounds
_SAME = 0.01  # largest deviation of derivatives that agree, in parts of the largest one of a quantity
AGREES, DIFFERS, UNCLEAR, ABSENT = "agrees", "DIFFERS", "unclear", "none"
#: What each verdict means.
VERDICTS = {
    AGREES: f"deviation of at most {_SAME:g}",
    DIFFERS: "larger deviation, although differences with another step agree with each other",
    UNCLEAR: "larger deviation, but differences change as much with their step: a tighter solver.accuracy tells more",
    ABSENT: "the run has no derivative, so that the algorithm takes differences; or there are no differences",
}


def check_usable(study: Study) -> None:
    """Refuse a study whose algorithm uses no derivatives, or with an output that has no sensitivities."""
    name, settings = settings_of(study)
    if not hasattr(settings, "derivatives"):
        raise InputError(study.source, "algorithm.name", f'"{name}" uses no derivatives; leave out --check')
    check_sensitivities(study)


@validated
def check_derivatives(study: Study, design: Vector, evaluator: Evaluator | None = None) -> dict[str, Any]:
    """Compare the derivatives of objectives and limits by sensitivities with differences of designs.

    Differences have steps of 1e-5 to 1e-2 of the bounds. For each derivative the two neighbouring steps count whose
    differences agree best; their distance is the doubt.

    Parameters
    ----------
    study : Study
    design : (n,) array
    evaluator : Evaluator, optional
        Default one that runs here, in all threads.

    Returns
    -------
    dict
        ``agrees``: whether no derivative differs. ``quantities``: for each objective and limit (``NAME.at_most``), as
        the algorithm sees it, and each variable's path ``sensitivity``, ``difference`` (per unit of the variable; None
        where there is none), ``deviation`` and ``doubt`` (changes over the bounds, in parts of the largest one of the
        quantity), and ``verdict``.

    Raises
    ------
    InputError
        If an output has no sensitivities.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.check_derivatives(study, study.nominal)
    >>> report["agrees"], list(report["quantities"])
    (True, ['force'])
    """
    fitting(design, len(study.names), "design", "variables")
    check_sensitivities(study)
    evaluate = Screened(study, evaluator or Evaluator(study), max(_STEPS))
    nominal = evaluate(study.nominal[None])
    problem, width = problem_of(study, evaluate, nominal), study.upper - study.lower
    own = Gradients(study, evaluate, nominal, evaluator.threads if evaluator else None)(design)
    tables = [jacobian(problem, problem.evaluate, design, width, step) for step in _STEPS]
    differences = np.array([np.full_like(own, np.nan) if one is None else one for one in tables])
    doubt, difference = _best_pair(differences)
    own, difference, doubt = own * width, difference * width, doubt * width
    largest = np.fmax(np.abs(own), np.abs(difference)).max(axis=1, keepdims=True, initial=0.0, where=np.isfinite(own))
    scale = np.where(largest > 0.0, largest, 1.0)
    quantities: dict[str, Any] = {}
    for i, name in enumerate([*study.file.objectives, *(limit.key for limit in limits(study))]):
        quantities[name] = {
            path: _entry(own[i, k], difference[i, k], doubt[i, k], float(scale[i, 0]), float(width[k]))
            for k, path in enumerate(study.paths)
        }
    verdicts = [entry["verdict"] for table in quantities.values() for entry in table.values()]
    return {"agrees": DIFFERS not in verdicts, "quantities": quantities}


def _best_pair(differences: Array) -> tuple[Array, Array]:
    """Return for each entry the least distance of differences with neighbouring steps, and their mean."""
    distances = np.abs(np.diff(differences, axis=0))
    best = np.argmin(np.where(np.isnan(distances), np.inf, distances), axis=0)[None]
    means = 0.5 * (differences[1:] + differences[:-1])
    return np.take_along_axis(distances, best, 0)[0], np.take_along_axis(means, best, 0)[0]


def _entry(own: float, difference: float, doubt: float, scale: float, width: float) -> dict[str, Any]:
    """Compare a derivative with its difference; all are changes over the bounds."""
    deviation, doubt = abs(own - difference) / scale, doubt / scale
    if not np.isfinite(deviation):
        verdict = ABSENT
    elif deviation <= _SAME:
        verdict = AGREES
    else:
        verdict = UNCLEAR if deviation <= numerics.DERIVATIVE_CHECK_DOUBT * doubt else DIFFERS
    return {
        "sensitivity": finite(own / width + 0.0) if width else None,
        "difference": finite(difference / width + 0.0) if width else None,
        "deviation": finite(deviation),
        "doubt": finite(doubt),
        "verdict": verdict,
    }


def format_derivative_check(study: Study, report: dict[str, Any], where: str) -> str:
    """Format a check of derivatives as lines of text.

    Parameters
    ----------
    study : Study
    report : dict
        From `optim.check_derivatives`.
    where : str
        Name of the design: "start".

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.check_derivatives(study, study.nominal)
    >>> optim.format_derivative_check(study, report, "start").splitlines()[1]
    'force [N]'
    """
    first = max(34, *(2 + len(path) for path in study.paths))
    head = f"{'sensitivity':>14s}{'differences':>14s}{'deviation':>12s}{'doubt':>10s}"
    lines, seen = [f"{f'derivatives at the {where}':{first}s}{head}"], set()
    for name, table in report["quantities"].items():
        lines.append(study.label(name) if name in study.file.objectives else name)
        for path, one in table.items():
            cells = f"{cell(one['sensitivity'], 14, '.5g')}{cell(one['difference'], 14, '.5g')}"
            cells += f"{cell(one['deviation'], 12, '.1e')}{cell(one['doubt'], 10, '.0e')}"
            lines.append(f"{'  ' + path:{first}s}{cells}   {one['verdict']}")
            seen.add(one["verdict"])
    return "\n".join([*lines, *(f"{key}: {text}" for key, text in VERDICTS.items() if key in seen)])
