"""`Scatter`: values that scatter from machine to machine, and how they depend on each other."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError, System, fit
from linkages.base.arrays import Array
from linkages.base.errors import nearest
from linkages.input.files.unit_conversion import decimal_comma, read
from optim.problem.distributions import Marginal, of_file, of_fit, of_shape
from optim.problem.schema import SHAPES, ScatterTable, StudyFile

_TAIL = 1e-7  # probability of a value beyond the bounds that batches prepare for


@dataclass(frozen=True)
class Scatter:
    """Distributions of n values with a Gaussian copula.

    R. B. Nelsen, An Introduction to Copulas, 2nd ed. 2006: each value is a function of one of n correlated standard
    normal numbers ``z = L g``, the numbers g independent.

    Attributes
    ----------
    names : tuple of str
    marginals : tuple of Marginal
    correlation : (n, n) array
        Of the normal numbers z.
    """

    names: tuple[str, ...]
    marginals: tuple[Marginal, ...]
    correlation: Array

    @property
    def factor(self) -> Array:
        """Return the lower triangular L, (n, n)."""
        return np.asarray(np.linalg.cholesky(self.correlation), dtype=np.float64)

    @property
    def means(self) -> Array:
        """Return the means of the values, (n,)."""
        return np.array([float(one.law.mean()) for one in self.marginals])

    @property
    def deviations(self) -> Array:
        """Return the standard deviations of the values, (n,)."""
        return np.array([float(one.law.std()) for one in self.marginals])

    @property
    def limits(self) -> Array:
        """Return lower and upper tolerance limits, (2, n)."""
        return np.array([(one.lower, one.upper) for one in self.marginals]).T

    def bounds(self) -> Array:
        """Return values that are hardly ever exceeded, (2, n)."""
        return np.array([one.law.ppf(np.array([_TAIL, 1.0 - _TAIL])) for one in self.marginals]).T

    def points(self, count: int, seed: int, sequence: str = "sobol") -> Array:
        """Return independent standard normal numbers (count, n); those of more points begin with the same ones.

        The sequence is "sobol", scrambled, or "random".
        """
        rng, size = np.random.default_rng(seed), len(self.names)
        if sequence == "random":
            return rng.standard_normal((count, size))
        from scipy.special import ndtri
        from scipy.stats import qmc

        shares = qmc.Sobol(size, rng=rng).random(1 << max(count - 1, 1).bit_length())[:count]
        return np.asarray(ndtri(np.clip(shares, 1e-12, 1.0 - 1e-12)))

    def values(self, normal: Array) -> Array:
        """Return the values (m, n) of independent standard normal numbers (m, n)."""
        from scipy.special import ndtr

        shares = ndtr(normal @ self.factor.T)
        return np.column_stack([one.law.ppf(x) for one, x in zip(self.marginals, shares.T, strict=True)])

    def stretch(self, normal: Array) -> Array:
        """Return the derivatives (n,) of the values by the correlated normal numbers, at independent ones (n,).

        Infinite in a gap between measured values.
        """
        z, x = self.factor @ normal, self.values(normal[None])[0]
        density = np.array([float(one.law.pdf(value)) for one, value in zip(self.marginals, x, strict=True)])
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi) / density)

    def narrowed(self, k: int, factor: float) -> Scatter:
        """Return the scatter with the deviation of value k times a factor."""
        marginals = list(self.marginals)
        marginals[k] = marginals[k].narrowed(factor)
        return Scatter(self.names, tuple(marginals), self.correlation)

    def log_density(self, values: Array) -> Array:
        """Return the logarithm of the joint density of values (m, n), (m,); minus infinity where there are none."""
        from scipy.special import ndtri

        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.column_stack([one.law.cdf(x) for one, x in zip(self.marginals, values.T, strict=True)])
            each = [np.log(one.law.pdf(x)) for one, x in zip(self.marginals, values.T, strict=True)]
            z = ndtri(shares)
            inside = np.isfinite(z).all(axis=1)
            excess = np.linalg.inv(self.correlation) - np.eye(len(self.names))
            copula = -0.5 * np.einsum("ij,jk,ik->i", np.where(inside[:, None], z, 0.0), excess, z)
            return np.where(inside, np.sum(each, axis=0) + copula, -np.inf)


def read_scatter(path: Path, file: StudyFile, system: System) -> Scatter | None:
    """Read the scattering values of a study; None if it has none."""
    if not file.scatter:
        if file.correlated:
            raise InputError(path, "correlated", "needs [scatter.NAME]")
        return None
    marginals = tuple(_marginal(path, name, table, system) for name, table in file.scatter.items())
    return Scatter(tuple(file.scatter), marginals, _correlation(path, file))


def _marginal(path: Path, name: str, table: ScatterTable, system: System) -> Marginal:
    where = f"scatter.{name}"
    try:
        nominal = system.value(table.path)
    except InputError as problem:
        raise InputError(path, f"{where}.path", str(problem)) from None
    if table.fit is not None:
        return _clearance(path, where, table.fit, table)
    if table.empirical is not None:
        found = of_file(path.parent / table.empirical)
    else:
        kind = next(kind for kind in SHAPES if getattr(table, kind) is not None)
        try:
            found = of_shape(kind, _numbers(getattr(table, kind), kind, system.value_unit(table.path)))
        except ValueError as problem:
            raise InputError(path, f"{where}.{kind}", str(problem)) from None
    return found.moved(nominal) if table.relative_to == "nominal" else found


def _numbers(given: list[Any], kind: str, unit: str) -> list[float]:
    """Read the parameters of a distribution in the unit of its value; the exponents of beta are pure numbers."""
    pure = 2 if kind == "beta" else 0
    found = [*given[:pure], *read(given[pure:], unit)]
    for number in found:
        if not isinstance(number, int | float):
            remedy = decimal_comma(str(number)) or '; give a number, or a number with its unit such as "0.1 mm"'
            raise ValueError(f'is "{number}"{remedy}')
    return [float(number) for number in found]


def _clearance(path: Path, where: str, text: str, table: ScatterTable) -> Marginal:
    """Return the distribution of the radial clearance of a fit."""
    if not table.path.endswith(".clearance"):
        raise InputError(path, f"{where}.path", f"is {table.path}; a fit gives the clearance of a joint")
    try:
        limits = fit(text)
    except InputError as problem:
        raise InputError(path, f"{where}.fit", str(problem).removeprefix("fit: ")) from None
    low, high = (1e6 * end for end in limits.clearance)
    if high <= 0.0 or (low < 0.0 and table.interference == "refuse"):
        remedy = ', or interference = "failed" to count such machines as failed' if high > 0.0 else ""
        found = f'"{text}" has interference: clearance {low:g} to {high:g} um; give another fit'
        raise InputError(path, f"{where}.fit", found + remedy)
    return of_fit(limits, table.parts)


def _correlation(path: Path, file: StudyFile) -> Array:
    names = list(file.scatter)
    matrix = np.eye(len(names))
    given: dict[frozenset[str], int] = {}
    for k, entry in enumerate(file.correlated):
        where = f"correlated[{k}].names"
        for name in entry.names:
            if name not in names:
                raise InputError(path, where, f'"{name}" is not in [scatter]; {nearest(name, names)}')
        for pair in itertools.combinations(entry.names, 2):
            if len(set(pair)) < 2 or frozenset(pair) in given:
                raise InputError(path, where, f"has the pair {pair[0]}, {pair[1]} already; give different names once")
            given[frozenset(pair)] = k
            i, j = map(names.index, pair)
            matrix[i, j] = matrix[j, i] = entry.correlation
    if np.linalg.eigvalsh(matrix)[0] < 1e-10:
        raise InputError(path, "correlated", "is not positive definite; give correlations that are possible together")
    return matrix


def content(scatter: Scatter) -> Mapping[str, Any]:
    """Return everything that determines the values, as JSON types."""
    return {
        name: {"quantiles": one.law.ppf(np.linspace(0.01, 0.99, 99)).tolist(), "limits": [one.lower, one.upper]}
        for name, one in zip(scatter.names, scatter.marginals, strict=True)
    }
