"""From a study to the mathematical problem that algorithms see: objectives to minimise, g <= 0 and h = 0."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from linkages import RunError
from linkages.arguments import Vector, fitting, validated
from optim.algorithms.nlp import Problem, Values
from optim.evaluate.evaluations import Evaluations
from optim.problem.study import Array, Study

FEASIBLE = 1e-6  # sum of violations, relative to their limits, that counts as none


@validated
def problem_of(
    study: Study,
    evaluate: Callable[[Array], Evaluations],
    nominal: Evaluations | None = None,
    start: Vector | None = None,
) -> Problem:
    """Make the problem of a study as an algorithm sees it.

    Parameters
    ----------
    study : Study
    evaluate : callable
        From designs (m, n) to their evaluations: an `Evaluator`.
    nominal : Evaluations, optional
        Evaluation of the nominal design alone; default evaluated here.
    start : (n,) array, optional
        Default the nominal design.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("fourbar_jitter"))
    >>> problem = optim.problem_of(study, optim.Evaluator(study))
    >>> problem.objectives, problem.size
    (('jitter',), 4)
    """
    if start is not None:
        fitting(start, len(study.names), "start", "variables")
    reference = evaluate(study.nominal[None]) if nominal is None else nominal
    names = [name for name, _, _, _ in limits(study)]
    return Problem(
        study.lower,
        study.upper,
        lambda designs: values_of(study, evaluate(designs), reference),
        tuple(study.file.objectives),
        tuple(name for name in names if not name.endswith(".equals")),
        tuple(name for name in names if name.endswith(".equals")),
        study.nominal if start is None else start,
    )


def values_of(study: Study, found: Evaluations, nominal: Evaluations) -> Values:
    """Convert evaluations for an algorithm: objectives to minimise, limits as g <= 0 and h = 0.

    Relative quantities are divided by the nominal design's. A limit L of a value f becomes (f - L)/|L|, or f if
    L = 0, so that violations of different constraints can be summed.

    Parameters
    ----------
    found : Evaluations
        Evaluations of m designs.
    nominal : Evaluations
        Evaluation of the nominal design alone.
    """
    objectives, constraints = in_units(study, found, nominal)
    columns: dict[bool, list[Array]] = {False: [], True: []}
    order = list(study.file.constraints)
    for key, name, limit, sign in limits(study):
        excess = sign * (constraints[:, order.index(name)] - limit) / (abs(limit) or 1.0)
        # unknown constraints of a design that was not run count for nothing
        columns[key.endswith(".equals")].append(np.where(found.unrun & np.isnan(excess), 0.0, excess))
    failed = found.failed[:, None]
    empty = np.empty((len(found), 0))
    return Values(
        np.where(failed | found.unrun[:, None], np.inf, objectives * study.signs),
        np.where(failed, np.inf, np.column_stack([empty, *columns[False]])),
        np.where(failed, np.inf, np.column_stack([empty, *columns[True]])),
        found.failed,
    )


def in_units(study: Study, found: Evaluations, nominal: Evaluations) -> tuple[Array, Array]:
    """Objectives and constraints as the file means them: relative ones divided by the nominal design's.

    Raises
    ------
    RunError
        As `scales`.
    """
    size, split = scales(study, nominal), found.objectives.shape[1]
    return found.objectives / size[:split], found.constraints / size[split:]


def scales(study: Study, nominal: Evaluations) -> Array:
    """Return what each objective and constraint is divided by: the nominal design's value if it is relative, else 1.

    Raises
    ------
    RunError
        If the nominal design, by which they are divided, failed or has the value zero.
    """
    found = np.ones(len(study.quantities))
    reference = np.concatenate([nominal.objectives[0], nominal.constraints[0]])
    for k, (kind, name, quantity) in enumerate(study.quantities):
        if not quantity.relative:
            continue
        if nominal.failed[0] or reference[k] == 0.0:
            why = nominal.reason[0] or "it is zero there"
            raise RunError(
                f"{study.source.name}: {kind}.{name} is relative to the nominal design, which has no value: {why}"
            )
        found[k] = reference[k]
    return found


def limits(study: Study) -> Iterable[tuple[str, str, float, float]]:
    """Every limit: its name, its constraint, its value, and the sign with which the excess must not be positive."""
    for name, constraint in study.file.constraints.items():
        for key, sign in (("at_most", 1.0), ("at_least", -1.0), ("equals", 1.0)):
            limit = getattr(constraint, key)
            if limit is not None:
                yield f"{name}.{key}", name, limit, sign
