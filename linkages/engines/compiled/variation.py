"""A system whose numbers follow values: the derivatives of everything that a run reads with respect to the values.

The numbers of neighbouring systems are differentiated (`linkages.engines.compiled.neighbours`). So lengths are
differentiated through the assembly, and a contact's stiffness through its material.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from linkages.engines.compiled.job import Given, model_of
from linkages.engines.compiled.kinks import kinks
from linkages.engines.compiled.model import Equations, make_memory, make_work
from linkages.engines.compiled.neighbours import Neighbours, unscaled
from linkages.engines.compiled.start_derivatives import start_derivatives
from linkages.kernel import Array, Indices, inlined_kernel, kernel
from linkages.kernel.block import Duplicate
from linkages.kernel.by_reference import Packed, packed
from linkages.laws import PARAMETERS
from linkages.outputs.registry import pack
from linkages.planar.arrays import Arrays
from linkages.planar.record_types import BODY, ENDS, MARKER
from linkages.system import System

EXACT = 2
_INERTIAL = ("mass", "cx", "cy", "inertia")  # the last fields of a body: they move nothing
assert (BODY.names or ())[-len(_INERTIAL) :] == _INERTIAL
_WORDS, _LAST = BODY.itemsize // 8, len(_INERTIAL)
#: Words of `BODY`: mount x, y, mass, mass centre x, y, moment of inertia.
_OF_BODY = [1, 2, *range(_WORDS - _LAST, _WORDS)]
_MARKERS = list(range(1, 1 + 2 * len(MARKER.names or ())))  # of the ends of a contact: its law does not read them
assert (BODY.names or ())[0] == "mount"
assert (ENDS.names or ())[1:3] == ("bearing", "journal")
_OF_ENDS = [2, 3, 5, 6]  # coordinates among them
_CLEARANCE = (PARAMETERS.names or ()).index("clearance")  # word of a law
assert (ENDS.names or ())[-3:] == ("nx", "ny", "half")
_NORMAL, _HALF = slice(-3, -1), -1  # words of the ends
#: Effects of a number: on the law of a contact; on the mechanics; without exact derivatives of it; on the motions of
#: contacts at given coordinates; on prescribed motions.
_LAW, _MECHANICS, _ROUGH, _KINEMATICS, _DRIVES = 1, 2, 4, 8, 16
#: Effects of the numbers of some fields of a model; others have effects on the mechanics, without exact derivatives.
_OF_FIELDS = {
    ("limits", "stiff"): 0,
    ("laws", "tables"): _LAW,
    ("gravity", "joints"): _MECHANICS,
    ("motion", "motion_c"): _MECHANICS | _KINEMATICS | _DRIVES,
    ("bodies",): _MECHANICS | _ROUGH | _KINEMATICS,
    ("ends",): _MECHANICS | _ROUGH | _KINEMATICS,
}


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
    laws : (np, nc) array
        Rate of the parameters of the law of each contact, in parts of their magnitudes; 0 where the value changes none.
    gaps : (np, nc) array
        Rate of the gap of each contact at a given motion [m, stop of a revolute joint: rad, per unit of the value].
    mechanics : (np,) array of int
        1 where it changes anything else; `EXACT` where the mechanics has exact derivatives with respect to the changed
        numbers: of rigid bodies without closure rows, of markers of contacts, of gravity and prescribed motions.
    kinematics : (np,) array of int
        1 where it may move the ends of contacts at given coordinates, or prescribed coordinates.
    drives : (np,) array of int
        1 where it changes a prescribed motion.
    kinks, kink_rates : (nc, KINKS), (np, nc, KINKS) arrays
        See `linkages.engines.compiled.kinks.kinks`, and their derivatives.
    """

    equations: Equations
    memory: Array
    first: Indices
    places: Indices
    numbers: Array
    rates: Array
    unit: Array
    laws: Array
    gaps: Array
    mechanics: Indices
    kinematics: Indices
    drives: Indices
    kinks: Array
    kink_rates: Array


