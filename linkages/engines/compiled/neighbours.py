"""Systems at neighbouring values of a path: derivatives of any numbers that are computed from a system.

Example: the numbers of a spring's stiffness k have the derivative (n(k + h) - n(k - h)) / (2 h) with h = 3e-5 k.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from linkages.errors import AssemblyError, InputError
from linkages.kernel import Array, Indices
from linkages.kernel.block import Contents, contents
from linkages.model.experiment import value_unit
from linkages.planar.arrays import Arrays
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
#: Places and weights of central differences of the fourth order; a constant gives exactly zero, pair by pair.
PAIRS = (-1.0, 1.0, -2.0, 2.0), (-2 / 3, 2 / 3, 1 / 12, -1 / 12)


class Rates(NamedTuple):
    """Numbers that change with a value: their places in the `contents` of a named tuple, and their derivatives."""

    places: Indices
    rates: Array


def magnitude_of(path: str, value: float) -> float:
    """Return the magnitude of a value: its own, or that of its unit if it is zero."""
    return _unit(path) if abs(value) <= _ZERO else abs(value)


@lru_cache(1000)
def _unit(path: str) -> float:
    """Return the magnitude of a value of zero."""
    return _UNITS.get(value_unit(path), _UNIT)


def neighbours(system: System, values: Sequence[str | Direction]) -> list[Neighbours]:
    """Return the systems near a system for each of several values, with one for all numbers proportional to a value.

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
    numbers = {path: system.value(path) for path in paths if keeps_start(path) or path.endswith(".speed")}
    together = Together(system, {path: number for path, number in numbers.items() if abs(number) > _ZERO})
    return [Neighbours(system, value, together) for value in values]


class Together:
    """A system in which several values grow, each by another part of itself.

    A number that grows by one of these parts is proportional to that value: the parts have generic ratios, which
    products and powers of values do not match.

    Parameters
    ----------
    system : System
    values : dict of str to float
        By path, not zero.
    """

    def __init__(self, system: System, values: Mapping[str, float]) -> None:
        self._system, self._paths, self._values = system, list(values), np.array(list(values.values()))
        self._new = self._values * (1.0 + _PART * (1.0 + np.random.default_rng(0).random(len(values))))
        self._latest: tuple[Any, tuple[Indices, Array, Indices] | None] | None = None

    def rates(self, make: Callable[[System], Any], along: Mapping[str, float]) -> Rates | None:
        """Differentiate as `Neighbours.rates` along some paths; None if any number of these or others is not known."""
        if not along.keys() <= set(self._paths):
            return None
        if self._latest is None or self._latest[0] is not make:
            self._latest = make, self._owners(make)
        if self._latest[1] is None:
            return None
        places, numbers, owners = self._latest[1]
        rates = numbers * np.array([along.get(path, 0.0) for path in self._paths])[owners] / self._values[owners]
        return Rates(places[rates != 0.0], rates[rates != 0.0])

    @cached_property
    def _moved(self) -> System | None:
        """The system; None near a limit of a value."""
        with suppress(InputError, AssemblyError):
            return self._system.replaced(dict(zip(self._paths, self._new.tolist(), strict=True)))
        return None

    def _owners(self, make: Callable[[System], Any]) -> tuple[Indices, Array, Indices] | None:
        """Return the places of numbers that change, they themselves, and the values to which they are proportional."""
        if self._moved is None:
            return None
        own, other = contents(make(self._system)), contents(make(self._moved))
        if own.structure != other.structure:
            return None
        places, (here, there) = _changed(own, [other])
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.abs((there / here)[:, None] - self._new / self._values)
        known = len(here) == 0 or apart.min(axis=1).max() <= _ROUNDING
        return (places, here, apart.argmin(axis=1)) if known else None


class Neighbours:
    """Systems near a system, with other values at a path.

    They are built when they are needed.

    Parameters
    ----------
    system : System
    value : str or Direction
        A dotted path, see `linkages.System.replaced`; or a value that several paths follow.
    together : Together, optional
        Used where it is sufficient.

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

    def __init__(self, system: System, value: str | Direction, together: Together | None = None) -> None:
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
        """Differentiate the numbers of a named tuple that is made from a system; see `linkages.kernel.block.contents`.

        Raises
        ------
        InputError
            If the value changes integers, or shapes of arrays.
        """
        if self._together is not None and (found := self._together.rates(make, self.along)) is not None:
            return found
        systems, weights = self._systems
        own, *others = (contents(make(one)) for one in (self.system, *systems))
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
