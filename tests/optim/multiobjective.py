"""Problems with several objectives whose fronts are known.

E. Zitzler, K. Deb, L. Thiele, Comparison of multiobjective evolutionary algorithms, Evolutionary Computation 8 (2000)
173-195 (ZDT1, ZDT2); K. Deb, Multi-Objective Optimization using Evolutionary Algorithms, Wiley 2001, section 7.5
(Constr-Ex); T. T. Binh, U. Korn, MOBES, Proc. MENDEL 97, 176-182 (BNH).
"""

import numpy as np

from optim.algorithms.nlp import Problem, Values


def problem(lower, upper, objectives, inequalities=None):
    lower, upper = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    count = 0 if inequalities is None else inequalities(lower[None, :]).shape[1]

    def evaluate(x):
        m = len(x)
        return Values(
            objectives(x),
            np.empty((m, 0)) if inequalities is None else inequalities(x),
            np.empty((m, 0)),
            np.zeros(m, dtype=bool),
        )

    names = tuple(f"f{i + 1}" for i in range(objectives(lower[None, :]).shape[1]))
    return Problem(lower, upper, evaluate, names, tuple(f"g{i + 1}" for i in range(count)))


def zdt(power, n=6):
    """ZDT1 with power 1/2, ZDT2 with power 2; the front is f2 = 1 - f1^power."""

    def objectives(x):
        g = 1.0 + 9.0 * x[:, 1:].mean(axis=1)
        return np.column_stack([x[:, 0], g * (1.0 - (x[:, 0] / g) ** power)])

    return problem(np.zeros(n), np.ones(n), objectives)


def constr_ex():
    return problem(
        [0.1, 0.0], [1.0, 5.0],
        lambda x: np.column_stack([x[:, 0], (1.0 + x[:, 1]) / x[:, 0]]),
        lambda x: np.column_stack([6.0 - x[:, 1] - 9.0 * x[:, 0], 1.0 + x[:, 1] - 9.0 * x[:, 0]]),
    )  # fmt: skip


def constr_ex_front(f1):
    return np.where(f1 < 2.0 / 3.0, 7.0 / f1 - 9.0, 1.0 / f1)


def bnh():
    return problem(
        [0.0, 0.0], [5.0, 3.0],
        lambda x: np.column_stack([4.0 * (x**2).sum(axis=1), ((x - 5.0) ** 2).sum(axis=1)]),
        lambda x: np.column_stack(
            [
                (x[:, 0] - 5.0) ** 2 + x[:, 1] ** 2 - 25.0,
                7.7 - (x[:, 0] - 8.0) ** 2 - (x[:, 1] + 3.0) ** 2,
            ]
        ),
    )  # fmt: skip


def bnh_front(f1):
    """Both variables equal up to 3, then the second stays there."""
    x = np.where(f1 < 72.0, np.sqrt(f1 / 8.0), np.sqrt(np.maximum(f1 / 4.0 - 9.0, 0.0)))
    y = np.minimum(x, 3.0)
    return (x - 5.0) ** 2 + (y - 5.0) ** 2