@inlined_kernel
def changes_law(variation: Variation, p: int, k: int) -> bool:
    """Whether value p changes the law or the gap of contact k."""
    return bool(variation.laws[p, k] > 0.0 or variation.gaps[p, k] > 0.0)


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
    model, nc = given.model, len(given.model.ends)
    moved = Duplicate(model)
    none = pack(system, ())
    whole = model is system.arrays  # no sections of links are left out

    def reduced(one: System) -> Arrays:
        return unscaled(model_of(one, none))

    changes = [near.arrays if whole else near.rates(reduced) for near in nearby]
    fields = _fields(model)
    effects, contacts = _effects(model, fields)
    found = np.array([np.bitwise_or.reduce(effects[one.places], initial=0) for one in changes], np.int64)
    laws, gaps, factors = np.zeros((len(nearby), nc)), np.zeros((len(nearby), nc)), _gap_factors(model, fields)
    for p, (near, one) in enumerate(zip(nearby, changes, strict=True)):
        laws[p, contacts[one.places[(effects[one.places] & _LAW) > 0]]] = 1.0 / near.magnitude
        mine = factors[one.places] > 0.0
        changed = one.places[mine]
        np.maximum.at(gaps[p], contacts[changed], factors[changed] * np.abs(one.rates[mine]))
    mechanics = np.where(found & _MECHANICS, np.where(found & _ROUGH, 1, EXACT), 0)
    kinematics, drives = ((found & effect > 0).astype(np.int64) for effect in (_KINEMATICS, _DRIVES))
    places = np.concatenate([np.zeros(0, np.int64), *(one.places for one in changes)])
    limits = kinks(system)
    variation = Variation(
        packed(Equations(moved.value, make_work(model, make_memory(model), np.full(nc, -1)), given.implicit)),
        moved.numbers,
        np.cumsum([0, *(len(one.places) for one in changes)]),
        places,
        moved.initial[places],
        np.concatenate([np.zeros(0), *(one.rates for one in changes)]),
        np.array([near.magnitude for near in nearby]),
        laws,
        gaps,
        mechanics,
        kinematics,
        drives,
        limits,
        _kink_rates(limits, nearby),
    )
    return packed(variation), start_derivatives(system, nearby)


def _kink_rates(limits: Array, nearby: Sequence[Neighbours]) -> Array:
    """Return the derivatives (np, nc, KINKS) of the kinks; zero where there is none."""
    rates = np.zeros((len(nearby), *limits.shape))
    if np.isfinite(limits).any():
        for rate, near in zip(rates, nearby, strict=True):
            rate[:] = near.derivative(lambda one: np.nan_to_num(kinks(one)))
    return rates


def _fields(model: Arrays) -> dict[str, slice]:
    """Return the places of the fields of a model in its `contents`."""
    ends = np.cumsum([0, *map(_count, model)]).tolist()
    return {name: slice(*part) for name, part in zip(model._fields, pairwise(ends), strict=True)}


def _count(value: Any) -> int:
    """Count the numbers of a value."""
    if isinstance(value, np.ndarray):
        return value.nbytes // 8
    if isinstance(value, Packed):
        return _count(value.unpacked)
    return sum(map(_count, value)) if isinstance(value, tuple) else 1


def _effects(model: Arrays, fields: Mapping[str, slice]) -> tuple[Indices, Indices]:
    """Return the effects of each number of a model, as a sum of the constants, and the contact whose law it changes."""
    nc, nb = len(model.ends), len(model.bodies.records)
    effects, contacts = np.full(fields["size"].stop, _MECHANICS | _ROUGH), np.zeros(fields["size"].stop, np.int64)
    for names, effect in _OF_FIELDS.items():
        for name in names:
            effects[fields[name]] = effect
    for name in ("laws", "tables", "ends"):  # a line for each contact
        contacts[fields[name]] = np.repeat(np.arange(nc), _count(getattr(model, name)) // max(nc, 1))
    ends = effects[fields["ends"]].reshape(nc, ENDS.itemsize // 8)
    ends[:, _OF_ENDS] &= ~_ROUGH
    ends[:, _HALF] = 0
    bodies = effects[fields["bodies"]][: nb * _WORDS].reshape(nb, _WORDS)
    bodies[:, _OF_BODY] &= ~_ROUGH
    bodies[:, -_LAST:] &= ~_KINEMATICS
    if not _is_rigid_tree(model):
        effects[(effects & _MECHANICS) > 0] |= _ROUGH
    return effects, contacts


def _gap_factors(model: Arrays, fields: Mapping[str, slice]) -> Array:
    """Return the change of a contact's gap with each number of a model, at a given motion; at least in magnitude.

    A wall's normal turns about a point within the linkage's length.
    """
    nc, factors = len(model.ends), np.zeros(fields["size"].stop)
    factors[fields["laws"]].reshape(nc, PARAMETERS.itemsize // 8)[:, _CLEARANCE] = 1.0
    ends = factors[fields["ends"]].reshape(nc, ENDS.itemsize // 8)
    ends[:, _NORMAL], ends[:, _HALF] = model.size, 1.0
    return factors


def _is_rigid_tree(model: Arrays) -> bool:
    return not len(model.rows) and not model.bodies.shapes.shape[2]
