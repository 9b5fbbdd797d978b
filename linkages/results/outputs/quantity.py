"""An output: a quantity of an element, the formula that computes it at an instant, and its record."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, lazy_kernel, record_type
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.reactive_loads import ReactiveLoads
from linkages.mechanics.planar.record_types import MARKER
from linkages.mechanics.planar.workspace import Workspace
from linkages.system import System

#: Data that a formula can read in addition to the motion of bodies and contacts:
#: `linkages.mechanics.planar.loads.LOAD_OUTPUTS`; forces in joints and efforts of drives.
READS = ("loads", "forces")

#: Record of one output.
OUTPUT = record_type(
    formula="i8",  # place of the quantity's formula among `linkages.results.outputs.registry.FORMULAS`
    column="i8",  # component of a vector, or column of a table
    at="i8",  # contact, joint, drive, load, coordinate, or first beam; deflection: section at the beam's first end;
    # gear: index minus the number of gears
    other="i8",  # drive: its coordinate, behind backlash its child's body; guide: the block's body; deflection: section
    # at the beam's last end; beams: index after the last one
    marker=MARKER,  # point: its place; guide: the slot's body and the normal of the slot
    constant="f8",  # point: reference angle; deflection: undeformed one; gear: sign of second joint
    jitter="i8",  # 1: minus the ideal linkage's value
    **dict.fromkeys(READS, "i8"),  # 1 for data that the formula reads
)


class Snapshot(NamedTuple):
    """State, contacts and forces of a linkage at one instant."""

    model: Arrays
    state: Workspace  # of which q, v, a, pose, vel and acc count
    contacts: Array  # `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS`, (nc, WIDTH)
    forces: Array  # on each joint's child, with moment, (nj, 3); see `linkages.mechanics.planar.reactions.joint_forces`
    efforts: Array  # torque or force of each drive, (nd,)
    loads: Array  # `linkages.mechanics.planar.loads.LOAD_OUTPUTS` of loads, then of elements, (nl, 4)
    reactive: ReactiveLoads


class OutputFormula(NamedTuple):
    """A kernel ``(output, seen) -> value`` of an `OUTPUT` and a `Snapshot`, and its part of `READS`."""

    kernel: Callable[[np.record, Snapshot], float]
    reads: tuple[str, ...]


def formula(*reads: str) -> Callable[[Callable[[np.record, Snapshot], float]], OutputFormula]:
    """Make a formula of a function; it is compiled at its first call."""
    return lambda function: OutputFormula(lazy_kernel(function), reads)


class Declaration(NamedTuple):
    """Meaning of an output, its unit (and its unit at a prismatic joint), its formula, the column that this reads."""

    meaning: str
    unit: str
    prismatic: str
    formula: OutputFormula
    column: int


def quantity(text: str, formula: OutputFormula, column: int = 0) -> Declaration:
    """Make a quantity from its meaning, which ends with the unit in brackets, and its formula."""
    meaning, _, unit = text.removesuffix("]").rpartition(" [")
    unit, _, prismatic = unit.partition(" or ")
    return Declaration(meaning, unit, prismatic, formula, column)


def quantities(formula: OutputFormula, **texts: str) -> dict[str, Declaration]:
    """Make the quantities that are the columns of one formula, in this order."""
    return {name: quantity(text, formula, k) for k, (name, text) in enumerate(texts.items())}


class OutputPlace(NamedTuple):
    """Numbers of an element in the record of its output; see `OUTPUT`."""

    at: int = 0
    other: int = 0
    marker: tuple[int, float, float] = (0, 0.0, 0.0)
    constant: float = 0.0


@dataclass(frozen=True)
class Owner:
    """A kind of element with outputs."""

    label: str  # the name before the dot, in the documentation
    names: Callable[[System], Iterable[str]]  # names of all elements of this kind
    place: Callable[[System, str], OutputPlace]  # of an element by name
    quantities: dict[str, Declaration]
    real: bool = False  # whether only a linkage with clearances has it
    asked: Callable[[System], Iterable[str]] | None = None  # elements with columns in a run; default: all
    unit: Callable[[System, str], str] | None = None  # of an element by name, instead of the quantities' units
