"""Write docs/optimisation_algorithms.md: ``python docs/make_algorithms.py``."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from statistics import median
from typing import NamedTuple

from linkages.input.files.table_keys import table_keys
from optim import ALGORITHMS, Ending, minimise

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "tests" / "optim"))

from hock_schittkowski import EXAMPLES, Example  # noqa: E402

_KINDS = {
    "b": "bounds", "i": "inequalities", "e": "equalities", "v": "an optimum in a vertex", "d": "a degenerate optimum", "": "any of them",
}  # fmt: skip

_HEAD = r"""# Algorithms of the optimisation

For readers who choose or add an optimisation algorithm for a [design study](optimisation.md): rules, settings, the reduced gradient method, and measurements on test
problems. `python docs/make_algorithms.py` writes this page and prints the result of every problem.

An algorithm is a function `(problem, settings, seed, progress) -> Result` (types in `optim/algorithms/nlp.py`). It gets the bounds of the variables and a function that evaluates a list of designs (a population) and returns
their objectives and constraints. It depends only on its arguments: the same call requests the same designs in the same order, so a stopped run is resumed by repeating it with the stored values.

```python
import optim

result = optim.minimise("grg", problem, {"starts": 8}, seed=1)
print(result.x[0], result.values.objectives[0, 0], result.status, result.status.remedy)
```

| name | algorithm | objectives | needs a start |
|---|---|---|---|
"""

_RULES = r"""
Common rules:

- A whole population is evaluated in one call; a gradient by differences is one population of 2 n designs, a step of `grg` and its double another. No design is evaluated twice in a run.
- Failed evaluations are worse than any other and never end a run.
- Designs are ordered by the rules of feasibility (Deb, [2000](references.md)): feasible before infeasible, then the lower objective, or the lower sum of violations. Several objectives use
  constrained domination.
- `progress` is called after each iteration and may raise `KeyboardInterrupt`: the best design so far is returned.
- A result has a status with a remedy (`result.status.remedy`): """

_THEORY = r"""
## The generalised reduced gradient method

The problem: minimise $f(x)$ subject to $g(x) \le 0$, $h(x) = 0$ and bounds. Every constraint has a slack, $s \ge 0$ for an inequality and $s = 0$ for an
equality; $y = (x, s)$:

$$c(x) + s = 0, \qquad l \le y \le u, \qquad A = \partial (c + s) / \partial y = [\,J \;\; I\,].$$

Variables are scaled by the distance of their bounds, objective and constraints by their change over it; a constraint that does not change to first order at the start is scaled by its value. Units therefore have no influence.

**Partition.** The m constraints determine m basic variables: $y = (y_B, y_N)$, $A = [\,B \;\; N\,]$. The gradient of the function of $y_N$ is the *reduced gradient*

$$r = \nabla_N f - N^T \pi, \quad B^T \pi = \nabla_B f, \qquad \text{or} \quad r = Z^T \nabla f, \quad
Z = \begin{bmatrix} I \\ -B^{-1} N \end{bmatrix}.$$

Columns are weighted by the distances of their variables from their bounds. Basic and nonbasic variables are exchanged as long as one exchange increases the weighted determinant of $B$ more than
tenfold: the basis is then well conditioned, and its variables can move.

**Step.** With a BFGS approximation $H$ of the reduced Hessian the step of the nonbasic variables solves

$$\min_v \; r^T v + \tfrac12 v^T H v \quad \text{subject to} \quad l - y \le Z v \le u - y.$$

Unlike the methods of Abadie and Carpentier ([1969](references.md)) and Lasdon et al. ([1978](references.md)), the model includes the bounds, so degenerate points, where basic variables lie on
bounds too, are no special case. It is a problem of nonnegative least squares. Its multipliers $\mu$ and $v$ satisfy $r + H v = Z^T \mu$. The search ends (`converged`) when $\lVert H v \rVert$ and the products of $\mu$ and the distances to the bounds are small: the conditions of
Karush, Kuhn and Tucker then hold.

A changed partition changes the coordinates: $v = T v'$, $H' = T^T H T$.

**Line search.** At $y_N + \alpha v$ Newton's method on $c(x) + s = 0$ determines the basic variables, with $B^{-1}$ from the last Jacobian and Broyden's updates. A basic variable that meets a bound
is set to it and exchanged with a nonbasic one. If the correction does not converge, or an evaluation fails, $\alpha$ is
reduced. Constraints that are formulas need no run: the objective is evaluated only where they hold. The step is accepted when $f - \pi^T (c + s)$ decreases enough (Armijo); the second term removes, to first order, the influence of the remaining residual.

**Curvature.** A maximum or a saddle fulfils these conditions too. Before the search ends, second differences of the Lagrangian, with steps of 1 % of the scales, therefore give the curvature along the
constraints in all directions in which the search has made no step: one population of k (k + 3)/2 designs for k directions. If the objective falls along the most negative curvature, the search goes on from there. SNOPT is started again from there.

**Phase I.** From an infeasible start the same method minimises the sum of the violations. At a stationary point, one small perturbation leaves a saddle before the status becomes `infeasible`.

