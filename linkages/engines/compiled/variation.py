"""A system whose numbers follow values: the derivatives of everything that a run reads with respect to the values.

The numbers of neighbouring systems are differentiated (`linkages.engines.compiled.neighbours`). So lengths are
differentiated through the assembly, and a contact's stiffness through its material.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, cast

import numpy as np

from linkages.engines.compiled.job import Given, model_of
from linkages.engines.compiled.model import Equations, make_memory, make_work
from linkages.engines.compiled.neighbours import Neighbours, Rates, unscaled
from linkages.engines.compiled.start_derivatives import start_derivatives
from linkages.kernel import Array, Indices, kernel
from linkages.kernel.block import Block, contents
from linkages.kernel.by_reference import packed
from linkages.kernel.simd import WIDTH, LaneArray
from linkages.kernel.simd import LaneArray as Lanes
from linkages.outputs.registry import pack
from linkages.planar.arrays import Arrays
from linkages.planar.record_types import BODY, ENDS, MARKER
from linkages.system import System

EXACT = 2
_INERTIAL = ("mass", "cx", "cy", "inertia")  # the last fields of a body: they move nothing
assert (BODY.names or ())[-len(_INERTIAL) :] == _INERTIAL
_WORDS, _LAST = BODY.itemsize // 8, len(_INERTIAL)
#: Words of `BODY` that have exact derivatives, in the order of `linkages.planar.tangent_workspace.BODY_NUMBERS`.
_OF_BODY = 1, 2, *range(_WORDS - _LAST, _WORDS)
_MARKERS = tuple(range(1, 1 + 2 * len(MARKER.names or ())))  # of the ends of a contact: its law does not read them
assert (BODY.names or ())[0] == "mount"
assert (ENDS.names or ())[1:3] == ("bearing", "journal")
_OF_ENDS = 2, 3, 5, 6  # coordinates among them


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
        1 where it changes anything else; `EXACT` where the mechanics has exact derivatives with respect to the changed
        numbers: of rigid bodies without closure rows, of markers of contacts, of gravity and prescribed motions.
    kinematics : (np,) array of int
        1 where it may move the ends of contacts at given coordinates, or prescribed coordinates.
    drives : (np,) array of int
        1 where it changes a prescribed motion.
    lanes : (ng, WIDTH) array of int
        Values that change no mechanics or with exact derivatives, side by side; -1: none. No line unless the linkage is
        a tree of rigid bodies.
    bodies, markers, gravity : (ng, nb, BODY_NUMBERS), (ng, nc, 4), (ng, 2) lanes
        Derivatives of numbers of bodies, of coordinates of the markers of contacts, and of gravity with respect to
        these values.
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
    drives: Indices
    lanes: Indices
    bodies: Lanes
    markers: Lanes
    gravity: Lanes


@kernel
def is_exact(variation: Variation, p: int) -> bool:
    """Whether value p is in the lanes."""
    return p >= 0 and len(variation.lanes) > 0 and variation.mechanics[p] != 1


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
    block = Block(Equations(model, make_work(model, make_memory(model), np.full(nc, -1)), given.implicit))
    memory, own = block.memory.view(np.float64), contents(model).words.view(np.float64)
    none = pack(system, ())
    whole = model is system.arrays  # no sections of links are left out

    def reduced(one: System) -> Arrays:
        return unscaled(model_of(one, none))

    changes = [near.arrays if whole else near.rates(reduced) for near in nearby]
    laws, mechanics, kinematics, drives = (np.zeros((len(nearby), *more), np.int64) for more in ((nc,), (), (), ()))
    fields = dict(_fields(model))
    for p, change in enumerate(changes):
        _note_effects(model, fields, change.places, laws[p], mechanics[p : p + 1], kinematics[p : p + 1], drives[p:])
    places = np.concatenate([np.zeros(0, np.int64), *(one.places for one in changes)])
    variation = Variation(
        cast(Equations, block),
        memory,
        np.cumsum([0, *(len(one.places) for one in changes)]),
        np.ascontiguousarray(block.where[places]),
        own[places],
        np.concatenate([np.zeros(0), *(one.rates for one in changes)]),
        np.array([near.magnitude for near in nearby]),
        laws,
        mechanics,
        kinematics,
        drives,
        *_side_by_side(model, fields, changes, mechanics),
    )
    return packed(variation), start_derivatives(system, nearby)


def _side_by_side(
    model: Arrays, fields: Mapping[str, range], changes: Sequence[Rates], mechanics: Indices
) -> tuple[Indices, Lanes, Lanes, Lanes]:
    """Return the values that are differentiated in lanes, and the derivatives of numbers; see `Variation`."""
    rigid_tree = not len(model.rows) and not model.bodies.shapes.shape[2]
    able = np.flatnonzero(mechanics != 1) if rigid_tree else np.zeros(0, np.int64)
    groups, nb, nc = -(-len(able) // WIDTH), len(model.bodies.records), len(model.ends)
    lanes, numbers = np.full(groups * WIDTH, -1), np.zeros((groups * WIDTH, fields["gravity"].stop))
    lanes[: len(able)] = able
    for row, p in zip(numbers, able, strict=False):
        row[changes[p].places] = changes[p].rates
    shapes = [("bodies", nb, _WORDS, _OF_BODY), ("ends", nc, -1, _OF_ENDS), ("gravity", 1, 2, (0, 1))]
    made = []
    for name, lines, words, kept in shapes:
        start = fields[name].start
        words = words if words > 0 else len(fields[name]) // max(nc, 1)
        part = numbers[:, start : start + lines * words].reshape(groups, WIDTH, lines, words)[..., list(kept)]
        made.append(np.ascontiguousarray(np.moveaxis(part, 1, -1)).view(LaneArray))
    return lanes.reshape(groups, WIDTH), made[0], made[1], made[2][:, 0].copy().view(LaneArray)


def _fields(model: Arrays) -> Iterator[tuple[str, range]]:
    """Fields of a model, and their places in its `contents`."""
    start = 0
    for name, value in model._asdict().items():
        end = start + len(contents((value,)).words)
        yield name, range(start, end)
        start = end


def _note_effects(
    model: Arrays, fields: Mapping[str, range], places: Indices, laws: Indices, mechanics: Indices, kinematics: Indices,
    drives: Indices,
) -> None:  # fmt: skip
    """Note the changes due to a value whose numbers have these places; see `Variation`."""
    ends = np.array([place.stop for place in fields.values()])
    owners = np.searchsorted(ends, places, side="right")
    changed = {list(fields)[owner]: places[owners == owner] for owner in np.unique(owners)}
    changed = {name: inside - fields[name].start for name, inside in changed.items() if name not in ("limits", "stiff")}
    exact = not len(model.rows) and not model.bodies.shapes.shape[2]
    for name in ("laws", "tables", "ends"):  # a line for each contact
        if name in changed:
            line, word = np.divmod(changed[name], len(fields[name]) // len(laws))
            laws[line if name != "ends" else line[~np.isin(word, _MARKERS)]] = 1
            exact = exact and (name != "ends" or bool(np.isin(word, _OF_ENDS).all()))
    inside = changed.get("bodies", np.zeros(0, np.int64))
    of_records, word = inside < model.bodies.records.size * _WORDS, inside % _WORDS
    exact = exact and bool(np.all(of_records & np.isin(word, _OF_BODY)))
    if changed.keys() - {"laws", "tables"}:
        known = {"laws", "tables", "ends", "bodies", "gravity", "motion", "motion_c", "joints"}
        mechanics[0] = EXACT if exact and changed.keys() <= known else 1
    drives[0] = int(bool(changed.keys() & {"motion", "motion_c"}))
    if drives[0] or "ends" in changed or not np.all(of_records & (word >= _WORDS - _LAST)):
        kinematics[0] = 1
