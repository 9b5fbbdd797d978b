"""A system whose numbers follow values: the derivatives of everything that a run reads with respect to the values.

The numbers of neighbouring systems are differentiated (`linkages.engines.compiled.derivatives.neighbours`). So lengths
are differentiated through the assembly, and a contact's stiffness through its material.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.base.kernel.block import Duplicate
from linkages.base.kernel.by_reference import Packed, packed
from linkages.engines.compiled.derivatives.neighbours import Neighbours, unscaled
from linkages.engines.compiled.derivatives.start_derivatives import start_derivatives
from linkages.engines.compiled.run.job import Given, model_of
from linkages.engines.compiled.run.model import Equations, make_memory, make_work
from linkages.laws import PARAMETERS
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.record_types import BODY, ENDS
from linkages.results.outputs.registry import pack
from linkages.system import System

#: Effect of a value beside that on laws of contacts: none; on inertial forces alone; the residual of the equations is a
#: polynomial of the second order in its numbers, at fixed accelerations and forces of contacts; any.
STILL, INERTIAL, QUADRATIC, ANY = range(4)


def _words(record: np.dtype[Any]) -> list[str]:
    """Return the name of each word of a record, of nested ones with a dot."""
    parts = ((name, record[name]) for name in record.names or ())
    return [f"{name}.{inner}" if inner else name for name, kind in parts for inner in (kind.names or [""])]


#: Numbers of rigid bodies and of contacts in which the residual is of the second order.
_MOUNT = [_words(BODY).index(name) for name in ("mount.x", "mount.y")]
_OF_MASS = [_words(BODY).index(name) for name in ("mass", "cx", "cy", "inertia")]
_OF_ENDS = [_words(ENDS).index(name) for name in ("bearing.x", "bearing.y", "journal.x", "journal.y")]
_NORMAL, _HALF = [_words(ENDS).index(name) for name in ("nx", "ny")], _words(ENDS).index("half")
_LENGTHS = [_words(PARAMETERS).index(name) for name in ("clearance", "radius")]
#: Fields of a model whose numbers change no motion: scales and results, and laws of contacts.
_STILL = "limits", "stiff", "joints", "laws", "tables"


class Variation(NamedTuple):
    """Equations of a model that compiled code moves along np values, and what changes with each value.

    Attributes
    ----------
    equations : Equations
        With a model whose arrays are parts of the next one.
    memory : (nw,) array
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
        1 where the value changes the law or the gap of a contact at a given motion.
    gaps : (np, nc) array
        Rate of the gap of each contact at a given motion, or of its radius, per unit of the value [m; stop of a
        revolute joint: rad].
    effect : (np,) array of int
        `STILL`, `INERTIAL`, `QUADRATIC` or `ANY`.
    """

    equations: Equations
    memory: Array
    first: Indices
    places: Indices
    numbers: Array
    rates: Array
    unit: Array
    laws: Indices
    gaps: Array
    effect: Indices


@kernel
def move(variation: Variation, p: int, amount: float) -> None:
    """Move the model by an amount of value p from where the run is; zero restores it exactly."""
    for i in range(variation.first[p], variation.first[p + 1]):
        variation.memory[variation.places[i]] = variation.numbers[i] + amount * variation.rates[i]


def vary(system: System, nearby: Sequence[Neighbours], given: Given) -> tuple[Variation, Array]:
    """Return the variation of a system with np values, and the derivatives of its start, (ny, np).

    Raises
    ------
    InputError
        If a value has no derivative.
    """
    model, count, nc = given.model, len(nearby), len(given.model.ends)
    moved, none = Duplicate(model), pack(system, ())
    whole = model is system.arrays  # no sections of links are left out

    def reduced(one: System) -> Arrays:
        return unscaled(model_of(one, none))

    changes = [near.arrays if whole else near.rates(reduced) for near in nearby]
    effects, contacts, factors = _effects(model)
    laws, gaps = np.zeros((count, nc), np.int64), np.zeros((count, nc))
    for p, (places, rates) in enumerate(changes):
        mine = contacts[places] >= 0
        of = contacts[places][mine]
        laws[p, of] = 1
        np.maximum.at(gaps[p], of, (factors[places] * np.abs(rates))[mine])
    places = np.concatenate([np.zeros(0, np.int64), *(one.places for one in changes)])
    equations = packed(Equations(moved.value, make_work(model, make_memory(model), np.full(nc, -1)), given.implicit))
    variation = Variation(
        equations,
        moved.numbers,
        np.cumsum([0, *(len(one.places) for one in changes)]),
        places,
        moved.initial[places],
        np.concatenate([np.zeros(0), *(one.rates for one in changes)]),
        np.array([near.magnitude for near in nearby]),
        laws,
        gaps,
        np.array([effects[one.places].max(initial=STILL) for one in changes], np.int64),
    )
    return packed(variation), start_derivatives(system, nearby)


def _effects(model: Arrays) -> tuple[Indices, Indices, Array]:
    """Return of each number of a model: its effect; the contact whose law it changes, or -1; the change of its gap.

    Changes of gaps are at least right in magnitude: a wall's normal turns about a point within the linkage's length.
    """
    ends = np.cumsum([0, *map(_count, model)]).tolist()
    fields = {name: slice(*part) for name, part in zip(model._fields, pairwise(ends), strict=True)}
    effects, contacts, gaps = np.full(ends[-1], ANY), np.full(ends[-1], -1), np.zeros(ends[-1])
    nc, nb = len(model.ends), len(model.bodies.records)
    for name in _STILL:
        effects[fields[name]] = STILL
    for name in ("laws", "tables"):  # a line for each contact
        contacts[fields[name]] = np.repeat(np.arange(nc), _count(getattr(model, name)) // max(nc, 1))
    gaps[fields["laws"]].reshape(nc, len(_words(PARAMETERS)))[:, _LENGTHS] = 1.0
    shape = nc, len(_words(ENDS))
    of_ends = effects[fields["ends"]].reshape(shape)
    of_ends[:, _HALF] = STILL
    contacts[fields["ends"]].reshape(shape)[:, [*_NORMAL, _HALF]] = np.arange(nc)[:, None]
    gaps[fields["ends"]].reshape(shape)[:, _NORMAL], gaps[fields["ends"]].reshape(shape)[:, _HALF] = model.size, 1.0
    if not len(model.rows) and not model.bodies.shapes.shape[2]:  # a tree of rigid bodies
        of_ends[:, _OF_ENDS] = QUADRATIC
        effects[fields["gravity"]] = INERTIAL
        bodies = effects[fields["bodies"]][: nb * len(_words(BODY))].reshape(nb, len(_words(BODY)))
        bodies[:, _MOUNT], bodies[:, _OF_MASS] = QUADRATIC, INERTIAL
    return effects, contacts, gaps


def _count(value: Any) -> int:
    """Count the numbers of a value."""
    if isinstance(value, np.ndarray):
        return value.nbytes // 8
    if isinstance(value, Packed):
        return _count(value.unpacked)
    return sum(map(_count, value)) if isinstance(value, tuple) else 1