**Derivatives** come from [sensitivities of runs](sensitivity.md) (`derivatives = "sensitivities"`; in Python `Problem.jacobian`) or from central differences, one-sided of second order at bounds. Where a run has no
sensitivities, because it fails, goes beyond the [horizon](glossary.md#horizon) or has the extreme at a jump of the output, differences take their place ([comparison](check_optimum.md)). The difference step is a share of the range between the bounds. A rough objective needs a large
step: with a step below the scale of its ripples the search ends with `no-progress`. A rough constraint needs a tolerance `feasibility` above its ripples.

SNOPT is the sequential quadratic programming code of Gill, Murray and Saunders ([2005](references.md)).

## Measured

Problems of Hock and Schittkowski ([1981](references.md)) from the printed starts, with default settings and difference derivatives: medians. A population is one call; the number of
populations matters where designs are evaluated in parallel. The last column is Drake's SNOPT on the same scaled problems with the same differences.

"""

_AFTER = r"""
All optima are found to 1e-6 of max(1, |optimum|); every constraint is satisfied to 1e-6 in its unit. SNOPT misses problem 64. Problems 20 and
61 end in local optima from the printed start. Problem 13 has no multipliers at its optimum.
*Vertex*: the active constraints leave no freedom. *Degenerate*: dependent gradients, a zero multiplier, or a singular reduced Hessian.

## Genetic algorithms

pygad supplies selection by tournament, simulated binary crossover, polynomial mutation, elitism, non-dominated sorting and crowding, with its own random generators. This package gives it a
fitness in which an infeasible design is below every feasible one, in order of its violation, and a faster sort for several objectives.

The best `elites` designs of elites and children are kept. With as many elites as children, as in `nsga2` and by default in `ga`,
only better designs displace the best ones. Two of the parents that take part in the crossover are drawn, so nearly every child is crossed.
Chen et al. (2025) print the mutation 0.6 without a definition.

The [Pareto front](glossary.md#pareto-front) contains all evaluated designs. `optim.hypervolume` measures it; `optim.knee` finds the design farthest from the plane through the extremes, with each objective divided by
its range.

## Settings

"""

_ADD = r"""
## Adding an algorithm

1. A module with a table of settings and a function. `Archive` evaluates, stores and orders designs by feasibility:

   ```python
   from pydantic import Field
   from scipy.stats import qmc
   import numpy as np

   from optim import Archive, Ending, Progress, Result, Table


   class RandomSearch(Table):
       designs: int = Field(100, ge=1, description="designs of a Latin hypercube")


   def random_search(problem, settings, seed=0, progress=None):
       archive = Archive(problem)
       sample = qmc.LatinHypercube(problem.size, rng=np.random.default_rng(seed)).random(settings.designs)
       archive(problem.lower + sample * (problem.upper - problem.lower))
       best = np.array([archive.best(1e-6)])
       x, values = archive.designs[best], archive.values.take(best)
       if progress is not None:
           progress(Progress(1, 1, x, values))
       return Result(x, values, Ending.BUDGET_USED, 1, len(archive))
   ```

2. An entry in `ALGORITHMS` of `optim/algorithms/registry.py`, by names, so that nothing is imported before its use:

   ```python
   "random": Algorithm("random_search", "random_search", "RandomSearch", "random search"),
   ```

The tests of `tests/optim/test_algorithms.py` then include it.
"""


class Row(NamedTuple):
    """Measurements on one problem."""

    example: Example
    found: float
    iterations: int
    evaluations: int
    populations: int
    snopt: int | None


def measure(example: Example) -> Row:
    """Solve a problem by both gradient methods."""
    populations, problem = [], example.problem

    def evaluate(designs):
        populations.append(designs)
        return problem.evaluate(designs)

    result = minimise("grg", dataclasses.replace(problem, evaluate=evaluate))
    other = minimise("snopt", problem)
    error = abs(other.values.objectives[0, 0] - example.optimum) / max(1.0, abs(example.optimum))
    snopt = other.evaluations if error <= 1e-6 and other.values.feasible(1e-6)[0] else None
    found = float(result.values.objectives[0, 0])
    return Row(example, found, result.iterations, result.evaluations, len(populations), snopt)


def counts(rows: list[Row], kind: str) -> tuple[int, ...]:
    """Count the problems of a kind (a letter of `_KINDS`; none: all); medians of their iterations, evaluations, populations, SNOPT's evaluations."""
    chosen = [row for row in rows if kind in row.example.kind]
    numbers = [(row.iterations, row.evaluations, row.populations) for row in chosen]
    snopt = [row.snopt for row in chosen if row.snopt is not None]
    return (len(chosen), *(int(median(column)) for column in (*zip(*numbers, strict=True), snopt)))


def table(rows: list[Row]) -> str:
    """Write the table of the kinds of problems."""
    text = "| problems with | number | iterations | evaluations | populations | SNOPT's evaluations |\n|---|---|---|---|---|---|\n"
    for kind, name in _KINDS.items():
        text += f"| {name} | {' | '.join(map(str, counts(rows, kind)))} |\n"
    return text


def page(problems: str) -> str:
    """Write the page around the table of problems."""
    summaries, settings = "", {}
    for name, algorithm in ALGORITHMS.items():
        objectives, start = "several" if algorithm.several else "one", "yes" if algorithm.local else "no"
        summaries += f"| `{name}` | {algorithm.summary} | {objectives} | {start} |\n"
        defaults = algorithm.table()
        for key, meaning in table_keys(algorithm.table):
            values = settings.setdefault((key, meaning), {})
            values.setdefault(str(getattr(defaults, key)), []).append(f"`{name}`")
    rows = ""
    for (key, meaning), values in settings.items():
        said = "; ".join(f"{value} ({', '.join(names)})" for value, names in values.items())
        rows += f"- `{key}`: {meaning}; {said}\n"
    endings = ", ".join(f"`{ending.value}`" for ending in Ending) + "\n"
    return _HEAD + summaries + _RULES + endings + _THEORY + problems + _AFTER + rows + _ADD


if __name__ == "__main__":
    found = [measure(example) for example in EXAMPLES]
    for row in found:
        print(row.example.number, row.example.optimum, *row[1:])
    measured = table(found)
    (HERE / "optimisation_algorithms.md").write_text(page(measured), encoding="utf-8")
