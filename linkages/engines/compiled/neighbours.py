"""Systems at neighbouring values of a path: derivatives of any numbers that are computed from a system.

Example: the numbers of a spring's stiffness k have the derivative (n(k + h) - n(k - h)) / (2 h) with h = 3e-5 k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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

_STEP = 3e-5  # of differences, in parts of the value
_ZERO = 1e-7  # values of a smaller magnitude count as zero, SI units
_UNITS = {"m/s2": 10.0}  # magnitudes of a value of zero, by its unit
_UNIT = 1e-2  # of other units
_SAME = 1e-15  # relative change of a number by rounding: the value does not change it
_INTEGER = 1e-290  # an integer, read as a float, is smaller
_ROUNDING = 1e-13  # error of a number that is proportional to the value
#: Places and weights of differences: of the first order, for numbers proportional to the value; of the second one,
#: central, or to one side at a limit of the value.
_ONE = (1,), (1.0,)
_STENCILS = ((-1, 1), (-1 / 2, 1 / 2)), ((1, 2), (2.0, -1 / 2)), ((-1, -2), (-2.0, 1 / 2))
#: Places and weights of central differences of the fourth order; a constant gives exactly zero, pair by pair.
PAIRS = (-1.0, 1.0, -2.0, 2.0), (-2 / 3, 2 / 3, 1 / 12, -1 / 12)

_Stencil = tuple[tuple[int, ...], tuple[float, ...]]


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
    """Return the systems near a system for each of several values.

    Raises
    ------
    InputError
        See `Neighbours`.
    """
    names = [value if isinstance(value, str) else value.name for value in values]
    for k, (name, value) in enumerate(zip(names, values, strict=True)):
        if name in names[:k] or not (isinstance(value, str) or value.rates):
            raise InputError("argument", name, "is given twice" if name in names[:k] else "has no rates")
    return [Neighbours(system, value) for value in values]


class Neighbours:
    """Systems near a system, with other values at a path.

    Numbers that are proportional to the value need one system, others two. They are built when they are needed.

    Parameters
    ----------
    system : System
    value : str or Direction
        A dotted path, see `linkages.System.replaced`; or a value that several paths follow.

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

    def __init__(self, system: System, value: str | Direction) -> None:
        along = Direction(value, system.value(value), {value: 1.0}) if isinstance(value, str) else value
        self.path, self._value, self.along = along
        self.system, self.magnitude = system, magnitude_of(self.path, self._value)
        self._built: dict[int, System] = {}
        self._use(_ONE, *_STENCILS[2:])

    def _use(self, *stencils: _Stencil) -> None:
        """Build the systems of the first stencil whose values are valid."""
        for places, weights in stencils:
            try:
                self._systems = [self._moved(place) for place in places]
            except InputError as error:
                problem = error
            except AssemblyError as error:
                text = f"has no neighbouring value that can be assembled: {error}"
                problem = InputError("argument", self.path, text)
            else:
                self._weights = np.array(weights) / (_STEP * self.magnitude)
                return
        raise problem

    def _moved(self, place: int) -> System:
        if place not in self._built:
            step, value = place * _STEP * self.magnitude, self.system.value
            found = self.system.replaced({path: value(path) + step * rate for path, rate in self.along.items()})
            _ = found.assembly  # a failure leads to another stencil
            self._built[place] = found
        return self._built[place]

    def _is_exact(self, here: Array, found: Sequence[Array]) -> bool:
        """Whether differences of the first order are exact, or others are taken; otherwise take others from now on."""
        if len(found) > 1:
            return True
        change, part = found[0] - here, _STEP * self.magnitude / self._value if self._value else 0.0
        if not change.any() or np.all(np.abs(change - part * here) <= _ROUNDING * np.abs(here)):
            return True
        self._use(*_STENCILS)
        return False

    def derivative(self, numbers: Callable[[System], Array]) -> Array:
        """Differentiate an array of numbers."""
        here, found = numbers(self.system), [numbers(one) for one in self._systems]
        if any(one.shape != here.shape for one in found):
            raise self._other_structure()
        if not self._is_exact(here, found):
            return self.derivative(numbers)
        return np.tensordot(self._weights, [one - here for one in found], 1)

    def rates(self, make: Callable[[System], Any]) -> Rates:
        """Differentiate the numbers of a named tuple that is made from a system; see `linkages.kernel.block.contents`.

        Raises
        ------
        InputError
            If the value changes integers, or shapes of arrays.
        """
        own, *found = (contents(make(one)) for one in (self.system, *self._systems))
        if any(one.structure != own.structure for one in found):
            raise self._other_structure()
        places, values = _changed(own, found)
        if np.any((np.abs(values) < _INTEGER) & (values != 0.0)):
            raise self._other_structure()
        if not self._is_exact(values[0], values[1:]):
            return self.rates(make)
        return Rates(places, self._weights @ (values[1:] - values[0]))

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
