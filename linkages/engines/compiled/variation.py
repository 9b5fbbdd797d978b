"""A system whose numbers follow values: the derivatives of everything that a run reads with respect to the values.

The numbers of systems that are built for neighbouring values are differentiated by differences of the fourth order. So
lengths are differentiated through the assembly, and a contact's stiffness through its material.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, cast

import numpy as np

from linkages.engines.compiled.job import Given, make_given
from linkages.engines.compiled.model import Equations, make_work
from linkages.errors import AssemblyError, InputError
from linkages.kernel import Array, Indices, kernel
from linkages.kernel.block import Block, contents
from linkages.kernel.by_reference import packed
from linkages.outputs.registry import pack
from linkages.planar.arrays import Arrays
from linkages.planar.record_types import BODY
from linkages.system import System

_STEP = 1e-3  # of differences of a system's numbers, in parts of the value
_ZERO = 1e-4  # magnitude that counts for a value of zero, SI units
#: Places and weights of differences of the fourth order: central, else to one side, at a limit of the value.
_STENCILS = (
    ((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12)),
    ((0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4)),
    ((0, -1, -2, -3, -4), (25 / 12, -4.0, 3.0, -4 / 3, 1 / 4)),
)


_INERTIAL = ("mass", "cx", "cy", "inertia")  # the last fields of a body: they move nothing
assert (BODY.names or ())[-len(_INERTIAL) :] == _INERTIAL
_WORDS = BODY.itemsize // 8


class Variation(NamedTuple):
    """Equations of a model that compiled code moves along np values, and what changes with each value.

    Attributes
    ----------
    equations : Equations
        In a block of memory.
    memory : (nw,) array
        Of that block, as numbers.
    first : (np + 1,) array of int
        First of the changed numbers of each value, in the next three arrays.
    places : array of int
        Their indices in the memory.
    numbers : array
        They themselves.
    rates : array
        Their derivatives with respect to the value.
    unit : (np,) array
        Magnitude of the value.
    laws : (np, nc) array of int
        1 where the value changes the law of a contact.
    mechanics : (np,) array of int
        1 where it changes anything else.
    kinematics : (np,) array of int
        1 where it may move the ends of contacts at given coordinates, or prescribed coordinates.
    """

    equations: Equations
    memory: Array
    first: Indices
    places: Indices
    numbers: Array
    rates: Array
    unit: Array
    laws: Indices
    mechanics: Indices
    kinematics: Indices


@kernel
def move(variation: Variation, p: int, amount: float) -> None:
    """Move the model by an amount of value p from where the run is; zero restores it exactly."""
    for i in range(variation.first[p], variation.first[p + 1]):
        variation.memory[variation.places[i]] = variation.numbers[i] + amount * variation.rates[i]


def magnitude(value: float) -> float:
    """Return the magnitude of a value, for steps of differences."""
    return abs(value) if abs(value) > _ZERO * _STEP else _ZERO


def neighbours(system: System, path: str, step: float) -> tuple[list[System], Array]:
    """Systems near the value at a path, and the weights with which their numbers give the derivative.

    Raises
    ------
    InputError
        If there is no number at the path, or no neighbouring value is valid.
    """
    value, problem = system.value(path), InputError("", "", "")
    for places, weights in _STENCILS:
        try:
            found = [system.replaced({path: value + k * step}) if k else system for k in places]
            for one in found:
                _ = one.assembly  # a failure leads to other neighbours
        except InputError as error:
            problem = error
        except AssemblyError as error:
            problem = InputError("argument", path, f"has no neighbouring value with which the linkage closes: {error}")
        else:
            return found, np.array(weights) / step
    raise problem


class _Changes(NamedTuple):
    places: Indices  # of numbers that change, in `contents` of the model
    rates: Array
    start: Array


def _changes(system: System, path: str, given: Given) -> _Changes:
    """Differentiate the numbers of a model, and the state at t = 0."""
    found, weights = neighbours(system, path, _STEP * magnitude(system.value(path)))
    own = contents(given.model)
    words, starts = [], []
    for one in found:
        other = make_given(one, pack(one, ()), np.zeros((0, 2)))
        numbers = contents(other.model)
        if numbers.structure != own.structure or len(other.start) != len(given.start):
            raise InputError("argument", path, "changes the structure of the system: there is no derivative")
        words.append(numbers.words)
        starts.append(other.start - given.start)
    table = np.stack([*words, own.words])
    places = np.flatnonzero((table != table[0]).any(axis=0))
    values = table[:, places].view(np.float64)
    if np.any((np.abs(values) < 1e-290) & (values != 0.0)):  # an integer, as a float
        raise InputError("argument", path, "changes the structure of the system: there is no derivative")
    finite = np.isfinite(values).all(axis=0)
    values, places = values[:, finite], places[finite]
    return _Changes(places, weights @ (values[:-1] - values[-1]), weights @ np.stack(starts))


def vary(system: System, paths: Sequence[str], given: Given) -> tuple[Variation, Array]:
    """Return the variation of a system with the values at np paths, and the derivatives of its start, (ny, np).

    Raises
    ------
    InputError
        If a path has no number, or no derivative.
    """
    model, nc = given.model, len(given.model.ends)
    block = Block(Equations(model, make_work(model, np.zeros((nc, 2)), np.full(nc, -1)), given.implicit))
    memory, own = block.memory.view(np.float64), contents(model).words.view(np.float64)
    changes = [_changes(system, path, given) for path in paths]
    laws, mechanics, kinematics = (np.zeros((len(paths), *more), np.int64) for more in ((nc,), (), ()))
    for p, change in enumerate(changes):
        for name, place in _fields(model):
            inside = change.places[(change.places >= place.start) & (change.places < place.stop)] - place.start
            if not len(inside) or name in ("limits", "stiff"):
                continue
            if name in ("laws", "tables", "ends"):  # a line for each contact
                laws[p, inside // (len(place) // nc)] = 1
            if name not in ("laws", "tables"):
                mechanics[p] = 1
            inertial = name == "bodies" and np.all(inside < model.bodies.records.size * _WORDS)
            inertial = inertial and np.all(inside % _WORDS >= _WORDS - len(_INERTIAL))
            if not inertial and name in ("bodies", "ends", "motion", "motion_c"):
                kinematics[p] = 1
    places = np.concatenate([np.zeros(0, np.int64), *(one.places for one in changes)])
    variation = Variation(
        cast(Equations, block),
        memory,
        np.cumsum([0, *(len(one.places) for one in changes)]),
        np.ascontiguousarray(block.where[places]),
        own[places],
        np.concatenate([np.zeros(0), *(one.rates for one in changes)]),
        np.array([magnitude(system.value(path)) for path in paths]),
        laws,
        mechanics,
        kinematics,
    )
    start = [np.zeros((len(given.start), 0)), *(one.start[:, None] for one in changes)]
    return packed(variation), np.concatenate(start, axis=1)


def _fields(model: Arrays) -> Iterator[tuple[str, range]]:
    """Fields of a model, and their places in its `contents`."""
    start = 0
    for name, value in model._asdict().items():
        end = start + len(contents((value,)).words)
        yield name, range(start, end)
        start = end
