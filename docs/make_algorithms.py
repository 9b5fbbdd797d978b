"""Write docs/optimisation_algorithms.md: ``python docs/make_algorithms.py``."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import NamedTuple

from linkages.files.table_keys import table_keys
from optim import ALGORITHMS, Ending, minimise

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests" / "optim"))

from hock_schittkowski import EXAMPLES, Example  # noqa: E402

_KINDS = {"b": "bounds", "i": "inequalities", "e": "equalities", "v": "vertex", "d": "degenerate"}

_HEAD = r"""# Algorithms of the optimisation

An algorithm is a function `(problem, settings, seed, progress) -> Result` (`optim/algorithms/nlp.py` has the types). It
sees bounds and a function of whole populations, never a mechanism. It depends on nothing but its arguments: run again, it
asks for the same designs in the same order, so a run that was stopped is resumed by running it again on the stored values.
This page is written by `python docs/make_algorithms.py`.

```python
import optim

result = optim.minimise("grg", problem, {"starts": 8}, seed=1)
print(result.x[0], result.values.objectives[0, 0], result.status, result.status.remedy)
```

| name | what it is | objectives | needs a start |
|---|---|---|---|
"""

_RULES = r"""
All of them keep these rules:

- A whole population is evaluated in one call; the gradient methods take a gradient as one population of 2 n designs.
- No design is evaluated twice in a run (`optim/algorithms/archive.py`).
- Failed evaluations, and values that are not finite, are worse than anything else and never end a run. Only where nothing
  can be evaluated, at the start of a local method or anywhere, the status is `evaluation-failed`.
- Designs are ordered by the rules of feasibility (Deb 2000): feasible before infeasible, the lower objective among the
  feasible, the lower sum of violations among the infeasible. With several objectives it is constrained domination.
- `progress` is called after each iteration and may raise `KeyboardInterrupt`: the best design so far is returned.

| status | what to try |
|---|---|
"""

_THEORY = r"""
## The generalised reduced gradient method

Minimise $f(x)$ subject to $g(x) \le 0$, $h(x) = 0$ and bounds. With a slack for every constraint, $s \ge 0$ for an inequality
and $s = 0$ for an equality, and $y = (x, s)$:

$$c(x) + s = 0, \qquad l \le y \le u, \qquad A = \partial (c + s) / \partial y = [\,J \;\; I\,].$$

Variables are measured by the distance of their bounds, the objective and the constraints by their change over it, so units
do not matter.

**Partition.** As many variables as there are constraints, m, are basic, $y = (y_B, y_N)$ and $A = [\,B \;\; N\,]$. The
equations determine them; n remain. Eliminating $y_B$ leaves a function of $y_N$ whose gradient is the *reduced gradient*

$$r = \nabla_N f - N^T \pi, \quad B^T \pi = \nabla_B f, \qquad \text{or} \quad r = Z^T \nabla f, \quad
Z = \begin{bmatrix} I \\ -B^{-1} N \end{bmatrix}.$$

An exchange of a basic with a nonbasic variable multiplies $\det B$ by the pivot $(B^{-1} N)_{ij}$. Columns are weighted by
the room that their variables have to their bounds, and exchanges are made as long as one makes the weighted determinant
more than ten times larger. So the basis is well conditioned, and its variables can move.

**Step.** With a BFGS approximation $H$ of the reduced Hessian the step of the nonbasic variables solves

$$\min_v \; r^T v + \tfrac12 v^T H v \quad \text{subject to} \quad l - y \le Z v \le u - y.$$

Abadie and Carpentier, and Lasdon et al., move the variables off their bounds (the superbasic ones) and release bounds one
by one by the sign of their multipliers. Taking the bounds into the model does both at once, and makes degenerate points,
where basic variables lie on bounds too, no special case. It is a problem of nonnegative least squares. Its multipliers $\mu$
and $v$ satisfy $r + H v = Z^T \mu$: where $\lVert H v \rVert$ and the products of $\mu$ and the distances to the bounds are small,
the conditions of Karush, Kuhn and Tucker hold, and the search ends (`converged`).

If the partition changes, so do the coordinates of the tangent space: $v = T v'$, and $H' = T^T H T$ keeps what was learnt.

**Line search.** At $y_N + \alpha v$ the basic variables follow by Newton's method on $c(x) + s = 0$, with $B^{-1}$ from the last
Jacobian, improved by Broyden's updates: no further derivatives. A basic variable that meets a bound is set on it, changes
places with a nonbasic one, and the correction goes on. Where it does not converge, or an evaluation fails, $\alpha$ is
shortened. The step is accepted when $f - \pi^T (c + s)$ falls enough (Armijo); the second term removes, to first order, what
the remaining residual adds.

**Phase I.** From an infeasible start the sum of the violations is minimised in the same way, with slacks that are allowed
to be out of their bounds as far as they are. A point where this is stationary may be a saddle: it is left once by a small
push before the status is `infeasible`.

