"""Systems at neighbouring values of a path: derivatives of any numbers that are computed from a system.

Example: the numbers of a spring's stiffness k have the derivative (n(k + h) - n(k - h)) / (2 h) with h = 3e-5 k.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from linkages.base.errors import AssemblyError, InputError
from linkages.base.kernel import Array, Indices
from linkages.base.kernel.block import Contents, contents
from linkages.input.model.experiment import value_unit
from linkages.mechanics.planar.arrays import Arrays
from linkages.results.derivatives import Direction
from linkages.system import System
from linkages.system.system import keeps_start

_STEP = 3e-5  # of differences, in parts of the value
_ZERO = 1e-7  # values of a smaller magnitude count as zero, SI units
_UNITS = {"m/s2": 10.0}  # magnitudes of a value of zero, by its unit
_UNIT = 1e-2  # of other units
_SAME = 1e-15  # relative change of a number by rounding: the value does not change it
_INTEGER = 1e-290  # an integer, read as a float, is smaller
_PART = 1e-3  # by which values grow together, at least
_ROUNDING = 1e-13  # error of a number that is proportional to a value
#: Places and weights of differences of the second order: central, or to one side at a limit of the value.
_STENCILS = ((-1, 1), (-1 / 2, 1 / 2)), ((1, 2), (2.0, -1 / 2)), ((-1, -2), (-2.0, 1 / 2))


class Rates(NamedTuple):
    """Numbers that change with a value: their places in the `contents` of a named tuple, and their derivatives."""

    places: Indices
    rates: Array


_NONE = Rates(np.zeros(0, np.int64), np.zeros(0))


def magnitude_of(path: str, value: float) -> float:
    """Return the magnitude of a value: its own, or its unit's if it is zero."""
    return _unit(path) if abs(value) <= _ZERO else abs(value)


@lru_cache(1000)
def _unit(path: str) -> float:
    """Return the magnitude of a value of zero."""
    return _UNITS.get(value_unit(path), _UNIT)


def neighbours(system: System, values: Sequence[str | Direction]) -> list[Neighbours]:
    """Return the systems near a system for each of several values, with few for all values together.

    Raises
    ------
    InputError
        See `Neighbours`.
    """
    names = [value if isinstance(value, str) else value.name for value in values]
    for k, (name, value) in enumerate(zip(names, values, strict=True)):
        if name in names[:k] or not (isinstance(value, str) or value.rates):
            raise InputError("argument", name, "is given twice" if name in names[:k] else "has no rates")
    paths = sorted({path for value in values for path in ([value] if isinstance(value, str) else value.rates)})
    laws = [path for path in paths if path.startswith("joints.") and keeps_start(path)]
    groups = [path for path in paths if path not in laws], laws  # each system has most arrays in common with another
    shared = [Together(system, group) for group in groups if group]
    return [Neighbours(system, value, shared) for value in values]


class Together:
    """A system in which the values at several paths are moved at once, each by another part of itself.

    A number that is proportional to a value changes by the same part; the coordinate of a point changes by the step of
    a length, its half, or the sum or difference of two steps. So it is known to which values the number belongs. The
    steps have generic ratios, which products and powers of values do not match.
    """

    def __init__(self, system: System, paths: Sequence[str]) -> None:
        self._system, self._paths = system, list(paths)
        self._values = np.array([system.value(path) for path in paths])
        units = [magnitude_of(path, value) for path, value in zip(paths, self._values.tolist(), strict=True)]
        self._new = self._values + _PART * (1.0 + np.random.default_rng(0).random(len(units))) * units
        one, (first, second) = np.eye(len(units)), np.triu_indices(len(units), 1)
        slopes = np.concatenate([one, one / 2, one[first] + one[second], one[first] - one[second]])
        self._slopes = np.concatenate([slopes, -slopes])  # of coordinates of points
        self._latest: tuple[Any, tuple[Indices, Array] | None] | None = None

    def rates(self, make: Callable[[System], Any], along: Mapping[str, float]) -> Rates | None:
        """Differentiate as `Neighbours.rates` along its own paths among some; None if any number is not known."""
        own = [along.get(path, 0.0) for path in self._paths]
        if not any(own):
            return _NONE
        if self._latest is None or self._latest[0] is not make:
            self._latest = make, self._changes(make)
        if self._latest[1] is None:
            return None
        places, changes = self._latest[1]
        rates = changes @ own
        return Rates(places[rates != 0.0], rates[rates != 0.0])

    @cached_property
    def _moved(self) -> System | None:
        """The system; None near a limit of a value."""
        with suppress(InputError, AssemblyError):
            return self._system.replaced(dict(zip(self._paths, self._new.tolist(), strict=True)))
        return None

    def _changes(self, make: Callable[[System], Any]) -> tuple[Indices, Array] | None:
        """Return the places of numbers that change, (n,), and their derivatives, (n, np)."""
        with suppress(InputError, AssemblyError):  # the value's own systems tell
            if self._moved is not None:
                own, other = _own(make, self._system), contents(make(self._moved))
                if own.structure == other.structure:
                    places, (here, there) = _changed(own, [other])
                    rates = self._rates(here, there)
                    return None if rates is None else (places, rates)
        return None

    def _rates(self, here: Array, there: Array) -> Array | None:
        """Differentiate numbers (n,) with respect to the values, (n, np)."""
        count, steps = len(self._paths), self._new - self._values
        rates = np.zeros((len(here), count))
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.abs((there / here - 1.0)[:, None] - steps / self._values)
            owners, unknown = np.argmin(apart, axis=1), ~(apart.min(axis=1) <= _ROUNDING)
            rates[np.arange(len(here)), owners] = here / self._values[owners]
        apart = np.abs(self._slopes @ steps - (there - here)[unknown, None])
        fits = apart <= _ROUNDING * np.abs(here[unknown, None])
        rates[unknown] = self._slopes[np.argmax(fits, axis=1)]
        return rates if np.all(fits.sum(axis=1) == 1) else None


