"""From a study to the mathematical problem that algorithms see: objectives to minimise, g <= 0 and h = 0."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from linkages import RunError
from linkages.base.arguments import Vector, fitting, validated
from optim.algorithms.nlp import Problem, Values
from optim.evaluate.evaluations import OK, Evaluations
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
    return Problem(
        study.lower,
        study.upper,
        lambda designs: values_of(study, evaluate(designs), reference),
        tuple(study.file.objectives),
        tuple(limit.key for limit in limits(study) if not limit.equality),
        tuple(limit.key for limit in limits(study) if limit.equality),
        study.nominal if start is None else start,
        constraints=_formulas(study, reference),
    )


def _formulas(study: Study, nominal: Evaluations) -> Callable[[Array], Array] | None:
    """Return the function of all limits at a design (n,) by formulas, (ni + ne,); None if one needs a run."""
    scattering = any(constraint.over_scatter is not None for constraint in study.file.constraints.values())
    if scattering or not study.formulas.keys() >= study.file.constraints.keys():
        return None
    unknown = np.full((1, len(study.file.objectives)), np.nan)

    def limits_at(design: Array) -> Array:
        named = study.named(design)
        numbers = np.array([[study.formulas[name](named) for name in study.file.constraints]])
        values = values_of(study, Evaluations(unknown, numbers, (OK,), ("",)), nominal)
        return np.concatenate([values.inequalities[0], values.equalities[0]])

    return limits_at


def values_of(study: Study, found: Evaluations, nominal: Evaluations) -> Values:
    """Convert evaluations of m designs for an algorithm: objectives to minimise, limits as g <= 0 and h = 0.

    Relative quantities are divided by the values of the nominal design, evaluated alone. A limit L of a value f becomes
    (f - L)/|L|, or f if L = 0, so that violations of different constraints can be summed.
    """
    objectives, constraints = in_units(study, found, nominal)
    columns, failed = dict(zip(study.file.constraints, constraints.T, strict=True)), found.failed[:, None]
    sides = []
    for equality in (False, True):
        excess = [limit.excess(columns[limit.name]) for limit in limits(study) if limit.equality == equality]
        side = np.column_stack([np.empty((len(found), 0)), *excess])
        side[found.unrun[:, None] & np.isnan(side)] = 0.0  # unknown, as the design was not run: it counts for nothing
        sides.append(np.where(failed, np.inf, side))
    unknown = failed | found.unrun[:, None]
    return Values(np.where(unknown, np.inf, objectives * study.signs), sides[0], sides[1], found.failed)


def in_units(study: Study, found: Evaluations, nominal: Evaluations) -> tuple[Array, Array]:
    """Objectives and constraints as the file means them: relative ones divided by the nominal design's (`scales`)."""
    size, split = scales(study, nominal), found.objectives.shape[1]
    return found.objectives / size[:split], found.constraints / size[split:]


def scales(study: Study, nominal: Evaluations) -> Array:
    """Return what each objective and constraint is divided by: the nominal design's value if it is relative, else 1.

    RunError if the nominal design failed or has the value zero.
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


class Limit(NamedTuple):
    """A limit, named ``NAME.at_most``, ``NAME.at_least`` or ``NAME.equals``, of the constraint NAME.

    The excess of a value over it, times `sign` and relative to `size`, must not be positive, or must be zero.
    """

    key: str
    name: str
    value: float
    sign: float
    size: float
    equality: bool

    def excess(self, found: Any) -> Any:
        """Return by how much a value, or an array of values, exceeds the limit, relative to it."""
        return self.sign * (found - self.value) / self.size


def limits(study: Study) -> list[Limit]:
    """List every limit: inequalities, then equalities."""
    found = []
    for name, constraint in study.file.constraints.items():
        for key, sign in (("at_most", 1.0), ("at_least", -1.0), ("equals", 1.0)):
            if (value := getattr(constraint, key)) is not None:
                found.append(Limit(f"{name}.{key}", name, value, sign, abs(value) or 1.0, key == "equals"))
    return sorted(found, key=lambda limit: limit.equality)