**Derivatives** are the problem's own (`Problem.jacobian`) or central differences, one-sided of second order at bounds. The
step is relative to the bounds. A rough objective needs a long one: below the scale of its ripples differences see nothing
but these, and the search ends with `no-progress`. A rough constraint needs a tolerance `feasibility` above its ripples:
Newton's method cannot find what is not resolved.

## Measured

Problems of W. Hock and K. Schittkowski, *Test Examples for Nonlinear Programming Codes*, Springer 1981, from the printed
starts, with the settings' defaults and differences for derivatives. A population is one call: it is what counts where
designs are evaluated in parallel. The last column is Drake's SNOPT on the same scaled problem with the same differences.

"""

_AFTER = r"""
All are found to 1e-6 of max(1, |optimum|) with every constraint satisfied to 1e-6 in its own unit. Two more are local optima:
from the printed start problem 20 ends at 40.199 (published 38.199), problem 61 at another of its separate feasible sets;
both find the published optimum from other starts. At the optimum of problem 13 no multipliers exist: a tolerance t of its
constraint shifts it by the cube root of t, for every method. (*Vertex*: the active constraints leave no freedom.
*Degenerate*: their gradients depend on each other, a multiplier vanishes, or the reduced Hessian is singular.)

## Genetic algorithms

pygad supplies generations, simulated binary crossover, polynomial mutation and two random generators of its own: those of
NumPy and Python are not touched. Survival and the choice of parents are ours: pygad orders by one finite
fitness, knows no constraints, and in its NSGA-II parents and children do not compete. Its probabilities:

- crossover: pygad's is that of a parent to be eligible, so nearly every child is crossed whatever it is; here it is the
  probability that a child is crossed, else it is a copy of its first parent;
- mutation: pygad's is that of *each variable*, and so it is here. Chen et al. (2025) print 0.6 without saying of what.

`elites` is the number of parents that compete with the children. With as many as the population (the default) the best
designs are only lost to better ones.

The front is that of all designs that were evaluated. `optim.hypervolume` measures it, `optim.knee` finds the design that
lies farthest from the plane through the extremes, each objective measured by its range.

## Settings

| algorithm | key | default | meaning |
|---|---|---|---|
"""

_ADD = r"""
## Adding an algorithm

1. A module with a table of settings and a function. `Archive` evaluates, remembers, and orders by feasibility:

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

2. An entry in `ALGORITHMS` of `optim/algorithms/registry.py`, by names, so that nothing is imported before it is used:

   ```python
   "random": Algorithm("random_search", "random_search", "RandomSearch", "random search"),
   ```

The tests of `tests/optim/test_algorithms.py` then run on it too: the same seed asks for the same populations, it can be
interrupted, failed evaluations do not end it.
"""


class Row(NamedTuple):
    """What was measured on one problem."""

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


def fixed(example: Example) -> str:
    """Beginning of a row, which does not depend on a measurement."""
    problem = example.problem
    kinds = ", ".join(_KINDS[letter] for letter in example.kind)
    constraints = f"{len(problem.inequalities)} + {len(problem.equalities)}"
    return f"| {example.number} | {kinds} | {problem.size} | {constraints} | {example.optimum:.9g} |"


def table(rows: list[Row]) -> str:
    """Write the table of problems."""
    text = (
        "| problem | kind | variables | inequalities + equalities | optimum | found | iterations | evaluations "
        "| populations | SNOPT's evaluations |\n|---|---|---|---|---|---|---|---|---|---|\n"
    )
    for row in rows:
        # what differs from zero by rounding only would differ on another machine
        found = 0.0 if abs(row.found) < 1e-7 else row.found
        other = "misses 1e-6" if row.snopt is None else row.snopt
        text += (
            f"{fixed(row.example)} {found:.7g} | {row.iterations} | {row.evaluations} | {row.populations} | {other} |\n"
        )
    return text


def page(problems: str) -> str:
    """Write the page around the table of problems."""
    summaries, settings = "", ""
    for name, algorithm in ALGORITHMS.items():
        objectives, start = "several" if algorithm.several else "one", "yes" if algorithm.local else "no"
        summaries += f"| `{name}` | {algorithm.summary} | {objectives} | {start} |\n"
        defaults = algorithm.table()
        for key, meaning in table_keys(algorithm.table):
            settings += f"| `{name}` | `{key}` | {getattr(defaults, key)} | {meaning} |\n"
    remedies = "".join(f"| `{ending.value}` | {ending.remedy} |\n" for ending in Ending)
    return _HEAD + summaries + _RULES + remedies + _THEORY + problems + _AFTER + settings + _ADD


if __name__ == "__main__":
    measured = table([measure(example) for example in EXAMPLES])
    (HERE / "optimisation_algorithms.md").write_text(page(measured), encoding="utf-8")
