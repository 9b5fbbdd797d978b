"""Derivatives of any numbers that are computed from a system, with respect to values.

Of values that fill numbers as they are the register (`linkages.system.owners`) tells these. Of others, such as lengths
that move the whole machine, they are differences of systems at neighbouring values: the numbers n of a value x have the
derivative (n(x + h) - n(x - h)) / (2 h) with h = 3e-5 x.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.errors import AssemblyError, InputError
from linkages.base.kernel import Array, Indices
from linkages.base.kernel.block import Contents, are_floats, contents, starts
from linkages.engines.numerics import NEIGHBOURS_SAME, NEIGHBOURS_STEP, NEIGHBOURS_UNIT, NEIGHBOURS_ZERO
from linkages.input.model.experiment import value_unit
from linkages.mechanics.planar.arrays import Arrays
from linkages.results.derivatives import Direction
from linkages.system import System
from linkages.system.owners import Fill, owners

_UNITS = {"m/s2": 10.0}  # magnitudes of a value of zero, by its unit
#: Places and weights of differences of the second order: central, or to one side at a limit of the value.
_STENCILS = ((-1, 1), (-1 / 2, 1 / 2)), ((1, 2), (2.0, -1 / 2)), ((-1, -2), (-2.0, 1 / 2))


class Rates(NamedTuple):
    """Numbers that change with a value: their places in the `contents` of a named tuple, and their derivatives."""

    places: Indices
    rates: Array


def magnitude_of(path: str, value: float) -> float:
    """Return the magnitude of a value: its own, or that of its unit if it is zero."""
    return _unit(path) if abs(value) <= NEIGHBOURS_ZERO else abs(value)


@lru_cache(1000)
def _unit(path: str) -> float:
    """Return the magnitude of a value of zero."""
    return _UNITS.get(value_unit(path), NEIGHBOURS_UNIT)


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

    They are built when they are needed.

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
        self.path, number, self.along = along
        self.system, self.magnitude = system, magnitude_of(self.path, number)

    @cached_property
    def _systems(self) -> tuple[list[System], Array]:
        """Return the systems, and the weights of their numbers."""
        for places, weights in _STENCILS:
            try:
                return [self._moved(place) for place in places], np.array(weights) / (NEIGHBOURS_STEP * self.magnitude)
            except InputError as error:
                problem = error
            except AssemblyError as error:
                text = f"has no neighbouring value that can be assembled: {error}"
                problem = InputError("argument", self.path, text)
        raise problem

    def _moved(self, place: int) -> System:
        step, value = place * NEIGHBOURS_STEP * self.magnitude, self.system.value
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
        register = _owners(self.system)
        if all(path in register for path in self.along):
            return self._owned(make, register)
        systems, weights = self._systems
        own, others = _own(make, self.system), [contents(make(one)) for one in systems]
        if any(one.structure != own.numbers.structure for one in others):
            raise self._other_structure()
        places, values = self._changed(own, others)
        return Rates(places, weights @ (values[1:] - values[0]))

    def _owned(self, make: Callable[[System], Any], register: Mapping[str, Sequence[Fill]]) -> Rates:
        """Differentiate numbers that the values fill."""
        begin, found = _own(make, self.system).starts, dict[int, float]()
        for path, rate in self.along.items():
            for fill in register[path]:
                if fill.array in begin:
                    place = begin[fill.array] + fill.place
                    found[place] = found.get(place, 0.0) + rate * fill.rate
        kept = {place: rate for place, rate in sorted(found.items()) if rate != 0.0}
        return Rates(np.array([*kept], np.int64), np.array([*kept.values()]))

    def _changed(self, own: _Numbers, others: Sequence[Contents]) -> tuple[Indices, Array]:
        """Return the places of the finite numbers that differ by more than rounding, and these, (1 + k, n)."""
        words = [own.numbers.words, *(one.words for one in others)]
        places = np.flatnonzero(np.any([one != words[0] for one in words[1:]], axis=0))
        if not own.floats[places].all():
            raise self._other_structure()
        values = np.stack([one[places] for one in words]).view(np.float64)
        with np.errstate(invalid="ignore"):
            differ = np.abs(values[1:] - values[0]).max(axis=0, initial=0.0) > NEIGHBOURS_SAME * np.abs(values[0])
        kept = np.isfinite(values).all(axis=0) & differ
        return places[kept], values[:, kept]

    @cached_property
    def arrays(self) -> Rates:
        """Differentiate the arrays of the system."""
        return self.rates(_arrays)

    def _other_structure(self) -> InputError:
        return InputError("argument", self.path, "changes the structure of the system: there is no derivative")


class _Numbers(NamedTuple):
    """The numbers of a named tuple, the place of the first one of each array, and which are floats."""

    numbers: Contents
    starts: Mapping[str, int]
    floats: NDArray[np.bool_]


@lru_cache(4)
def _own(make: Callable[[System], Any], system: System) -> _Numbers:
    """Return the numbers of the system itself."""
    made = make(system)
    return _Numbers(contents(made), starts(made), are_floats(made))


@lru_cache(2)
def _owners(system: System) -> Mapping[str, Sequence[Fill]]:
    return owners(system)


def _arrays(system: System) -> Arrays:
    return unscaled(system.arrays)


def unscaled(model: Arrays) -> Arrays:
    """Return a model whose scales, of errors by a length and of closure rows by masses, do not change with a value."""
    rows = model.rows.copy()
    rows["scale"] = 1.0
    return model._replace(size=1.0, rows=rows)
