"""Systems at neighbouring values of a path: derivatives of any numbers that are computed from a system."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, lru_cache
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
_ROUNDING = 1e-13  # error of a number that is proportional to the value
_SAME = 1e-15  # relative change of a number by rounding: the value does not change it
_BENT = 1e-4  # second over first difference, beyond which two systems do not give nine digits
#: Places and weights of differences: of the first order, for numbers proportional to the value; central, of the
#: second and the fourth order; to one side, at a limit of the value.
_ONE = (1,), (1.0,)
_PAIR = (-1, 1), (-1 / 2, 1 / 2)
_FOUR = (-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12)
#: Places and weights of central differences of the fourth order; a constant gives exactly zero, pair by pair.
PAIRS = (-1.0, 1.0, -2.0, 2.0), (-2 / 3, 2 / 3, 1 / 12, -1 / 12)
_UPWARD = (0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4)
_DOWNWARD = (0, -1, -2, -3, -4), (25 / 12, -4.0, 3.0, -4 / 3, 1 / 4)
_INTEGER = 1e-290  # an integer, read as a float, is smaller

_MANY = 50  # values that are moved together
_SPREAD = 1e-3 * (1.0 + np.random.default_rng(0).random(_MANY))  # their steps, in parts of their magnitudes

_Stencil = tuple[tuple[int, ...], tuple[float, ...]]


class Rates(NamedTuple):
    """Numbers that change with a value: their places in the `contents` of a named tuple, and their derivatives."""

    places: Indices
    rates: Array


class Together:
    """A system in which the values at several paths are moved at once, each by another part of itself.

    A number that is proportional to a value changes by the same part; the coordinate of a point changes by the step of
    a length, its half, or the sum or difference of two steps. So it is known to which values the number belongs, and
    one system is sufficient for all such values. The steps have generic ratios, which products and powers of values do
    not match.

    Parameters
    ----------
    system : System
    values : dict of str to float
        Their numbers by path.
    """

    def __init__(self, system: System, values: Mapping[str, float]) -> None:
        self._system, self._paths, self._values = system, list(values), np.array(list(values.values()))
        units = [magnitude_of(path, value) for path, value in values.items()]
        self._new = self._values + _SPREAD[: len(values)] * units
        self._steps = self._new - self._values  # after rounding
        self._latest: tuple[Any, tuple[Indices, Array] | None] | None = None

    @cached_property
    def _moved(self) -> System | None:
        """The system; None near a limit of a value."""
        with suppress(InputError):
            return self._system.replaced(dict(zip(self._paths, self._new.tolist(), strict=True)))
        return None

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        """Slopes of coordinates of points (m, np), and the changes of such coordinates (m,)."""
        one, (first, second) = np.eye(len(self._paths)), np.triu_indices(len(self._paths), 1)
        slopes = np.concatenate([one, one / 2, one[first] + one[second], one[first] - one[second]])
        slopes = np.concatenate([slopes, -slopes])
        return slopes, slopes @ self._steps

    def covers(self, along: Mapping[str, float]) -> bool:
        """Tell whether some paths are among these."""
        return along.keys() <= set(self._paths)

    def rates(self, make: Callable[[System], Any], along: Mapping[str, float]) -> Rates | None:
        """Differentiate as `Neighbours.rates` along the rates of some paths; None if an owner is unknown."""
        if self._latest is None or self._latest[0] is not make:
            self._latest = make, self._changes(make)
        if self._latest[1] is None:
            return None
        rates = self._latest[1][1] @ [along.get(path, 0.0) for path in self._paths]
        mine = rates != 0.0
        return Rates(self._latest[1][0][mine], rates[mine])

    def still(self, numbers: Callable[[System], Array]) -> bool:
        """Tell whether no value changes an array of numbers."""
        return self._moved is not None and np.array_equal(numbers(self._system), numbers(self._moved))

    def _changes(self, make: Callable[[System], Any]) -> tuple[Indices, Array] | None:
        """Return the places of numbers that change, (n,), and their derivatives, (n, np)."""
        with suppress(InputError, AssemblyError):  # the value's own systems tell
            if self._moved is not None:
                own, other = contents(make(self._system)), contents(make(self._moved))
                if own.structure == other.structure:
                    places, numbers = _changed(own, [other])
                    rates = self._differences(*numbers)
                    return None if rates is None else (places, rates)
        return None

    def _differences(self, here: Array, there: Array) -> Array | None:
        """Differentiate numbers (n,) with respect to the values, (n, np)."""
        rates = np.zeros((len(here), len(self._paths)))
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.abs((there / here - 1.0)[:, None] - self._steps / self._values)
            owners, unknown = np.argmin(apart, axis=1), ~(apart.min(axis=1) <= _ROUNDING)
            rates[np.arange(len(here)), owners] = here / self._values[owners]
        rates[unknown] = 0.0
        if unknown.any():
            slopes, changes = self._slopes
            apart = np.abs(changes - (there - here)[unknown, None])
            fits = apart <= _ROUNDING * np.abs(here[unknown, None])
            if not np.all(fits.sum(axis=1) == 1):
                return None
            rates[unknown] = slopes[np.argmax(fits, axis=1)]
        return rates


def magnitude_of(path: str, value: float) -> float:
    """Return the magnitude of a value: its own, or that of its unit if it is zero."""
    return _unit(path) if abs(value) <= _ZERO else abs(value)


@lru_cache(1000)
def _unit(path: str) -> float:
    """Return the magnitude of a value of zero."""
    return _UNITS.get(value_unit(path), _UNIT)


def _changed(own: Contents, others: Sequence[Contents]) -> tuple[Indices, Array]:
    """Return the places of the numbers that differ from others by more than rounding, and these, (1 + k, n).

    Raises
    ------
    InputError
        If an integer differs.
    """
    differs: NDArray[np.bool_] = np.any([one.words != own.words for one in others], axis=0)
    places = np.flatnonzero(differs)
    values = np.stack([one.words[places] for one in (own, *others)]).view(np.float64)
    if np.any((np.abs(values) < _INTEGER) & (values != 0.0)):
        raise InputError("", "", "an integer")
    kept = np.isfinite(values).all(axis=0)
    places, values = places[kept], values[:, kept]
    kept = np.abs(values[1:] - values[0]).max(axis=0, initial=0.0) > _SAME * np.abs(values[0])
    return places[kept], values[:, kept]


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
    paths = {path for value in values for path in ([value] if isinstance(value, str) else value.rates)}
    every = {path: system.value(path) for path in sorted(paths)}
    proportional = {path: value for path, value in every.items() if keeps_start(path) and abs(value) > _ZERO}
    free_of_laws = {path: value for path, value in every.items() if not path.startswith("joints.")}
    groups = [dict(islice(each.items(), _MANY)) for each in (every, proportional, free_of_laws)]
    shared = [Together(system, each) for k, each in enumerate(groups) if each not in groups[:k]]
    directions = [Direction(one, every[one], {one: 1.0}) if isinstance(one, str) else one for one in values]
    return [Neighbours(system, direction, shared) for direction in directions]


class Neighbours:
    """Systems near a system, with other values at a path.

    Numbers that are proportional to the value need one system, nearly linear ones two, others four. They are built when
    they are needed.

    Parameters
    ----------
    system : System
    value : str or Direction
        A dotted path, see `linkages.System.replaced`; or a value that several paths follow.
    together : sequence of Together
        Systems for several values, which are used if they are sufficient for this one.

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
        self.path, self._value, self.along = along
        self.system, self.magnitude = system, magnitude_of(self.path, self._value)
        self._built, self._together = {0: system}, together
        self.systems: list[System] = []
        if not together:
            self._begin()

    def _begin(self) -> None:
        """Build the first systems."""
        path = self.path
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
        step, value = _STEP * self.magnitude, self.system.value
        for k in stencil[0]:
            if k not in self._built:
                found = self.system.replaced({path: value(path) + k * step * by for path, by in self.along.items()})
                _ = found.assembly  # a failure leads to another stencil
                self._built[k] = found
        self.systems, self.weights = [self._built[k] for k in stencil[0]], np.array(stencil[1]) / step

    def derivative(self, numbers: Callable[[System], Array], together: bool = False) -> Array:
        """Differentiate an array of numbers, which may be long.

        Errors are compared with each number's change; if `together`, with the largest one along the last axis.
        """
        if not self.systems:
            if any(each.still(numbers) for each in self._together if each.covers(self.along)):
                return 0.0 * numbers(self.system)
            self._begin()
        here, found = numbers(self.system), [numbers(one) for one in self.systems]
        if any(len(one) != len(here) for one in found):
            raise self._other_structure()
        changes = np.stack([one - here for one in found])
        if self._refine(here, changes, together):
            return self.derivative(numbers, together)
        return np.tensordot(self.weights, changes, 1)

    def _refine(self, here: Array, changes: Array, together: bool) -> bool:
        """Build more systems if the changes are not accurate; False if they are, or if there are no more."""
        if len(changes) == 1:
            expected = here * (_STEP * self.magnitude / self._value) if self._value else 0.0 * here
            if np.all(np.abs(changes[0] - expected) <= _ROUNDING * np.abs(here)) or not changes.any():
                return False
        elif len(changes) != 2:
            return False
        else:
            largest = np.abs(changes).max(axis=0)
            largest = largest.max(axis=-1, keepdims=True, initial=0.0) if together else largest
            if np.all(np.abs(changes.sum(axis=0)) <= _BENT * largest):
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
        if not self.systems:
            for each in self._together:
                if each.covers(self.along) and (found := each.rates(make, self.along)) is not None:
                    return found
            self._begin()
        own = contents(make(self.system))
        kept: dict[int, Contents] = {id(self.system): own}

        def read(one: System) -> Contents:
            if id(one) not in kept:
                kept[id(one)] = contents(make(one))
            if kept[id(one)].structure != own.structure:
                raise self._other_structure()
            return kept[id(one)]

        try:
            places, _ = _changed(own, [read(one) for one in self.systems])
        except InputError:
            raise self._other_structure() from None
        return Rates(places, self.derivative(lambda one: read(one).words[places].view(np.float64)))

    @cached_property
    def arrays(self) -> Rates:
        """Differentiate the arrays of the system."""
        return self.rates(_arrays)

    def _other_structure(self) -> InputError:
        return InputError("argument", self.path, "changes the structure of the system: there is no derivative")


def _arrays(system: System) -> Arrays:
    return unscaled(system.arrays)


def unscaled(model: Arrays) -> Arrays:
    """Return a model whose length, a scale of errors alone, does not change with any value."""
    return model._replace(size=1.0)
