"""Systems at neighbouring values of a path: derivatives of any numbers that are computed from a system."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.errors import AssemblyError, InputError
from linkages.kernel import Array, Indices
from linkages.kernel.block import Contents, contents
from linkages.model.experiment import value_unit
from linkages.results.derivatives import Direction
from linkages.system import System

_STEP = 3e-5  # of differences, in parts of the value
_ZERO = 1e-7  # values of a smaller magnitude count as zero, SI units
_UNITS = {"m/s2": 10.0}  # magnitudes of a value of zero, by its unit
_UNIT = 1e-2  # of other units
_ROUNDING = 1e-13  # error of a number that is proportional to the value
_BENT = 1e-4  # second over first difference, beyond which two systems do not give nine digits
#: Places and weights of differences: of the first order, for numbers proportional to the value; central, of the
#: second and the fourth order; to one side, at a limit of the value.
_ONE = (1,), (1.0,)
_PAIR = (-1, 1), (-1 / 2, 1 / 2)
_FOUR = (-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12)
_UPWARD = (0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4)
_DOWNWARD = (0, -1, -2, -3, -4), (25 / 12, -4.0, 3.0, -4 / 3, 1 / 4)
_INTEGER = 1e-290  # an integer, read as a float, is smaller

_Stencil = tuple[tuple[int, ...], tuple[float, ...]]


class Rates(NamedTuple):
    """Numbers that change with a value: their places in the `contents` of a named tuple, and their derivatives."""

    places: Indices
    rates: Array


class Neighbours:
    """Systems near a system, with other values at a path.

    Numbers that are proportional to the value need one system, nearly linear ones two, others four. They are built when
    they are needed.

    Parameters
    ----------
    system : System
    value : str or Direction
        A dotted path, see `linkages.System.replaced`; or a value that several paths follow.

    Attributes
    ----------
    magnitude : float
        Of the value.

    Raises
    ------
    InputError
        If there is no number at the path, or no neighbouring value is valid.
    """

    def __init__(self, system: System, value: str | Direction) -> None:
        along = Direction(value, system.value(value), {value: 1.0}) if isinstance(value, str) else value
        path, self._value, rates = along
        self.system, self.path = system, path
        self._along = {each: (system.value(each), rate) for each, rate in rates.items()}
        small = abs(self._value) <= _ZERO
        self.magnitude = _UNITS.get(value_unit(path), _UNIT) if small else abs(self._value)
        self._built = {0: system}
        problem = InputError("argument", path, "has no derivative")
        for stencil in (_ONE, _DOWNWARD):
            try:
                self._use(stencil)
            except InputError as error:
                problem = error
            except AssemblyError as error:
                problem = InputError("argument", path, f"has no neighbouring value that can be assembled: {error}")
            else:
                return
        raise problem

    def _use(self, stencil: _Stencil) -> None:
        """Build the systems of a stencil."""
        step = _STEP * self.magnitude
        for k in stencil[0]:
            if k not in self._built:
                found = self.system.replaced({path: x + k * step * rate for path, (x, rate) in self._along.items()})
                _ = found.assembly  # a failure leads to another stencil
                self._built[k] = found
        self.systems, self.weights = [self._built[k] for k in stencil[0]], np.array(stencil[1]) / step

    def derivative(self, numbers: Callable[[System], Array]) -> Array:
        """Differentiate an array of numbers, which may be long."""
        return self._derivative([numbers(one) for one in self.systems], numbers)

    def _derivative(self, found: list[Array], numbers: Callable[[System], Array]) -> Array:
        here = numbers(self.system)
        if any(len(one) != len(here) for one in found):
            raise self._other_structure()
        changes = np.stack([one - here for one in found])
        if self._refine(here, changes):
            return self.derivative(numbers)
        return np.tensordot(self.weights, changes, 1)

    def _refine(self, here: Array, changes: Array) -> bool:
        """Build more systems if the changes are not accurate; False if they are, or if there are no more."""
        if len(changes) == 1:
            expected = here * (_STEP * self.magnitude / self._value) if self._value else 0.0 * here
            if np.all(np.abs(changes[0] - expected) <= _ROUNDING * np.abs(here)) or not changes.any():
                return False
        elif len(changes) != 2 or np.all(np.abs(changes.sum(axis=0)) <= _BENT * np.abs(changes).max(axis=0)):
            return False
        for stencil in (_PAIR, _UPWARD) if len(changes) == 1 else (_FOUR,):
            try:
                self._use(stencil)
            except (InputError, AssemblyError):
                continue  # near a limit of the value
            return True
        return False

    def rates(self, make: Callable[[System], Any]) -> Rates:
        """Differentiate the numbers of a named tuple that is made from a system; see `linkages.kernel.block.contents`.

        Raises
        ------
        InputError
            If the value changes integers, or shapes of arrays.
        """
        kept: dict[int, Contents] = {}

        def read(one: System) -> Contents:
            if id(one) not in kept:
                kept[id(one)] = contents(make(one))
            return kept[id(one)]

        own = read(self.system)
        others = [read(one) for one in self.systems]
        if any(one.structure != own.structure for one in others):
            raise self._other_structure()
        changed: NDArray[np.bool_] = np.any([one.words != own.words for one in others], axis=0)
        places = np.flatnonzero(changed)
        values = np.stack([own.words[places], *(one.words[places] for one in others)]).view(np.float64)
        if np.any((np.abs(values) < _INTEGER) & (values != 0.0)):
            raise self._other_structure()
        places = places[np.isfinite(values).all(axis=0)]
        return Rates(places, self.derivative(lambda one: read(one).words[places].view(np.float64)))

    def _other_structure(self) -> InputError:
        return InputError("argument", self.path, "changes the structure of the system: there is no derivative")