class Neighbours:
    """Systems near a system, with other values at a path.

    They are built when they are needed.

    Parameters
    ----------
    system : System
    value : str or Direction
        A dotted path, see `linkages.System.replaced`; or a value that several paths follow.
    together : sequence of Together
        Used where they are sufficient.

    Attributes
    ----------
    magnitude : float
        Of the value.
    along : mapping of str to float
        Paths that follow the value, and their rates.

    Raises
    ------
    InputError
        If there is no number at the path, or no neighbouring value is valid.
    """

    def __init__(self, system: System, value: str | Direction, together: Sequence[Together] = ()) -> None:
        along = Direction(value, system.value(value), {value: 1.0}) if isinstance(value, str) else value
        self.path, number, self.along = along
        self.system, self.magnitude, self._together = system, magnitude_of(self.path, number), together

    @cached_property
    def _systems(self) -> tuple[list[System], Array]:
        """Return the systems, and the weights of their numbers."""
        for places, weights in _STENCILS:
            try:
                return [self._moved(place) for place in places], np.array(weights) / (_STEP * self.magnitude)
            except InputError as error:
                problem = error
            except AssemblyError as error:
                text = f"has no neighbouring value that can be assembled: {error}"
                problem = InputError("argument", self.path, text)
        raise problem

    def _moved(self, place: int) -> System:
        step, value = place * _STEP * self.magnitude, self.system.value
        found = self.system.replaced({path: value(path) + step * rate for path, rate in self.along.items()})
        _ = found.assembly  # a failure leads to another stencil
        return found

    def derivative(self, numbers: Callable[[System], Array]) -> Array:
        """Differentiate an array of numbers."""
        systems, weights = self._systems
        here, found = numbers(self.system), [numbers(one) for one in systems]
        if any(one.shape != here.shape for one in found):
            raise self._other_structure()
        return np.tensordot(weights, [one - here for one in found], 1)

    def rates(self, make: Callable[[System], Any]) -> Rates:
        """Differentiate the numbers of a named tuple that is made from a system; see `contents`.

        Raises
        ------
        InputError
            If the value changes integers, or shapes of arrays.
        """
        parts = [each.rates(make, self.along) for each in self._together]
        if parts and None not in parts:
            return _total([part for part in parts if part is not None and len(part.places)] or [_NONE])
        systems, weights = self._systems
        own, others = _own(make, self.system), [contents(make(one)) for one in systems]
        if any(one.structure != own.structure for one in others):
            raise self._other_structure()
        places, values = _changed(own, others)
        if np.any((np.abs(values) < _INTEGER) & (values != 0.0)):
            raise self._other_structure()
        return Rates(places, weights @ (values[1:] - values[0]))

    @cached_property
    def arrays(self) -> Rates:
        """Differentiate the arrays of the system."""
        return self.rates(_arrays)

    def _other_structure(self) -> InputError:
        return InputError("argument", self.path, "changes the structure of the system: there is no derivative")


@lru_cache(2)
def _own(make: Callable[[System], Any], system: System) -> Contents:
    """Return the numbers of the system itself."""
    return contents(make(system))


def _total(parts: Sequence[Rates]) -> Rates:
    """Add derivatives."""
    if len(parts) == 1:
        return parts[0]
    places, inverse = np.unique(np.concatenate([one.places for one in parts]), return_inverse=True)
    return Rates(places, np.bincount(inverse, np.concatenate([one.rates for one in parts])).astype(np.float64))


def _changed(own: Contents, others: Sequence[Contents]) -> tuple[Indices, Array]:
    """Return the places of the finite numbers that differ from others by more than rounding, and these, (1 + k, n)."""
    places = np.flatnonzero(np.any([one.words != own.words for one in others], axis=0))
    values = np.stack([one.words[places] for one in (own, *others)]).view(np.float64)
    with np.errstate(invalid="ignore"):
        differ = np.abs(values[1:] - values[0]).max(axis=0, initial=0.0) > _SAME * np.abs(values[0])
    kept = np.isfinite(values).all(axis=0) & differ
    return places[kept], values[:, kept]


def _arrays(system: System) -> Arrays:
    return unscaled(system.arrays)


def unscaled(model: Arrays) -> Arrays:
    """Return a model whose length, a scale of errors alone, does not change with any value."""
    return model._replace(size=1.0)
